//! How the points of a batch act on their bodies: one row after the other, all lanes at once.

use crate::Bodies;
use crate::contact_batch::Batch;
use crate::contact_kernels::{kick_of, stop_approach, stop_roll, stop_slip, turn};
use crate::contact_rows::{Beat, Row, RowImpulse, Stage};
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask};
use crate::moving::{Movers, Side};
use crate::settings::Frame;
use crate::tally::{Cause, Tally};

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

/// A pass over the rows.
#[derive(Clone, Copy)]
pub(crate) struct Pass {
    /// Last row first.
    pub(crate) is_fro: bool,
    /// The points of each pair that meet fast act together, before all else.
    together: bool,
    /// All points act: normal, friction, rolling.
    sweeps: bool,
    /// Only those act that meet fast.
    only_meeting: bool,
}

impl Pass {
    /// Stops what meets fast.
    pub(crate) const TOGETHER: Self =
        Self { is_fro: false, together: true, sweeps: false, only_meeting: true };

    /// Over all rows.
    pub(crate) const TO: Self = Self { is_fro: false, together: false, sweeps: true, only_meeting: false };

    /// And back.
    pub(crate) const FRO: Self = Self { is_fro: true, ..Self::TO };

    /// Another one over what meets fast: it has no impulses to start from.
    pub(crate) const MEETING: Self = Self { sweeps: true, ..Self::TOGETHER };
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
        let mut any_bounces = Mask::NONE;
        for row in &mut self.rows {
            let closing = -row.relative_velocity(&sides).dot(row.normal);
            row.forget_if_parted(Stage::BeforeDrift, &sides, step.dt);
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
            any_bounces = any_bounces.or(row.bounces);
        }
        self.bounces = any_bounces.any();
    }

    /// What a kinematic body has left, after a drift in a substep of `dt` [s], is forgotten.
    pub(crate) fn forget_driven(&mut self, movers: &Movers, dt: f64) {
        if self.is_driven {
            let sides = self.sides(movers);
            self.rows.iter_mut().for_each(|row| row.forget_if_parted(Stage::AfterDrift, &sides, dt));
        }
    }

    /// What acted at this stage of the last substep acts again.
    #[inline(always)]
    pub(crate) fn go_on(&mut self, movers: &mut Movers, beat: &Beat, given: &mut Given<I>) {
        let mut sides = self.sides(movers);
        let kick = kick_of(&sides, beat);
        for row in &self.rows {
            let RowImpulse { normal, tangent, twist } = row.impulses[beat.stage.at()];
            let along = row.normal * normal;
            let impulse = along + tangent;
            if !impulse.dot(impulse).above(Lanes::ZERO).any() {
                continue;
            }
            let before = row.relative_velocity(&sides);
            row.push(&mut sides, impulse);
            let mean = (before + row.relative_velocity(&sides)) * Lanes::splat(0.5) - kick;
            let (by_normal, by_friction) = (along.dot(mean), tangent.dot(mean));
            given.add_normal(row.bounces, by_normal);
            given.friction = given.friction + by_friction;
            self.given = self.given + by_normal + by_friction;
            if self.rolls {
                let work = turn(&mut sides, self.spin, twist);
                given.friction = given.friction + work;
                self.given = self.given + work;
            }
        }
        self.store(movers, &sides);
    }

    /// One pass over the rows.
    #[inline(always)]
    pub(crate) fn act(&mut self, movers: &mut Movers, beat: &Beat, pass: Pass, given: &mut Given<I>) {
        if pass.only_meeting && !self.bounces {
            return;
        }
        let mut sides = self.sides(movers);
        if pass.together {
            self.act_together(&mut sides, beat, given);
        }
        if pass.sweeps {
            let count = self.rows.len();
            for at in 0..count {
                let row = &mut self.rows[if pass.is_fro { count - 1 - at } else { at }];
                let acts = if pass.only_meeting { row.bounces } else { row.acts(beat) };
                let by_normal = stop_approach(row, &mut sides, &self.soft, self.restitution, (beat, acts));
                given.add_normal(row.bounces, by_normal);
                let mut by_friction = stop_slip(row, &mut sides, self.friction, (beat, acts));
                if self.rolls && beat.stage != Stage::Bounce {
                    let lengths = (&self.roll_lengths, self.spin);
                    by_friction = by_friction + stop_roll(row, &mut sides, lengths, (beat, acts));
                }
                given.friction = given.friction + by_friction;
                self.given = self.given + by_normal + by_friction;
            }
        }
        self.store(movers, &sides);
    }

    /// Lets the points of each pair that meet fast act together: to and fro until what one does to the others has settled. A face that
    /// lands flat must not turn by the order of its corners. Normals come first: it does not slip.
    #[inline(always)]
    fn act_together(&mut self, sides: &mut [Side<I>; 2], beat: &Beat, given: &mut Given<I>) {
        let of_lane = |lane: usize| self.rows.iter().filter(|row| row.bounces.get(lane)).count();
        let together = Mask::of(|lane| of_lane(lane) > 1);
        if !together.any() {
            return;
        }
        let count = self.rows.len();
        for pass in 0..2 * TOGETHER_PASSES {
            for at in 0..count {
                let row = &mut self.rows[if pass % 2 == 0 { at } else { count - 1 - at }];
                let acts = row.bounces.and(together);
                let work = stop_approach(row, sides, &self.soft, self.restitution, (beat, acts));
                given.collision = given.collision + work;
                self.given = self.given + work;
            }
        }
    }

    /// The impulses of what bounces begin, and end, at nothing.
    pub(crate) fn clear_bouncing(&mut self) {
        for row in &mut self.rows {
            for lane in (0..LANES).filter(|&lane| row.bounces.get(lane)) {
                row.impulses.iter_mut().for_each(|impulse| impulse.clear(lane));
            }
        }
    }

    /// Closes the books of a stage: who acted; what closed an overlap did work, as a wedge between the two would.
    #[inline(always)]
    pub(crate) fn close(&mut self, beat: &Beat, given: &mut Given<I>) {
        let (mut sum, mut moment) = (Lanes3::ZERO, Lanes3::ZERO);
        for row in &mut self.rows {
            let RowImpulse { normal, tangent, twist } = row.impulses[beat.stage.at()];
            let impulse = row.normal * normal + tangent;
            sum = sum + impulse;
            moment = moment + row.levers[0].cross(impulse);
            if self.rolls {
                moment = moment + twist;
            }
            let acted = normal.above(Lanes::ZERO).or(tangent.dot(tangent).above(Lanes::ZERO));
            row.touched = row.touched.or(acted);
            given.impulses += u64::from(acted.count());
            if beat.stage == Stage::BeforeDrift {
                let work = normal * row.target_speed(self.soft.rate, beat).max(Lanes::ZERO);
                given.projection = given.projection + work;
                given.add_normal(row.bounces, -work);
            }
        }
        self.acted = [sum, moment];
    }

    /// Ends a bounce: what stopped and returned the points is no guide to the next substep.
    #[inline(always)]
    pub(crate) fn close_bounce(&mut self) {
        let (mut sum, mut moment) = (Lanes3::ZERO, Lanes3::ZERO);
        for row in &mut self.rows {
            let RowImpulse { normal, tangent, .. } = row.impulses[Stage::Bounce.at()];
            let impulse = row.bounces.select3(row.normal * normal + tangent, Lanes3::ZERO);
            sum = sum + impulse;
            moment = moment + row.levers[0].cross(impulse);
        }
        self.acted = [sum, moment];
    }

    /// Books what static and kinematic bodies gave in the stage that was closed.
    pub(crate) fn book_outside(&self, bodies: &Bodies, stage: Stage, tally: &mut Tally) {
        for (lane, patch) in self.patches.iter().enumerate() {
            let pair = [patch.pair.first, patch.pair.second];
            let [first_is_outside, second_is_outside] = pair.map(|i| bodies.inertias[i].is_infinite());
            if first_is_outside == second_is_outside {
                continue;
            }
            // On the body that can move.
            let (sign, pair) =
                if second_is_outside { (1.0, pair) } else { (-1.0, [patch.pair.second, patch.pair.first]) };
            let [impulse, moment] = self.acted.map(|sum| sum.get(lane));
            let moment = moment + bodies.poses[patch.pair.first].position.cross(impulse);
            let work = if self.is_driven { self.driven_work(lane, stage) } else { 0.0 };
            tally.book_outside(bodies, pair, (sign * impulse, sign * moment), work);
        }
    }

    /// What a kinematic body did to the other one of its pair [J]: the drive is its velocity, against that of the other one.
    fn driven_work(&self, lane: usize, stage: Stage) -> f64 {
        let of_row = |row: &Row<I>| {
            let RowImpulse { normal, tangent, twist } = row.impulses[stage.at()];
            let impulse = normal.get(lane) * row.normal.get(lane) + tangent.get(lane);
            -impulse.dot(row.drive.get(lane)) - twist.get(lane).dot(self.spin.get(lane))
        };
        let acts = |row: &&Row<I>| stage != Stage::Bounce || row.bounces.get(lane);
        self.rows.iter().filter(acts).map(of_row).sum()
    }
}
