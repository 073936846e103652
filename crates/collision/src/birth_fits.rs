//! How fragments fit when they are born: where the samples of their cracks overlap, nothing has
//! moved, and nothing is to be parted.

use crate::manifold::ManifoldPoint;
use crate::manifold::list::Manifolds;
use frangible_bodies::{Bodies, BodyId, Pair};
use std::collections::BTreeMap;

/// Overlaps of pairs of fragments at their birth, or less: what they have parted by since is
/// forgotten.
#[derive(Clone, Debug, Default)]
pub struct BirthFits {
    /// The deepest overlap of each pair that is still forgiven [m].
    overlaps: BTreeMap<[BodyId; 2], f64>,
}

/// Overlaps that are smaller, relative to the pieces' distance from each other, are rounding:
/// polyhedra fit as exactly.
const ROUNDING: f64 = 1e-9;

impl BirthFits {
    /// Lets fragments be where they were born: their points, among those of all pairs, that overlap
    /// no more than at their birth just touch. `are_newborn` says whether a pair has come from one
    /// body in this frame.
    pub fn forgive(
        &mut self,
        bodies: &Bodies,
        manifolds: &mut Manifolds,
        are_newborn: impl Fn(Pair) -> bool,
    ) {
        // Few bodies overlap from their birth on.
        let mut fits = vec![false; bodies.len()];
        self.overlaps
            .keys()
            .flatten()
            .filter_map(|&id| bodies.index_of(id))
            .for_each(|i| fits[i] = true);
        let mut still = BTreeMap::new();
        for (pair, points) in manifolds.iter_mut() {
            let ids = [pair.first, pair.second].map(|i| bodies.ids[i]);
            let overlap =
                if fits[pair.first] && fits[pair.second] { self.overlaps.get(&ids) } else { None };
            let most = match overlap {
                Some(&most) => most,
                None if are_newborn(pair) => f64::INFINITY,
                None => continue,
            };
            let gap = |point: &ManifoldPoint| {
                let [on_first, on_second] = point.on_surfaces(bodies, pair);
                (on_first - on_second).dot(point.normal)
            };
            let gaps: Vec<f64> = points.iter().map(gap).collect();
            let deepest = gaps.iter().fold(0.0_f64, |deepest, gap| deepest.max(-gap)).min(most);
            let apart =
                bodies.poses[pair.first].position.distance(bodies.poses[pair.second].position);
            if deepest <= ROUNDING * apart {
                continue;
            }
            still.insert(ids, deepest);
            for (point, gap) in points.iter_mut().zip(gaps) {
                let forgiven = (-gap).clamp(0.0, deepest);
                point.rounding[0] -= forgiven;
                point.gap += forgiven;
            }
        }
        self.overlaps = still;
    }
}
