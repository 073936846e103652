//! How the points of a batch act on their bodies: one row after the other, all lanes at once.

use crate::contact_batch::{Batch, Hold};
use crate::contact_kernels::{Visit, stop, stop_roll};
use crate::contact_rows::{Basis, Beat, RowImpulse, Stage, closing_speed};
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask, Single, Single3};
use crate::moving::{Movers, Push, Side};
use crate::settings::Frame;
use crate::tally::{Cause, Tally};
use std::ops::Range;

/// Of impulses on what is squeezed [1]. Below 2 none of them makes energy. A ball at 60 m/s that is nine times as heavy as the cube between it
/// and a plate of 1 cm has pressed it through in 2 of 40 cases with 1, and in none with 1.5; with 1.7 in one.
const OVER_RELAXATION: f64 = 1.5;

/// What rows gave: energy by its cause [J], how many impulses they were, and what came from outside.
pub(crate) struct Given<I> {
    pub(crate) contact: Lanes<I>,
    pub(crate) collision: Lanes<I>,
    pub(crate) friction: Lanes<I>,
    pub(crate) projection: Lanes<I>,
    /// What closing overlaps would have taken if it had been paid for in full [J].
    pub(crate) wanted: Lanes<I>,
    pub(crate) impulses: u64,
    /// Sums of impulses and of their moments about the world's origin that static and kinematic bodies gave.
    pub(crate) impulse: Lanes3<I>,
    pub(crate) moment: Lanes3<I>,
}

/// A pass over the rows.
#[derive(Clone, Copy)]
pub(crate) struct Pass {
    /// Last row first.
    pub(crate) is_fro: bool,
    /// The points of each pair that meet fast act together, before all else, in so many passes to and fro.
    together: u32,
    /// All points act: normal, friction, rolling.
    sweeps: bool,
    /// Only those act that meet fast.
    pub(crate) only_meeting: bool,
    /// The last one of a stage.
    is_last: bool,
    /// How much of what would stop a rigid point acts [1]: more than 1 settles what presses each other sooner.
    relaxation: f64,
}

impl Pass {
    /// Stops what meets fast, the points of each pair together in so many passes to and fro.
    pub(crate) fn over_meeting(together: u32) -> Self {
        Self { together, sweeps: false, only_meeting: true, ..Self::over_all(false, false) }
    }

    /// The same, and then normals, friction and rolling of each point: what meets has no impulses to start from.
    pub(crate) fn sweeping(self) -> Self {
        Self { sweeps: true, ..self }
    }

    /// Over all rows, to or fro.
    pub(crate) const fn over_all(is_fro: bool, is_last: bool) -> Self {
        Self { is_fro, together: 0, sweeps: true, only_meeting: false, is_last, relaxation: 1.0 }
    }

    /// Over what is squeezed.
    pub(crate) fn over_squeezed(is_fro: bool) -> Self {
        Self { relaxation: OVER_RELAXATION, ..Self::over_all(is_fro, false) }
    }
}

impl<I: Instructions> Given<I> {
    pub(crate) const ZERO: Self = Self {
        contact: Lanes::ZERO,
        collision: Lanes::ZERO,
        friction: Lanes::ZERO,
        projection: Lanes::ZERO,
        wanted: Lanes::ZERO,
        impulses: 0,
        impulse: Lanes3::ZERO,
        moment: Lanes3::ZERO,
    };

    /// In all [J].
    pub(crate) fn energy(&self) -> f64 {
        (self.contact + self.collision + self.friction + self.projection).sum()
    }

    /// Books it.
    pub(crate) fn book(&self, tally: &mut Tally) {
        tally.causes.add(Cause::Contact, self.contact.sum());
        tally.causes.add(Cause::Collision, self.collision.sum());
        tally.causes.add(Cause::Friction, self.friction.sum());
        tally.causes.add(Cause::Projection, self.projection.sum());
        tally.impulses += self.impulses;
        tally.outside_impulse += self.impulse.sum();
        tally.outside_angular_impulse += self.moment.sum();
    }
}

