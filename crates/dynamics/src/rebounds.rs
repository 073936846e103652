//! Bounces as impacts that follow each other: what met fast leaves with its share of its speed, what approaches fast because of that
//! bounces next, and so on, so that balls in a row pass on what they are struck with [SKV12]. What stopped them before the drift, all at
//! once, is taken back first: the bodies went no further by it, and it has taken their energy.

use crate::contact_batch::Batch;
use crate::contact_kernels::Visit;
use crate::contact_rows::{Beat, RowImpulse, Stage};
use crate::contact_sweep::Given;
use crate::lanes::{Instructions, LANES, Mask, Single};
use crate::moving::Movers;

/// What changes a speed by less [m/s] is no part of an impact: where nothing falls no speed is too low to bounce, and rounding would go on
/// bouncing.
pub(crate) const SLOWEST: f64 = 1e-3;

/// The bodies of a cluster that impacts have reached, by the number of the last impact; 0 is none.
pub(crate) struct Reached(Vec<u32>);

impl Reached {
    pub(crate) fn none(movers: &Movers) -> Self {
        Self(vec![0; movers.who.len() + 1])
    }

    /// Adds the bodies of some lanes that impulses move. Whether they had been reached by none before.
    fn add(&mut self, movers: &Movers, locals: &[[u32; LANES]; 2], (lanes, impact): (Mask, u32)) -> bool {
        let mut is_new = false;
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for local in locals.map(|side| side[lane]).into_iter().filter(|&local| movers.is_mobile(local)) {
                is_new |= std::mem::replace(&mut self.0[local as usize], impact) == 0;
            }
        }
        is_new
    }

    /// The lanes with a body that has been reached by an impact, or by a later one.
    #[inline(always)]
    fn lanes(&self, locals: &[[u32; LANES]; 2], impact: u32) -> Mask {
        let mut lanes = Mask::NONE;
        for lane in 0..LANES {
            lanes.set(lane, locals.iter().any(|side| self.0[side[lane] as usize] >= impact));
        }
        lanes
    }
}

/// One of the impacts that follow each other.
#[derive(Clone, Copy)]
pub(crate) struct Impact {
    /// From 1.
    pub(crate) number: u32,
    /// Nothing follows it: what met leaves, and what stopped it holds.
    pub(crate) is_only: bool,
    /// What approaches no faster bounces no more [m/s].
    pub(crate) threshold: f64,
}

impl<I: Instructions> Batch<I> {
    /// Whether any points approach faster, by more than `least` [m/s], than closes their gap in this substep. Those that have not followed
    /// their bodies do so first, if they could.
    #[inline(always)]
    pub(crate) fn is_squeezed(&mut self, movers: &Movers, beat: &Beat, least: f64) -> bool {
        let rates = movers.rates_of(&self.locals);
        // Most are slower than that, and their rows need not come from memory.
        if !self.is_driven && !self.closing_at_most(&rates).above(Single::splat(least * beat.dt)).any() {
            return false;
        }
        self.wake_rows(movers, &rates);
        let (shared, least, per_dt) =
            (self.shared_basis(), Single::splat(least), Single::splat(1.0 / beat.dt));
        let mut any = Mask::NONE;
        for at in 0..self.near_rows {
            let row = &self.rows[at];
            let most = row.gap.max(Single::ZERO) * per_dt + least;
            any = any.or(row.is_there.and(self.point(at, shared).closing(&rates).above(most)));
        }
        any.any()
    }

    /// Which lanes have a point that met fast and leaves again.
    #[inline(always)]
    pub(crate) fn rebounding(&self) -> Mask {
        if !self.bounces {
            return Mask::NONE;
        }
        let mut any = Mask::NONE;
        for (row, anchors) in self.rows.iter().zip(&self.anchors) {
            any = any.or(row.bounces.and(anchors.met_at.above(Single::ZERO)));
        }
        any.and(self.rest.restitution.above(Single::ZERO))
    }

    /// Notes with which impulses the substep begins.
    pub(crate) fn note_starts(&mut self) {
        self.rest.starts.clear();
        self.rest.starts.extend(self.rows.iter().map(|row| row.impulses));
    }

    /// Where a row stopped what had met, or took a part of that on.
    #[inline(always)]
    fn stopped(&self, at: usize) -> Mask {
        let row = &self.rows[at];
        let now = row.impulses[Stage::BeforeDrift.at()].normal;
        let change = now - self.rest.starts[at][Stage::BeforeDrift.at()].normal;
        let least = row.response.mass * Single::splat(SLOWEST);
        row.bounces.or((change * change).above(least * least))
    }

