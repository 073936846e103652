//! The axis along which two hulls are furthest apart, or overlap least: separating axis test over
//! faces and edges [Gregorius13].

use super::eight::{IN_BOTH, furthest_edges, furthest_face, mark_within};
use super::{HullPair, Room};
use frangible_geometry::{HalfSpace, Hull};
use frangible_math::{RigidTransform, with_widest};
use glam::{DMat3, DVec3};

/// Where a frame is in another, ready to be used often.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Placement {
    pub(crate) matrix: DMat3,
    pub(crate) shift: DVec3,
}

impl Placement {
    pub(crate) fn new(to_from_from: &RigidTransform) -> Self {
        Self { matrix: to_from_from.matrix(), shift: to_from_from.translation }
    }

    pub(crate) fn inverse(&self) -> Self {
        let matrix = self.matrix.transpose();
        Self { matrix, shift: -(matrix * self.shift) }
    }

    #[inline]
    pub(crate) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix * point + self.shift
    }

    #[inline]
    pub(crate) fn direction(&self, direction: DVec3) -> DVec3 {
        self.matrix * direction
    }

    #[inline]
    pub(crate) fn plane(&self, plane: HalfSpace) -> HalfSpace {
        let normal = self.matrix * plane.normal;
        HalfSpace { normal, offset: plane.offset + normal.dot(self.shift) }
    }
}

/// A hull seen from the frame in which two of them meet.
#[derive(Clone, Copy)]
pub(crate) struct View<'a> {
    pub(crate) hull: &'a Hull,
    /// `None` in its own frame.
    pub(crate) here_from_hull: Option<&'a Placement>,
}

impl View<'_> {
    #[inline]
    pub(crate) fn vertex(&self, vertex: usize) -> DVec3 {
        let point = self.hull.vertices()[vertex];
        self.here_from_hull.map_or(point, |placement| placement.point(point))
    }

    #[inline]
    pub(crate) fn plane(&self, face: usize) -> HalfSpace {
        let plane = self.hull.planes()[face];
        self.here_from_hull.map_or(plane, |placement| placement.plane(plane))
    }

    #[inline]
    fn direction(&self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.direction(direction))
    }

    /// The ends of an edge [m].
    #[inline]
    pub(crate) fn ends(&self, edge: usize) -> [DVec3; 2] {
        let [start, end] = self.hull.edges()[edge].vertices;
        [self.vertex(start as usize), self.vertex(end as usize)]
    }

    /// A direction in the hull's own frame.
    pub(crate) fn into_hull(self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.matrix.transpose() * direction)
    }
}

/// A face whose normal separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceAxis {
    /// Of the hull that has the face.
    pub(crate) face: usize,
    /// The vertex of the other hull that is deepest below the face.
    pub(crate) vertex: usize,
    /// How far that is above the face's plane [m].
    pub(crate) separation: f64,
}

impl FaceAxis {
    /// Of a face of one of two hulls, by its number, and the vertex of the other one that is lowest
    /// there.
    pub(super) fn of_face(pair: &HullPair, side: usize, face: usize, vertex: usize) -> Self {
        let plane = &pair.hulls[side].planes()[face];
        let own_from_other = pair.own_from_other(side);
        let height =
            plane.normal.dot(own_from_other.direction(pair.hulls[1 - side].vertices()[vertex]));
        Self {
            face,
            vertex,
            separation: height + plane.normal.dot(own_from_other.shift) - plane.offset,
        }
    }
}

/// The face of one of two hulls, by its number, that the other is furthest away from.
pub(super) fn face_axis(pair: &HullPair, side: usize) -> FaceAxis {
    let (hull, other) = (pair.hulls[side].columns(), pair.hulls[1 - side].columns());
    let (own_from_other, other_from_own) =
        (pair.own_from_other(side), pair.own_from_other(1 - side));
    let [face, vertex] =
        with_widest!(pair.width, furthest_face(hull, other, own_from_other, other_from_own));
    FaceAxis::of_face(pair, side, face, vertex)
}

/// A pair of edges whose common perpendicular separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeAxis {
    /// Of the first hull and of the second.
    pub(crate) edges: [usize; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Along the normal [m].
    pub(crate) separation: f64,
}