impl<I: Instructions> Batch<I> {
    /// Rows whose gap closes in this substep: at which speed, and whether they will bounce. What has come apart can meet again; so can
    /// what touches and is struck, but it does not begin to bounce by itself. What meets no faster than `threshold` [m/s] bounces no more.
    #[inline(always)]
    pub(crate) fn meet(&mut self, movers: &Movers, threshold: f64, step: &Frame) {
        let (rates, falls) = movers.kicked_rates_of(&self.locals);
        let (dt, threshold) = (Single::splat(step.dt), Single::splat(threshold));
        let shared = self.shared_basis();
        let mut any_bounces = Mask::NONE;
        self.wake_rows(movers, &rates);
        self.met_rows = 0;
        for at in 0..self.near_rows {
            let point = self.point(at, shared);
            let closing = point.closing(&rates);
            let parts = self.forget_if_parted(at, Stage::BeforeDrift, closing, step.dt);
            let row = &mut self.rows[at];
            let gap = row.gap;
            let comes_apart = parts.and(gap.above(threshold * dt));
            row.has_met = row.has_met.and(comes_apart.not());
            let is_still = row.has_met.and(closing.above(threshold).not());
            let meets = row.is_there.and(gap.above(closing * dt).or(is_still).not());

            // The speed at the surface: from that before the kick, with gravity along the rest of the gap.
            let touched = row.has_met;
            row.has_met = touched.or(meets);
            if row.has_met.any() {
                self.met_rows = at + 1;
            }
            if !meets.any() && !row.bounces.any() {
                continue;
            }
            let acceleration = -(Single3::splat(step.gravity) * falls).dot(point.basis.normal);
            let start = closing - Single::splat(0.5) * dt * acceleration;
            let squared = start * start + Single::splat(2.0) * acceleration * gap.max(Single::ZERO);
            let approaches = closing.above(Single::ZERO);
            let speed = approaches.select(squared.max(Single::ZERO).sqrt(), Single::ZERO);
            let met_at = &mut self.anchors[at].met_at;
            *met_at = meets.select(touched.select(Single::ZERO, speed), *met_at);
            let bounces = meets.and(speed.above(threshold));
            row.bounces = bounces.or(row.bounces.and(meets.not()));
            any_bounces = any_bounces.or(row.bounces);
        }
        self.bounces = any_bounces.any();
    }

    /// What a kinematic body has left, after a drift in a substep of `dt` [s], is forgotten.
    #[cold]
    pub(crate) fn forget_driven(&mut self, movers: &Movers, dt: f64) {
        I::run(
            #[inline(always)]
            || {
                let (rates, _) = movers.kicked_rates_of(&self.locals);
                for at in 0..self.rows.len() {
                    let closing = self.point(at, self.shared_basis()).closing(&rates);
                    self.forget_if_parted(at, Stage::AfterDrift, closing, dt);
                }
            },
        );
    }

    /// See [`Row::forget_if_parted`].
    #[inline(always)]
    pub(crate) fn forget_if_parted(&mut self, at: usize, stage: Stage, closing: Single<I>, dt: f64) -> Mask {
        let parts = self.rows[at].forget_if_parted(stage, closing, dt);
        if self.rolls {
            let twist = &mut self.rest.twists[at][stage.at()];
            *twist = parts.select(Single3::ZERO, *twist);
        }
        parts
    }

    /// What acted at this stage of the last substep acts again, if anything did.
    #[inline(always)]
    pub(crate) fn go_on(&mut self, movers: &Movers, beat: &Beat, given: &mut Given<I>) {
        if self.carrying_rows[beat.stage.at()] == 0 {
            return;
        }
        let mut visit = Visit::new(self.sides(movers), beat);
        let shared = self.shared_basis();
        for at in 0..self.carrying_rows[beat.stage.at()] {
            let row = &self.rows[at];
            let impulse = row.impulses[beat.stage.at()];
            if !impulse.is_any() {
                continue;
            }
            self.give(&mut visit, (at, shared), impulse);
            if self.rolls {
                visit.turn(self.rest.spin, self.rest.twists[at][beat.stage.at()]);
            }
        }
        self.settle(visit, movers, given, false);
    }

    /// Gives the bodies an impulse at a row's points, along its normals and tangents.
    #[inline(always)]
    pub(crate) fn give(
        &self,
        visit: &mut Visit<I>,
        (at, shared): (usize, Option<Basis<I>>),
        RowImpulse { normal, tangent }: RowImpulse<I>,
    ) {
        let (row, point) = (&self.rows[at], self.point(at, shared));
        let before = -point.closing(&visit.now.rates);
        let Single3 { x, y, z } = row.response.to_normal;
        let gain = x * normal + y * tangent[0] + z * tangent[1];
        visit.push(&point, point.impulse(normal, tangent));
        visit.note_normal(normal, before + Single::splat(0.5) * gain, (&point, row.bounces));
    }

