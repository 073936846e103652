//! An island of touching bodies: energy allowance, anchor, and energies of its bodies.

use crate::energy::frame_accounts::FrameAccounts;
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pair, Pose, Velocity, accelerate};
use frangible_math::threads;
use glam::DVec3;
use std::collections::BTreeMap;

/// The frame with ballistic motion after impacts: its energy is at most the opening's, plus the
/// work up to the impacts.
#[derive(Clone, Debug)]
pub struct ContactFreeState {
    /// Poses at the frame's end.
    pub poses: Vec<Pose>,
    /// Velocities at the frame's end.
    pub velocities: Vec<Velocity>,
    /// Work of each kinematic body on each dynamic body, up to the impacts [J].
    pub work: BTreeMap<[BodyId; 2], f64>,
}

impl ContactFreeState {
    /// Contact-free motion to `poses`, with the present velocities and the work to date.
    pub fn new(bodies: &Bodies, poses: Vec<Pose>, accounts: &FrameAccounts, frame: &Frame) -> Self {
        let velocities = accelerate(bodies, &bodies.velocities, frame.dt, frame);
        Self { poses, velocities, work: accounts.work.clone() }
    }
}

/// An island of touching bodies.
pub(crate) struct Island {
    /// Dense indices of the living dynamic bodies.
    pub(crate) members: Vec<usize>,
    /// The body outside the island that holds or carries it.
    pub(crate) anchor: Anchor,
    /// Work of penetration recovery that may remain [J].
    pub(crate) recovered: f64,
    /// Its pairs with such work, indices into [`FrameAccounts`]'s list.
    pub(crate) recoveries: Vec<usize>,
    /// Allowed energy at the end of the frame, without the bank [J].
    pub(crate) allowance: f64,
    /// [J]
    pub(crate) bank: f64,
    /// Indices of its contacts in [`FrameAccounts::gains`].
    pub(crate) gains: Vec<usize>,
}

/// Static and kinematic bodies in contact with an island.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Anchor {
    Free,
    Kinematic(usize),
    Fixed,
}

impl Anchor {
    /// Anchor by an immovable body.
    pub(crate) fn of(bodies: &Bodies, i: usize) -> Self {
        if matches!(bodies.motions[i], Motion::Kinematic { .. }) {
            Self::Kinematic(i)
        } else {
            Self::Fixed
        }
    }
}

/// Kinetic and potential energy of a pair's dynamic bodies at `poses`, with their present
/// velocities [J].
pub(crate) fn pair_energy(bodies: &Bodies, pair: Pair, poses: &[Pose], gravity: DVec3) -> f64 {
    let dynamic =
        [pair.first, pair.second].into_iter().filter(|&i| !bodies.inertias[i].is_infinite());
    dynamic.map(|i| energy(bodies, i, &poses[i], &bodies.velocities[i], gravity)).sum()
}

/// Kinetic and potential energy of a dynamic body [J].
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

/// Potential energy of a dynamic body [J].
pub(crate) fn potential(bodies: &Bodies, i: usize, gravity: DVec3) -> f64 {
    -bodies.masses[i] * gravity.dot(bodies.poses[i].position)
}

/// Kinetic and potential energy of each body, 0 for immovable bodies [J].
pub(crate) fn energies(bodies: &Bodies, frame: &Frame) -> Vec<f64> {
    let of = |i: usize| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity);
    threads::list(bodies.len(), |i| if bodies.inertias[i].is_infinite() { 0.0 } else { of(i) })
}

/// Kinetic plus absolute potential energy, from the total `energy`: the scale of rounding errors
/// [J].
pub(crate) fn magnitude(bodies: &Bodies, i: usize, energy: f64, gravity: DVec3) -> f64 {
    let potential = potential(bodies, i, gravity);
    energy - potential + potential.abs()
}

/// Work of kinematic bodies on the bodies `ids` [J].
pub(crate) fn work_on(work: &BTreeMap<[BodyId; 2], f64>, ids: &[BodyId]) -> f64 {
    const FIRST: BodyId = BodyId { index: 0, generation: 0 };
    const LAST: BodyId = BodyId { index: u32::MAX, generation: u32::MAX };
    if work.is_empty() {
        return 0.0;
    }
    ids.iter().flat_map(|&id| work.range([id, FIRST]..=[id, LAST])).map(|(_, work)| work).sum()
}
