//! Axis of largest separation, or least overlap, of two hulls: separating axis test over faces and
//! edges [Gregorius13].

use crate::narrow_phase::hull_hull::feature_scan::{FurthestEdges, IN_BOTH, MarkWithin};
use crate::narrow_phase::hull_hull::furthest_face::FurthestFace;
use crate::narrow_phase::hull_hull::hull_pair::HullPair;
use crate::narrow_phase::hull_hull::placement::Ridge;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use frangible_geometry::HalfSpace;
use frangible_math::with_widest;
use glam::DVec3;

/// A face whose normal separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceAxis {
    /// Index of the face in its hull.
    pub(crate) face: usize,
    /// Lowest vertex of the other hull above the face.
    pub(crate) vertex: usize,
    /// Height of this vertex above the face's plane [m].
    pub(crate) separation: f64,
}

impl FaceAxis {
    /// Face axis of the hull on `side`, with the lowest vertex of the other hull.
    pub(crate) fn of_face(pair: &HullPair, side: usize, face: usize, vertex: usize) -> Self {
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

/// Face of the hull on `side` with the largest separation from the other hull.
pub(crate) fn face_axis(pair: &HullPair, side: usize, scratch: &mut Scratch) -> FaceAxis {
    let (hull, other) = (pair.hulls[side].columns(), pair.hulls[1 - side].columns());
    let (own_from_other, other_from_own) =
        (pair.own_from_other(side), pair.own_from_other(1 - side));
    let kernel = FurthestFace {
        hull,
        other,
        hull_from_other: own_from_other,
        other_from_hull: other_from_own,
        blocks: &mut scratch.face_blocks,
        lowest: &mut scratch.lowest[side],
    };
    let [face, vertex] = with_widest(pair.width, kernel);
    FaceAxis::of_face(pair, side, face, vertex)
}

/// A pair of edges whose common perpendicular separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeAxis {
    /// Edges of the first and of the second hull.
    pub(crate) edges: [usize; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Separation along the normal [m].
    pub(crate) separation: f64,
}

/// Gathers edges of both hulls within `within` [m] of each other, from the best faces of both.
pub(crate) fn gather_ridges(
    pair: &HullPair,
    axes: &[FaceAxis; 2],
    within: f64,
    scratch: &mut Scratch,
) {
    // Each hull lies below its own face; the other hull begins at the separation above it. A
    // candidate edge must enter both layers.
    let views = pair.views();
    let Scratch { marks, ridges, .. } = scratch;

    // Candidates of the second side must lie in the box of the first side's candidates.
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
        with_widest(pair.width, MarkWithin { hull: hull.columns(), spaces: &layers, marks });
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
            // Clip the edge to the part within reach of the other hull's face.
            let low = [a.lowered_to(&b), b.lowered_to(&a)];
            around = (around.0.min(low[0]).min(low[1]), around.1.max(low[0]).max(low[1]));
            let normal = |face: u32| view.direction(hull.planes()[face as usize].normal);
            let normals = [normal(edge.faces[0]), normal(edge.faces[1])];
            let (ends, along, bound) = ([start, end], end - start, f64::INFINITY);
            ridges.push(Ridge { edge: index, ends, along, normals, bound });
        }
        bounds = (around.0 - within, around.1 + within);
    }
}

/// A vertex and its height between the best faces of two hulls.
#[derive(Clone, Copy, Debug)]
struct Spot {
    /// In the common frame [m].
    point: DVec3,
    /// Excess of its height above the other hull's face [m].
    above: f64,
}

impl Spot {
    /// The point, or its intersection with the allowed height on the way to `other`.
    fn lowered_to(&self, other: &Self) -> DVec3 {
        // Rounding may put both too high.
        if self.above > 0.0 && other.above < self.above {
            self.point.lerp(other.point, self.above / (self.above - other.above))
        } else {
            self.point
        }
    }
}

/// Largest product of the numbers of both hulls' edges up to which all pairs are compared [1].
/// Without bounds a deep overlap of hulls of 87 vertices takes 92 instead of 43 us, and one of 2000
/// vertices 12 instead of 0.7 ms.
const FEW_PAIRS: usize = 1 << 12;

/// Sorts the first hull's gathered edges by bounds of their separations, the largest first, if
/// there are many; drops those of both hulls that separate no further than `least` [m]. A few
/// vertices of the other hull bound all of them: almost none of the pairs is looked at.
fn bound_ridges(pair: &HullPair, least: f64, scratch: &mut Scratch) {
    let Scratch { ridges, lowest, .. } = scratch;
    if ridges[0].len() * ridges[1].len() <= FEW_PAIRS {
        return;
    }
    let views = pair.views();
    for (side, ridges) in ridges.iter_mut().enumerate() {
        let points: Vec<DVec3> =
            lowest[side].iter().map(|&vertex| views[1 - side].vertex(vertex as usize)).collect();
        for ridge in ridges.iter_mut() {
            ridge.bound = ridge.most_apart(points.iter().map(|&point| point - ridge.ends[0]));
        }
        ridges.retain(|ridge| ridge.bound > least);
    }
    ridges[0].sort_by(|a, b| b.bound.total_cmp(&a.bound));
}

/// Pair of gathered edges with the largest separation, among pairs that form a face of the
/// Minkowski difference; `None` if all such pairs are parallel. Those that separate no further than
/// `least` [m] may be left out.
pub(crate) fn edge_axis(pair: &HullPair, least: f64, scratch: &mut Scratch) -> Option<EdgeAxis> {
    bound_ridges(pair, least, scratch);
    let Scratch { ridges: [first, second], ridge_columns, .. } = scratch;
    let [at, other] =
        with_widest(pair.width, FurthestEdges { ridges: [first, second], columns: ridge_columns })?;
    EdgeAxis::of(&first[at], &second[other])
}

impl EdgeAxis {
    /// Axis across two edges.
    fn of(first: &Ridge, second: &Ridge) -> Option<Self> {
        let across = first.along.cross(second.along).try_normalize()?;
        let normal = if across.dot(second.outward()) < 0.0 { -across } else { across };
        let separation = normal.dot(first.ends[0] - second.ends[0]);
        Some(Self { edges: [first.edge, second.edge], normal, separation })
    }
}
