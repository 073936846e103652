//! Displacements against the velocities: what the position update does to angular momentum, and how it is made up for.

use crate::impulse::apply_impulse;
use crate::pair::Pair;
use crate::pair_rotation::turn_pair;
use crate::{Bodies, Inertia, Tally};
use glam::DVec3;
use std::collections::BTreeMap;

/// For each pair, the angular momentum that it gained because the position update moved its bodies off the paths of the
/// velocities that they keep: the sum of `displacement cross m v` [kg m^2/s].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Displacements {
    gains: BTreeMap<Pair, DVec3>,
}

impl Displacements {
    /// Books that `push` over its mass [kg m] displaced the first body of a pair, and its opposite the second, as far as
    /// `inertias` let them move.
    pub fn book(&mut self, bodies: &Bodies, pair: Pair, push: DVec3, inertias: &[Inertia]) {
        let gain = self.gains.entry(pair).or_insert(DVec3::ZERO);
        for (i, push) in [(pair.first, push), (pair.second, -push)] {
            if !inertias[i].is_infinite() {
                *gain += push.cross(bodies.velocities[i].linear);
            }
        }
    }

    /// Gives each pair of dynamic bodies back what it gained, by turning it rigidly; what static and kinematic bodies gave
    /// is booked.
    pub fn restore_angular_momentum(&self, bodies: &mut Bodies, tally: &mut Tally) {
        for (&pair, &gain) in &self.gains {
            tally.link(bodies, pair);
            let indices = [pair.first, pair.second];
            if indices.iter().any(|&i| bodies.inertias[i].is_infinite()) {
                tally.outside_angular_impulse += gain;
                continue;
            }
            for (i, turn) in indices.into_iter().zip(turn_pair(bodies, pair, -gain)) {
                bodies.velocities[i] =
                    apply_impulse(&bodies.velocities[i], bodies.inertias[i].inverse_mass, &turn);
            }
        }
    }
}
