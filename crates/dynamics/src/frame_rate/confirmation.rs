//! Confirmation of speculative contacts. A pair without a cached impulse is detected again in the
//! substep in which it would first act, at the poses and velocities of that substep: bodies that
//! pass each other after an impact, a slide or a turn do not touch.

use super::constraints::{SAME_NORMAL, Selection, Source};
use super::group::Group;
use super::solver_bodies::SolverBodies;
use super::touching::Place;
use frangible_bodies::{BallisticPath, Bodies, Frame, Motion, Pair};
use frangible_collision::{FixedNeighbours, Manifold, ManifoldFinder, ManifoldPoint, PairMotion};
use frangible_math::{Instructions, threads};
use glam::{DVec3, Vec3};

/// Separation up to which a second look finds points, relative to those of the first look [1]: the
/// bodies have moved in between. With 1, balls and pieces of `rain-25` overlap by 15.5 mm at the
/// 99th percentile of frame 40, with this value by 12.1, with 2.5 by 12.5.
const WIDER: f64 = 1.25;

/// Pairs per task: a tenth of a millisecond of work.
const SHARE: usize = 32;

impl<I: Instructions> Group<I> {
    /// Detects the pairs of all asking lanes again, with `time_left` [s] of the frame, and
    /// velocities without `kick` [m/s], gravity's of a substep that contacts have not answered yet.
    /// Returns the batches with new constraints. Once the frame has had its number of detections, the
    /// lanes act as they were first seen.
    pub(super) fn confirm(
        &mut self,
        bodies: &Bodies,
        (manifolds, neighbours): (&[Manifold], &FixedNeighbours),
        (time_left, kick): (f64, Vec3),
        frame: &Frame,
    ) -> Vec<usize> {
        let mut asked = Vec::new();
        let mut unseen = Vec::new();
        for at in self.speculative.asking.take() {
            let batch = &mut self.batches[at];
            for lane in batch.take_asking() {
                if self.speculative.looks > 0 {
                    asked.push(self.selections[batch.constraints[lane] as usize].manifold);
                } else {
                    batch.unconfirmed.set(lane, false);
                    self.speculative.confirmed.push(Place::new(at, lane));
                    unseen.push(at);
                }
            }
        }
        if asked.is_empty() {
            unseen.dedup();
            return unseen;
        }
        asked.sort_unstable();
        asked.dedup();
        self.speculative.looks = self.speculative.looks.saturating_sub(asked.len());

        let substep = Frame { dt: self.h, ..*frame };
        let (selections, solver_bodies) = (&self.selections, &self.bodies);
        let detect = |finder: &mut ManifoldFinder, manifold: u32| {
            let Manifold { pair, points } = manifolds[manifold as usize];
            let lines = selections[first_of(selections, manifold)].lines;
            let [first, second] =
                [(pair.first, lines[0]), (pair.second, lines[1])].map(|(i, line)| {
                    path_now(bodies, i, (solver_bodies, line as usize, kick), &substep)
                });
            // Features that an impact may bring together are further apart.
            let margin = frame.speculative_margin();
            let near = points.iter().map(|point| WIDER * point.gap).fold(margin, f64::max);
            // A touch as the frame ends may pass on in the next one.
            let ahead = time_left + substep.dt;
            let pair_motion =
                PairMotion::of_substep(bodies, pair, [&first, &second], &substep, (ahead, near))
                    .among(neighbours);
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
            .map(|number| self.speculative.places[number])
            .filter(|place| !self.batches[place.batch()].unconfirmed.get(place.lane()))
            .map(|place| self.batches[place.batch()].normal.get(place.lane()))
            .collect();
        let is_new = |selection: &&Selection| {
            let normal = selection.points().next().map(|number| -points[number].normal);
            normal.is_some_and(|normal| acting.iter().all(|of| of.dot(normal) <= SAME_NORMAL))
        };
        // The first touch has a place.
        let gap = |selection: &Selection| {
            selection.points().map(|number| points[number].gap).fold(f64::INFINITY, f64::min)
        };
        new.sort_by(|a, b| gap(a).total_cmp(&gap(b)));
        let mut new = new.iter().filter(is_new);
        let source = Source { manifold: &Manifold { pair, points: &points }, carried: &[] };
        for number in first..first + count {
            let place = self.speculative.places[number];
            let batch = &mut self.batches[place.batch()];
            if !batch.unconfirmed.get(place.lane()) {
                continue;
            }
            let Some(selection) = new.next() else {
                batch.passes.set(place.lane(), true);
                self.speculative.passing.push(place);
                continue;
            };
            self.speculative.confirmed.push(place);
            let replaced = self.speculative.replace(number);
            if batch.acted.get(place.lane()) {
                replaced.given += batch.take_frame_impulse(place.lane());
            }
            replaced.features.clear();
            replaced.features.extend(selection.points().map(|number| points[number].feature));
            let mut constraint = source.constraint(selection, bodies, (self.h, frame));
            for point in constraint.points.iter_mut() {
                point.separation = gap_at_start(bodies, pair, &points[point.number]);
            }
            batch.refill(place.lane(), (number as u32, &constraint));
            changed.push(place.batch());
        }
        self.speculative.points.insert(manifold, points);
    }

    /// Lanes without an impulse are speculative again.
    pub(super) fn end_confirmation(&mut self) {
        let Self { batches, speculative, .. } = self;
        for place in speculative.passing.drain(..) {
            batches[place.batch()].passes.set(place.lane(), false);
        }
        speculative.confirmed.retain(|place| {
            let batch = &mut batches[place.batch()];
            let stays = batch.presses(place.lane());
            batch.unconfirmed.set(place.lane(), !stays);
            stays
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
