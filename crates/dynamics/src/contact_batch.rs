//! The points of contact as the substeps' solver sees them: several pairs side by side, one in each lane. No body that can move is in
//! two of them, so they act at the same time.

mod anew;
mod frame_end;
mod points;
mod rest;
#[cfg(test)]
mod tests;

pub(crate) use anew::STALE;
use anew::STALE_IN_HEAPS;
pub(crate) use points::Touching;

use crate::Bodies;
use crate::contact_rows::{Basis, Point, Row, RowDirections, RowImpulse, Stage};
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask, Single, Single3};
use crate::moving::{Movers, Rates, Shift, Side, Sides, drive};
use crate::pair::Pair;
use frangible_geometry::RigidTransform;
use glam::DVec3;

/// Where the points of a row are on their bodies: see [`ManifoldPoint`](crate::manifold::ManifoldPoint).
#[derive(Clone)]
pub(crate) struct Anchors<I> {
    /// Levers of the anchors from the centres of mass at the frame's start [m].
    levers: [Single3<I>; 2],
    rounding: [Single<I>; 2],
    /// The gap there if nothing had moved since the frame's start [m].
    gap: Single<I>,
    /// The smallest of these gaps here and in all rows behind [m].
    reach: Single<I>,
    /// At which speed the surfaces have met [m/s]; 0 if they touched before.
    pub(crate) met_at: Single<I>,
    /// Which go with the first body, as samples or features of it; the others go with the second.
    is_of_first: Mask,
    /// Which sample or feature each is.
    sample: [u64; LANES],
}

/// How a contact's normal impulses answer [Cat24].
#[derive(Clone, Copy)]
pub(crate) struct Softness<I> {
    /// Closing speed of an overlap per depth [1/s].
    pub(crate) rate: Single<I>,
    /// Of what a rigid point would add to its impulse [1].
    pub(crate) mass_scale: Single<I>,
    /// Of the impulse so far, that it takes back [1].
    pub(crate) impulse_scale: Single<I>,
}

/// How the contacts of a batch hold their bodies.
pub(crate) struct Hold<I> {
    pub(crate) soft: Softness<I>,
    /// Coefficient of friction.
    pub(crate) friction: Single<I>,
    /// Of what a rigid point would add to its impulse [1].
    pub(crate) relaxation: Single<I>,
}

/// Several pairs.
pub(crate) struct Batch<I> {
    /// Their bodies, by their place in the cluster.
    pub(crate) locals: [[u32; LANES]; 2],
    /// Centres of mass of the first bodies less those of the second ones [m].
    pub(crate) offset: Lanes3<I>,
    /// What acted in this stage and has yet to be given to the bodies exactly: the sum of the impulses on the first ones [N s], and of their moments about the first and about
    /// the second centres of mass [N m s].
    pub(crate) pending: [Single3<I>; 3],
    /// Whether there is any.
    pub(crate) is_pending: bool,
    /// Energy that they have given to their bodies in this frame, beyond a kinematic body's work [J].
    pub(crate) given: Lanes<I>,
    pub(crate) soft: Softness<I>,
    pub(crate) friction: Single<I>,
    pub(crate) rows: Vec<Row<I>>,
    pub(crate) anchors: Vec<Anchors<I>>,
    directions: RowDirections<I>,
    /// Whether there is rolling or spinning friction.
    pub(crate) rolls: bool,
    /// Whether a kinematic body is among them.
    pub(crate) is_driven: bool,
    /// Whether a static or kinematic body is among them.
    pub(crate) has_outside: bool,
    /// Whether any point has met fast in this substep.
    pub(crate) bounces: bool,
    /// Whether no stage looks at it again in this frame, as long as none of its bodies is fast.
    pub(crate) rests: bool,
    /// Whether any takes part in the impact that acts now.
    pub(crate) impacts: bool,
    /// Behind so many rows none has met in this frame: said by [`Self::meet`], never too few.
    pub(crate) met_rows: usize,
    /// Behind so many rows none carried in the last substep, before and after its drift: said where a stage's books close, never too few.
    pub(crate) carrying_rows: [usize; 2],
    /// Rows behind these are too far from touching to act, and have not followed their bodies, until those of a pair come closer by `room` [m].
    pub(crate) near_rows: usize,
    room: Single<I>,
    /// Radii of balls around the centres of mass that hold the bodies [m], 0 of infinite ones.
    sizes: [Single<I>; 2],
    /// Centres of mass of the first bodies less those of the second ones, at the frame's start [m].
    start_offset: Lanes3<I>,
    /// How much [`Movers`] had been stirred when the rows' responses were found.
    answered_at: Lanes<I>,
    /// Up to which travel of the two bodies their points need no look [m].
    look_at: Lanes<I>,
    /// Which pairs have come so far that their points have to be looked at.
    looks: Mask,
    /// Of a substep [s].
    dt: f64,
    pub(crate) rest: Box<Rest<I>>,
}

