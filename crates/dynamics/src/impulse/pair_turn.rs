//! The rigid rotation that gives a pair back its angular momentum.
//!
//! The paper's method moves bodies along other velocities than those they keep, and collides them
//! where they will be. Equal and opposite impulses keep the sum of linear momenta through all of
//! that, but the orbital part of angular momentum, x cross m v, goes wrong by what the positions
//! and the velocities disagree. Turning the pair rigidly about its common centre of mass makes up
//! for it: the relative velocity at their contact stays as it is, and so does the sum of linear
//! momenta.

use crate::impulse::collision_impulse::Impulse;
use frangible_bodies::{Bodies, Pair};
use frangible_geometry::parallel_axis;
use glam::DVec3;

/// The impulses that add `angular_momentum` [kg m^2/s] to a pair of dynamic bodies at the poses of
/// `bodies`, by turning it rigidly; one for each body, with opposite linear parts.
pub(crate) fn turn_pair(bodies: &Bodies, pair: Pair, angular_momentum: DVec3) -> [Impulse; 2] {
    // Inertia of the two about their common centre of mass.
    let [first, second] = [pair.first, pair.second];
    let [tensor_first, tensor_second] =
        [first, second].map(|i| bodies.inertias[i].tensor(bodies.poses[i].orientation));
    let (mass_first, mass_second) = (bodies.masses[first], bodies.masses[second]);
    let reduced_mass = mass_first * mass_second / (mass_first + mass_second);
    let apart = bodies.poses[first].position - bodies.poses[second].position;
    let composite = tensor_first + tensor_second + parallel_axis(reduced_mass, apart);

    // One angular velocity for both, and the orbital motion that goes with it.
    let turn = composite.inverse() * angular_momentum;
    let orbital = reduced_mass * turn.cross(apart);
    let spin = [tensor_first * turn, tensor_second * turn];

    // What the solution of the 3 x 3 system leaves over goes to the first body's spin: the sum is
    // exact to rounding.
    let rest = angular_momentum - (spin[0] + spin[1] + apart.cross(orbital));
    [
        Impulse { linear: orbital, angular: spin[0] + rest },
        Impulse { linear: -orbital, angular: spin[1] },
    ]
}