    /// Reaches the bodies that rebound, and those that took a part of what stopped bodies that are reached. Whether any is new.
    #[inline(always)]
    pub(crate) fn reach(&self, movers: &Movers, reached: &mut Reached) -> bool {
        let lanes = self.rebounding().or(reached.lanes(&self.locals, 1));
        if !lanes.any() {
            return false;
        }
        let mut stopped = Mask::NONE;
        for at in 0..self.rows.len() {
            stopped = stopped.or(self.stopped(at));
        }
        reached.add(movers, &self.locals, (stopped.and(lanes), 1))
    }

    /// Takes back what stopped bodies that are reached.
    #[inline(always)]
    pub(crate) fn take_back(&mut self, movers: &Movers, reached: &Reached, given: (&Beat, &mut Given<I>)) {
        let lanes = reached.lanes(&self.locals, 1);
        if !lanes.any() {
            return;
        }
        self.forget_who_acts();
        let shared = self.shared_basis();
        let mut visit = Visit::new(self.sides(movers), given.0);
        for at in 0..self.rows.len() {
            let takes = self.stopped(at).and(lanes);
            let now = self.rows[at].impulses[Stage::BeforeDrift.at()];
            let back = now.but(takes, self.rest.starts[at][Stage::BeforeDrift.at()]);
            let across = |tangent: usize| back.tangent[tangent] - now.tangent[tangent];
            let change = RowImpulse { normal: back.normal - now.normal, tangent: [across(0), across(1)] };
            self.give(&mut visit, (at, shared), change);
            self.rows[at].impulses[Stage::BeforeDrift.at()] = back;
        }
        self.settle(visit, movers, given.1, true);
    }

    /// Finds what an impact brings about among the bodies that the one before has reached, and how fast that is: the first is what met, as
    /// it met. Whether there is any.
    #[inline(always)]
    pub(crate) fn find_impacts(&mut self, movers: &Movers, impact: Impact, reached: &mut Reached) -> bool {
        let Impact { number, is_only, threshold } = impact;
        let lanes = if is_only { self.rebounding() } else { reached.lanes(&self.locals, number) };
        if !lanes.any() {
            return false;
        }
        self.forget_who_acts();
        let (rates, shared) = (movers.rates_of(&self.locals), self.shared_basis());
        let least = Single::splat(threshold.max(SLOWEST));
        let mut any = Mask::NONE;
        for at in 0..self.rows.len() {
            let closing = self.point(at, shared).closing(&rates);
            let row = &mut self.rows[at];
            let met_at = &mut self.anchors[at].met_at;
            let as_met = if number == 1 { row.bounces.and(met_at.above(Single::ZERO)) } else { Mask::NONE };
            let touches = row.is_there.and(row.has_met.or(row.gap.above(Single::ZERO).not()));
            let approaches = as_met.and(closing.above(Single::ZERO)).or(touches.and(closing.above(least)));
            let acts = if is_only { as_met } else { approaches }.and(lanes);
            *met_at = acts.and(as_met.not()).select(closing, *met_at);

            // What carried goes on to do so.
            let (impulse, rest) =
                (&mut row.impulses[Stage::Bounce.at()], &mut self.rest.starts[at][Stage::Bounce.at()]);
            *rest = impulse.but(row.impacts, *rest);
            *impulse = rest.but(acts, RowImpulse::ZERO);
            row.impacts = acts;
            row.bounces = row.bounces.and(lanes.not());
            row.has_met = row.has_met.or(acts);
            row.touched = row.touched.or(acts);
            any = any.or(acts);
        }
        self.impacts = any.any();
        reached.add(movers, &self.locals, (any, number + 1));
        self.impacts
    }

    /// Leaves other impacts to the next substep. What carried before this one goes on to do so, unless it has done so in this substep already.
    #[inline(always)]
    pub(crate) fn end_impacts(&mut self, has_gone_on: bool) {
        for (row, starts) in self.rows.iter_mut().zip(&self.rest.starts) {
            let impulse = &mut row.impulses[Stage::Bounce.at()];
            let carries = if has_gone_on { RowImpulse::ZERO } else { starts[Stage::Bounce.at()] };
            *impulse = impulse.but(row.impacts, carries);
            row.impacts = Mask::NONE;
        }
        self.impacts = false;
    }
}