/// What few visits need to know of a batch: nobody asks memory for it before, so each of them waits for that.
pub(crate) struct Rest<I> {
    /// Centres of mass of the first bodies at the frame's start, and now if there is something outside [m].
    start: Lanes3<I>,
    pub(crate) centre: Lanes3<I>,
    pub(crate) restitution: Single<I>,
    /// Of the contacts, in units of that of one that carries itself.
    stiffness: Single<I>,
    /// Of rolling and of spinning friction [m].
    pub(crate) roll_lengths: [Single<I>; 2],
    /// What kinematic bodies add to the spin of the first bodies less that of the second ones [rad/s].
    pub(crate) spin: Single3<I>,
    /// Work of kinematic bodies in this frame [J].
    pub(crate) work: Lanes<I>,
    /// The rows' impulses when this substep began, if anything rebounds in it.
    pub(crate) starts: Vec<[RowImpulse<I>; 2]>,
    /// Of rolling and spinning friction, before and after the drift, a pair for each row if anything rolls [N m s].
    pub(crate) twists: Vec<[Single3<I>; 2]>,
    /// What kinematic bodies add to the velocity of the first bodies' material less that of the second ones', for each row if they are
    /// there [m/s].
    drives: Vec<Single3<I>>,
    /// One for each lane that is used.
    pub(crate) patches: Vec<Patch>,
}

/// What is known of one pair.
pub(crate) struct Patch {
    pub(crate) pair: Pair,
    /// Its place among the manifolds.
    pub(crate) manifold: usize,
    /// Of the smaller body [m].
    size: f64,
    /// See [`Manifold::struck`](crate::manifold::Manifold::struck), as far as it is watched for it [m/s].
    struck: f64,
    /// If it may be struck, its bodies may move so far against each other before points are missed that were too far away at the frame's start [m].
    near: f64,
    /// Whether they are polyhedra in a heap.
    are_in_heap: bool,
    /// Whether it has one point, or none. What only [passes](crate::hull_contact::approach) has one, as long as it stays [`STALE`] apart, so it is looked at before it is pushed that far.
    has_few: bool,
    /// Whether its points have yet to be looked for, as far as a blow may bring them together: at the frame's start they were not.
    is_watched: bool,
    /// Whether points acted that have been replaced since.
    touched: bool,
    /// If its points were found anew since the frame's start.
    anew: Option<Box<Anew>>,
}

/// When points were found anew.
struct Anew {
    /// `second_from_first` then.
    found_at: RigidTransform,
    /// Where the first of them was before, in the world frame [m].
    point: DVec3,
}

/// How far pairs, or points of theirs, must be apart to be left as they are, in units of what they can come closer in a substep: what strikes
/// one of them makes it faster.
const WARY: f64 = 1.5;

/// Motion of the bodies, relative to their sizes, after which the responses of their rows are found anew: they have changed by no
/// more than some hundredths.
const STIRRED: f64 = 0.02;

impl<I: Instructions> Batch<I> {
    /// Follows the bodies to where they are now, and sees how those move that are driven. After a drift, in a substep of `drifted` [s], what has parted is forgotten.
    #[inline(always)]
    pub(crate) fn follow(&mut self, (bodies, movers): (&Bodies, &Movers), drifted: Option<f64>) {
        self.follow_points(movers, drifted);
        if self.is_driven {
            self.be_driven(bodies, None);
            if let Some(dt) = drifted {
                self.forget_driven(movers, dt);
            }
        }
    }

