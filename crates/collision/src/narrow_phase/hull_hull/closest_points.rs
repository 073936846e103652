//! Closest points of two separated hulls.

use crate::narrow_phase::hull_hull::feature_scan::PARALLEL;
use crate::narrow_phase::hull_hull::hull_pair::HullPair;
use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::placement::Ridge;
use crate::narrow_phase::hull_hull::separating_axis::FaceAxis;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;

/// Closest points of two hulls: a vertex against any feature, or two of the given edges. `None` if
/// the hulls touch or overlap, or are more than `most` [m] apart. `axes` are the best faces.
pub(crate) fn nearest_points(
    pair: &HullPair,
    axes: &[FaceAxis; 2],
    ridges: &[Vec<Ridge>; 2],
    most: f64,
) -> Option<HullPoint> {
    let mut best: Option<HullPoint> = None;
    let mut consider = |on: [DVec3; 2], feature: Feature| {
        let gap = on[0].distance(on[1]);
        if best.is_none_or(|best| gap < best.gap) {
            best = Some(HullPoint { on, normal: DVec3::ZERO, gap, feature });
        }
        best.map_or(most, |best| best.gap.min(most))
    };

    let [first, second] = pair.hulls;
    let mut least = most;
    for (vertex, &point) in first.vertices().iter().enumerate() {
        if let Some(foot) = foot_on(second, &axes[1], pair.second_from_first.point(point), least) {
            let on = [point, pair.first_from_second.point(foot)];
            least = consider(on, Feature::VertexOfFirst(vertex as u32));
        }
    }
    for (vertex, &point) in second.vertices().iter().enumerate() {
        let point = pair.first_from_second.point(point);
        if let Some(foot) = foot_on(first, &axes[0], point, least) {
            least = consider([foot, point], Feature::VertexOfSecond(vertex as u32));
        }
    }
    for a in &ridges[0] {
        for b in &ridges[1] {
            if let Some(on) = between_edges(a.ends, b.ends) {
                consider(on, Feature::Edges(a.edge as u32, b.edge as u32));
            }
        }
    }
    let best = best.filter(|best| best.gap <= most)?;
    let normal = (best.on[0] - best.on[1]).try_normalize()?;
    Some(HullPoint { normal, ..best })
}

/// Closest point of a hull to a point, both in its frame; `None` beyond `most` [m].
fn foot_on(hull: &Hull, axis: &FaceAxis, point: DVec3, most: f64) -> Option<DVec3> {
    // Almost all points are too high above the best face.
    let is_above = |plane: &HalfSpace| plane.distance(point) > most;
    if is_above(&hull.planes()[axis.face]) || hull.planes().iter().any(is_above) {
        return None;
    }
    let (distance, gradient) = hull.distance_and_gradient(point);
    (distance <= most).then(|| point - distance.max(0.0) * gradient)
}

/// Closest points of the lines through two edges; `None` if outside the edges, or if the edges are
/// parallel.
pub(crate) fn between_edges(first: [DVec3; 2], second: [DVec3; 2]) -> Option<[DVec3; 2]> {
    let (along_first, along_second) = (first[1] - first[0], second[1] - second[0]);
    let apart = first[0] - second[0];
    let (aa, bb, ab) = (
        along_first.length_squared(),
        along_second.length_squared(),
        along_first.dot(along_second),
    );
    let determinant = aa * bb - ab * ab;
    if determinant <= PARALLEL * PARALLEL * aa * bb {
        return None;
    }
    let (a, b) = (along_first.dot(apart), along_second.dot(apart));
    let (s, t) = ((ab * b - bb * a) / determinant, (aa * b - ab * a) / determinant);
    let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    inside.then(|| [first[0] + s * along_first, second[0] + t * along_second])
}
