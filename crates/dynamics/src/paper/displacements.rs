//! Displacements off the velocities: effect of the position update on angular momentum, and its
//! compensation.

use crate::energy::frame_accounts::{EnergyGain, FrameAccounts};
use crate::impulse::collision_impulse::apply_impulse;
use crate::impulse::pair_turn::turn_pair;
use frangible_bodies::{Bodies, Inertia, Pair};
use glam::DVec3;
use std::collections::BTreeMap;

/// Effect of the position update on each pair, as displacements off the paths of the final
/// velocities.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Displacements {
    gains: BTreeMap<Pair, Gain>,
}

/// Gains of a pair.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Gain {
    /// Sum of `displacement cross m v` [kg m^2/s].
    angular_momentum: DVec3,
    /// Kinetic and potential energy [J].
    energy: f64,
    /// Point of the last displacement, world frame [m].
    point: DVec3,
}

/// A displacement of a pair at a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Push {
    /// Point of the push, world frame [m].
    pub point: DVec3,
    /// Displacement of the first body times its mass; the second body moves by the opposite [kg m].
    pub amount: DVec3,
    /// Change of the pair's energy, at its final velocities [J].
    pub energy: f64,
}

impl Displacements {
    /// Books the displacement of a pair, limited to movable bodies of `inertias`.
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

    /// Restores the angular momentum of each pair of dynamic bodies by a rigid rotation; books the
    /// share of static and kinematic bodies, and gains.
    pub fn restore_angular_momentum(&self, bodies: &mut Bodies, accounts: &mut FrameAccounts) {
        for (&pair, gain) in &self.gains {
            accounts.link(bodies, pair);
            let indices = [pair.first, pair.second];
            if gain.energy > 0.0 {
                let ids = indices.map(|i| bodies.ids[i]);
                accounts.gains.push(EnergyGain {
                    ids,
                    point: gain.point,
                    energy: gain.energy,
                    net: 0.0,
                });
            }
            if indices.iter().any(|&i| bodies.inertias[i].is_infinite()) {
                accounts.outside_angular_impulse += gain.angular_momentum;
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