    /// One pass over the rows.
    #[inline(always)]
    pub(crate) fn act(&mut self, movers: &Movers, beat: &Beat, pass: Pass, given: &mut Given<I>) {
        let mut visit = Visit::new(self.sides(movers), beat);
        if pass.together > 0 {
            self.act_together(&mut visit, beat, pass.together);
        }
        if pass.sweeps {
            // What is far may wake before it would act: first on the way fro, last on the way to.
            let wakes = !pass.only_meeting && beat.stage == Stage::BeforeDrift;
            if wakes && pass.is_fro {
                self.wake_rows(movers, &visit.now.rates);
            }
            let mut rows = 0..if pass.only_meeting { self.near_rows } else { self.acting_rows(beat.stage) };
            loop {
                self.sweep(&mut visit, beat, pass, rows.clone());
                if !wakes || pass.is_fro {
                    break;
                }
                self.wake_rows(movers, &visit.now.rates);
                rows = rows.end..self.near_rows;
                if rows.is_empty() {
                    break;
                }
            }
        }
        if pass.is_last {
            self.close(&mut visit, beat, given);
        }
        self.settle(visit, movers, given, pass.is_last || beat.stage == Stage::Bounce);
    }

    /// Some rows act: normal, friction, rolling.
    #[inline(always)]
    fn sweep(&mut self, visit: &mut Visit<I>, beat: &Beat, pass: Pass, rows: Range<usize>) {
        let hold = Hold { relaxation: Single::splat(pass.relaxation), ..self.hold() };
        let shared = self.shared_basis();
        for step in 0..rows.len() {
            let at = if pass.is_fro { rows.end - 1 - step } else { rows.start + step };
            let point = self.point(at, shared);
            let leaving = if beat.stage == Stage::Bounce { self.leaving(at) } else { Single::ZERO };
            let row = &mut self.rows[at];
            let acts = if pass.only_meeting { row.meets(beat) } else { row.acts(beat) };
            stop(row, &point, (&hold, leaving), visit, (beat, acts, true));
            if self.rolls && beat.stage != Stage::Bounce {
                let load = row.impulses[beat.stage.at()].normal;
                let twist = &mut self.rest.twists[at][beat.stage.at()];
                let lengths = (&self.rest.roll_lengths, self.rest.spin);
                *twist = stop_roll(visit, point.basis.normal, lengths, (load, *twist, acts));
            }
        }
    }

    /// Whether any point meets fast at a stage.
    pub(crate) fn meets(&self, beat: &Beat) -> bool {
        if beat.stage == Stage::Bounce { self.impacts } else { self.bounces }
    }

    /// Lets the points of each pair that meet fast act together: to and fro until what one does to the others has settled. A face that
    /// lands flat must not turn by the order of its corners. Normals come first: it does not slip.
    #[inline(always)]
    fn act_together(&mut self, visit: &mut Visit<I>, beat: &Beat, passes: u32) {
        let of_lane = |lane: usize| self.rows.iter().filter(|row| row.meets(beat).get(lane)).count();
        let together = Mask::of(|lane| of_lane(lane) > 1);
        if !together.any() {
            return;
        }
        let (shared, hold) = (self.shared_basis(), self.hold());
        let count = self.near_rows;
        for pass in 0..2 * passes {
            for step in 0..count {
                let at = if pass % 2 == 0 { step } else { count - 1 - step };
                let point = self.point(at, shared);
                let leaving = if beat.stage == Stage::Bounce { self.leaving(at) } else { Single::ZERO };
                let row = &mut self.rows[at];
                let acts = row.meets(beat).and(together);
                stop(row, &point, (&hold, leaving), visit, (beat, acts, false));
            }
        }
    }

    /// Speed at which a row that bounces leaves [m/s].
    #[inline(always)]
    fn leaving(&self, at: usize) -> Single<I> {
        self.rest.restitution * self.rows[at].has_met.select(self.anchors[at].met_at, Single::ZERO)
    }

