//! Removal of an island's excess energy: scales its relative velocities, or stops them and shortens
//! the displacements.

use crate::energy::frame_accounts::FrameAccounts;
use crate::energy::island::{Anchor, ContactFreeState, Island, energy, work_on};
use crate::energy::rigid_part::Twist;
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pose, Velocity};
use glam::DVec3;

/// Tolerance of the bisection, relative to the energy of the displacements: a micrometre per metre
/// of fall.
const CLOSE: f64 = 1e-6;

/// Maximum number of steps in search of the displacement fraction. Half of them are bisections:
/// 2^-20 of a displacement is negligible.
const MOST_STEPS: u32 = 40;

/// Takes `excess` [J] out of an island, and books the impulse and the work of its anchor. Returns
/// true if displacements were shortened.
pub(crate) fn reduce_energy(
    bodies: &mut Bodies,
    island: &mut Island,
    contact_free: &ContactFreeState,
    excess: f64,
    frame: &Frame,
    accounts: &mut FrameAccounts,
) -> bool {
    // Scale the relative velocities by the excess, or stop them and shorten the displacements.
    let motion = RelativeMotion::of(bodies, &island.members, island.anchor);
    let shortened = excess > motion.energy;
    if shortened {
        // Motion after the ballistic state is undone, and so is the anchor's work in it.
        let ids: Vec<BodyId> = island.members.iter().map(|&i| bodies.ids[i]).collect();
        let undone = work_on(&accounts.work, &ids) - work_on(&contact_free.work, &ids);
        island.allowance -= undone;
        accounts.causes.work -= undone;
        accounts.outside_angular_impulse +=
            shorten(bodies, island, contact_free, motion.momenta, frame);
    } else {
        motion.lose(bodies, &island.members, excess);
    }

    // Book the change of momenta, and its work, to the anchor.
    if island.anchor != Anchor::Free {
        let change = motion.change(bodies, &island.members);
        accounts.outside_impulse += change.0;
        accounts.outside_angular_impulse += change.1;
        let work = if shortened {
            let flown =
                momenta(bodies, &contact_free.poses, &contact_free.velocities, &island.members);
            let since = RelativeMotion { momenta: flown, ..motion };
            since.work(since.change(bodies, &island.members))
        } else {
            motion.work(change)
        };
        accounts.causes.work += work;
        island.allowance += work;
    }
    shortened
}

/// Momenta and relative energy of bodies with respect to a rigid motion.
pub(crate) struct RelativeMotion {
    rigid: Twist,
    /// Linear and angular momentum, about the world's origin.
    momenta: (DVec3, DVec3),
    /// Kinetic energy relative to the rigid motion [J].
    pub(crate) energy: f64,
}

impl RelativeMotion {
    pub(crate) fn of(bodies: &Bodies, members: &[usize], anchor: Anchor) -> Self {
        let momenta = momenta(bodies, &bodies.poses, &bodies.velocities, members);
        let rigid = rigid_part(bodies, (members, anchor), &bodies.poses, momenta);
        let energy = rigid.relative_energy(bodies, &bodies.poses, &bodies.velocities, members);
        Self { rigid, momenta, energy }
    }

    /// Reduces the relative energy by `energy` [J], at most to zero.
    pub(crate) fn lose(&self, bodies: &mut Bodies, members: &[usize], energy: f64) {
        let scale = (1.0 - energy / self.energy).sqrt();
        let mut velocities = std::mem::take(&mut bodies.velocities);
        self.rigid.scale_relative(bodies, &bodies.poses, &mut velocities, members, scale);
        bodies.velocities = velocities;
    }

    /// Change of momenta since construction.
    pub(crate) fn change(&self, bodies: &Bodies, members: &[usize]) -> (DVec3, DVec3) {
        let after = momenta(bodies, &bodies.poses, &bodies.velocities, members);
        (after.0 - self.momenta.0, after.1 - self.momenta.1)
    }

    /// Work of a change of momenta on the rigid motion [J].
    pub(crate) fn work(&self, (impulse, moment): (DVec3, DVec3)) -> f64 {
        self.rigid.work(impulse, moment)
    }
}