    /// Follows the bodies to where they are now. What has parted after a drift is forgotten if nothing is driven.
    #[inline(always)]
    pub(crate) fn follow_points(&mut self, movers: &Movers, drifted: Option<f64>) {
        // After a drift contacts may have acted on some of them again.
        let rates = if drifted.is_some() {
            movers.kicked_rates_of(&self.locals).0
        } else {
            movers.rates_of(&self.locals)
        };
        let shifts = [movers.shifts(&self.locals[0]), movers.shifts(&self.locals[1])];
        let [first, second] = &shifts;
        self.offset = self.start_offset + (first.translation - second.translation);
        if self.has_outside {
            self.rest.centre = self.rest.start + first.translation;
        }
        let stirred = first.stirred + second.stirred;
        let travel = first.stirred * self.sizes[0].double() + second.stirred * self.sizes[1].double();
        self.looks = travel.above(self.look_at);
        let answers = drifted.is_none() || (stirred - self.answered_at).above(Lanes::splat(STIRRED)).any();
        if answers {
            self.answered_at = stirred;
        }
        let answered_rows = if answers { 0 } else { self.near_rows };
        self.find_near_rows(&rates, travel.single());
        let sides = if answered_rows < self.near_rows { Some(Sides::of(&self.sides(movers))) } else { None };
        let shared = self.shared_basis();
        for at in 0..self.near_rows {
            self.follow_row((at, shared), &shifts);
            let point = self.point(at, shared);
            if let Some(sides) = &sides
                && at >= answered_rows
            {
                self.rows[at].response = point.response(sides, self.rows[at].is_there);
            }
            if let Some(dt) = drifted
                && !self.is_driven
            {
                self.forget_if_parted(at, Stage::AfterDrift, point.closing(&rates), dt);
            }
        }
    }

    /// A row's points go with their bodies.
    #[inline(always)]
    fn follow_row(&mut self, (at, shared): (usize, Option<Basis<I>>), [first, second]: &[Shift<I>; 2]) {
        let normal = self.basis(at, shared).normal;
        let anchors = &self.anchors[at];
        let [lever, other_lever] = anchors.levers;
        let (turn, other_turn) = (first.turn(lever), second.turn(other_lever));
        let shift = (first.translation - second.translation).single() + turn - other_turn;
        let gap = anchors.gap + shift.dot(normal);

        // Between the surfaces, beside the corner that slides along the other body.
        let half = Single::splat(0.5) * gap;
        let on_first = lever + turn - normal * (anchors.rounding[0] + half);
        let on_second = other_lever + other_turn + normal * (anchors.rounding[1] + half);
        let row = &mut self.rows[at];
        row.lever = anchors.is_of_first.select(on_first, on_second - self.offset.single());
        row.gap = gap;
    }

    /// Which rows may act in the next substep, after so much `travel` of the bodies [m]: those behind them are too far from touching. A gap
    /// changes by no more than what its bodies travel.
    #[inline(always)]
    fn find_near_rows(&mut self, rates: &Rates<I>, travel: Single<I>) {
        let [before, after] = self.carrying_rows;
        let wary = Single::splat(WARY) * self.closing_at_most(rates);
        let mut near = self.met_rows.max(before).max(after);
        self.room = Single::splat(f64::INFINITY);
        if self.is_driven {
            near = self.rows.len();
        }
        while near < self.rows.len() {
            let room = self.anchors[near].reach - travel;
            if room.above(wary).not().any() {
                near += 1;
            } else {
                self.room = room;
                break;
            }
        }
        self.near_rows = near;
    }

    /// How far the two sides of the pairs can come nearer in a substep at most, as fast as they are [m].
    #[inline(always)]
    pub(crate) fn closing_at_most(&self, Rates { apart, spins }: &Rates<I>) -> Single<I> {
        let turning = |side: usize| spins[side].dot(spins[side]) * (self.sizes[side] * self.sizes[side]);
        // No sum of three numbers is larger than the root of three times the sum of their squares.
        let squares = apart.dot(*apart) + turning(0) + turning(1);
        (Single::splat(3.0 * self.dt * self.dt) * squares).sqrt()
    }

