//! The axis along which two hulls are furthest apart, or overlap least: separating axis test over faces and edges [Gregorius13].

use super::{HullPair, Room};
use frangible_geometry::{HalfSpace, Hull, RigidTransform};
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

    pub(crate) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix * point + self.shift
    }

    pub(crate) fn direction(&self, direction: DVec3) -> DVec3 {
        self.matrix * direction
    }

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
    pub(crate) fn vertex(&self, vertex: usize) -> DVec3 {
        let point = self.hull.vertices()[vertex];
        self.here_from_hull.map_or(point, |placement| placement.point(point))
    }

    pub(crate) fn plane(&self, face: usize) -> HalfSpace {
        let plane = self.hull.planes()[face];
        self.here_from_hull.map_or(plane, |placement| placement.plane(plane))
    }

    fn direction(&self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.direction(direction))
    }

    /// The ends of an edge [m].
    pub(crate) fn ends(&self, edge: usize) -> [DVec3; 2] {
        let [start, end] = self.hull.edges()[edge].vertices;
        [self.vertex(start as usize), self.vertex(end as usize)]
    }

    /// A direction in the hull's own frame.
    pub(crate) fn into_hull(self, direction: DVec3) -> DVec3 {
        self.here_from_hull.map_or(direction, |placement| placement.matrix.transpose() * direction)
    }
}

/// A ball inside of a hull, in the hull's frame [m].
#[derive(Clone, Copy, Debug)]
struct Core {
    center: DVec3,
    radius: f64,
}

