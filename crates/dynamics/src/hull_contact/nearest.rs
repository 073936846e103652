//! The nearest points of two hulls that are apart.

use super::axis::View;
use super::{Feature, HullPoint};
use frangible_geometry::RigidTransform;
use glam::DVec3;

/// The nearest points of two hulls: a vertex against anything, or two of some edges. `None` if they touch or overlap, or are more than
/// `most` [m] apart.
pub(crate) fn nearest_points(
    first: &View,
    second: &View,
    edges: [&[usize]; 2],
    first_from_second: &RigidTransform,
    most: f64,
) -> Option<HullPoint> {
    let mut best: Option<HullPoint> = None;
    let mut consider = |on: [DVec3; 2], feature: Feature| {
        let gap = on[0].distance(on[1]);
        if best.is_none_or(|best| gap < best.gap) {
            best = Some(HullPoint { on, normal: DVec3::ZERO, gap, feature });
        }
    };
    for &vertex in &first.vertices_in(second.bounds(most)) {
        let point = first.vertices[vertex];
        let (distance, gradient) =
            second.hull.distance_and_gradient(first_from_second.inverse().point(point));
        let foot = point - distance.max(0.0) * first_from_second.direction(gradient);
        consider([point, foot], Feature::VertexOfFirst(vertex as u32));
    }
    for &vertex in &second.vertices_in(first.bounds(most)) {
        let point = second.vertices[vertex];
        let (distance, gradient) = first.hull.distance_and_gradient(point);
        consider([point - distance.max(0.0) * gradient, point], Feature::VertexOfSecond(vertex as u32));
    }
    for &a in edges[0] {
        for &b in edges[1] {
            if let Some(on) = between_edges(first.ends(a), second.ends(b)) {
                consider(on, Feature::Edges(a as u32, b as u32));
            }
        }
    }
    let best = best?;
    let normal = (best.on[0] - best.on[1]).try_normalize()?;
    Some(HullPoint { normal, ..best })
}

/// The nearest points of the lines through two edges; `None` if they are not inside of the edges, or the edges are parallel.
pub(crate) fn between_edges(first: [DVec3; 2], second: [DVec3; 2]) -> Option<[DVec3; 2]> {
    const PARALLEL: f64 = 1e-3;
    let (along_first, along_second) = (first[1] - first[0], second[1] - second[0]);
    let apart = first[0] - second[0];
    let (aa, bb, ab) =
        (along_first.length_squared(), along_second.length_squared(), along_first.dot(along_second));
    let determinant = aa * bb - ab * ab;
    if determinant <= PARALLEL * PARALLEL * aa * bb {
        return None;
    }
    let (a, b) = (along_first.dot(apart), along_second.dot(apart));
    let (s, t) = ((ab * b - bb * a) / determinant, (aa * b - ab * a) / determinant);
    let inside = (0.0..=1.0).contains(&s) && (0.0..=1.0).contains(&t);
    inside.then(|| [first[0] + s * along_first, second[0] + t * along_second])
}