    /// The impulses of what bounces begin, and end, at nothing.
    #[inline(always)]
    pub(crate) fn clear_bouncing(&mut self) {
        for row in &mut self.rows {
            for lane in (0..LANES).filter(|&lane| row.bounces.get(lane)) {
                row.impulses.iter_mut().for_each(|impulse| impulse.clear(lane));
            }
        }
        for (row, twists) in self.rows.iter().zip(&mut self.rest.twists) {
            twists.iter_mut().for_each(|twist| *twist = row.bounces.select(Single3::ZERO, *twist));
        }
    }

    /// Closes the books of a stage: who acted; what closed an overlap did work, as a wedge between the two would.
    #[inline(always)]
    fn close(&mut self, visit: &mut Visit<I>, beat: &Beat, given: &mut Given<I>) {
        let rate = self.soft.rate;
        let mut carrying = 0;
        let count = self.acting_rows(beat.stage).max(self.carrying_rows[beat.stage.at()]);
        for (at, row) in self.rows[..count].iter_mut().enumerate() {
            let impulse = &row.impulses[beat.stage.at()];
            let (normal, [t, b]) = (impulse.normal, impulse.tangent);
            let rubs = t.differs_from_zero().or(b.differs_from_zero());
            let acted = normal.above(Single::ZERO).or(rubs);
            row.touched = row.touched.or(acted);
            if acted.any() {
                carrying = at + 1;
            }
            given.impulses += u64::from(acted.count());
            if beat.stage == Stage::BeforeDrift {
                let wanted = normal * closing_speed(row.gap, rate).max(Single::ZERO);
                let work = wanted * Single::splat(beat.parting);
                given.wanted = given.wanted + wanted.double();
                visit.by_collision = visit.by_collision - row.bounces.select(work, Single::ZERO);
                visit.by_contact = visit.by_contact - row.bounces.select(Single::ZERO, work);
                visit.projected = visit.projected + work;
            }
        }
        self.carrying_rows[beat.stage.at()] = carrying;
    }

    /// Ends a visit: the bodies are seen as fast as they are now, and get what acted exactly if the visit `ends` their stage; energy is booked by its cause.
    #[inline(always)]
    pub(crate) fn settle(&mut self, visit: Visit<I>, movers: &Movers, given: &mut Given<I>, ends: bool) {
        let mut energy = Lanes::ZERO;
        if visit.has_acted {
            self.show(movers, &visit.after());
            energy = visit.given().double();
            self.given = self.given + energy;
            if self.has_outside {
                self.rest.work = self.rest.work + visit.work.double();
            }
            let acted = visit.acted();
            for (pending, acted) in self.pending.iter_mut().zip(acted) {
                *pending = *pending + acted;
            }
            self.is_pending = true;
        }
        if ends && self.is_pending {
            self.give_exactly(movers, &visit.before, given);
        }

        // Its causes add up to it.
        let [collision, contact, projected] =
            [visit.by_collision.double(), visit.by_contact.double(), visit.projected.double()];
        given.collision = given.collision + collision;
        given.contact = given.contact + contact;
        given.projection = given.projection + projected;
        given.friction = given.friction + (energy - collision - contact - projected);
    }

    /// The bodies get what acted. What one side gets the other one loses, to rounding in double precision: the impulses act at one point of space, which is the batch's
    /// offset further from the second centre of mass. What static and kinematic bodies gave is noted.
    #[inline(always)]
    pub(crate) fn give_exactly(&mut self, movers: &Movers, sides: &[Side<I>; 2], given: &mut Given<I>) {
        let [impulse, first, second] = self.pending;
        let impulse = impulse.double();
        let moment = self.first_moments(impulse, [first, second]);
        let pushes = [
            Push { impulse, moment },
            Push { impulse: -impulse, moment: -(moment + self.offset.cross(impulse)) },
        ];
        for side in 0..2 {
            movers.push(&self.locals[side], (&pushes[side], sides[side].inverse_mass));
        }
        if self.has_outside {
            // On the first bodies, or against what acts on the second ones.
            let sign = (sides[0].falls - sides[1].falls).double();
            given.impulse = given.impulse + impulse * sign;
            given.moment = given.moment + (moment + self.rest.centre.cross(impulse)) * sign;
        }
        self.pending = [Single3::ZERO; 3];
        self.is_pending = false;
    }
}
