//! Restitution: impacts within a substep, in the order of their times of impact. Impulses propagate
//! at once through rows of any length.

use super::constraints::MOST_POINTS;
use super::contact_batch::{ContactBatch, ENTRY, reciprocal};
use super::kernels::{Sides, Substep, clamp_to_cone, shortened, stopping};
use super::solver_bodies::{LaneDisplacements, LaneVelocities, Lines, SolverBodies, SolverBody};
use super::touching::Touching;
use frangible_math::{Instructions, LANES, Mask, Single, Single3, Singles};

/// Bounds the visits of a substep to `VISITS * (VISITS + batches)`. A row of 500 touching balls has
/// 63 batches and takes 1,000 visits. Later impacts are stopped without bouncing.
const VISITS: usize = 32;

/// Minimum closing speed in a time of impact [m/s].
const LEAST_SPEED: f32 = 1e-9;

/// Propagates impacts until no contact approaches faster than the threshold. In each round a pair
/// may bounce only if neither body has an earlier impact: a body that travels past several
/// neighbours in a substep hits the nearest first.
#[inline(always)]
pub(super) fn propagate_impacts<I: Instructions>(
    batches: &mut [ContactBatch<I>],
    bodies: &mut SolverBodies,
    (timeline, touching): (&mut Timeline, &Touching),
    substep: &Substep<I>,
) {
    let mut visits = VISITS * (VISITS + batches.len());
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
        let mut from = 0;
        while let Some(at) = asked.take_from(from) {
            from = at + 1;
            let batch = &mut batches[at];
            let lines = &bodies.lines(batch.first_line..bodies.lines.len());
            let of_batch = LinesOf::new(batch);
            let meeting = batch.meeting(lines, of_batch.clocks(timeline), substep);
            of_batch.claim(timeline, meeting.hits, meeting.first.to_array());
            timeline.needs[at] = meeting.needs.to_array();
            if meeting.hits.any() {
                coming.insert(at);
            }
        }
        if coming.is_empty() {
            break;
        }
        let mut from = 0;
        while let Some(at) = coming.take_from(from) {
            from = at + 1;
            if visits == 0 {
                continue;
            }
            visits -= 1;
            let batch = &mut batches[at];
            let of_batch = LinesOf::new(batch);
            let mut lines = bodies.lines(batch.first_line..bodies.lines.len());
            let changes = batch.bounce(&mut lines, (timeline, of_batch), substep);
            if batch.may_bounce {
                asked.insert(at);
            }
            for (line, change) in of_batch.changed(timeline, changes) {
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
        if visits == 0 {
            break;
        }
    }
    asked.clear();
    (timeline.asked, timeline.coming) = (asked, coming);
    timeline.end();
}

/// Impact times of bodies within a substep.
pub(super) struct Timeline {
    round: u32,
    /// Round of each body's last velocity change.
    changed: Vec<u32>,
    /// Time of each body's next impact in this round, and of its last impact in this substep [s].
    next: Vec<f32>,
    last: Vec<f32>,
    /// Lines with times to reset.
    claimed: Vec<usize>,
    bounced: Vec<usize>,
    is_movable: Vec<bool>,
    /// Batches to test for impacts, and batches with impacts; both empty between substeps.
    asked: Numbers,
    coming: Numbers,
    /// Velocity change of each lane that would cause an impact [m/s].
    needs: Vec<[f32; LANES]>,
}

/// A set of batch indices with extraction in ascending order.
#[derive(Default)]
struct Numbers {
    /// One bit per index.
    words: Vec<u64>,
}

impl Numbers {
    fn below(most: usize) -> Self {
        Self { words: vec![0; most.div_ceil(64)] }
    }

    fn insert(&mut self, number: usize) {
        self.words[number / 64] |= 1 << (number % 64);
    }

    fn clear(&mut self) {
        self.words.fill(0);
    }

    fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Removes and returns the smallest index not below `from`.
    fn take_from(&mut self, from: usize) -> Option<usize> {
        let first = self.words.get(from / 64)? & (u64::MAX << (from % 64));
        let mut at = from / 64;
        let mut word = first;
        while word == 0 {
            at += 1;
            word = *self.words.get(at)?;
        }
        let bit = word.trailing_zeros();
        self.words[at] &= !(1 << bit);
        Some(64 * at + bit as usize)
    }
}

/// Solver lines of a batch.
#[derive(Clone, Copy)]
struct LinesOf {
    lines: [[usize; LANES]; 2],
}

impl Timeline {
    pub(super) fn new(bodies: &SolverBodies, batches: usize) -> Self {
        let is_movable: Vec<bool> = bodies.lines.iter().map(SolverBody::is_movable).collect();
        let count = is_movable.len();
        Self {
            round: 1,
            changed: vec![0; count],
            next: vec![f32::INFINITY; count],
            last: vec![0.0; count],
            claimed: Vec::new(),
            bounced: Vec::new(),
            is_movable,
            asked: Numbers::below(batches),
            coming: Numbers::below(batches),
            needs: vec![[0.0; LANES]; batches],
        }
    }

    fn next_round(&mut self) {
        self.round += 1;
        for line in self.claimed.drain(..) {
            self.next[line] = f32::INFINITY;
        }
    }

    /// Resets all times at the end of a substep.
    fn end(&mut self) {
        self.next_round();
        for line in self.bounced.drain(..) {
            self.last[line] = 0.0;
        }
    }
}

impl LinesOf {
    fn new<I>(batch: &ContactBatch<I>) -> Self {
        Self { lines: batch.lines() }
    }

    /// Time of the last impact of either body of each lane [s].
    fn clocks(&self, timeline: &Timeline) -> [f32; LANES] {
        std::array::from_fn(|lane| {
            let [first, second] = [0, 1].map(|side| timeline.last[self.lines[side][lane]]);
            first.max(second)
        })
    }

    fn movable(self, timeline: &Timeline, lane: usize) -> impl Iterator<Item = usize> + use<> {
        let lines = [0, 1].map(|side| self.lines[side][lane]);
        let is_movable = lines.map(|line| timeline.is_movable[line]);
        (0..2).filter(move |&side| is_movable[side]).map(move |side| lines[side])
    }

    /// Bodies with a changed velocity, and an upper bound of the change [m/s].
    fn changed(
        self,
        timeline: &Timeline,
        by: [[f32; LANES]; 2],
    ) -> impl Iterator<Item = (usize, f32)> + use<> {
        let of_line = |side: usize, lane: usize| {
            let line = self.lines[side][lane];
            (timeline.is_movable[line] && by[side][lane] > 0.0).then_some((line, by[side][lane]))
        };
        let all: [[Option<(usize, f32)>; LANES]; 2] =
            std::array::from_fn(|side| std::array::from_fn(|lane| of_line(side, lane)));
        all.into_iter().flatten().flatten()
    }

    /// Registers the times of possible impacts [s].
    fn claim(&self, timeline: &mut Timeline, lanes: Mask, times: [f32; LANES]) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in self.movable(timeline, lane) {
                timeline.claimed.push(line);
                timeline.next[line] = timeline.next[line].min(times[lane]);
            }
        }
    }

    /// Lanes in which neither body has an earlier impact. A body may bounce several times in a
    /// round at the same time.
    fn are_next(&self, timeline: &Timeline, lanes: Mask, times: [f32; LANES]) -> Mask {
        let mut are_next = Mask::NONE;
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            let is_next = |line: usize| {
                let is_known = timeline.changed[line] != timeline.round;
                let earliest = if is_known { timeline.next[line] } else { timeline.last[line] };
                times[lane] <= earliest
            };
            are_next.set(lane, self.movable(timeline, lane).all(is_next));
        }
        are_next
    }

    /// Registers the impacts of some lanes.
    fn mark(&self, timeline: &mut Timeline, lanes: Mask, times: [f32; LANES]) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in self.movable(timeline, lane) {
                timeline.changed[line] = timeline.round;
                timeline.last[line] = timeline.last[line].max(times[lane]);
                timeline.bounced.push(line);
            }
        }
    }
}

