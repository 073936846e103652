//! Speculative contacts of a group: pairs without a cached impulse, which are detected again before
//! they act (`confirmation.rs`).

use super::constraints::{NEAR, Source};
use super::contact_batch::ContactBatch;
use super::touching::Place;
use frangible_bodies::{Bodies, Frame, Pair};
use frangible_collision::{FeatureId, Manifold, ManifoldPoint, needs_one_look};
use glam::DVec3;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Width of a contact patch, in ways of the bodies in the frame [1], above which they need no
/// second look.
const SLIDES: f64 = 4.0;

/// Turn of a body in a frame [rad] from which on its contacts with what it [may
/// pierce](may_pierce) are detected again each time that it has turned by a tenth of a radian.
/// Without it corners of one in five random hulls and compounds come through a thin plate that they
/// hit; with it, and substeps for the turn that impacts give, of one in sixteen.
pub(super) const LOOKS_AGAIN: f64 = 0.5;

/// Thickness of a body that a lighter one may pierce, relative to the other's radius [1]. With all
/// pairs, falling shards take 1.8 times as long.
const THIN: f64 = 0.5;

/// Detections in a frame for each manifold, and at least in all [1]. The crowds of `rain-25` ask for
/// 3.3. Without a bound 309 pieces that an impact spun in one place asked for 70, in 6 s.
const LOOKS: usize = 4;
const LEAST_LOOKS: usize = 4096;

/// Speculative contacts of a group.
pub(super) struct SpeculativeContacts {
    /// Batches with speculative lanes, in ascending order, and those with lanes that ask to act.
    batches: Vec<usize>,
    pub(super) asking: BatchFlags,
    /// Batch and lane of each constraint.
    pub(super) places: Vec<Place>,
    /// Lanes that were detected again and have not lost their impulse since.
    pub(super) confirmed: Vec<Place>,
    /// Lanes without a contact in this substep.
    pub(super) passing: Vec<Place>,
    /// Number in `replaced` of each constraint, or [`NOT_REPLACED`].
    numbers: Vec<u32>,
    /// Constraints that were detected again.
    replaced: Vec<Replaced>,
    /// Points of the manifolds that were detected again, by manifold.
    pub(super) points: BTreeMap<u32, Vec<ManifoldPoint>>,
    /// Pairs that may still be detected again in the frame.
    pub(super) looks: usize,
}

/// A constraint that was detected again.
#[derive(Default)]
pub(super) struct Replaced {
    /// Impulse along its earlier normals, on the second body, world frame [N s].
    pub(super) given: DVec3,
    /// Features of its points.
    pub(super) features: Vec<FeatureId>,
}

const NOT_REPLACED: u32 = u32::MAX;

/// A set of batch indices, filled in parallel.
pub(super) struct BatchFlags {
    words: Vec<AtomicU64>,
}

impl BatchFlags {
    fn below(most: usize) -> Self {
        Self { words: (0..most.div_ceil(64)).map(|_| AtomicU64::new(0)).collect() }
    }

    #[inline]
    pub(super) fn insert(&self, number: usize) {
        self.words[number / 64].fetch_or(1 << (number % 64), Ordering::Relaxed);
    }

    /// Removes all indices and returns them in ascending order.
    pub(super) fn take(&mut self) -> Vec<usize> {
        let mut all = Vec::new();
        for (at, word) in self.words.iter_mut().enumerate() {
            let mut word = std::mem::take(word.get_mut());
            while word != 0 {
                all.push(64 * at + word.trailing_zeros() as usize);
                word &= word - 1;
            }
        }
        all
    }
}

impl SpeculativeContacts {
    /// Of so many manifolds; `places` has the batch and lane of each constraint.
    pub(super) fn new<I>(
        batches: &[ContactBatch<I>],
        places: Vec<Place>,
        manifolds: usize,
    ) -> Self {
        Self {
            batches: (0..batches.len()).filter(|&at| batches[at].unconfirmed.any()).collect(),
            asking: BatchFlags::below(batches.len()),
            numbers: vec![NOT_REPLACED; places.len()],
            replaced: Vec::new(),
            places,
            confirmed: Vec::new(),
            passing: Vec::new(),
            points: BTreeMap::new(),
            looks: (LOOKS * manifolds).max(LEAST_LOOKS),
        }
    }

    /// Batches with speculative lanes, in ascending order.
    pub(super) fn batches(&self) -> &[usize] {
        &self.batches
    }

    /// Batches with lanes that ask to act.
    pub(super) fn asking(&self) -> &BatchFlags {
        &self.asking
    }

    /// Batch and lane of a constraint.
    pub(super) fn place(&self, number: u32) -> Place {
        self.places[number as usize]
    }

    /// A constraint, if it was detected again.
    pub(super) fn replaced(&self, number: u32) -> Option<&Replaced> {
        self.replaced.get(self.numbers[number as usize] as usize)
    }

    /// A constraint that is detected again.
    pub(super) fn replace(&mut self, number: usize) -> &mut Replaced {
        if self.numbers[number] == NOT_REPLACED {
            self.numbers[number] = self.replaced.len() as u32;
            self.replaced.push(Replaced::default());
        }
        &mut self.replaced[self.numbers[number] as usize]
    }
}

/// True for a pair that may act without a second look: it carried an impulse in the last frame, it
/// meets along so many normals that its lanes may not do, one body is a half-space with one normal
/// everywhere, or its overlap at birth is forgiven.
pub(super) fn is_confirmed(
    bodies: &Bodies,
    Source { manifold, carried }: &Source,
    frame: &Frame,
) -> bool {
    let pair = manifold.pair.both();
    !carried.is_empty()
        || is_wide(bodies, manifold, frame)
        || needs_one_look(pair.map(|i| &*bodies.shapes[i]))
        || manifold.points.iter().any(|point| point.rounding[0] < 0.0)
}

/// True if features that come near as one body turns may go through the other: a thin one that does
/// not give way, as it is fixed or heavier.
pub(super) fn may_pierce(bodies: &Bodies, pair: Pair) -> bool {
    let [first, second] = pair.both();
    let is_pierced_by = |i: usize, other: usize| {
        let (low, high) = bodies.shapes[i].bounds;
        let is_thin = (high - low).min_element() < THIN * bodies.radii[other];
        is_thin && bodies.masses[i] > bodies.masses[other]
    };
    (is_pierced_by(first, second) || is_pierced_by(second, first))
        && !needs_one_look([first, second].map(|i| &*bodies.shapes[i]))
}

/// True for touching bodies with a contact patch wider than they slide in the frame: other features
/// do not come first.
fn is_wide(bodies: &Bodies, Manifold { pair, points }: &Manifold, frame: &Frame) -> bool {
    let close = NEAR * frame.speculative_margin();
    let touching = points.iter().filter(|point| point.gap <= close);
    let mut middles = touching.map(|point| point.middle(bodies, *pair));
    let Some(from) = middles.next() else { return false };
    let arms: Vec<DVec3> = middles.map(|middle| middle - from).collect();
    let longest = arms.iter().max_by(|a, b| a.length_squared().total_cmp(&b.length_squared()));
    let Some(along) = longest.and_then(|arm| arm.try_normalize()) else { return false };
    let width = arms.iter().map(|arm| arm.cross(along).length()).fold(0.0, f64::max);
    let [first, second] = pair.both().map(|i| bodies.velocities[i].linear);
    width > SLIDES * frame.dt * (first - second).length()
}
