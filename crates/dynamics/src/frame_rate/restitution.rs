//! Impacts that follow each other within a substep, each at its time: what bounces passes its
//! impulse on at once, through rows of any length.

use super::constraints::MOST_POINTS;
use super::contact_batch::{ContactBatch, ENTRY};
use super::kernels::{POINT_SWEEPS, Sides, Substep, clamp_to_cone, shortened, stopping};
use super::slabs::Slab;
use super::solver_bodies::{LaneDisplacements, Lines, SolverBodies, SolverBody};
use frangible_math::{Instructions, LANES, Mask, Single, Single3};

/// Visits of batches in a substep's impacts: at least, and per batch. A row of 500 touching
/// balls takes 1,000; what comes later is stopped without bouncing.
const LEAST_VISITS: usize = 4096;
const VISITS_PER_BATCH: usize = 4;

/// Slower than this against what it would touch within the substep nothing is timed [m/s].
const LEAST_SPEED: f32 = 1e-9;

/// Propagates impacts: visits what may come, then all batches of bodies that an impact changed,
/// until none approaches faster than the threshold. `stamps` is room, one for each body.
#[inline(always)]
pub(super) fn propagate_impacts<I: Instructions>(
    slabs: &mut [Slab<I>],
    bodies: &mut SolverBodies,
    stamps: &mut Stamps,
    substep: &Substep<I>,
) {
    let batches: usize = slabs.iter().map(|slab| slab.batches.len()).sum();
    let mut visits = LEAST_VISITS + VISITS_PER_BATCH * batches;
    let mut is_first = true;
    loop {
        stamps.next();
        let mut any = Mask::NONE;
        for Slab { batches, first_line } in slabs.iter_mut() {
            let mut lines = bodies.lines(*first_line..bodies.lines.len());
            for batch in batches.iter_mut().filter(|batch| batch.bounces.any()) {
                let looks = if is_first {
                    std::mem::replace(&mut batch.may_bounce, false)
                } else {
                    stamps.are_recent(&batch.ids, *first_line)
                };
                if looks && visits > 0 {
                    visits -= 1;
                    let hit = batch.impact(&mut lines, substep);
                    stamps.mark((&batch.ids, *first_line), hit);
                    any = any.or(hit);
                }
            }
        }
        if !any.any() || visits == 0 {
            return;
        }
        is_first = false;
    }
}

/// In which round each body was last changed.
pub(super) struct Stamps {
    round: u32,
    of: Vec<u32>,
    is_movable: Vec<bool>,
}

impl Stamps {
    pub(super) fn new(bodies: &SolverBodies) -> Self {
        let is_movable: Vec<bool> = bodies.lines.iter().map(SolverBody::is_movable).collect();
        Self { round: 1, of: vec![0; is_movable.len()], is_movable }
    }

    fn next(&mut self) {
        self.round += 1;
    }

    /// True if any of these bodies was changed in this round or the last one.
    fn are_recent(&self, ids: &[[u32; LANES]; 2], first_line: usize) -> bool {
        let of = &self.of[first_line..];
        ids.iter().flatten().any(|&id| of[id as usize] + 1 >= self.round)
    }

    fn mark(&mut self, (ids, first_line): (&[[u32; LANES]; 2], usize), lanes: Mask) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in [0, 1].map(|side| first_line + ids[side][lane] as usize) {
                if self.is_movable[line] {
                    self.of[line] = self.round;
                }
            }
        }
    }
}

impl<I: Instructions> ContactBatch<I> {
    /// Bounces what will meet within the substep faster than the threshold, at the time at
    /// which it does. Returns the lanes in which anything did.
    #[inline(always)]
    fn impact(&mut self, lines: &mut Lines, substep: &Substep<I>) -> Mask {
        let zero = Single::<I>::ZERO;
        let n = self.normal;
        let mut sides = self.sides(lines);
        let at = self.displacements(lines);
        let linear = n.dot(sides.of[1].linear - sides.of[0].linear);
        let apart = n.dot(at[1].translation - at[0].translation);

        // Points that meet, when, and how fast then: gravity has kicked for the whole substep.
        let mut arms = [[Single3::ZERO; 2]; MOST_POINTS];
        let (mut approach, mut target) = ([zero; MOST_POINTS], [zero; MOST_POINTS]);
        let mut time = [zero; MOST_POINTS];
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
            time[i] = (separation / closing).max(zero).min(substep.h);
            let later = self.gravity * (substep.h - time[i]);
            let at_impact = velocity - later;
            let is_fast = substep.bounce_velocity.above(at_impact);
            meets[i] = zero.above(separation + velocity * substep.h);
            target[i] = is_fast.select(later - self.restitution * at_impact, zero);
            hits = hits.or(is_fast.and(meets[i]));
        }
        let hits = hits.and(self.bounces);
        if !hits.any() {
            return hits;
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
        hits
    }

    /// The impulses of all points that meet, together: towards the targets, and none that pulls.
    #[inline(always)]
    fn solve_impact(
        &self,
        mut velocity: [Single<I>; MOST_POINTS],
        target: &[Single<I>; MOST_POINTS],
        meets: &[Mask; MOST_POINTS],
        hits: Mask,
    ) -> [Single<I>; MOST_POINTS] {
        let zero = Single::ZERO;
        let mut impulses = [zero; MOST_POINTS];
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