/// Points of a batch that meet within a substep.
struct Meeting<I> {
    sides: Sides<I>,
    at: [LaneDisplacements<I>; 2],
    /// Per point: moments of a unit impulse, velocity, and target velocity [m/s].
    arms: [[Single3<I>; 2]; MOST_POINTS],
    approach: [Single<I>; MOST_POINTS],
    target: [Single<I>; MOST_POINTS],
    /// Time of impact [s], and validity.
    time: [Single<I>; MOST_POINTS],
    meets: [Mask; MOST_POINTS],
    /// Lanes with an impact above the threshold, and the first time of impact [s].
    hits: Mask,
    first: Single<I>,
    /// Velocity change of each lane that would cause an impact [m/s].
    needs: Single<I>,
}

impl<I: Instructions> ContactBatch<I> {
    /// Finds the points that meet within the substep; none before its `clock` [s].
    #[inline(always)]
    fn meeting(&self, lines: &Lines, clock: [f32; LANES], substep: &Substep<I>) -> Meeting<I> {
        let zero = Single::<I>::ZERO;
        let n = self.normal;
        let sides = self.sides(lines);
        let at = self.displacements(lines);
        let linear = n.dot(sides.of[1].linear - sides.of[0].linear);
        let apart = n.dot(at[1].translation - at[0].translation);
        let clock = Single::of_column(&Singles(clock));

        // Velocities include gravity's kick of the whole substep.
        let mut arms = [[Single3::ZERO; 2]; MOST_POINTS];
        let (mut approach, mut target) = ([zero; MOST_POINTS], [zero; MOST_POINTS]);
        let (mut time, mut first) = ([zero; MOST_POINTS], substep.h);
        let (mut meets, mut hits) = ([Mask::NONE; MOST_POINTS], Mask::NONE);
        let never = Single::same(f32::MAX);
        let mut needs = never;
        for i in 0..self.point_count {
            let anchors = self.points[i].anchors;
            let turns = [at[0].turn_of(anchors[0]), at[1].turn_of(anchors[1])];
            let separation = self.points[i].separation + apart + n.dot(turns[1] - turns[0]);
            arms[i] = [(anchors[0] + turns[0]).cross(n), (anchors[1] + turns[1]).cross(n)];
            let velocity =
                linear + arms[i][1].dot(sides.of[1].angular) - arms[i][0].dot(sides.of[0].angular);
            approach[i] = velocity;
            let closing = (-velocity).max(Single::same(LEAST_SPEED));
            time[i] = (separation / closing).max(clock).min(substep.h);
            let later = self.gravity * (substep.h - time[i]);
            let at_impact = velocity - later;
            let is_fast = substep.bounce_velocity.above(at_impact);
            meets[i] = zero.above(separation + velocity * substep.h);
            target[i] = is_fast.select(later - self.restitution * at_impact, zero);
            let hit = is_fast.and(meets[i]);
            first = hit.select(first.min(time[i]), first);
            hits = hits.or(hit);
            let to_meet = separation * substep.per_second + velocity;
            let slowest = velocity - (self.gravity * substep.h).max(zero);
            needs = needs.min(to_meet.max(slowest - substep.bounce_velocity));
        }
        let hits = hits.and(self.bounces);
        let needs = self.bounces.select(needs, never);
        Meeting { sides, at, arms, approach, target, time, meets, hits, first, needs }
    }

