//! What an island pays: its relative velocities are scaled down, or stopped and its displacements shortened.

use crate::ledger::{Anchor, Ballistic, Island, energy, work_on};
use crate::rigid_part::Twist;
use crate::{Bodies, BodyId, Frame, Motion, Pose, Tally, Velocity};
use glam::DVec3;

/// Halvings of the interval in which the displacements' part is sought: 2^-30 of a displacement is no displacement.
const HALVINGS: u32 = 30;

/// Takes `excess` [J] out of an island, and books what its anchor has to do with it. Tells whether displacements had to be shortened.
pub(crate) fn take_out(
    bodies: &mut Bodies,
    island: &mut Island,
    flight: &Ballistic,
    excess: f64,
    frame: &Frame,
    tally: &mut Tally,
) -> bool {
    // Scale the relative velocities so that the excess is gone, or stop them and shorten the displacements.
    let before = momenta(bodies, &bodies.poses, &bodies.velocities, &island.members);
    let rigid = rigid_part(bodies, island, &bodies.poses, before);
    let relative = rigid.relative_energy(bodies, &bodies.poses, &bodies.velocities, &island.members);
    let shortened = excess > relative;
    if shortened {
        // What came after the flight never happened, and the anchor did no work by it.
        let ids: Vec<BodyId> = island.members.iter().map(|&i| bodies.ids[i]).collect();
        let undone = work_on(&tally.work, &ids) - work_on(&flight.work, &ids);
        island.allowance -= undone;
        tally.causes.work -= undone;
        shorten(bodies, island, flight, before, frame);
    } else {
        let scale = (1.0 - excess / relative).sqrt();
        let mut velocities = std::mem::take(&mut bodies.velocities);
        rigid.scale_relative(bodies, &bodies.poses, &mut velocities, &island.members, scale);
        bodies.velocities = velocities;
    }

    // What holds or carries the island gave it the change of its momenta, and did work by it.
    if island.anchor != Anchor::Free {
        let after = momenta(bodies, &bodies.poses, &bodies.velocities, &island.members);
        let (impulse, moment) = (after.0 - before.0, after.1 - before.1);
        tally.outside_impulse += impulse;
        tally.outside_angular_impulse += moment;
        let work = if shortened {
            let flown = momenta(bodies, &flight.poses, &flight.velocities, &island.members);
            rigid.work(after.0 - flown.0, after.1 - flown.1)
        } else {
            rigid.work(impulse, moment)
        };
        tally.causes.work += work;
        island.allowance += work;
    }
    shortened
}

/// Linear and angular momentum, the latter about the world's origin.
fn momenta(bodies: &Bodies, poses: &[Pose], velocities: &[Velocity], members: &[usize]) -> (DVec3, DVec3) {
    let mut sums = (DVec3::ZERO, DVec3::ZERO);
    for &i in members {
        let momentum = bodies.masses[i] * velocities[i].linear;
        sums.0 += momentum;
        sums.1 += poses[i].position.cross(momentum) + velocities[i].angular_momentum;
    }
    sums
}

/// The rigid motion that an island keeps, with the bodies at `poses`.
fn rigid_part(
    bodies: &Bodies,
    island: &Island,
    poses: &[Pose],
    (momentum, angular_momentum): (DVec3, DVec3),
) -> Twist {
    match island.anchor {
        Anchor::Free => Twist::of_momentum(bodies, poses, &island.members, momentum, angular_momentum),
        Anchor::Fixed => Twist::default(),
        Anchor::Kinematic(i) => match bodies.motions[i] {
            Motion::Kinematic { linear, angular } => Twist { origin: poses[i].position, linear, angular },
            Motion::Static | Motion::Dynamic => Twist::default(),
        },
    }
}

/// Leaves the island its rigid motion only, and as much of its displacements off the flight as its energy allows.
fn shorten(bodies: &mut Bodies, island: &Island, flight: &Ballistic, present: (DVec3, DVec3), frame: &Frame) {
    let flown = momenta(bodies, &flight.poses, &flight.velocities, &island.members);
    let mut poses = bodies.poses.clone();
    let place = |poses: &mut [Pose], part: f64| {
        for &i in &island.members {
            let (from, to) = (&flight.poses[i], &bodies.poses[i]);
            poses[i] = Pose {
                position: from.position.lerp(to.position, part),
                orientation: from.orientation.slerp(to.orientation, part),
            };
        }
    };
    // The energy of the rigid motion, less the work that its anchor does to bring it about.
    let mut velocities = bodies.velocities.clone();
    let mut rigid_energy = |poses: &[Pose]| -> f64 {
        let rigid = rigid_part(bodies, island, poses, present);
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

    // The largest part that the allowance pays for, to the precision of the halvings.
    let allowed = island.allowance + island.bank;
    let (mut low, mut high) = (0.0, 1.0);
    if rigid_energy(&poses) <= allowed {
        low = 1.0;
    } else {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            place(&mut poses, middle);
            if rigid_energy(&poses) <= allowed { low = middle } else { high = middle }
        }
    }
    place(&mut poses, low);
    let rigid = rigid_part(bodies, island, &poses, present);
    for &i in &island.members {
        bodies.velocities[i] = rigid.velocity_of(bodies, &poses, i);
    }
    bodies.poses = poses;
}