/// An edge and the normals beside it, in the frame in which two hulls meet.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ridge {
    pub(crate) edge: usize,
    pub(crate) ends: [DVec3; 2],
    pub(super) along: DVec3,
    pub(super) normals: [DVec3; 2],
}

/// Gathers the edges of the two hulls that may come within `within` [m] of each other, given the
/// best faces of both.
pub(crate) fn gather_ridges(pair: &HullPair, axes: &[FaceAxis; 2], within: f64, room: &mut Room) {
    // Each hull is below its own face; the other begins at the separation above it. An edge must
    // come into both layers.
    let views = pair.views();
    let Room { marks, ridges, .. } = room;

    // What is of interest is in a box.
    let mut bounds = (DVec3::NEG_INFINITY, DVec3::INFINITY);
    for side in [1, 0] {
        let (hull, view, other) = (pair.hulls[side], &views[side], 1 - side);
        let face = hull.planes()[axes[side].face];
        let face_of_other =
            pair.own_from_other(side).plane(pair.hulls[other].planes()[axes[other].face]);
        let layers = [
            HalfSpace {
                normal: -face.normal,
                offset: within - axes[side].separation - face.offset,
            },
            HalfSpace { offset: face_of_other.offset + within, ..face_of_other },
        ];
        with_widest!(pair.width, mark_within(hull.columns(), &layers, marks));
        let spot = |vertex: u32| {
            let above = face_of_other.distance(hull.vertices()[vertex as usize]) - within;
            Spot { point: view.vertex(vertex as usize), above }
        };

        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let ridges = &mut ridges[side];
        ridges.clear();
        for (index, edge) in hull.edges().iter().enumerate() {
            let [first, second] = edge.vertices;
            if (marks[first as usize] | marks[second as usize]) != IN_BOTH {
                continue;
            }
            let (a, b) = (spot(first), spot(second));
            let (start, end) = (a.point, b.point);
            if start.min(end).cmpgt(bounds.1).any() || start.max(end).cmplt(bounds.0).any() {
                continue;
            }
            // The part of it that is not too high above the other's face.
            let low = [a.lowered_to(&b), b.lowered_to(&a)];
            around = (around.0.min(low[0]).min(low[1]), around.1.max(low[0]).max(low[1]));
            let normal = |face: u32| view.direction(hull.planes()[face as usize].normal);
            let normals = [normal(edge.faces[0]), normal(edge.faces[1])];
            ridges.push(Ridge { edge: index, ends: [start, end], along: end - start, normals });
        }
        bounds = (around.0 - within, around.1 + within);
    }
}

/// A vertex and where it is between the best faces of two hulls.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// In the frame in which they meet [m].
    point: DVec3,
    /// How much higher above the other hull's face than it may be [m].
    above: f64,
}

impl Spot {
    /// It, or the point on the way to another one that is not too high.
    fn lowered_to(&self, other: &Self) -> DVec3 {
        // Both may be too high by rounding.
        if self.above > 0.0 && other.above < self.above {
            self.point.lerp(other.point, self.above / (self.above - other.above))
        } else {
            self.point
        }
    }
}

/// Sine of the angle below which edges count as parallel: then a face's normal does as well.
pub(super) const PARALLEL: f64 = 1e-3;

/// The pair of some edges that are furthest apart, of those that make a face of the Minkowski
/// difference; `None` if all that do are parallel.
pub(crate) fn edge_axis(pair: &HullPair, room: &mut Room) -> Option<EdgeAxis> {
    let Room { ridges: [first, second], ridge_columns, .. } = room;
    let [at, other] = with_widest!(pair.width, furthest_edges([first, second], ridge_columns))?;
    EdgeAxis::of(&first[at], &second[other])
}

impl EdgeAxis {
    /// Across two edges.
    fn of(first: &Ridge, second: &Ridge) -> Option<Self> {
        let across = first.along.cross(second.along).try_normalize()?;
        // Outward of the second hull is between the normals of its edge.
        let outward = second.normals[0] + second.normals[1];
        let normal = if across.dot(outward) < 0.0 { -across } else { across };
        let separation = normal.dot(first.ends[0] - second.ends[0]);
        Some(Self { edges: [first.edge, second.edge], normal, separation })
    }
}
