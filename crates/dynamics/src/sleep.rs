//! Islands that sleep, where the scene lets them: what stands on something that does not move, and has been slow for long enough, stays where it is. It is
//! still looked whom it may touch; so whatever comes near wakes it before it touches, and whatever goes, as a support that breaks, wakes what it held.

use crate::detection::radius;
use crate::ledger::energy;
use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::tally::{Cause, Tally};
use crate::warm_start::WarmStart;
use crate::{Bodies, Frame, Motion, Velocity};
use glam::DVec3;

/// Speed [m/s] below which a body is slow, its centre and what its turning adds at its rim together. Heaps fidget below it; what begins to slide passes it
/// within [`SLOW_FOR`], unless its slope is less than 0.1 degrees too steep. It does not scale with the scene.
const SLOW: f64 = 5e-3;

/// So long all bodies of an island must have been slow [s], as in Box2D.
const SLOW_FOR: f64 = 0.5;

/// What decides whether a body sleeps, from frame to frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Drowsiness {
    /// In so many frames, one after the other, it has been slow, and has touched as many others.
    slow_for: u8,
    /// So many pairs had points with it.
    touching: u32,
    is_asleep: bool,
}

impl Drowsiness {
    pub(crate) fn is_asleep(&self) -> bool {
        self.is_asleep
    }
}

/// Who sleeps in a frame.
#[derive(Default)]
pub(crate) struct Sleep {
    /// Of each body, how many pairs have points with it; empty if nothing may sleep.
    touching: Vec<u32>,
    /// Of each island that was asked about and sleeps, its manifolds.
    pub(crate) manifolds: Vec<usize>,
}

impl Sleep {
    /// Takes those of some islands out that sleep in this frame: all of their bodies have been slow for long enough, and touch as many others as they did
    /// then, of which one at least does not move.
    pub(crate) fn take_out(
        bodies: &Bodies,
        manifolds: &[Manifold],
        islands: &mut Vec<Vec<usize>>,
        (warm, frame): (&WarmStart, &Frame),
    ) -> Self {
        let mut sleep = Self::default();
        if !frame.settings.sleep {
            return sleep;
        }
        sleep.touching = vec![0; bodies.len()];
        for Manifold { pair: Pair { first, second }, points, .. } in manifolds {
            if !points.is_empty() {
                sleep.touching[*first] += 1;
                sleep.touching[*second] += 1;
            }
        }
        let enough = (SLOW_FOR / frame.dt).ceil().min(u8::MAX.into()) as u8;
        let is_drowsy = |i: usize| {
            let before = warm.drowsiness(bodies.ids[i]);
            before.slow_for >= enough && before.touching == sleep.touching[i] && is_slow(bodies, i)
        };
        let sleeps = |island: &[usize]| {
            let mut stands = false;
            let all = island.iter().all(|&at| {
                let Manifold { pair, points, .. } = manifolds[at];
                [pair.first, pair.second].into_iter().all(|i| {
                    stands |= bodies.motions[i] != Motion::Dynamic && !points.is_empty();
                    is_drowsy(i) || bodies.motions[i] != Motion::Dynamic && is_still(bodies, i)
                })
            });
            all && stands
        };
        islands.retain(|island| {
            let sleeps = sleeps(island);
            if sleeps {
                sleep.manifolds.extend_from_slice(island);
            }
            !sleeps
        });
        sleep
    }

    /// The bodies that sleep stand still: what they lose by that, what they stand on has given.
    pub(crate) fn hold(&self, bodies: &mut Bodies, manifolds: &[Manifold], tally: &mut Tally) -> Vec<bool> {
        let mut are_asleep = vec![false; if self.touching.is_empty() { 0 } else { bodies.len() }];
        for Pair { first, second } in self.manifolds.iter().map(|&at| manifolds[at].pair) {
            for i in [first, second].into_iter().filter(|&i| bodies.motions[i] == Motion::Dynamic) {
                if !std::mem::replace(&mut are_asleep[i], true) {
                    let Velocity { linear, angular_momentum } = bodies.velocities[i];
                    let momentum = bodies.masses[i] * linear;
                    tally.outside_impulse -= momentum;
                    tally.outside_angular_impulse -=
                        bodies.poses[i].position.cross(momentum) + angular_momentum;
                    let kinetic = energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], DVec3::ZERO);
                    tally.causes.add(Cause::Contact, -kinetic);
                    bodies.velocities[i] = Velocity { linear: DVec3::ZERO, angular_momentum: DVec3::ZERO };
                }
            }
        }
        are_asleep
    }

    /// How drowsy each body is at the frame's end, if any may sleep.
    pub(crate) fn drowsiness(
        &self,
        bodies: &Bodies,
        warm: &WarmStart,
        are_asleep: &[bool],
    ) -> Vec<Drowsiness> {
        let of = |(i, &touching): (usize, &u32)| {
            let before = warm.drowsiness(bodies.ids[i]);
            let goes_on = before.touching == touching && is_slow(bodies, i);
            let slow_for = if goes_on { before.slow_for.saturating_add(1) } else { 0 };
            Drowsiness { slow_for, touching, is_asleep: are_asleep[i] }
        };
        self.touching.iter().enumerate().map(of).collect()
    }
}

fn is_slow(bodies: &Bodies, i: usize) -> bool {
    let turning = bodies.inertias[i].inverse_moments.max_element() * radius(&bodies.shapes[i]);
    let Velocity { linear, angular_momentum } = bodies.velocities[i];
    linear.length() + turning * angular_momentum.length() < SLOW
}

/// Whether a static or kinematic body does not move.
fn is_still(bodies: &Bodies, i: usize) -> bool {
    match bodies.motions[i] {
        Motion::Kinematic { linear, angular } => linear == DVec3::ZERO && angular == DVec3::ZERO,
        Motion::Static | Motion::Dynamic => true,
    }
}
