//! Restitution: impacts within a substep, in the order of their times of impact. Impulses propagate
//! at once through rows of any length.

use super::constraints::MOST_POINTS;
use super::contact_batch::{ContactBatch, ENTRY};
use super::effective_mass::reciprocal;
use super::joint_impacts::JointImpact;
use super::lane_bodies::LaneVelocities;
use super::meeting::Meeting;
use super::sides::shortened;
use super::solver_bodies::{Lines, SolverBodies};
use super::speculative_contacts::BatchFlags;
use super::substep::Substep;
use super::timeline::{BatchLines, Timeline};
use super::touching::{Place, Touching};
use frangible_math::{Instructions, LANES, Mask, Single, Single3};

/// Bounds the visits of a substep to `VISITS * (VISITS + batches)`. A row of 500 touching balls has
/// 63 batches and takes 1,000 visits. Later impacts are stopped without bouncing.
const VISITS: usize = 32;

/// Bounds the work of a frame to that of the visits of so many substeps. Without a bound twelve
/// bodies in a crusher took 0.9 s for a frame, and 120 took 6.4 s; with it 0.67 s.
const FULL_SUBSTEPS: usize = 4;

/// Lanes of a body that are looked through in the time of a visit [1].
const LOOKS: usize = 64;

/// Batches that are asked for impacts in the time of a visit [1].
const ASKS: usize = 8;

/// Work that impacts may still cost.
#[derive(Clone, Copy)]
pub(super) struct ImpactBudget {
    /// Visits to batches in a substep.
    visits: usize,
    most_visits: usize,
    /// Work in a frame, in visits.
    work: usize,
}

impl ImpactBudget {
    pub(super) fn of_frame(batches: usize) -> Self {
        let most_visits = VISITS * (VISITS + batches);
        Self { visits: most_visits, most_visits, work: FULL_SUBSTEPS * most_visits }
    }

    pub(super) fn begin_substep(&mut self) {
        self.visits = self.most_visits;
    }

    /// True if all impacts from here on are stopped.
    pub(super) fn is_spent(&self) -> bool {
        self.visits == 0 || self.work == 0
    }

    /// True if the work of the frame is done before the frame is.
    pub(super) fn is_short(&self) -> bool {
        self.work == 0
    }

    fn visit(&mut self) {
        self.visits = self.visits.saturating_sub(1);
        self.work(1);
    }

    fn work(&mut self, work: usize) {
        self.work = self.work.saturating_sub(work);
    }
}

/// Maximum number of Gauss-Seidel sweeps over the points of an impact, and change of a velocity in a
/// sweep, relative to the fastest approach, at which they end [1].
const SWEEPS: usize = 32;
const CLOSE: f32 = 1e-4;

/// Propagates impacts until no contact approaches faster than the threshold. In each round a pair
/// may bounce only if neither body has an earlier impact: a body that travels past several
/// neighbours in a substep hits the nearest first. What that costs is taken off `budget`.
#[inline(always)]
pub(super) fn propagate_impacts<I: Instructions>(
    batches: &mut [ContactBatch<I>],
    bodies: &mut SolverBodies,
    (timeline, touching): (&mut Timeline, &Touching),
    asking: &BatchFlags,
    budget: &mut ImpactBudget,
    substep: &Substep<I>,
) {
    let may_bounce = |batch: &ContactBatch<I>| batch.may_bounce && batch.bounces.any();
    let mut asked = std::mem::take(&mut timeline.asked);
    let mut coming = std::mem::take(&mut timeline.coming);
    (0..batches.len()).filter(|&at| may_bounce(&batches[at])).for_each(|at| asked.insert(at));
    for (needs, batch) in timeline.needs.iter_mut().zip(batches.iter()) {
        // Lanes with restitution have unknown needs: zero asks at the first change.
        *needs = std::array::from_fn(|lane| if batch.bounces.get(lane) { 0.0 } else { f32::MAX });
    }
    loop {
        timeline.next_round();
        let (mut from, mut count) = (0, 0);
        while let Some(at) = asked.take_from(from) {
            (from, count) = (at + 1, count + 1);
            let batch = &mut batches[at];
            let lines = &bodies.lines(batch.first_line..bodies.lines.len());
            let of_batch = BatchLines::new(batch);
            let meeting = batch.meeting(lines, of_batch.clocks(timeline), substep);
            of_batch.claim(timeline, meeting.hits, meeting.first.to_array());
            if meeting.waits.any() {
                batch.asks = batch.asks.or(meeting.waits);
                asking.insert(at);
            }
            timeline.needs[at] = meeting.needs.to_array();
            if meeting.hits.any() {
                coming.insert(at);
            }
        }
        budget.work(count / ASKS);
        if coming.is_empty() {
            break;
        }
        let mut from = 0;
        while let Some(at) = coming.take_from(from) {
            from = at + 1;
            if budget.is_spent() {
                continue;
            }
            budget.visit();
            let links = (&mut *timeline, touching, &mut *budget);
            let joint = bounce_jointly(batches, bodies, links, at, substep);
            let batch = &mut batches[at];
            let of_batch = BatchLines::new(batch);
            let mut lines = bodies.lines(batch.first_line..bodies.lines.len());
            let changes = batch.bounce(&mut lines, (timeline, of_batch), substep);
            if batch.may_bounce {
                asked.insert(at);
            }
            let changed = of_batch.changed(timeline, changes);
            for (line, change) in joint.into_iter().chain(changed) {
                for place in touching.lanes(line) {
                    let next = place.batch();
                    let need = &mut timeline.needs[next][place.lane()];
                    *need -= change;
                    if *need <= 0.0 {
                        asked.insert(next);
                        if next > at {
                            coming.insert(next);
                        }
                    }
                }
            }
        }
        if budget.is_spent() {
            break;
        }
    }
    asked.clear();
    (timeline.asked, timeline.coming) = (asked, coming);
    timeline.end();
}

