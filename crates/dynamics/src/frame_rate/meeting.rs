//! Points that meet within a substep, and when.

use super::constraints::MOST_POINTS;
use super::contact_batch::ContactBatch;
use super::lane_bodies::{LaneDisplacements, LaneVelocities};
use super::sides::Sides;
use super::solver_bodies::Lines;
use super::substep::Substep;
use frangible_math::{Instructions, LANES, Mask, Single, Single3, Singles};

/// Minimum closing speed in a time of impact [m/s].
const LEAST_SPEED: f32 = 1e-9;

/// Points no farther apart touch, relative to the larger body: they resist an impact at another point
/// at once. Rounding lifts what rests by less, and a foot that felt the slam of the head a substep
/// later took 1/9 off its blow, at 3000 Hz.
const TOUCHING: f32 = 1e-3;

/// Points of a batch that meet within a substep.
pub(super) struct Meeting<I> {
    pub(super) sides: Sides<I>,
    pub(super) at: [LaneDisplacements<I>; 2],
    /// Per point: moments of a unit impulse, velocity, and target velocity [m/s].
    pub(super) arms: [[Single3<I>; 2]; MOST_POINTS],
    pub(super) approach: [Single<I>; MOST_POINTS],
    pub(super) target: [Single<I>; MOST_POINTS],
    /// Time of impact [s], and validity.
    pub(super) time: [Single<I>; MOST_POINTS],
    pub(super) meets: [Mask; MOST_POINTS],
    /// Lanes with an impact above the threshold, those that must be detected again before it, and
    /// the first time of impact [s].
    pub(super) hits: Mask,
    pub(super) waits: Mask,
    pub(super) first: Single<I>,
    /// Velocity change of each lane that would cause an impact [m/s].
    pub(super) needs: Single<I>,
}

impl<I: Instructions> ContactBatch<I> {
    /// Finds the points that meet within the substep; none before its `clock` [s].
    #[inline(always)]
    pub(super) fn meeting(
        &self,
        lines: &Lines,
        clock: [f32; LANES],
        substep: &Substep<I>,
    ) -> Meeting<I> {
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
        let sizes = [0, 1].map(|side| {
            let LaneVelocities { inverse_mass, radius, .. } = sides.of[side];
            inverse_mass.above(zero).select(radius, zero)
        });
        let touching = sizes[0].max(sizes[1]) * Single::same(TOUCHING);
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
            let gap = separation + velocity * substep.h;
            meets[i] = touching.above(gap);
            target[i] = is_fast.select(later - self.restitution * at_impact, zero);
            let hit = is_fast.and(zero.above(gap));
            first = hit.select(first.min(time[i]), first);
            hits = hits.or(hit);
            let to_meet = separation * substep.per_second + velocity;
            let slowest = velocity - (self.gravity * substep.h).max(zero);
            needs = needs.min(to_meet.max(slowest - substep.bounce_velocity));
        }
        let hits = hits.and(self.bounces);
        let (hits, waits) =
            (hits.and(self.unconfirmed.not()), hits.and(self.unconfirmed).and(self.passes.not()));
        let needs = self.bounces.select(needs, never);
        Meeting { sides, at, arms, approach, target, time, meets, hits, waits, first, needs }
    }
}