    /// Lets all rows follow their bodies, if those behind the near ones could touch within a substep.
    #[inline(always)]
    pub(crate) fn wake_rows(&mut self, movers: &Movers, rates: &Rates<I>) {
        let all_are_near = self.near_rows == self.rows.len();
        if !all_are_near && self.room.above(self.closing_at_most(rates)).not().any() {
            self.follow_all(movers);
        }
    }

    /// Lets all rows follow their bodies, if some have not yet.
    pub(crate) fn let_all_follow(&mut self, movers: &Movers) {
        if self.near_rows < self.rows.len() {
            self.follow_all(movers);
        }
    }

    /// Lets all rows follow their bodies.
    #[cold]
    pub(crate) fn follow_all(&mut self, movers: &Movers) {
        I::run(
            #[inline(always)]
            || {
                let shifts = [movers.shifts(&self.locals[0]), movers.shifts(&self.locals[1])];
                let (sides, shared) = (Sides::of(&self.sides(movers)), self.shared_basis());
                for at in self.near_rows..self.rows.len() {
                    self.follow_row((at, shared), &shifts);
                    self.rows[at].response = self.point(at, shared).response(&sides, self.rows[at].is_there);
                }
                self.near_rows = self.rows.len();
            },
        );
    }

    /// What kinematic bodies do at the points, now or in the mean over `chord` [s]: their points are followed along their chords.
    pub(crate) fn be_driven(&mut self, bodies: &Bodies, chord: Option<f64>) {
        if !self.is_driven {
            return;
        }
        for (lane, patch) in self.rest.patches.iter().enumerate() {
            let motions = [patch.pair.first, patch.pair.second].map(|i| &bodies.motions[i]);
            for (row, drives) in self.rows.iter().zip(&mut self.rest.drives) {
                let lever = row.lever.get(lane);
                let levers = [lever, lever + self.offset.get(lane)];
                let of = |side: usize| drive(motions[side], levers[side], chord);
                drives.set(lane, of(0) - of(1));
            }
        }
    }

    /// Asks for what a visit of the first rows will need.
    #[inline(always)]
    pub(crate) fn prefetch(&self, movers: &Movers, rows: usize) {
        I::prefetch(&self.rows[..rows]);
        self.directions.prefetch();
        movers.prefetch::<I>(&self.locals[0]);
        movers.prefetch::<I>(&self.locals[1]);
    }

    /// Asks for what the last pass of a stage will need beside that.
    #[inline(always)]
    pub(crate) fn prefetch_motions(&self, movers: &Movers) {
        movers.prefetch_motions::<I>(&self.locals[0]);
        movers.prefetch_motions::<I>(&self.locals[1]);
    }

    /// Asks for what [`Self::meet`] will need.
    #[inline(always)]
    pub(crate) fn prefetch_to_meet(&self, movers: &Movers) {
        self.prefetch(movers, self.near_rows);
        movers.prefetch_kicked::<I>(&self.locals[0]);
        movers.prefetch_kicked::<I>(&self.locals[1]);
    }

    /// Asks for what [`Self::follow`] will need.
    #[inline(always)]
    pub(crate) fn prefetch_to_follow(&self, movers: &Movers) {
        self.prefetch_to_meet(movers);
        movers.prefetch_shifts::<I>(&self.locals[0]);
        movers.prefetch_shifts::<I>(&self.locals[1]);
        I::prefetch(&self.anchors[..self.near_rows]);
        if let Some(far) = self.anchors.get(self.near_rows) {
            I::prefetch(std::slice::from_ref(&far.reach));
        }
    }

    /// Asks for all that is known of the pairs.
    #[inline(always)]
    pub(crate) fn prefetch_all(&self) {
        I::prefetch(&self.rows);
        self.directions.prefetch();
        I::prefetch(&self.anchors);
        I::prefetch(&self.rest.patches);
    }