/// Bounces those lanes of a batch that have a joint impact with others. Returns the lines whose
/// velocities change, and upper bounds of the changes [m/s].
#[inline(always)]
fn bounce_jointly<I: Instructions>(
    batches: &mut [ContactBatch<I>],
    bodies: &mut SolverBodies,
    (timeline, touching, budget): (&mut Timeline, &Touching, &mut ImpactBudget),
    at: usize,
    substep: &Substep<I>,
) -> Vec<(usize, f32)> {
    let batch = &batches[at];
    if !batch.companions.any() {
        return Vec::new();
    }
    let lines = &bodies.lines(batch.first_line..bodies.lines.len());
    let of_batch = BatchLines::new(batch);
    let meeting = batch.meeting(lines, of_batch.clocks(timeline), substep);
    let hits = meeting.hits.and(batch.companions);
    let are_next = of_batch.are_next(timeline, hits, meeting.first.to_array());
    let mut changed = Vec::new();
    for lane in (0..LANES).filter(|&lane| are_next.get(lane)) {
        let of_lane = (Place::new(at, lane), &meeting);
        let joint = JointImpact::of_lane(batches, bodies, (timeline, touching), of_lane, substep);
        let [first, second] = batches[at].lines_of(lane);
        let looked_through = touching.lanes(first).len().max(touching.lanes(second).len());
        budget.work(looked_through / LOOKS);
        if let Some(joint) = joint {
            budget.work(joint.work());
            changed.extend(joint.bounce(batches, bodies, timeline, substep));
        }
    }
    changed
}