impl Core {
    /// Around the centre of mass of a body, or the middle of the vertices if the frame has its origin elsewhere.
    fn of(hull: &Hull) -> Self {
        let least = |center: DVec3| {
            hull.planes().iter().map(|plane| -plane.distance(center)).fold(f64::INFINITY, f64::min)
        };
        let radius = hull.planes().iter().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
        if radius > 0.0 {
            return Self { center: DVec3::ZERO, radius };
        }
        let center = hull.vertices().iter().sum::<DVec3>() / hull.vertices().len() as f64;
        Self { center, radius: least(center) }
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

/// The face of `hull` that `other` is furthest away from, the first of equals; any that it is more than `most` [m] away from.
pub(crate) fn face_axis(
    hull: &Hull,
    other: &Hull,
    hull_from_other: &Placement,
    other_from_hull: &Placement,
    most: f64,
) -> FaceAxis {
    // The face that looks most at a ball inside of the other.
    let core = Core::of(other);
    let center = hull_from_other.point(core.center);
    let mut towards = (f64::NEG_INFINITY, 0);
    for (face, plane) in hull.planes().iter().enumerate() {
        let height = plane.distance(center);
        if height > towards.0 {
            towards = (height, face);
        }
    }
    let over = |face: usize| {
        let plane = hull.planes()[face];
        let (vertex, height) = lowest(other.vertices(), other_from_hull.direction(plane.normal));
        FaceAxis { face, vertex, separation: height + plane.normal.dot(hull_from_other.shift) - plane.offset }
    };
    let deepest = |axis: &FaceAxis| hull_from_other.point(other.vertices()[axis.vertex]);
    let mut best = over(towards.1);
    let mut inside = deepest(&best);

    // No other face is further away than from that ball, or from a vertex of the other.
    for (face, plane) in hull.planes().iter().enumerate() {
        if best.separation > most {
            break;
        }
        let bound = (plane.distance(center) - core.radius).min(plane.distance(inside));
        if bound < best.separation || face == best.face {
            continue;
        }
        let next = over(face);
        let is_first = face < best.face;
        if next.separation > best.separation || (next.separation == best.separation && is_first) {
            best = next;
            inside = deepest(&best);
        }
    }
    best
}

/// The first of the points that are lowest in a direction, and how high that is [m].
fn lowest(points: &[DVec3], direction: DVec3) -> (usize, f64) {
    // Side by side, so that no comparison has to wait for the one before it.
    const LANES: usize = 4;
    let mut least = [f64::INFINITY; LANES];
    let chunks = points.chunks_exact(LANES);
    let rest = chunks.remainder();
    for chunk in chunks {
        for (least, point) in least.iter_mut().zip(chunk) {
            let height = direction.dot(*point);
            *least = if height < *least { height } else { *least };
        }
    }
    let of_rest = rest.iter().map(|&point| direction.dot(point));
    let least = least.into_iter().chain(of_rest).fold(f64::INFINITY, |a, b| if b < a { b } else { a });
    let at = points.iter().position(|&point| direction.dot(point) == least);
    (at.unwrap_or(0), least)
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
    along: DVec3,
    normals: [DVec3; 2],
}

/// Gathers the edges of the two hulls that may come within `within` [m] of each other, given the best faces of both.
pub(crate) fn gather_ridges(pair: &HullPair, axes: &[FaceAxis; 2], within: f64, room: &mut Room) {
    // Each hull is below its own face; the other begins at the separation above it. An edge must come into both layers.
    const IN_OWN: u8 = 1;
    const IN_OTHERS: u8 = 2;
    let own_from_other = [&pair.first_from_second, &pair.second_from_first];
    let views = pair.views();
    let Room { layers, ridges, .. } = room;

    // What is of interest is in a box.
    let mut bounds = (DVec3::NEG_INFINITY, DVec3::INFINITY);
    for side in [1, 0] {
        let (hull, view, other) = (pair.hulls[side], &views[side], 1 - side);
        let face = hull.planes()[axes[side].face];
        let face_of_other = own_from_other[side].plane(pair.hulls[other].planes()[axes[other].face]);
        let least = axes[side].separation - within;
        let of_vertex = |&vertex: &DVec3| {
            let in_own = if face.distance(vertex) >= least { IN_OWN } else { 0 };
            in_own | if face_of_other.distance(vertex) <= within { IN_OTHERS } else { 0 }
        };
        layers.clear();
        layers.extend(hull.vertices().iter().map(of_vertex));

        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let ridges = &mut ridges[side];
        ridges.clear();
        for (index, edge) in hull.edges().iter().enumerate() {
            let (a, b) = (edge.vertices[0] as usize, edge.vertices[1] as usize);
            if layers[a] | layers[b] != IN_OWN | IN_OTHERS {
                continue;
            }
            let (start, end) = (view.vertex(a), view.vertex(b));
            if start.min(end).cmpgt(bounds.1).any() || start.max(end).cmplt(bounds.0).any() {
                continue;
            }
            // The part of it that is not too high above the other's face.
            let above = |vertex: usize| face_of_other.distance(hull.vertices()[vertex]) - within;
            let (at_start, at_end) = (above(a), above(b));
            let part = |here: f64, there: f64| if here > 0.0 { here / (here - there) } else { 0.0 };
            let low = [start.lerp(end, part(at_start, at_end)), end.lerp(start, part(at_end, at_start))];
            around = (around.0.min(low[0]).min(low[1]), around.1.max(low[0]).max(low[1]));
            let normal = |face: u32| view.direction(hull.planes()[face as usize].normal);
            let normals = [normal(edge.faces[0]), normal(edge.faces[1])];
            ridges.push(Ridge { edge: index, ends: [start, end], along: end - start, normals });
        }
        bounds = (around.0 - within, around.1 + within);
    }
}

/// The pair of some edges that are furthest apart, of those that make a face of the Minkowski difference; `None` if all that do are
/// parallel.
pub(crate) fn edge_axis([first, second]: &[Vec<Ridge>; 2]) -> Option<EdgeAxis> {
    // Sine of the angle below which edges count as parallel: then a face's normal does as well.
    const PARALLEL: f64 = 1e-3;
    let mut best: Option<EdgeAxis> = None;
    for of_first in first {
        for of_second in second {
            // Arcs of the Gauss map: those between the first edge's normals and between the negated ones of the second must
            // cross, else other features are further apart.
            let [beside_c, beside_d] = &of_second.normals;
            let (c, d) = (beside_c.dot(of_first.along), beside_d.dot(of_first.along));
            if c * d >= 0.0 {
                continue;
            }
            let [beside_u, beside_v] = &of_first.normals;
            let (u, v) = (-beside_u.dot(of_second.along), -beside_v.dot(of_second.along));
            if u * v >= 0.0 || c * v <= 0.0 {
                continue;
            }
            let across = of_first.along.cross(of_second.along);
            let squared = across.length_squared();
            let lengths = of_first.along.length_squared() * of_second.along.length_squared();
            if squared <= PARALLEL * PARALLEL * lengths {
                continue;
            }
            // Outward of the second hull is between the normals of its edge.
            let across = across / squared.sqrt();
            let outward = of_second.normals[0] + of_second.normals[1];
            let normal = if across.dot(outward) < 0.0 { -across } else { across };
            let separation = normal.dot(of_first.ends[0] - of_second.ends[0]);
            if best.is_none_or(|best| separation > best.separation) {
                best = Some(EdgeAxis { edges: [of_first.edge, of_second.edge], normal, separation });
            }
        }
    }
    best
}
