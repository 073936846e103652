//! How the points of a batch act on their bodies: one row after the other, all lanes at once.

use crate::Bodies;
use crate::contact_batch::Batch;
use crate::contact_kernels::{kick_of, leave, stop_approach, stop_roll, stop_slip, turn};
use crate::contact_rows::{Beat, Row, RowImpulse, Stage};
use crate::lanes::{Instructions, Lanes, Lanes3, Mask};
use crate::moving::{Movers, Side};
use crate::settings::Frame;
use crate::tally::{Cause, Tally};
use glam::DVec3;

/// Passes to and fro over the points of one pair that meet fast: a cube that lands flat keeps 1e-3 of the turn that one pass gives it.
const TOGETHER_PASSES: u32 = 8;

/// Energy that rows gave, by cause [J], and how many impulses they were.
pub(crate) struct Given<I> {
    pub(crate) contact: Lanes<I>,
    pub(crate) collision: Lanes<I>,
    pub(crate) friction: Lanes<I>,
    pub(crate) projection: Lanes<I>,
    pub(crate) impulses: u64,
}

/// In which order.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Direction {
    To,
    Fro,
}

impl<I: Instructions> Given<I> {
    pub(crate) const ZERO: Self = Self {
        contact: Lanes::ZERO,
        collision: Lanes::ZERO,
        friction: Lanes::ZERO,
        projection: Lanes::ZERO,
        impulses: 0,
    };

    /// Books it.
    pub(crate) fn book(&self, tally: &mut Tally) {
        tally.causes.add(Cause::Contact, self.contact.sum());
        tally.causes.add(Cause::Collision, self.collision.sum());
        tally.causes.add(Cause::Friction, self.friction.sum());
        tally.causes.add(Cause::Projection, self.projection.sum());
        tally.impulses += self.impulses;
    }

    #[inline(always)]
    fn add_normal(&mut self, bounces: Mask, energy: Lanes<I>) {
        self.collision = self.collision + bounces.select(energy, Lanes::ZERO);
        self.contact = self.contact + bounces.select(Lanes::ZERO, energy);
    }
}

impl<I: Instructions> Batch<I> {
    /// Rows whose gap closes in this substep: at which speed, and whether they will bounce. What has come apart can meet again; so can
    /// what touches and is struck. What meets no faster than `threshold` [m/s] bounces no more.
    #[inline(always)]
    pub(crate) fn meet(&mut self, movers: &Movers, threshold: f64, step: &Frame) {
        let sides = self.sides(movers);
        let (dt, threshold) = (Lanes::splat(step.dt), Lanes::splat(threshold));
        let falls = sides[0].falls - sides[1].falls;
        for row in &mut self.rows {
            let closing = -row.relative_velocity(&sides).dot(row.normal);
            let comes_apart = row.gap.above(closing.max(threshold) * dt);
            row.has_met = row.has_met.and(comes_apart.not());
            let is_still = row.has_met.and(closing.above(threshold).not());
            let meets = row.is_there.and(row.gap.above(closing * dt).or(is_still).not());

            // The speed at the surface: from that before the kick, with gravity along the rest of the gap.
            let acceleration = -(Lanes3::splat(step.gravity) * falls).dot(row.normal);
            let start = closing - Lanes::splat(0.5) * dt * acceleration;
            let squared = start * start + Lanes::splat(2.0) * acceleration * row.gap.max(Lanes::ZERO);
            let approaches = closing.above(Lanes::ZERO);
            let speed = approaches.select(squared.max(Lanes::ZERO).sqrt(), Lanes::ZERO);
            row.met_at = meets.select(speed, row.met_at);
            row.has_met = row.has_met.or(meets);
            let bounces = meets.and(speed.above(threshold));
            row.bounces = bounces.or(row.bounces.and(meets.not()));
        }
    }

    /// What no longer meets has nothing to go on from.
    #[inline(always)]
    pub(crate) fn forget_parted(&mut self, movers: &Movers, beat: &Beat) {
        let sides = self.sides(movers);
        for row in &mut self.rows {
            let closing = -row.relative_velocity(&sides).dot(row.normal);
            let parts = row.gap.above(closing.max(Lanes::ZERO) * Lanes::splat(beat.dt));
            let impulse = &mut row.impulses[beat.at()];
            impulse.normal = parts.select(Lanes::ZERO, impulse.normal);
            impulse.tangent = parts.select3(Lanes3::ZERO, impulse.tangent);
            impulse.twist = parts.select3(Lanes3::ZERO, impulse.twist);
        }
    }