impl<I: Instructions> ContactBatch<I> {
    /// Bounces each lane at its time of impact unless one of its bodies has an earlier impact.
    /// Returns an upper bound of each body's change of point velocity [m/s].
    #[inline(always)]
    fn bounce(
        &mut self,
        lines: &mut Lines,
        (timeline, of_batch): (&mut Timeline, BatchLines),
        substep: &Substep<I>,
    ) -> [[f32; LANES]; 2] {
        let zero = Single::<I>::ZERO;
        let n = self.normal;
        let Meeting { mut sides, at, arms, approach, target, time, meets, hits, first, .. } =
            self.meeting(lines, of_batch.clocks(timeline), substep);
        let are_next = of_batch.are_next(timeline, hits, first.to_array());
        self.may_bounce = hits.and(are_next.not()).any();
        let hits = are_next;
        if !hits.any() {
            return [[0.0; LANES]; 2];
        }

        if self.is_stale {
            self.prepare(lines);
        }
        let mut impulses = self.solve_impact(approach, &target, &meets, hits);
        let (mut sum, mut moments, mut when) = (zero, [Single3::ZERO; 2], zero);
        for i in 0..self.point_count {
            sum = sum + impulses[i];
            when = when + impulses[i] * time[i];
            for side in 0..2 {
                moments[side] = moments[side] + arms[i][side] * impulses[i];
            }
        }
        let when = sum.above(zero).select(when / sum, zero);

        // K belongs to the poses of the last `prepare`, and the bodies may have turned since. Scale
        // the impulse to add no energy to the pair.
        let mut lost = zero;
        for i in 0..self.point_count {
            lost = lost - impulses[i] * approach[i];
        }
        let scale = shortened(sides.work_of(sum, moments), lost + lost);
        let share = reciprocal(sum);
        let middle = [moments[0] * share, moments[1] * share];
        let sum = sum * scale;
        let mut twist_arm = zero;
        for i in 0..self.point_count {
            impulses[i] = impulses[i] * scale;
            // The nearer center has the smaller rounding error.
            let [a, b] = [0, 1].map(|side| arms[i][side] - middle[side]);
            twist_arm = twist_arm + impulses[i] * a.dot(a).min(b.dot(b)).sqrt();
        }
        let before = sides.of;
        sides.push(n, sum, [moments[0] * scale, moments[1] * scale]);

        let noted = hits.and(self.breakable);
        for lane in (0..LANES).filter(|&lane| noted.get(lane)) {
            let bodies = self.ids.map(|of_side| lines.bodies[of_side[lane] as usize]);
            let of_lane = impulses.map(|impulse| impulse.get(lane));
            timeline.impacts.note(self, lane, bodies, of_lane, when.get(lane));
        }
        let acting = (sum, &impulses, twist_arm);
        let (friction, slip) = self.rub_impact(&mut sides, &at, acting);
        self.book_impact(sum, friction, slip);
        if self.has_driven() {
            self.note_driven_work(lines, impulses, [friction[0], friction[1]], friction[2]);
        }
        self.store(&sides, lines);

        // Until the time of impact the bodies moved with their old velocities.
        let mut changes = [zero; 2];
        for side in 0..2 {
            let linear = sides.of[side].linear - before[side].linear;
            let angular = sides.of[side].angular - before[side].angular;
            at[side].retreat((lines.bodies, &self.ids[side]), hits, (linear, angular), when);
            // The body's spin also rotates arms within the substep.
            let LaneVelocities { angular: spin, radius, .. } = sides.of[side];
            let turns = angular.dot(angular).sqrt() * radius;
            let turns = turns + turns * spin.dot(spin).sqrt() * substep.h;
            changes[side] = hits.select(linear.dot(linear).sqrt() + turns, zero);
        }
        of_batch.mark(timeline, hits, when.to_array());
        changes.map(Single::to_array)
    }

    /// Impulses of all meeting points together, towards the targets and never negative. The
    /// iteration begins with equal impulses, as flat impacts of faces need.
    #[inline(always)]
    fn solve_impact(
        &self,
        mut velocity: [Single<I>; MOST_POINTS],
        target: &[Single<I>; MOST_POINTS],
        meets: &[Mask; MOST_POINTS],
        hits: Mask,
    ) -> [Single<I>; MOST_POINTS] {
        let zero = Single::ZERO;
        let (mut missing, mut yields) = (zero, [zero; MOST_POINTS]);
        let mut slowest = zero;
        for i in 0..self.point_count {
            slowest = slowest.min(meets[i].select(velocity[i], zero));
            missing = missing + meets[i].select(target[i] - velocity[i], zero);
            for j in 0..self.point_count {
                let both = meets[i].and(meets[j]);
                yields[i] = yields[i] + both.select(self.k[ENTRY[i][j]], zero);
            }
        }
        let all = (yields[0] + yields[1]) + (yields[2] + yields[3]);
        let equal = hits.select((missing * reciprocal(all)).max(zero), zero);
        let mut impulses = [zero; MOST_POINTS];
        for i in 0..self.point_count {
            impulses[i] = meets[i].select(equal, zero);
            velocity[i] = velocity[i] + equal * yields[i];
        }
        let close = slowest * Single::same(-CLOSE);
        for _ in 0..SWEEPS {
            let mut largest = zero;
            for i in 0..self.point_count {
                let change = self.points[i].effective_mass * (velocity[i] - target[i]);
                let impulse = (impulses[i] - change).max(zero);
                let impulse = hits.and(meets[i]).select(impulse, zero);
                let given = impulse - impulses[i];
                impulses[i] = impulse;
                let moved = self.k[ENTRY[i][i]] * given;
                largest = largest.max(moved.max(-moved));
                for j in 0..self.point_count {
                    velocity[j] = velocity[j] + self.k[ENTRY[i][j]] * given;
                }
            }
            if !largest.above(close).any() {
                break;
            }
        }
        impulses
    }
}
