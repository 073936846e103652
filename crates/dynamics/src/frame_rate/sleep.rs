//! Sleeping islands, if enabled in the scene: an island with a fixed support sleeps after all its
//! bodies have been slow for half a second. The broad phase still reports its pairs: approaching
//! bodies wake the island before contact, and removing a support wakes it too.

use super::constraints::NEAR;
use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::energy::island::energy;
use frangible_bodies::{Bodies, BodyId, Drowsiness, Frame, Motion, Pair, Velocity};
use frangible_collision::{CachedImpulse, ImpulseChunk, Manifold, ManifoldPoint};
use glam::DVec3;

/// Speed limit [m/s] of a slow body: linear speed plus rim speed from rotation. Resting heaps
/// jitter below this speed. On earth a sliding body exceeds it within [`SLOW_FOR`], unless its
/// slope is within 0.06 degrees of the friction angle. The limit does not scale with the scene.
const SLOW: f64 = 5e-3;

/// Time [s] for which all bodies of an island must be slow before sleep, as in Box2D.
const SLOW_FOR: f64 = 0.5;

/// Sleeping islands of a frame.
#[derive(Default)]
pub(crate) struct Sleep {
    /// Manifolds of all sleeping islands.
    pub(crate) manifolds: Vec<usize>,
    /// Order-independent hash of each body's near neighbours; empty if sleep is disabled.
    touching: Vec<u64>,
    /// True for bodies in an island with a moving kinematic body.
    is_stirred: Vec<bool>,
    /// Positions at the frame's start [m].
    starts: Vec<DVec3>,
}

impl Sleep {
    /// Removes sleeping islands from `islands`. An island sleeps if all its bodies have been slow
    /// for long enough with unchanged neighbours, and at least one loaded contact is with a fixed
    /// body.
    pub(crate) fn extract(
        bodies: &Bodies,
        (manifolds, carried): (&[Manifold], &[&[CachedImpulse]]),
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
        // Count near points only: distant pairs vary with the sleep state of other bodies.
        let is_close = |point: &ManifoldPoint| point.gap <= NEAR * frame.speculative_margin();
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

    /// Zeroes velocities of sleeping bodies; the lost momentum is booked to their supports.
    pub(crate) fn hold(
        &self,
        bodies: &mut Bodies,
        manifolds: &[Manifold],
        accounts: &mut FrameAccounts,
    ) -> Vec<bool> {
        let mut are_asleep = vec![false; bodies.len()];
        for Pair { first, second } in self.manifolds.iter().map(|&at| manifolds[at].pair) {
            for i in [first, second].into_iter().filter(|&i| bodies.motions[i] == Motion::Dynamic) {
                if !std::mem::replace(&mut are_asleep[i], true) {
                    let Velocity { linear, angular_momentum } = bodies.velocities[i];
                    let momentum = bodies.masses[i] * linear;
                    accounts.outside_impulse -= momentum;
                    accounts.outside_angular_impulse -=
                        bodies.poses[i].position.cross(momentum) + angular_momentum;
                    let kinetic =
                        energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], DVec3::ZERO);
                    accounts.causes.add(Cause::Contact, -kinetic);
                    bodies.velocities[i] =
                        Velocity { linear: DVec3::ZERO, angular_momentum: DVec3::ZERO };
                }
            }
        }
        are_asleep
    }

    /// Keeps the cached impulses of sleeping contacts.
    pub(crate) fn carried(
        &self,
        manifolds: &[Manifold],
        carried: &[&[CachedImpulse]],
    ) -> ImpulseChunk {
        let mut part = ImpulseChunk::default();
        for &at in &self.manifolds {
            part.keep(at, manifolds[at].pair, carried[at]);
        }
        part
    }

    /// Sleep counters of all bodies at the frame's end. Penetration recovery displaces a body even
    /// if its final velocity is small, hence the test of its displacement.
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

/// SplitMix64 hash of a body id; sums of hashes distinguish sets of bodies.
fn scattered(BodyId { index, generation }: BodyId) -> u64 {
    let mut number =
        (u64::from(generation) << 32 | u64::from(index)).wrapping_add(0x9e37_79b9_7f4a_7c15);
    number = (number ^ number >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    number = (number ^ number >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    number ^ number >> 31
}

fn is_slow(bodies: &Bodies, i: usize) -> bool {
    let spin = bodies.spin(i, &bodies.poses[i], &bodies.velocities[i]).length();
    // Unbounded bodies have no spin.
    let turning = if spin > 0.0 { spin * bodies.radii[i] } else { 0.0 };
    bodies.velocities[i].linear.length() + turning < SLOW
}

/// True for moving kinematic bodies.
fn is_driven(bodies: &Bodies, i: usize) -> bool {
    matches!(bodies.motions[i], Motion::Kinematic { linear, angular } if linear != DVec3::ZERO || angular != DVec3::ZERO)
}
