//! Displacements against the velocities: what the position update does to angular momentum, and how
//! it is made up for.

use crate::energy::tally::{Debt, Tally};
use crate::impulse::collision_impulse::apply_impulse;
use crate::impulse::pair_turn::turn_pair;
use frangible_bodies::{Bodies, Inertia, Pair};
use glam::DVec3;
use std::collections::BTreeMap;

/// What the position update did to each pair by moving its bodies off the paths of the velocities
/// that they keep.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Displacements {
    gains: BTreeMap<Pair, Gain>,
}

/// What a pair gained.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gain {
    /// The sum of `displacement cross m v` [kg m^2/s].
    angular_momentum: DVec3,
    /// Of kinetic and potential energy [J].
    energy: f64,
    /// Where it was pushed last, in the world frame [m].
    point: DVec3,
}

/// How a pair was pushed apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Push {
    /// Where, in the world frame [m].
    pub point: DVec3,
    /// Over its mass, how far the first body was displaced; the second by the opposite [kg m].
    pub amount: DVec3,
    /// What it added to the pair's energy, at the velocities that it keeps [J].
    pub energy: f64,
}

impl Displacements {
    /// Books that a pair was pushed, as far as `inertias` let its bodies move.
    pub(crate) fn book(&mut self, bodies: &Bodies, pair: Pair, push: &Push, inertias: &[Inertia]) {
        let gain = self.gains.entry(pair).or_default();
        for (i, amount) in [(pair.first, push.amount), (pair.second, -push.amount)] {
            if !inertias[i].is_infinite() {
                gain.angular_momentum += amount.cross(bodies.velocities[i].linear);
            }
        }
        gain.energy += push.energy;
        gain.point = push.point;
    }

    /// Gives each pair of dynamic bodies back the angular momentum that it gained, by turning it
    /// rigidly; what static and kinematic bodies gave is booked, and who owes energy.
    pub fn restore_angular_momentum(&self, bodies: &mut Bodies, tally: &mut Tally) {
        for (&pair, gain) in &self.gains {
            tally.link(bodies, pair);
            let indices = [pair.first, pair.second];
            if gain.energy > 0.0 {
                let ids = indices.map(|i| bodies.ids[i]);
                tally.debts.push(Debt { ids, point: gain.point, energy: gain.energy, net: 0.0 });
            }
            if indices.iter().any(|&i| bodies.inertias[i].is_infinite()) {
                tally.outside_angular_impulse += gain.angular_momentum;
                continue;
            }
            for (i, turn) in
                indices.into_iter().zip(turn_pair(bodies, pair, -gain.angular_momentum))
            {
                bodies.velocities[i] =
                    apply_impulse(&bodies.velocities[i], bodies.inertias[i].inverse_mass, &turn);
            }
        }
    }
}
