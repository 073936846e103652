//! Least overlap of two cores: all normals of faces and across edges, and finer ones around the best
//! where rims are edges.

use crate::oracle::body::{Around, Convex, Features};
use glam::DVec3;

/// Valleys that are followed down, by the values of the first steps: how many so far, and the cosine
/// within which normals are in one valley. Some lie side by side, some on other sides.
const VALLEYS: [(usize, f64); 3] = [(4, 0.99999), (8, 0.999), (16, 0.98)];

/// Steps on rims: the first is half of those everywhere, and each makes them smaller, down to 1e-8.
const FIRST_STEP: f64 = 0.1;
const SMALLER: f64 = 0.3;
const ROUNDS: usize = 14;

/// Separation along the best normal [m], negative for overlap, and this normal, from the second to
/// the first.
pub(crate) fn least_overlap(first: &Convex, second: &Convex) -> (f64, DVec3) {
    let value = |normal: DVec3| (first.support(-normal) - second.support(normal)).dot(normal);
    let mut tried: Vec<(f64, DVec3)> = Vec::new();
    let features = [first.features(None), second.features(None)];
    each_normal(&features, |normal| tried.push((value(normal), normal)));
    if tried.is_empty() {
        // Two points.
        let normal = DVec3::Y;
        return (value(normal), normal);
    }
    if !first.is_round() && !second.is_round() {
        return tried.into_iter().fold((f64::NEG_INFINITY, DVec3::Y), better);
    }
    tried.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut valleys: Vec<(f64, DVec3)> = Vec::new();
    for (most, one_valley) in VALLEYS {
        for &(value, normal) in &tried {
            if valleys.len() < most && valleys.iter().all(|known| known.1.dot(normal) < one_valley)
            {
                valleys.push((value, normal));
            }
        }
    }
    let mut best = (f64::NEG_INFINITY, DVec3::Y);
    for mut here in valleys {
        let mut step = FIRST_STEP;
        for _ in 0..ROUNDS {
            let towards = here.1;
            let features = [
                first.features(Some(Around { towards: -towards, step })),
                second.features(Some(Around { towards, step })),
            ];
            each_normal(&features, |normal| here = better(here, (value(normal), normal)));
            step *= SMALLER;
        }
        best = better(best, here);
    }
    best
}

pub(crate) fn better(a: (f64, DVec3), b: (f64, DVec3)) -> (f64, DVec3) {
    if b.0 > a.0 { b } else { a }
}

/// Normals from the second to the first: of faces of either, and across an edge of each.
pub(crate) fn each_normal(features: &[Features; 2], mut visit: impl FnMut(DVec3)) {
    features[0].normals.iter().for_each(|&normal| visit(-normal));
    features[1].normals.iter().for_each(|&normal| visit(normal));
    for &a in &features[0].edges {
        for &b in &features[1].edges {
            let across = a.cross(b);
            if across.length_squared() <= 1e-24 * a.length_squared() * b.length_squared() {
                continue;
            }
            let normal = across.normalize();
            visit(normal);
            visit(-normal);
        }
    }
}