    /// How many rows may act at a stage: none behind them does.
    #[inline(always)]
    pub(crate) fn acting_rows(&self, stage: Stage) -> usize {
        if stage == Stage::AfterDrift { self.met_rows } else { self.near_rows }
    }

    /// Whether a pass at a stage has anything to do here, where it does not rest: rows that act or have carried.
    #[inline(always)]
    pub(crate) fn has_work(&self, stage: Stage) -> bool {
        stage != Stage::AfterDrift || self.met_rows > 0 || self.carrying_rows[stage.at()] > 0
    }

    /// Any row may have met, and carry.
    pub(crate) fn forget_who_acts(&mut self) {
        (self.met_rows, self.carrying_rows) = (self.rows.len(), [self.rows.len(); 2]);
    }

    #[inline(always)]
    pub(crate) fn sides(&self, movers: &Movers) -> [Side<I>; 2] {
        [movers.load(&self.locals[0]), movers.load(&self.locals[1])]
    }

    /// Shows the bodies as fast as they are now.
    #[inline(always)]
    pub(crate) fn show(&self, movers: &Movers, sides: &[Side<I>; 2]) {
        movers.show(&self.locals[0], &sides[0], self.sizes[0]);
        movers.show(&self.locals[1], &sides[1], self.sizes[1]);
    }

    /// The moments about the first centres of mass of impulses with these sums and these moments about both: exactly those about the smaller bodies, whose levers are short, as single
    /// precision has lost more of the others.
    #[inline(always)]
    pub(crate) fn first_moments(&self, impulse: Lanes3<I>, [first, second]: [Single3<I>; 2]) -> Lanes3<I> {
        let [size, other_size] = self.sizes;
        let is_smaller = size.above(other_size).or(size.above(Single::ZERO).not());
        let by_second = other_size.above(Single::ZERO).and(is_smaller);
        by_second.select(second.double() - self.offset.cross(impulse), first.double())
    }

    /// The directions of all rows, if they have the same ones.
    #[inline(always)]
    pub(crate) fn shared_basis(&self) -> Option<Basis<I>> {
        match &self.directions {
            RowDirections::Shared(directions) => Some(directions.basis()),
            RowDirections::Each(_) => None,
        }
    }

    #[inline(always)]
    fn basis(&self, at: usize, shared: Option<Basis<I>>) -> Basis<I> {
        match shared {
            Some(basis) => basis,
            None => self.directions.of(at).basis(),
        }
    }

    /// A row as it acts.
    #[inline(always)]
    pub(crate) fn point(&self, at: usize, shared: Option<Basis<I>>) -> Point<I> {
        let lever = self.rows[at].lever;
        let drive = if self.is_driven { Some(self.rest.drives[at]) } else { None };
        Point { basis: self.basis(at, shared), levers: [lever, lever + self.offset.single()], drive }
    }

    #[inline(always)]
    pub(crate) fn hold(&self) -> Hold<I> {
        Hold { soft: self.soft, friction: self.friction, relaxation: Single::splat(1.0) }
    }

    /// Where the first point of a pair is, in the world frame [m]; where one was, if it has none.
    fn last_point(&self, movers: &Movers, lane: usize) -> DVec3 {
        let patch = &self.rest.patches[lane];
        match self.rows.first() {
            Some(row) if row.is_there.get(lane) => {
                row.lever.get(lane) + movers.pose(self.locals[0][lane]).position
            }
            _ => patch.anew.as_ref().map_or(DVec3::ZERO, |anew| anew.point),
        }
    }
}

impl Patch {
    /// By how much its bodies may move against each other since its points were found, until these have to be looked for anew [m].
    fn rests_for(&self) -> f64 {
        let stale = if self.are_in_heap && !self.has_few { STALE_IN_HEAPS } else { STALE } * self.size;
        if self.anew.is_none() { stale.min(self.near) } else { stale }
    }
}

impl<I: Instructions> Anchors<I> {
    fn sample(&self, lane: usize) -> (bool, u64) {
        (self.is_of_first.get(lane), self.sample[lane])
    }
}