    /// Bounces each lane at its time of impact unless one of its bodies has an earlier impact.
    /// Returns an upper bound of each body's change of point velocity [m/s].
    #[inline(always)]
    fn bounce(
        &mut self,
        lines: &mut Lines,
        (timeline, of_batch): (&mut Timeline, LinesOf),
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
        let sum = sum * scale;
        let before = sides.of;
        sides.push(n, sum, [moments[0] * scale, moments[1] * scale]);

        let (friction, slip) = self.rub_impact(&mut sides, &at, sum);
        let rubs = sum.above(zero);
        self.acted = self.acted.or(rubs);
        self.frame_impulse[0] = self.frame_impulse[0] + sum;
        for k in 0..2 {
            self.frame_impulse[k + 1] = self.frame_impulse[k + 1] + friction[k];
            self.friction_work = self.friction_work + friction[k] * slip[k] * Single::same(0.5);
        }
        if self.has_driven() {
            for impulse in &mut impulses {
                *impulse = *impulse * scale;
            }
            self.note_driven_work(lines, impulses, friction, zero);
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
        for i in 0..self.point_count {
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
        for _ in 0..self.point_sweeps() {
            for i in 0..self.point_count {
                let change = self.points[i].effective_mass * (velocity[i] - target[i]);
                let impulse = (impulses[i] - change).max(zero);
                let impulse = hits.and(meets[i]).select(impulse, zero);
                let given = impulse - impulses[i];
                impulses[i] = impulse;
                for j in 0..self.point_count {
                    velocity[j] = velocity[j] + self.k[ENTRY[i][j]] * given;
                }
            }
        }
        impulses
    }

    /// Friction of an impact with normal impulse `sum`, and the slip before it along both tangents.
    #[inline(always)]
    fn rub_impact(
        &self,
        sides: &mut Sides<I>,
        at: &[LaneDisplacements<I>; 2],
        sum: Single<I>,
    ) -> ([Single<I>; 2], [Single<I>; 2]) {
        let zero = Single::ZERO;
        let centers = self.turned_centers(at);
        let tangents = [self.tangent, self.normal.cross(self.tangent)];
        let slip = sides.velocity_at(centers);
        let slip = [slip.dot(tangents[0]), slip.dot(tangents[1])];
        let wanted = stopping([zero; 2], self.tangent_mass, slip);
        let most = self.friction_coefficient * sum;
        let friction = clamp_to_cone(wanted, most);
        let rubs = sum.above(zero);
        let friction = [rubs.select(friction[0], zero), rubs.select(friction[1], zero)];
        let friction = sides.rub(friction, slip, tangents, centers);
        sides.push_at(centers, tangents[0] * friction[0] + tangents[1] * friction[1]);
        (friction, slip)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices come out in ascending order from the query on, including later inserts; smaller
    /// indices stay.
    #[test]
    fn numbers_are_taken_in_order() {
        let mut numbers = Numbers::below(200);
        [3, 64, 63, 199, 0, 128].into_iter().for_each(|number| numbers.insert(number));
        let (mut from, mut taken) = (1, Vec::new());
        while let Some(number) = numbers.take_from(from) {
            taken.push(number);
            from = number + 1;
            if number == 64 {
                [63, 65].into_iter().for_each(|number| numbers.insert(number));
            }
        }
        assert_eq!(taken, [3, 63, 64, 65, 128, 199]);
        assert_eq!([numbers.take_from(0), numbers.take_from(0)], [Some(0), Some(63)]);
        assert!(numbers.is_empty());
    }
}
