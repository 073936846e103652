//! Faces, sides and rims that bodies turn to each other.

use crate::narrow_phase::revolved::partner::furthest_vertex;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;

/// A normal within this angle of a face's belongs to the face [rad]: the normals of contacts are
/// those of faces exactly, or of none.
const ALIGNED: f64 = 1e-4;

/// Edges within this sine of being across the normal may touch [1].
const ACROSS: f64 = 0.02;

/// Ends of edges this near to the furthest vertex along the normal are as far, relative to the
/// edge's length [1]: all corners of a face.
const AS_HIGH: f64 = 1e-6;

/// Feature of a body of revolution that faces another body.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Facing {
    Disc(usize),
    /// The line of its side.
    Side,
    /// A point of a rim.
    Rim(usize),
}

impl PlacedRevolved {
    /// The feature with this outward normal.
    pub(crate) fn facing(&self, towards: DVec3) -> Facing {
        let (along, _, across) = self.split(towards);
        let end = self.furthest_end(towards);
        let is_at_end = across < ALIGNED && (end == 1) == (along > 0.0);
        if is_at_end && self.ends[end].radius > 0.0 {
            return Facing::Disc(end);
        }
        if self.off_side(towards) < ALIGNED { Facing::Side } else { Facing::Rim(end) }
    }

    /// Sine of the angle between a direction and the side's normals.
    pub(crate) fn off_side(&self, towards: DVec3) -> f64 {
        let (along, _, across) = self.split(towards);
        (self.side.x * along - self.side.y * across).abs()
    }

    /// The disc or the side that is nearest to facing a flat face of the other body: the one whose
    /// normal is nearest to a direction.
    pub(crate) fn nearest_facing(&self, towards: DVec3) -> Facing {
        let (along, _, across) = self.split(towards);
        let of_side = self.side.x * across + self.side.y * along;
        let end = usize::from(along > 0.0);
        let is_disc = self.ends[end].radius > 0.0 && along.abs() > of_side;
        if is_disc { Facing::Disc(end) } else { Facing::Side }
    }
}

/// A flat part of a surface.
#[derive(Clone, Copy)]
pub(crate) enum Area<'a> {
    Plane(HalfSpace),
    Face(&'a Hull, usize),
    Disc(&'a PlacedRevolved, usize),
    /// Corners, counter-clockwise seen from the side of the plane's normal [m].
    Triangle([DVec3; 3], HalfSpace),
}

impl Area<'_> {
    pub(crate) fn plane(&self) -> HalfSpace {
        match *self {
            Self::Plane(plane) | Self::Triangle(_, plane) => plane,
            Self::Face(hull, face) => hull.planes()[face],
            Self::Disc(body, end) => {
                let normal = body.end_normal(end);
                HalfSpace { normal, offset: normal.dot(body.center(end)) }
            }
        }
    }

    /// The point of the plane along a direction from a point [m].
    pub(crate) fn drop(&self, point: DVec3, along: DVec3) -> DVec3 {
        let plane = self.plane();
        point - plane.distance(point) / plane.normal.dot(along) * along
    }

    /// True for a point of the plane within the area, or within `close` [m] of it, seen along a
    /// normal.
    pub(crate) fn contains(&self, point: DVec3, normal: DVec3, close: f64) -> bool {
        match *self {
            Self::Plane(_) => true,
            Self::Face(hull, face) => sides_of(hull, face).all(|[start, end]| {
                let outward = outward_of(hull, face, end - start, normal);
                outward.dot(point - start) <= close * outward.length()
            }),
            Self::Triangle(corners, plane) => {
                sides_of_triangle(corners).into_iter().all(|[start, end]| {
                    let outward = (end - start).cross(plane.normal.dot(normal).signum() * normal);
                    outward.dot(point - start) <= close * outward.length()
                })
            }
            Self::Disc(body, end) => {
                let reach = body.ends[end].radius + close;
                point.distance_squared(body.center(end)) <= reach * reach
            }
        }
    }
}

/// The sides of a face, counter-clockwise [m].
pub(crate) fn sides_of(hull: &Hull, face: usize) -> impl Iterator<Item = [DVec3; 2]> + '_ {
    let corners = hull.face(face).vertices;
    (0..corners.len()).map(move |at| {
        let next = if at + 1 == corners.len() { 0 } else { at + 1 };
        [corners[at], corners[next]].map(|vertex| hull.vertices()[vertex as usize])
    })
}

/// The sides of a triangle, in its order [m].
pub(crate) fn sides_of_triangle([a, b, c]: [DVec3; 3]) -> [[DVec3; 2]; 3] {
    [[a, b], [b, c], [c, a]]
}

/// Away from a face across one of its sides, and across a normal along which it is seen.
pub(crate) fn outward_of(hull: &Hull, face: usize, side: DVec3, normal: DVec3) -> DVec3 {
    side.cross(hull.planes()[face].normal.dot(normal).signum() * normal)
}

/// The face whose normal is nearest to a direction, and the cosine between both.
pub(crate) fn nearest_face(hull: &Hull, direction: DVec3) -> (usize, f64) {
    let mut best = (0, f64::NEG_INFINITY);
    for (face, plane) in hull.planes().iter().enumerate() {
        let cosine = plane.normal.dot(direction);
        if cosine > best.1 {
            best = (face, cosine);
        }
    }
    best
}

/// True if a unit normal is a face's, by the cosine between both.
pub(crate) fn is_aligned(cosine: f64) -> bool {
    cosine > 1.0 - 0.5 * ALIGNED * ALIGNED
}

/// Ends of the edge that a normal belongs to, nearest to a point seen along it; twice the vertex if
/// it belongs to one [m].
pub(crate) fn touching_edge(hull: &Hull, normal: DVec3, point: DVec3) -> [DVec3; 2] {
    let vertex = hull.vertices()[furthest_vertex(hull, normal)];
    let mut best = (f64::INFINITY, [vertex; 2]);
    for edge in hull.edges() {
        let ends = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
        let along = ends[1] - ends[0];
        let (length, rise) = (along.length(), along.dot(normal).abs());
        let below = ends.map(|end| (vertex - end).dot(normal));
        if rise > ACROSS * length || below[0].min(below[1]) > AS_HIGH * length {
            continue;
        }
        let part = ((point - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        let apart = point - ends[0].lerp(ends[1], part);
        let beside = (apart - apart.dot(normal) * normal).length_squared();
        if beside < best.0 {
            best = (beside, ends);
        }
    }
    best.1
}
