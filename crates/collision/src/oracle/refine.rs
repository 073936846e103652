//! The best normal near a known one, by brute force over all corners, edges, faces and rims that
//! bodies turn to each other there: where rounding has ended the search for nearest points.
//!
//! A normal of nearest points is the way between two corners, the way from a corner across an edge,
//! across two edges, or a face's. Each is formed from few coordinates, and its separation is that of
//! the supports: a normal that rounding has spoiled separates less than another one, and is left.

use crate::oracle::body::{Around, Convex, Features};
use crate::oracle::depth::{better, each_normal};
use glam::DVec3;

/// Steps on rims, and the angles within which features are near [rad]: the first is about that of
/// unfinished searches, the last leaves 1e-12 of a rim's radius.
const FIRST_STEP: f64 = 0.03;
const SMALLER: f64 = 0.3;
const ROUNDS: usize = 14;

/// Separation of the cores along the best normal [m], and this normal, from the second to the first.
pub(crate) fn refine(first: &Convex, second: &Convex, start: (f64, DVec3)) -> (f64, DVec3) {
    let value = |normal: DVec3| (first.support(-normal) - second.support(normal)).dot(normal);
    let (mut best, mut step) = (start, FIRST_STEP);
    for (body, sign) in [(first, -1.0), (second, 1.0)] {
        for normal in body.features(None).normals {
            best = better(best, (value(sign * normal), sign * normal));
        }
    }
    for _ in 0..ROUNDS {
        let towards = best.1;
        let features = [
            first.features(Some(Around { towards: -towards, step })),
            second.features(Some(Around { towards, step })),
        ];
        let mut offer = |normal: DVec3| best = better(best, (value(normal), normal));
        each_normal(&features, &mut offer);
        each_way(&features, &mut offer);
        step *= SMALLER;
    }
    best
}

/// Ways between corners, and from corners across edges of either body.
fn each_way(features: &[Features; 2], mut visit: impl FnMut(DVec3)) {
    let edges = || features.iter().flat_map(|features| features.edges.iter());
    for a in &features[0].points {
        for b in &features[1].points {
            let between = *a - *b;
            for way in [Some(between)].into_iter().chain(edges().map(|e| across(between, *e))) {
                let Some(normal) = way.and_then(DVec3::try_normalize) else { continue };
                visit(normal);
                visit(-normal);
            }
        }
    }
}

/// The part of a way across an edge, without what rounding leaves along it.
fn across(way: DVec3, edge: DVec3) -> Option<DVec3> {
    let along = edge.try_normalize()?;
    let rough = way - way.dot(along) * along;
    let across = rough.try_normalize()?;
    Some(across - across.dot(along) * along)
}
