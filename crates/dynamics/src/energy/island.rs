//! An island of touching bodies: what it may have, what holds it, and energies of its bodies.

use crate::energy::tally::Tally;
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pair, Pose, Velocity, accelerate};
use frangible_math::threads;
use glam::DVec3;
use std::collections::BTreeMap;

/// The frame as it would be if bodies flew on after they were struck: its energy is no more than
/// the opening's, plus the work until then.
#[derive(Clone, Debug)]
pub struct Ballistic {
    /// At its end.
    pub poses: Vec<Pose>,
    /// At its end.
    pub velocities: Vec<Velocity>,
    /// Of each kinematic body on each dynamic body, until then [J].
    pub work: BTreeMap<[BodyId; 2], f64>,
}

impl Ballistic {
    /// To `poses`, with the velocities that the bodies have and the work so far.
    pub fn new(bodies: &Bodies, poses: Vec<Pose>, tally: &Tally, frame: &Frame) -> Self {
        let velocities = accelerate(bodies, &bodies.velocities, frame.dt, frame);
        Self { poses, velocities, work: tally.work.clone() }
    }
}

/// An island of touching bodies.
pub(crate) struct Island {
    /// Dense indices of its living dynamic bodies.
    pub(crate) members: Vec<usize>,
    /// What moves it from outside, if anything does.
    pub(crate) anchor: Anchor,
    /// What closing its overlaps did [J].
    pub(crate) recovered: f64,
    /// The energy that it may have at the end of the frame, without the bank [J].
    pub(crate) allowance: f64,
    /// [J]
    pub(crate) bank: f64,
    /// Of its contacts, by their place in the tally.
    pub(crate) debts: Vec<usize>,
}

/// What an island touches besides itself.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Anchor {
    Free,
    Kinematic(usize),
    Fixed,
}

impl Anchor {
    /// A body that impulses do not move.
    pub(crate) fn of(bodies: &Bodies, i: usize) -> Self {
        if matches!(bodies.motions[i], Motion::Kinematic { .. }) {
            Self::Kinematic(i)
        } else {
            Self::Fixed
        }
    }
}

/// Kinetic and potential energy of the dynamic bodies of a pair at `poses`, with the velocities
/// that they have [J].
pub(crate) fn pair_energy(bodies: &Bodies, pair: Pair, poses: &[Pose], gravity: DVec3) -> f64 {
    let dynamic =
        [pair.first, pair.second].into_iter().filter(|&i| !bodies.inertias[i].is_infinite());
    dynamic.map(|i| energy(bodies, i, &poses[i], &bodies.velocities[i], gravity)).sum()
}

/// Kinetic and potential energy of one dynamic body [J].
pub(crate) fn energy(
    bodies: &Bodies,
    i: usize,
    pose: &Pose,
    velocity: &Velocity,
    gravity: DVec3,
) -> f64 {
    let mass = bodies.masses[i];
    let spin = bodies.inertias[i].rotational_energy(pose.orientation, velocity.angular_momentum);
    0.5 * mass * velocity.linear.length_squared() + spin - mass * gravity.dot(pose.position)
}

/// Kinetic and potential energy of each body, 0 of those that impulses do not move [J].
pub(crate) fn energies(bodies: &Bodies, frame: &Frame) -> Vec<f64> {
    let of = |i: usize| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity);
    threads::list(bodies.len(), |i| if bodies.inertias[i].is_infinite() { 0.0 } else { of(i) })
}

/// The sum of its kinetic and of the size of its potential energy, by the sum of both: what
/// rounding is relative to [J].
pub(crate) fn magnitude(bodies: &Bodies, i: usize, energy: f64, gravity: DVec3) -> f64 {
    let potential = -bodies.masses[i] * gravity.dot(bodies.poses[i].position);
    energy - potential + potential.abs()
}

/// The work of kinematic bodies on some bodies [J].
pub(crate) fn work_on(work: &BTreeMap<[BodyId; 2], f64>, ids: &[BodyId]) -> f64 {
    const FIRST: BodyId = BodyId { index: 0, generation: 0 };
    const LAST: BodyId = BodyId { index: u32::MAX, generation: u32::MAX };
    if work.is_empty() {
        return 0.0;
    }
    ids.iter().flat_map(|&id| work.range([id, FIRST]..=[id, LAST])).map(|(_, work)| work).sum()
}
