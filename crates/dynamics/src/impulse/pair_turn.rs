//! Rigid rotation that restores a pair's angular momentum.
//!
//! The paper's method moves bodies along other velocities than their final velocities, and collides
//! them at predicted poses. Equal and opposite impulses keep the total linear momentum, but the
//! orbital part of angular momentum, x cross m v, is off by the mismatch of positions and
//! velocities. A rigid rotation of the pair about its common centre of mass restores it: the
//! relative velocity at the contact and the total linear momentum stay.

use crate::impulse::collision_impulse::Impulse;
use frangible_bodies::{Bodies, Pair};
use frangible_geometry::parallel_axis;
use glam::DVec3;

/// Impulses that add `angular_momentum` [kg m^2/s] to a pair of dynamic bodies at the poses of
/// `bodies` by a rigid rotation; one per body, with opposite linear parts.
pub(crate) fn turn_pair(bodies: &Bodies, pair: Pair, angular_momentum: DVec3) -> [Impulse; 2] {
    // Inertia of both bodies about their common centre of mass.
    let [first, second] = [pair.first, pair.second];
    let [tensor_first, tensor_second] =
        [first, second].map(|i| bodies.inertias[i].tensor(bodies.poses[i].orientation));
    let (mass_first, mass_second) = (bodies.masses[first], bodies.masses[second]);
    let reduced_mass = mass_first * mass_second / (mass_first + mass_second);
    let apart = bodies.poses[first].position - bodies.poses[second].position;
    let composite = tensor_first + tensor_second + parallel_axis(reduced_mass, apart);

    // One angular velocity for both, and the matching orbital motion.
    let turn = composite.inverse() * angular_momentum;
    let orbital = reduced_mass * turn.cross(apart);
    let spin = [tensor_first * turn, tensor_second * turn];

    // The residual of the 3 x 3 solve goes to the first body's spin: the sum is exact to rounding.
    let rest = angular_momentum - (spin[0] + spin[1] + apart.cross(orbital));
    [
        Impulse { linear: orbital, angular: spin[0] + rest },
        Impulse { linear: -orbital, angular: spin[1] },
    ]
}
