//! Flat contacts of many points: of several parts, samples or triangles.

use crate::manifold::{MOST_POINTS, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::reduction::{FEW_POINTS, reduce};
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::relative_motion::Placed;
use glam::DVec3;

/// Normals within this cosine belong to the same flat contact, which needs four points for any
/// number of parts.
const FLAT: f64 = 0.9998;

/// Maximum difference of separations within a flat contact, relative to the smaller body's size.
const LEVEL: f64 = 5e-3;

/// Reduces each flat contact to as many points as two hulls, or a hull on the ground, would have.
pub(crate) fn few(
    pair_motion: &PairMotion,
    points: &[ManifoldPoint],
    scratch: &mut Scratch,
) -> Vec<ManifoldPoint> {
    let (size, [first, second]) = (pair_motion.size, pair_motion.paths);
    let is_ground = |body: Placed| {
        matches!(ConvexShape::of(body.shape), ConvexShape::Ground(_) | ConvexShape::Mesh(_))
    };
    let most =
        if pair_motion.placed().into_iter().any(is_ground) { MOST_POINTS } else { FEW_POINTS };
    // A mesh's own points are those of features, and what is higher above another than beside it
    // touches later.
    let is_mesh = |body: Placed| matches!(ConvexShape::of(body.shape), ConvexShape::Mesh(_));
    let is_on_mesh = pair_motion.placed().into_iter().any(is_mesh);
    let level = if is_on_mesh { f64::INFINITY } else { LEVEL * size };
    let mut flats: Vec<(DVec3, f64, Vec<HullPoint>)> = Vec::new();
    for (index, point) in points.iter().enumerate() {
        let on = point.on_surfaces_at([&first.start, &second.start]);
        let gap = (on[0] - on[1]).dot(point.normal);
        let feature = Feature::VertexOfFirst(index as u32);
        let candidate = HullPoint { on, normal: point.normal, gap, feature };
        let same = |flat: &&mut (DVec3, f64, Vec<HullPoint>)| {
            flat.0.dot(point.normal) > FLAT && (flat.1 - gap).abs() <= level
        };
        match flats.iter_mut().find(same) {
            Some(flat) => flat.2.push(candidate),
            None => flats.push((point.normal, gap, vec![candidate])),
        }
    }
    for (normal, _, candidates) in &mut flats {
        reduce(candidates, &mut scratch.spare, most, (*normal, PREFERENCE * size));
    }
    let index = |point: HullPoint| match point.feature {
        Feature::VertexOfFirst(index) => Some(index as usize),
        Feature::VertexOfSecond(_) | Feature::Edges(..) => None,
    };
    flats.into_iter().flat_map(|flat| flat.2).filter_map(index).map(|index| points[index]).collect()
}
