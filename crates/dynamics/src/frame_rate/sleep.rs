//! Islands that sleep, where the scene lets them: what stands on something that does not move, and
//! has been slow for long enough, stays where it is. It is still looked whom it may touch; so
//! whatever comes near wakes it before it touches, and whatever goes, as a support that breaks,
//! wakes what it held.

use super::constraints::NEAR;
use crate::energy::island::energy;
use crate::energy::tally::{Cause, Tally};
use frangible_bodies::{Bodies, BodyId, Drowsiness, Frame, Motion, Pair, Velocity};
use frangible_collision::{Carried, Manifold, ManifoldPoint, Part};
use glam::DVec3;

/// Speed [m/s] below which a body is slow, its centre and what its turning adds at its rim
/// together. Heaps fidget below it; on earth what begins to slide passes it within [`SLOW_FOR`],
/// unless its slope is less than 0.06 degrees too steep. It does not scale with the scene.
const SLOW: f64 = 5e-3;

/// So long all bodies of an island must have been slow [s], as in Box2D.
const SLOW_FOR: f64 = 0.5;

/// Who sleeps in a frame.
#[derive(Default)]
pub(crate) struct Sleep {
    /// The manifolds of all islands that sleep.
    pub(crate) manifolds: Vec<usize>,
    /// Of each body, a number that says with whom it has points that are close, in any order; empty
    /// if nothing may sleep.
    touching: Vec<u64>,
    /// Whether each is in an island with something that is driven.
    is_stirred: Vec<bool>,
    /// Where each was at the frame's start [m].
    starts: Vec<DVec3>,
}

impl Sleep {
    /// Takes those islands out that sleep in this frame: all of their bodies have been slow for
    /// long enough, and touch the same others as they did then, of which one at least does not move
    /// and carries something.
    pub(crate) fn take_out(
        bodies: &Bodies,
        (manifolds, carried): (&[Manifold], &[&[Carried]]),
        islands: &mut Vec<Vec<usize>>,
        frame: &Frame,
    ) -> Self {
        let mut sleep = Self::default();
        if !frame.settings.sleep {
            return sleep;
        }
        sleep.starts = bodies.poses.iter().map(|pose| pose.position).collect();
        sleep.is_stirred = vec![false; bodies.len()];
        sleep.touching = vec![0; bodies.len()];
        // Only what is close: who meets what is further away depends on who has settled.
        let is_close = |point: &ManifoldPoint| point.gap <= NEAR * frame.sag();
        for Manifold { pair: Pair { first, second }, points, .. } in manifolds {
            if points.iter().any(is_close) {
                for (i, other) in [(*first, *second), (*second, *first)] {
                    sleep.touching[i] =
                        sleep.touching[i].wrapping_add(scattered(bodies.ids[other]));
                }
            }
        }
        let enough = (SLOW_FOR / frame.dt).ceil() as u32;
        islands.retain(|island| {
            let pairs = || island.iter().map(|&at| manifolds[at].pair);
            let all = || pairs().flat_map(|Pair { first, second }| [first, second]);
            if all().any(|i| is_driven(bodies, i)) {
                all().for_each(|i| sleep.is_stirred[i] = true);
                return true;
            }
            let is_drowsy = |i: usize| {
                let Drowsiness { slow_for, touching, .. } = bodies.activities[i].drowsiness;
                slow_for >= enough && touching == sleep.touching[i] && is_slow(bodies, i)
            };
            let presses = |at: usize| carried[at].iter().any(|carried| carried.force.normal > 0.0);
            let is_fixed = |i: usize| bodies.motions[i] != Motion::Dynamic;
            let stands = |&at: &usize| {
                let Pair { first, second } = manifolds[at].pair;
                (is_fixed(first) || is_fixed(second)) && presses(at)
            };
            let sleeps = all().all(|i| is_fixed(i) || is_drowsy(i)) && island.iter().any(stands);
            if sleeps {
                sleep.manifolds.extend_from_slice(island);
            }
            !sleeps
        });
        sleep
    }

    /// The bodies that sleep stand still: what they lose by that, what they stand on has given.
    pub(crate) fn hold(
        &self,
        bodies: &mut Bodies,
        manifolds: &[Manifold],
        tally: &mut Tally,
    ) -> Vec<bool> {
        let mut are_asleep = vec![false; bodies.len()];
        for Pair { first, second } in self.manifolds.iter().map(|&at| manifolds[at].pair) {
            for i in [first, second].into_iter().filter(|&i| bodies.motions[i] == Motion::Dynamic) {
                if !std::mem::replace(&mut are_asleep[i], true) {
                    let Velocity { linear, angular_momentum } = bodies.velocities[i];
                    let momentum = bodies.masses[i] * linear;
                    tally.outside_impulse -= momentum;
                    tally.outside_angular_impulse -=
                        bodies.poses[i].position.cross(momentum) + angular_momentum;
                    let kinetic =
                        energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], DVec3::ZERO);
                    tally.causes.add(Cause::Contact, -kinetic);
                    bodies.velocities[i] =
                        Velocity { linear: DVec3::ZERO, angular_momentum: DVec3::ZERO };
                }
            }
        }
        are_asleep
    }

    /// What the contacts of those that sleep carried goes on.
    pub(crate) fn carried(&self, manifolds: &[Manifold], carried: &[&[Carried]]) -> Part {
        let mut part = Part::default();
        for &at in &self.manifolds {
            part.keep(at, manifolds[at].pair, carried[at]);
        }
        part
    }

    /// How drowsy each body is at the frame's end, if any may sleep. What is lifted out of an
    /// overlap moves, though it is slow in the end.
    pub(crate) fn drowsiness(
        &self,
        bodies: &Bodies,
        frame: &Frame,
        are_asleep: &[bool],
    ) -> Vec<Drowsiness> {
        let of = |(i, &touching): (usize, &u64)| {
            let before = bodies.activities[i].drowsiness;
            let way = bodies.poses[i].position.distance(self.starts[i]);
            let is_still = is_slow(bodies, i) && way < SLOW * frame.dt && !self.is_stirred[i];
            let goes_on = is_still && before.touching == touching;
            let slow_for = if goes_on { before.slow_for.saturating_add(1) } else { 0 };
            Drowsiness { slow_for, touching, is_asleep: are_asleep[i] }
        };
        self.touching.iter().enumerate().map(of).collect()
    }
}

/// A number for a body, of which sums tell one set of bodies from another: its id through
/// SplitMix64.
fn scattered(BodyId { index, generation }: BodyId) -> u64 {
    let mut number =
        (u64::from(generation) << 32 | u64::from(index)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ number >> 31
}

fn is_slow(bodies: &Bodies, i: usize) -> bool {
    let spin = bodies.spin(i, &bodies.poses[i], &bodies.velocities[i]).length();
    // What has no bounds does not turn.
    let turning = if spin > 0.0 { spin * bodies.radii[i] } else { 0.0 };
    bodies.velocities[i].linear.length() + turning < SLOW
}

/// Whether it is a kinematic body that moves.
fn is_driven(bodies: &Bodies, i: usize) -> bool {
    matches!(bodies.motions[i], Motion::Kinematic { linear, angular } if linear != DVec3::ZERO || angular != DVec3::ZERO)
}