    /// What acted at this stage of the last substep acts again.
    #[inline(always)]
    pub(crate) fn go_on(&mut self, movers: &mut Movers, beat: &Beat, given: &mut Given<I>) {
        let mut sides = self.sides(movers);
        let kick = kick_of(&sides, beat);
        let rolls = self.rolls();
        for row in &self.rows {
            let RowImpulse { normal, tangent, twist } = row.impulses[beat.at()];
            let along = row.normal * normal;
            let impulse = along + tangent;
            let before = row.relative_velocity(&sides);
            row.push(&mut sides, impulse);
            let mean = (before + row.relative_velocity(&sides)) * Lanes::splat(0.5) - kick;
            let (by_normal, by_friction) = (along.dot(mean), tangent.dot(mean));
            given.add_normal(row.bounces, by_normal);
            given.friction = given.friction + by_friction;
            self.given = self.given + by_normal + by_friction;
            if rolls {
                let work = turn(&mut sides, self.spin, twist);
                given.friction = given.friction + work;
                self.given = self.given + work;
            }
        }
        self.store(movers, &sides);
    }

    /// One pass over all rows: normal, friction, rolling.
    #[inline(always)]
    pub(crate) fn sweep(
        &mut self,
        movers: &mut Movers,
        beat: &Beat,
        direction: Direction,
        given: &mut Given<I>,
    ) {
        let mut sides = self.sides(movers);
        let count = self.rows.len();
        for at in 0..count {
            let number = if direction == Direction::To { at } else { count - 1 - at };
            let acts = self.rows[number].acts(beat);
            self.sweep_row(number, &mut sides, beat, acts, given);
        }
        self.store(movers, &sides);
    }

    /// Another pass over the points that meet fast: they have no impulses to start from.
    #[inline(always)]
    pub(crate) fn sweep_meeting(&mut self, movers: &mut Movers, beat: &Beat, given: &mut Given<I>) {
        if !self.bounces() {
            return;
        }
        self.stop_together(movers, beat, given);
        let mut sides = self.sides(movers);
        for number in 0..self.rows.len() {
            let bounces = self.rows[number].bounces;
            if bounces.any() {
                self.sweep_row(number, &mut sides, beat, bounces, given);
            }
        }
        self.store(movers, &sides);
    }

    #[inline(always)]
    fn sweep_row(
        &mut self,
        number: usize,
        sides: &mut [Side<I>; 2],
        beat: &Beat,
        acts: Mask,
        given: &mut Given<I>,
    ) {
        let work = stop_approach(&mut self.rows[number], sides, &self.soft, (beat, acts));
        given.add_normal(self.rows[number].bounces, work);
        self.given = self.given + work;
        let mut work = stop_slip(&mut self.rows[number], sides, self.friction, (beat, acts));
        if self.rolls() {
            work = work
                + stop_roll(&mut self.rows[number], sides, (&self.roll_lengths, self.spin), (beat, acts));
        }
        given.friction = given.friction + work;
        self.given = self.given + work;
    }

    /// Lets the points of each pair that meet fast act together: to and fro until what one does to the others has settled. A face that
    /// lands flat must not turn by the order of its corners. Normals come first: it does not slip.
    #[inline(always)]
    pub(crate) fn stop_together(&mut self, movers: &mut Movers, beat: &Beat, given: &mut Given<I>) {
        let soft = self.soft;
        self.act_together(
            movers,
            given,
            #[inline(always)]
            |row, sides, acts| stop_approach(row, sides, &soft, (beat, acts)),
        );
    }

    #[inline(always)]
    fn act_together(
        &mut self,
        movers: &mut Movers,
        given: &mut Given<I>,
        mut act: impl FnMut(&mut Row<I>, &mut [Side<I>; 2], Mask) -> Lanes<I>,
    ) {
        if !self.bounces() {
            return;
        }
        let of_lane = |lane: usize| self.rows.iter().filter(|row| row.bounces.get(lane)).count();
        let together = Mask::of(|lane| of_lane(lane) > 1);
        if !together.any() {
            return;
        }
        let mut sides = self.sides(movers);
        let count = self.rows.len();
        for pass in 0..2 * TOGETHER_PASSES {
            for at in 0..count {
                let row = &mut self.rows[if pass % 2 == 0 { at } else { count - 1 - at }];
                let acts = row.bounces.and(together);
                let work = act(row, &mut sides, acts);
                given.collision = given.collision + work;
                self.given = self.given + work;
            }
        }
        self.store(movers, &sides);
    }

