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

/// A ball inside of a hull, in the hull's frame [m].
#[derive(Clone, Copy, Debug)]
struct Core {
    center: DVec3,
    radius: f64,
}

impl Core {
    /// Around the centre of mass of a body, or the middle of the vertices if the frame has its origin elsewhere.
    fn of(hull: &Hull) -> Self {
        let radius = least_of(hull.planes(), |plane| plane.offset);
        if radius > 0.0 {
            return Self { center: DVec3::ZERO, radius };
        }
        let center = hull.vertices().iter().sum::<DVec3>() / hull.vertices().len() as f64;
        Self { center, radius: least_of(hull.planes(), |plane| -plane.distance(center)) }
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
    /// Of a face of `hull`.
    #[inline]
    pub(crate) fn of_face(
        face: usize,
        hull: &Hull,
        other: &Hull,
        hull_from_other: &Placement,
        other_from_hull: &Placement,
    ) -> Self {
        let plane = &hull.planes()[face];
        let down = other_from_hull.direction(plane.normal);
        let (vertex, height) = first_least(other.vertices(), |vertex| down.dot(*vertex));
        Self { face, vertex, separation: height + plane.normal.dot(hull_from_other.shift) - plane.offset }
    }
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
    let over = |face: usize| FaceAxis::of_face(face, hull, other, hull_from_other, other_from_hull);
    let deepest = |axis: &FaceAxis| hull_from_other.point(other.vertices()[axis.vertex]);
    let (towards, _) = first_least(hull.planes(), |plane| -plane.distance(center));
    let mut best = over(towards);
    let mut inside = deepest(&best);

    // No other face is further away than from that ball, or from a vertex of the other.
    for (face, plane) in hull.planes().iter().enumerate() {
        if best.separation > most {
            break;
        }
        let is_behind = plane.distance(center) - core.radius < best.separation;
        if is_behind || plane.distance(inside) < best.separation || face == best.face {
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

/// The face whose normal is nearest to a direction, and the cosine between them if that is a unit vector.
pub(crate) fn face_along(hull: &Hull, direction: DVec3) -> (usize, f64) {
    let (face, least) = first_least(hull.planes(), |plane| -plane.normal.dot(direction));
    (face, -least)
}

/// The least of some numbers; infinite if there are none.
#[inline]
pub(crate) fn least_of<T>(items: &[T], number: impl Fn(&T) -> f64) -> f64 {
    // Side by side, so that no comparison has to wait for the one before it.
    const LANES: usize = 4;
    let lower = |a: f64, b: f64| if b < a { b } else { a };
    let mut least = [f64::INFINITY; LANES];
    let chunks = items.chunks_exact(LANES);
    for (lane, item) in chunks.remainder().iter().enumerate() {
        least[lane] = lower(f64::INFINITY, number(item));
    }
    for chunk in chunks {
        for lane in 0..LANES {
            least[lane] = lower(least[lane], number(&chunk[lane]));
        }
    }
    lower(lower(least[0], least[1]), lower(least[2], least[3]))
}

/// The first of the items with the least number, and that number.
#[inline]
fn first_least<T>(items: &[T], number: impl Fn(&T) -> f64) -> (usize, f64) {
    let least = least_of(items, &number);
    (items.iter().position(|item| number(item) == least).unwrap_or(0), least)
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
    let own_from_other = [&pair.first_from_second, &pair.second_from_first];
    let views = pair.views();
    let Room { spots, ridges, .. } = room;

    // What is of interest is in a box.
    let mut bounds = (DVec3::NEG_INFINITY, DVec3::INFINITY);
    for side in [1, 0] {
        let (hull, view, other) = (pair.hulls[side], &views[side], 1 - side);
        let face = hull.planes()[axes[side].face];
        let face_of_other = own_from_other[side].plane(pair.hulls[other].planes()[axes[other].face]);
        let least = axes[side].separation - within;
        spots.clear();
        spots.extend(hull.vertices().iter().enumerate().map(|(vertex, &point)| {
            let above = face_of_other.distance(point) - within;
            let in_own = face.distance(point) >= least;
            Spot { point: view.vertex(vertex), above, in_own, in_others: above <= 0.0 }
        }));

        let mut around = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let ridges = &mut ridges[side];
        ridges.clear();
        for (index, edge) in hull.edges().iter().enumerate() {
            let [a, b] = [&spots[edge.vertices[0] as usize], &spots[edge.vertices[1] as usize]];
            if !(a.in_own | b.in_own) | !(a.in_others | b.in_others) {
                continue;
            }
            let (start, end) = (a.point, b.point);
            if start.min(end).cmpgt(bounds.1).any() || start.max(end).cmplt(bounds.0).any() {
                continue;
            }
            // The part of it that is not too high above the other's face.
            let low = [a.lowered_to(b), b.lowered_to(a)];
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
pub(crate) struct Spot {
    /// In the frame in which they meet [m].
    point: DVec3,
    /// How much higher above the other hull's face than it may be [m].
    above: f64,
    /// Whether it is near enough to its own hull's face, and to the other's.
    in_own: bool,
    in_others: bool,
}

impl Spot {
    /// It, or the point on the way to another one that is not too high.
    fn lowered_to(&self, other: &Self) -> DVec3 {
        if self.above > 0.0 {
            self.point.lerp(other.point, self.above / (self.above - other.above))
        } else {
            self.point
        }
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