/// Linear momentum, and angular momentum about the world's origin.
fn momenta(
    bodies: &Bodies,
    poses: &[Pose],
    velocities: &[Velocity],
    members: &[usize],
) -> (DVec3, DVec3) {
    let mut sums = (DVec3::ZERO, DVec3::ZERO);
    for &i in members {
        let momentum = bodies.masses[i] * velocities[i].linear;
        sums.0 += momentum;
        sums.1 += poses[i].position.cross(momentum) + velocities[i].angular_momentum;
    }
    sums
}

/// Rigid motion of an island or a set of bodies, at `poses`.
fn rigid_part(
    bodies: &Bodies,
    (members, anchor): (&[usize], Anchor),
    poses: &[Pose],
    (momentum, angular_momentum): (DVec3, DVec3),
) -> Twist {
    match anchor {
        Anchor::Free => Twist::of_momentum(bodies, poses, members, momentum, angular_momentum),
        Anchor::Fixed => Twist::default(),
        Anchor::Kinematic(i) => match bodies.motions[i] {
            Motion::Kinematic { linear, angular } => {
                Twist { origin: poses[i].position, linear, angular }
            }
            Motion::Static | Motion::Dynamic => Twist::default(),
        },
    }
}

/// Reduces the island to its rigid motion, and its displacements off the ballistic path to the
/// fraction within the energy allowance. Returns the change of gravity's moment on a free island
/// [kg m^2/s]: its bodies fell elsewhere.
fn shorten(
    bodies: &mut Bodies,
    island: &Island,
    contact_free: &ContactFreeState,
    present: (DVec3, DVec3),
    frame: &Frame,
) -> DVec3 {
    let flown = momenta(bodies, &contact_free.poses, &contact_free.velocities, &island.members);
    let ends: Vec<Pose> = island.members.iter().map(|&i| bodies.poses[i]).collect();
    let (mut poses, mut velocities) =
        (std::mem::take(&mut bodies.poses), std::mem::take(&mut bodies.velocities));
    let place = |poses: &mut [Pose], part: f64| {
        for (&i, to) in island.members.iter().zip(&ends) {
            let from = &contact_free.poses[i];
            poses[i] = Pose {
                position: from.position.lerp(to.position, part),
                orientation: from.orientation.slerp(to.orientation, part),
            };
        }
    };
    let momenta_at = |part: f64| (present.0, flown.1.lerp(present.1, part));
    // Energy of the rigid motion, minus the anchor's work for it.
    let mut rigid_energy = |poses: &[Pose], part: f64| -> f64 {
        let rigid = rigid_part(bodies, (&island.members, island.anchor), poses, momenta_at(part));
        let mut total = 0.0;
        for &i in &island.members {
            velocities[i] = rigid.velocity_of(bodies, poses, i);
            total += energy(bodies, i, &poses[i], &velocities[i], frame.gravity);
        }
        if island.anchor == Anchor::Free {
            return total;
        }
        let after = momenta(bodies, poses, &velocities, &island.members);
        total - rigid.work(after.0 - flown.0, after.1 - flown.1)
    };

    // Find the largest affordable fraction, alternating secant steps (potential energy grows
    // linearly) and bisection.
    let allowed = island.allowance + island.bank;
    let mut energy_at = |part: f64| {
        place(&mut poses, part);
        (part, rigid_energy(&poses, part))
    };
    let mut high = energy_at(1.0);
    let mut low = high;
    let is_enough = high.1 <= allowed;
    if !is_enough {
        low = energy_at(0.0);
        let close = CLOSE * (high.1 - low.1);
        for step in 0..MOST_STEPS {
            let left = allowed - low.1;
            if left <= close {
                break;
            }
            let straight = (1.0 - 0.5 * CLOSE) * left / (high.1 - low.1);
            let way = if step % 2 == 0 { straight } else { 0.5 };
            let next = energy_at(low.0 + way * (high.0 - low.0));
            if next.1 <= allowed { low = next } else { high = next }
        }
    }
    place(&mut poses, low.0);
    let at_end = momenta_at(low.0);
    let rigid = rigid_part(bodies, (&island.members, island.anchor), &poses, at_end);
    for &i in &island.members {
        velocities[i] = rigid.velocity_of(bodies, &poses, i);
    }
    (bodies.poses, bodies.velocities) = (poses, velocities);
    if island.anchor == Anchor::Free { at_end.1 - present.1 } else { DVec3::ZERO }
}
