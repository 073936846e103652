//! Overlaps of fragments at birth: crack samples of neighbours overlap slightly without any motion.
//! Such overlaps must not be resolved.

use crate::manifold::ManifoldPoint;
use crate::manifold::list::Manifolds;
use frangible_bodies::{Bodies, BodyId, Pair};
use frangible_math::check::{Check, Checked, require};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Tolerated overlaps of fragment pairs: the overlap at birth, or the smallest since.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct BirthFits {
    /// Tolerated overlap of each pair [m].
    overlaps: BTreeMap<[BodyId; 2], f64>,
}

/// Overlaps below this fraction of the pieces' distance are rounding errors, as between polyhedra.
const ROUNDING: f64 = 1e-9;

impl Check for BirthFits {
    fn check(&self) -> Checked {
        let is_depth = |&depth: &f64| depth >= 0.0 && depth.is_finite();
        require(self.overlaps.values().all(is_depth), "overlaps that are depths")
    }
}

impl BirthFits {
    /// Shifts contact points of fragments to zero overlap while the overlap stays within the
    /// tolerance of the pair. `are_newborn` is true for pairs from one body broken in this frame.
    pub fn forgive(
        &mut self,
        bodies: &Bodies,
        manifolds: &mut Manifolds,
        are_newborn: impl Fn(Pair) -> bool,
    ) {
        // Few bodies overlap since birth.
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