    /// What met fast enough leaves with its share of the speed at which it met; what stopped it is no guide to the next substep.
    #[inline(always)]
    pub(crate) fn bounce(&mut self, movers: &mut Movers, beat: &Beat, given: &mut Given<I>) {
        if !self.bounces() {
            return;
        }
        let restitution = self.restitution;
        self.act_together(
            movers,
            given,
            #[inline(always)]
            |row, sides, acts| leave(row, sides, restitution, (beat, acts)),
        );
        let mut sides = self.sides(movers);
        for row in self.rows.iter_mut().filter(|row| row.bounces.any()) {
            let bounces = row.bounces;
            let by_normal = leave(row, &mut sides, restitution, (beat, bounces));
            let by_friction = stop_slip(row, &mut sides, self.friction, (beat, bounces));
            given.collision = given.collision + by_normal;
            given.friction = given.friction + by_friction;
            self.given = self.given + by_normal + by_friction;
        }
        self.store(movers, &sides);
    }

    /// Whether any point has to bounce.
    #[inline(always)]
    pub(crate) fn bounces(&self) -> bool {
        self.rows.iter().any(|row| row.bounces.any())
    }

    /// The impulses of what bounces begin, or end, at nothing.
    #[inline(always)]
    pub(crate) fn clear_bouncing(&mut self) {
        for row in &mut self.rows {
            let bounces = row.bounces;
            for impulse in &mut row.impulses {
                impulse.normal = bounces.select(Lanes::ZERO, impulse.normal);
                impulse.tangent = bounces.select3(Lanes3::ZERO, impulse.tangent);
                impulse.twist = bounces.select3(Lanes3::ZERO, impulse.twist);
            }
        }
    }

    /// Nothing has to bounce any more.
    #[inline(always)]
    pub(crate) fn end_bouncing(&mut self) {
        for row in &mut self.rows {
            row.bounces = Mask::NONE;
        }
    }

    /// Closes the books of a stage: who acted; what closed an overlap did work, as a wedge between the two would.
    #[inline(always)]
    pub(crate) fn close(&mut self, beat: &Beat, given: &mut Given<I>) {
        for row in &mut self.rows {
            let RowImpulse { normal, tangent, .. } = row.impulses[beat.at()];
            let acted = normal.above(Lanes::ZERO).or(tangent.dot(tangent).above(Lanes::ZERO));
            row.touched = row.touched.or(acted);
            given.impulses += u64::from(acted.count());
            if beat.stage == Stage::BeforeDrift {
                let work = normal * row.target_speed(self.soft.rate, beat).max(Lanes::ZERO);
                given.projection = given.projection + work;
                given.add_normal(row.bounces, -work);
            }
        }
    }

    /// Books what static and kinematic bodies gave; of what bounces only, if that is asked for.
    pub(crate) fn book_outside(&self, bodies: &Bodies, beat: &Beat, bouncing: bool, tally: &mut Tally) {
        for (lane, patch) in self.patches.iter().enumerate() {
            let pair = [patch.pair.first, patch.pair.second];
            let [first_is_outside, second_is_outside] = pair.map(|i| bodies.inertias[i].is_infinite());
            if first_is_outside == second_is_outside {
                continue;
            }
            // On the body that can move.
            let (sign, pair) =
                if second_is_outside { (1.0, pair) } else { (-1.0, [patch.pair.second, patch.pair.first]) };
            let origin = bodies.poses[patch.pair.first].position;
            for row in self.rows.iter().filter(|row| !bouncing || row.bounces.get(lane)) {
                let RowImpulse { normal, tangent, twist } = row.impulses[beat.at()];
                let impulse = normal.get(lane) * row.normal.get(lane) + tangent.get(lane);
                if impulse == DVec3::ZERO {
                    continue;
                }
                let moment = (row.levers[0].get(lane) + origin).cross(impulse) + twist.get(lane);
                // The drive is what is outside, and against the velocity of the body that can move.
                let work = if self.is_driven {
                    -impulse.dot(row.drive.get(lane)) - twist.get(lane).dot(self.spin.get(lane))
                } else {
                    0.0
                };
                tally.book_outside(bodies, pair, (sign * impulse, sign * moment), work);
            }
        }
    }

    /// Whether rolling or spinning friction acts.
    #[inline(always)]
    fn rolls(&self) -> bool {
        let [rolling, spinning] = self.roll_lengths;
        rolling.above(Lanes::ZERO).or(spinning.above(Lanes::ZERO)).any()
    }
}
