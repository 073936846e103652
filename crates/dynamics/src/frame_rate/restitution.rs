//! Impacts that follow each other within a substep, each at its time: what bounces passes its
//! impulse on at once, through rows of any length.

use super::constraints::MOST_POINTS;
use super::contact_batch::{ContactBatch, ENTRY, reciprocal};
use super::kernels::{POINT_SWEEPS, Sides, Substep, clamp_to_cone, shortened, stopping};
use super::slabs::Slab;
use super::solver_bodies::{LaneDisplacements, Lines, SolverBodies, SolverBody};
use frangible_math::{Instructions, LANES, Mask, Single, Single3, Singles};

/// Visits of batches in a substep's impacts: at least, and per batch. A row of 500 touching
/// balls takes 1,000; what comes later is stopped without bouncing.
const LEAST_VISITS: usize = 4096;
const VISITS_PER_BATCH: usize = 4;

/// Slower than this against what it would touch within the substep nothing is timed [m/s].
const LEAST_SPEED: f32 = 1e-9;

/// Propagates impacts until none approaches faster than the threshold. In each round of visits a
/// pair may bounce only if neither of its bodies bounces earlier: a body that comes further than
/// its neighbours in a substep meets the nearest one first.
#[inline(always)]
pub(super) fn propagate_impacts<I: Instructions>(
    slabs: &mut [Slab<I>],
    bodies: &mut SolverBodies,
    timeline: &mut Timeline,
    substep: &Substep<I>,
) {
    let batches: usize = slabs.iter().map(|slab| slab.batches.len()).sum();
    let mut visits = LEAST_VISITS + VISITS_PER_BATCH * batches;
    loop {
        timeline.next_round();
        let mut any = false;
        for Slab { batches, first_line } in slabs.iter_mut() {
            let lines = bodies.lines(*first_line..bodies.lines.len());
            for batch in batches.iter_mut().filter(|batch| batch.bounces.any()) {
                let of_batch = timeline.of(&batch.ids, *first_line);
                if batch.may_bounce || of_batch.is_recent(timeline) {
                    let meeting = batch.meeting(&lines, of_batch.clocks(timeline), substep);
                    of_batch.claim(timeline, meeting.hits, meeting.first.to_array());
                    batch.may_bounce = meeting.hits.any();
                    any |= batch.may_bounce;
                }
            }
        }
        if !any {
            break;
        }
        for Slab { batches, first_line } in slabs.iter_mut() {
            let mut lines = bodies.lines(*first_line..bodies.lines.len());
            for batch in batches.iter_mut().filter(|batch| batch.bounces.any()) {
                let of_batch = timeline.of(&batch.ids, *first_line);
                if visits > 0 && (batch.may_bounce || of_batch.is_changed(timeline)) {
                    visits -= 1;
                    batch.bounce(&mut lines, (timeline, of_batch), substep);
                }
            }
        }
        if visits == 0 {
            break;
        }
    }
    timeline.end();
}

/// When bodies bounce within a substep.
pub(super) struct Timeline {
    round: u32,
    /// The round in which each body was last changed.
    changed: Vec<u32>,
    /// When each body bounces next, as far as this round knows, and did last in this substep [s].
    next: Vec<f32>,
    last: Vec<f32>,
    /// Lines whose times are to be forgotten.
    claimed: Vec<usize>,
    bounced: Vec<usize>,
    is_movable: Vec<bool>,
}

/// The lines of a batch.
#[derive(Clone, Copy)]
struct LinesOf {
    lines: [[usize; LANES]; 2],
}

impl Timeline {
    pub(super) fn new(bodies: &SolverBodies) -> Self {
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
        }
    }

    fn next_round(&mut self) {
        self.round += 1;
        for line in self.claimed.drain(..) {
            self.next[line] = f32::INFINITY;
        }
    }

    /// The substep is over.
    fn end(&mut self) {
        self.next_round();
        for line in self.bounced.drain(..) {
            self.last[line] = 0.0;
        }
    }

    fn of(&self, ids: &[[u32; LANES]; 2], first_line: usize) -> LinesOf {
        LinesOf { lines: ids.map(|of_side| of_side.map(|id| first_line + id as usize)) }
    }
}

