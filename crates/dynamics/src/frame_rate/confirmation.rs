//! Confirmation of speculative contacts. A pair without a cached impulse is detected again in the
//! substep in which it would first act, at the poses and velocities of that substep: bodies that
//! pass each other after an impact, a slide or a turn do not touch.

use super::constraints::{NEAR, SAME_NORMAL, Selection, Source};
use super::contact_batch::ContactBatch;
use super::group::Group;
use super::solver_bodies::SolverBodies;
use super::touching::Place;
use frangible_bodies::{BallisticPath, Bodies, Frame, Motion, Pair};
use frangible_collision::{
    FeatureId, Manifold, ManifoldFinder, ManifoldPoint, PairMotion, has_many_normals,
};
use frangible_math::{Instructions, threads};
use glam::{DVec3, Vec3};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};

/// Width of a contact patch, in ways of the bodies in the frame [1], above which they need no second
/// look.
const SLIDES: f64 = 4.0;

/// Pairs per task: a tenth of a millisecond of work.
const SHARE: usize = 32;

/// Speculative contacts of a group.
pub(super) struct Confirmation {
    /// Batches with speculative lanes, in ascending order, and those with lanes that ask to act.
    speculative: Vec<usize>,
    asking: BatchFlags,
    /// Batch and lane of each constraint.
    places: Vec<Place>,
    /// Lanes that were detected again and have not lost their impulse since.
    confirmed: Vec<Place>,
    /// Lanes without a contact in this substep.
    passing: Vec<Place>,
    /// Impulses along earlier normals of constraints, on the second body, world frame [N s].
    given: BTreeMap<u32, DVec3>,
    /// Features of the constraints that were detected again.
    features: BTreeMap<u32, Vec<FeatureId>>,
    /// Points of the manifolds that were detected again, by manifold.
    pub(super) points: BTreeMap<u32, Vec<ManifoldPoint>>,
}

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
    fn take(&mut self) -> Vec<usize> {
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

impl Confirmation {
    /// `places` has the batch and lane of each constraint.
    pub(super) fn new<I>(batches: &[ContactBatch<I>], places: Vec<Place>) -> Self {
        Self {
            speculative: (0..batches.len()).filter(|&at| batches[at].unconfirmed.any()).collect(),
            asking: BatchFlags::below(batches.len()),
            places,
            confirmed: Vec::new(),
            passing: Vec::new(),
            given: BTreeMap::new(),
            features: BTreeMap::new(),
            points: BTreeMap::new(),
        }
    }

    /// Batches with speculative lanes, in ascending order.
    pub(super) fn speculative(&self) -> &[usize] {
        &self.speculative
    }

    /// Batches with lanes that ask to act.
    pub(super) fn asking(&self) -> &BatchFlags {
        &self.asking
    }

    /// Batch and lane of a constraint.
    pub(super) fn place(&self, number: u32) -> Place {
        self.places[number as usize]
    }

    /// Impulse of a constraint along earlier normals, on the second body, world frame [N s].
    pub(super) fn given(&self, number: u32) -> DVec3 {
        self.given.get(&number).copied().unwrap_or_default()
    }

    /// Features of a constraint.
    pub(super) fn features(
        &self,
        number: u32,
        (selection, points): (&Selection, &[ManifoldPoint]),
    ) -> Vec<FeatureId> {
        match self.features.get(&number) {
            Some(features) => features.clone(),
            None => selection.points().map(|number| points[number].feature).collect(),
        }
    }
}

/// Whether a pair may act without a second look: it carried an impulse in the last frame, it meets
/// along so many normals that its lanes may not do, one body is a half-space with one normal
/// everywhere, or its overlap at birth is forgiven.
pub(super) fn is_confirmed(
    bodies: &Bodies,
    Source { manifold, carried }: &Source,
    frame: &Frame,
) -> bool {
    let pair = manifold.pair.both();
    !carried.is_empty()
        || is_wide(bodies, manifold, frame)
        || pair
            .iter()
            .any(|&i| bodies.radii[i].is_infinite() || has_many_normals(&bodies.shapes[i]))
        || manifold.points.iter().any(|point| point.rounding[0] < 0.0)
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

impl<I: Instructions> Group<I> {
    /// Detects the pairs of all asking lanes again, with `time_left` [s] of the frame, and velocities
    /// without `kick` [m/s], gravity's of a substep that contacts have not answered yet. Returns the
    /// batches with new constraints.
    pub(super) fn confirm(
        &mut self,
        bodies: &Bodies,
        manifolds: &[Manifold],
        (time_left, kick): (f64, Vec3),
        frame: &Frame,
    ) -> Vec<usize> {
        let mut asked = Vec::new();
        for at in self.confirmation.asking.take() {
            let batch = &mut self.batches[at];
            for lane in batch.take_asking() {
                asked.push(self.selections[batch.constraints[lane] as usize].manifold);
            }
        }
        if asked.is_empty() {
            return Vec::new();
        }
        asked.sort_unstable();
        asked.dedup();

        let substep = Frame { dt: self.h, ..*frame };
        let ahead = (time_left, frame.speculative_margin());
        let (selections, solver_bodies) = (&self.selections, &self.bodies);
        let detect = |finder: &mut ManifoldFinder, manifold: u32| {
            let pair = manifolds[manifold as usize].pair;
            let lines = selections[first_of(selections, manifold)].lines;
            let [first, second] =
                [(pair.first, lines[0]), (pair.second, lines[1])].map(|(i, line)| {
                    path_now(bodies, i, (solver_bodies, line as usize, kick), &substep)
                });
            let pair_motion =
                PairMotion::of_substep(bodies, pair, [&first, &second], &substep, ahead);
            let found = finder.of_motion(&pair_motion, |_| false);
            found.map_or(Vec::new(), |manifold| manifold.points.to_vec())
        };
        let shares: Vec<&[u32]> = asked.chunks(SHARE).collect();
        let found = threads::map_with(
            shares,
            SHARE * asked.len(),
            ManifoldFinder::default,
            |finder, share: &[u32]| {
                share.iter().map(|&manifold| detect(finder, manifold)).collect::<Vec<_>>()
            },
        );

        let mut changed = Vec::new();
        for (manifold, points) in asked.into_iter().zip(found.into_iter().flatten()) {
            let pair = manifolds[manifold as usize].pair;
            self.replace((manifold, pair), points, (bodies, frame), &mut changed);
        }
        changed.sort_unstable();
        changed.dedup();
        changed
    }

    /// Replaces the constraints of a manifold that have not acted yet, and notes their batches.
    fn replace(
        &mut self,
        (manifold, pair): (u32, Pair),
        points: Vec<ManifoldPoint>,
        (bodies, frame): (&Bodies, &Frame),
        changed: &mut Vec<usize>,
    ) {
        let first = first_of(&self.selections, manifold);
        let all = self.selections[first..].iter();
        let count = all.take_while(|selection| selection.manifold == manifold).count();
        let mut new = Vec::new();
        Selection::all(
            &mut new,
            (manifold as usize, &points),
            self.selections[first].lines,
            &mut Vec::new(),
        );

        // Constraints that have acted keep their normals.
        let acting: Vec<_> = (first..first + count)
            .map(|number| self.confirmation.places[number])
            .filter(|place| !self.batches[place.batch()].unconfirmed.get(place.lane()))
            .map(|place| self.batches[place.batch()].normal.get(place.lane()))
            .collect();
        let is_new = |selection: &&Selection| {
            let normal = selection.points().next().map(|number| -points[number].normal);
            normal.is_some_and(|normal| acting.iter().all(|of| of.dot(normal) <= SAME_NORMAL))
        };
        let mut new = new.iter().filter(is_new);
        let source = Source { manifold: &Manifold { pair, points: &points }, carried: &[] };
        for number in first..first + count {
            let place = self.confirmation.places[number];
            let batch = &mut self.batches[place.batch()];
            if !batch.unconfirmed.get(place.lane()) {
                continue;
            }
            let Some(selection) = new.next() else {
                batch.passes.set(place.lane(), true);
                self.confirmation.passing.push(place);
                continue;
            };
            self.confirmation.confirmed.push(place);
            if batch.acted.get(place.lane()) {
                let given = self.confirmation.given.entry(number as u32).or_default();
                *given += batch.take_frame_impulse(place.lane());
            }
            let mut constraint = source.constraint(selection, bodies, (self.h, frame));
            for point in constraint.points.iter_mut() {
                point.separation = gap_at_start(bodies, pair, &points[point.number]);
            }
            batch.refill(place.lane(), (number as u32, &constraint));
            let features = selection.points().map(|number| points[number].feature).collect();
            self.confirmation.features.insert(number as u32, features);
            changed.push(place.batch());
        }
        self.confirmation.points.insert(manifold, points);
    }

    /// Lanes without an impulse are speculative again.
    pub(super) fn end_confirmation(&mut self) {
        let Self { batches, confirmation, .. } = self;
        for place in confirmation.passing.drain(..) {
            batches[place.batch()].passes.set(place.lane(), false);
        }
        confirmation.confirmed.retain(|place| {
            let batch = &mut batches[place.batch()];
            let presses = batch.presses(place.lane());
            batch.unconfirmed.set(place.lane(), !presses);
            presses
        });
    }
}

/// Index of the first constraint of a manifold.
fn first_of(selections: &[Selection], manifold: u32) -> usize {
    selections.partition_point(|selection| selection.manifold < manifold)
}

/// Path of a body from its present pose, with its present velocity.
fn path_now(
    bodies: &Bodies,
    i: usize,
    (solver_bodies, line, kick): (&SolverBodies, usize, Vec3),
    frame: &Frame,
) -> BallisticPath {
    let path = BallisticPath::of(bodies, i, frame);
    if bodies.motions[i] == Motion::Static {
        return path;
    }
    let (start, [linear, angular]) = solver_bodies.now(line, &bodies.poses[i]);
    let spin_speed = bodies.sweeping_spin(i, &start, angular).length() * path.radius;
    BallisticPath {
        start,
        linear: if bodies.motions[i] == Motion::Dynamic {
            linear - kick.as_dvec3()
        } else {
            linear
        },
        angular,
        acceleration: DVec3::ZERO,
        spin_speed,
        ..path
    }
}

/// Separation along a point's normal at the frame's start [m].
fn gap_at_start(bodies: &Bodies, pair: Pair, point: &ManifoldPoint) -> f64 {
    let [on_first, on_second] = point.on_surfaces(bodies, pair);
    (on_first - on_second).dot(point.normal)
}