impl LinesOf {
    /// True if any of these bodies was changed in the last round.
    fn is_recent(&self, timeline: &Timeline) -> bool {
        self.lines.iter().flatten().any(|&line| timeline.changed[line] + 1 == timeline.round)
    }

    /// The same in this round.
    fn is_changed(&self, timeline: &Timeline) -> bool {
        self.lines.iter().flatten().any(|&line| timeline.changed[line] == timeline.round)
    }

    /// When either body of each lane bounced last [s].
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

    /// Some lanes would bounce then [s].
    fn claim(&self, timeline: &mut Timeline, lanes: Mask, times: [f32; LANES]) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in self.movable(timeline, lane) {
                timeline.claimed.push(line);
                timeline.next[line] = timeline.next[line].min(times[lane]);
            }
        }
    }

    /// Lanes of which neither body bounces earlier. A body that has bounced in this round may do
    /// so again at the same time.
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

    /// Some lanes have bounced.
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

/// The points of a batch that meet within a substep.
struct Meeting<I> {
    sides: Sides<I>,
    at: [LaneDisplacements<I>; 2],
    /// Of each point: moments of a unit impulse, velocity, and what it shall become [m/s].
    arms: [[Single3<I>; 2]; MOST_POINTS],
    approach: [Single<I>; MOST_POINTS],
    target: [Single<I>; MOST_POINTS],
    /// When it meets [s], if it does.
    time: [Single<I>; MOST_POINTS],
    meets: [Mask; MOST_POINTS],
    /// Lanes in which anything meets fast, and when it does first [s].
    hits: Mask,
    first: Single<I>,
}

impl<I: Instructions> ContactBatch<I> {
    /// The points that will meet within the substep faster than the threshold, none before its
    /// `clock` [s].
    #[inline(always)]
    fn meeting(&self, lines: &Lines, clock: [f32; LANES], substep: &Substep<I>) -> Meeting<I> {
        let zero = Single::<I>::ZERO;
        let n = self.normal;
        let sides = self.sides(lines);
        let at = self.displacements(lines);
        let linear = n.dot(sides.of[1].linear - sides.of[0].linear);
        let apart = n.dot(at[1].translation - at[0].translation);
        let clock = Single::of_column(&Singles(clock));

        // Gravity has kicked for the whole substep.
        let mut arms = [[Single3::ZERO; 2]; MOST_POINTS];
        let (mut approach, mut target) = ([zero; MOST_POINTS], [zero; MOST_POINTS]);
        let (mut time, mut first) = ([zero; MOST_POINTS], substep.h);
        let (mut meets, mut hits) = ([Mask::NONE; MOST_POINTS], Mask::NONE);
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
        }
        let hits = hits.and(self.bounces);
        Meeting { sides, at, arms, approach, target, time, meets, hits, first }
    }

    /// Bounces what meets, at the time at which it does, where neither body bounces earlier.
    #[inline(always)]
    fn bounce(
        &mut self,
        lines: &mut Lines,
        (timeline, of_batch): (&mut Timeline, LinesOf),
        substep: &Substep<I>,
    ) {
        let zero = Single::<I>::ZERO;
        let n = self.normal;
        let Meeting { mut sides, at, arms, approach, target, time, meets, hits, first } =
            self.meeting(lines, of_batch.clocks(timeline), substep);
        let are_next = of_batch.are_next(timeline, hits, first.to_array());
        self.may_bounce = hits.and(are_next.not()).any();
        let hits = are_next;
        if !hits.any() {
            return;
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

        // Shortened to what gives the pair no energy: K is that of where the bodies were
        // prepared, and they may have turned since.
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

        // Until then the bodies went on as they were.
        for side in 0..2 {
            let linear = sides.of[side].linear - before[side].linear;
            let angular = sides.of[side].angular - before[side].angular;
            at[side].retreat((lines.bodies, &self.ids[side]), hits, (linear, angular), when);
        }
        of_batch.mark(timeline, hits, when.to_array());
    }

    /// The impulses of all points that meet, together: towards the targets, and none that pulls.
    /// They begin with equal ones, which faces that meet flat need.
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
        for _ in 0..POINT_SWEEPS {
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

    /// Friction of an impact of this size, and the slip before it along both tangents.
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
