//! The points of contact as the substeps' solver sees them: several pairs side by side, one in each lane. No body that can move is in
//! two of them, so they act at the same time.

use crate::clusters::Member;
use crate::contact_rows::{Basis, Directions, Point, Row, RowImpulse, Stage};
use crate::detection::{moved_since, second_from_first};
use crate::lanes::{Instructions, Kept, Kept3, LANES, Lanes, Lanes3, Mask};
use crate::manifold::{Manifold, ManifoldFinder, ManifoldPoint};
use crate::moving::{Movers, Side, drive};
use crate::pair::{Pair, placed};
use crate::tally::{Debt, Tally};
use crate::warm_start::{Carried, PointImpulse, WarmStart};
use crate::{Bodies, Frame, Motion};
use frangible_geometry::RigidTransform;
use glam::{DQuat, DVec3, Vec3};

/// Where the points of a row are on their bodies: see [`ManifoldPoint`].
#[derive(Clone)]
struct Anchors<I> {
    /// Levers of the anchors from the centres of mass at the frame's start [m].
    levers: [Kept3<I>; 2],
    rounding: [Kept<I>; 2],
    /// The gap there if nothing had moved since the frame's start [m].
    gap: Kept<I>,
    /// Which go with the first body, as samples or features of it; the others go with the second.
    is_of_first: Mask,
    /// Which sample or feature each is.
    sample: [u64; LANES],
}

/// How a contact's normal impulses answer [Cat24].
#[derive(Clone, Copy)]
pub(crate) struct Softness<N> {
    /// Closing speed of an overlap per depth [1/s].
    pub(crate) rate: N,
    /// Of what a rigid point would add to its impulse [1].
    pub(crate) mass_scale: N,
    /// Of the impulse so far, that it takes back [1].
    pub(crate) impulse_scale: N,
}

/// How the contacts of a batch hold their bodies.
pub(crate) struct Hold<I> {
    pub(crate) soft: Softness<Lanes<I>>,
    /// Coefficient of friction.
    pub(crate) friction: Lanes<I>,
}

/// Several pairs.
pub(crate) struct Batch<I> {
    /// Their bodies, by their place in the cluster.
    pub(crate) locals: [[u32; LANES]; 2],
    /// Centres of mass of the first bodies less those of the second ones [m].
    pub(crate) offset: Lanes3<I>,
    /// Energy that they have given to their bodies in this frame, beyond a kinematic body's work [J].
    pub(crate) given: Lanes<I>,
    pub(crate) soft: Softness<Kept<I>>,
    pub(crate) friction: Kept<I>,
    pub(crate) rows: Vec<Row<I>>,
    /// One for all rows, or one for each.
    directions: Vec<Directions<I>>,
    /// Whether there is rolling or spinning friction.
    pub(crate) rolls: bool,
    /// Whether a kinematic body is among them.
    pub(crate) is_driven: bool,
    /// Whether a static or kinematic body is among them.
    pub(crate) has_outside: bool,
    /// Whether any point has to bounce.
    pub(crate) bounces: bool,
    pub(crate) rest: Box<Rest<I>>,
}

/// What not every pass needs to know of a batch.
pub(crate) struct Rest<I> {
    /// Centres of mass of the first bodies less those of the second ones, at the frame's start [m].
    start_offset: Lanes3<I>,
    /// Centres of mass of the first bodies at the frame's start, and now if there is something outside [m].
    start: Lanes3<I>,
    pub(crate) centre: Lanes3<I>,
    /// How much [`Movers`] had been stirred when the rows' responses were found.
    answered_at: Lanes<I>,
    pub(crate) restitution: Lanes<I>,
    /// Of rolling and of spinning friction [m].
    pub(crate) roll_lengths: [Lanes<I>; 2],
    /// What kinematic bodies add to the spin of the first bodies less that of the second ones [rad/s].
    pub(crate) spin: Lanes3<I>,
    /// Work of kinematic bodies in this frame [J].
    pub(crate) work: Lanes<I>,
    /// At which speed the surfaces of each row have met [m/s].
    pub(crate) met_at: Vec<Lanes<I>>,
    /// Of rolling and spinning friction, before and after the drift, a pair for each row if anything rolls [N m s].
    pub(crate) twists: Vec<[Lanes3<I>; 2]>,
    /// What kinematic bodies add to the velocity of the first bodies' material less that of the second ones', for each row if they are
    /// there [m/s].
    drives: Vec<Lanes3<I>>,
    anchors: Vec<Anchors<I>>,
    /// One for each lane that is used.
    pub(crate) patches: Vec<Patch>,
    /// Of a substep [s].
    dt: f64,
}

/// What is known of one pair.
pub(crate) struct Patch {
    pub(crate) pair: Pair,
    /// Its place among the manifolds.
    pub(crate) manifold: usize,
    /// The bodies' travel when it was last looked at [m].
    travel: f64,
    /// Of the smaller body [m].
    size: f64,
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

/// Natural frequency of soft contact at up to four points [Hz], limited to a quarter of the substeps' rate. More points share its
/// stiffness. At 30 an elevator's stack sinks by more than a millimetre, at 60 stacks sway.
const CONTACT_HERTZ: f64 = 42.0;

/// Damping ratio of soft contact [1]: ten times critical, so that overlaps close without bouncing back [Cat24].
const CONTACT_DAMPING: f64 = 10.0;

/// Relative motion after which a pair's points are found anew, relative to the size of the smaller body: within it a curved
/// surface's normal turns by no more than some degrees.
const STALE: f64 = 0.1;

/// Motion of the bodies, relative to their sizes, after which the responses of their rows are found anew: they have changed by no
/// more than some hundredths.
const STIRRED: f64 = 0.02;

impl<I: Instructions> Batch<I> {
    /// Of the contacts of at most [`LANES`] pairs, with the impulses that the same points had at the end of the last frame.
    pub(crate) fn new(
        bodies: &Bodies,
        movers: &Movers,
        group: &[Member],
        manifolds: &[Manifold],
        (carried, step): (&[&[Carried]], &Frame),
    ) -> Self {
        let mut batch = Self::empty([[movers.nobody(); LANES]; 2], step.dt);
        for (lane, member) in group.iter().enumerate() {
            let manifold = &manifolds[member.manifold];
            batch.add_pair((bodies, movers), lane, member, manifold.pair);
            let orientations = batch.start_orientations(movers, lane);
            let carried = carried[member.manifold];
            for (number, point) in manifold.points.iter().enumerate() {
                let same = carried.iter().find(|carried| carried.sample == point.sample);
                let forces = same.map(|same| same.forces).unwrap_or_default();
                let impulses = [forces[0].scaled(step.dt), forces[1].scaled(step.dt)];
                batch.place(lane, (number, point), &orientations, impulses);
            }
            batch.soften(lane, manifold.points.len());
        }
        batch
    }

    fn empty(locals: [[u32; LANES]; 2], dt: f64) -> Self {
        let rest = Rest {
            start_offset: Lanes3::ZERO,
            start: Lanes3::ZERO,
            centre: Lanes3::ZERO,
            answered_at: Lanes::ZERO,
            restitution: Lanes::ZERO,
            roll_lengths: [Lanes::ZERO; 2],
            spin: Lanes3::ZERO,
            work: Lanes::ZERO,
            met_at: Vec::with_capacity(4),
            twists: Vec::new(),
            drives: Vec::new(),
            anchors: Vec::with_capacity(4),
            patches: Vec::with_capacity(LANES),
            dt,
        };
        Self {
            locals,
            offset: Lanes3::ZERO,
            given: Lanes::ZERO,
            soft: Softness { rate: Kept::ZERO, mass_scale: Kept::ZERO, impulse_scale: Kept::ZERO },
            friction: Kept::ZERO,
            rows: Vec::with_capacity(4),
            directions: Vec::with_capacity(1),
            rolls: false,
            is_driven: false,
            has_outside: false,
            bounces: false,
            rest: Box::new(rest),
        }
    }

    /// Gives a lane its pair.
    fn add_pair(&mut self, (bodies, movers): (&Bodies, &Movers), lane: usize, member: &Member, pair: Pair) {
        let locals = member.locals;
        [self.locals[0][lane], self.locals[1][lane]] = locals;
        let (centre, other_centre) = (movers.start(locals[0]).position, movers.start(locals[1]).position);
        self.rest.start_offset.set(lane, centre - other_centre);

        // How its surfaces hold.
        let surfaces = bodies.pair_contactant(pair.first, pair.second);
        self.friction.set(lane, surfaces.friction);
        self.rest.restitution.set(lane, surfaces.restitution);
        self.rest.roll_lengths[0].set(lane, surfaces.rolling_friction);
        self.rest.roll_lengths[1].set(lane, surfaces.spinning_friction);
        self.rolls |= surfaces.rolling_friction > 0.0 || surfaces.spinning_friction > 0.0;

        // What comes from outside.
        self.rest.start.set(lane, centre);
        for (local, i, sign) in [(locals[0], pair.first, 1.0), (locals[1], pair.second, -1.0)] {
            if !movers.is_mobile(local) {
                self.has_outside = true;
                if let Motion::Kinematic { angular, .. } = bodies.motions[i] {
                    self.is_driven = true;
                    self.rest.spin.set(lane, self.rest.spin.get(lane) + sign * angular);
                }
            }
        }
        self.rest.patches.push(Patch {
            pair,
            manifold: member.manifold,
            travel: 0.0,
            size: movers.size(locals[0]).min(movers.size(locals[1])),
            touched: false,
            anew: None,
        });
    }

    /// However many points a contact has, it is as stiff as with four: soft contact is a spring and a damper that no step size makes
    /// unstable [Cat24].
    fn soften(&mut self, lane: usize, points: usize) {
        let share = (4.0 / points as f64).min(1.0);
        let hertz = share.sqrt() * CONTACT_HERTZ;
        let omega = std::f64::consts::TAU * hertz.min(0.25 / self.rest.dt);
        let a = 2.0 * CONTACT_DAMPING + self.rest.dt * omega;
        let b = self.rest.dt * omega * a;
        self.soft.rate.set(lane, omega / a);
        self.soft.mass_scale.set(lane, b / (1.0 + b));
        self.soft.impulse_scale.set(lane, 1.0 / (1.0 + b));
    }

    /// Puts a point into a lane, with what acts there.
    fn place(
        &mut self,
        lane: usize,
        (number, point): (usize, &ManifoldPoint),
        start_orientations: &[DQuat; 2],
        impulses: [PointImpulse; 2],
    ) {
        self.turn_lane(lane, number, point.normal);
        while self.rows.len() <= number {
            self.rows.push(Row::empty());
            self.rest.anchors.push(Anchors::empty());
            self.rest.met_at.push(Lanes::ZERO);
        }
        if self.rolls {
            self.rest.twists.resize(self.rows.len(), [Lanes3::ZERO; 2]);
        }
        if self.is_driven {
            self.rest.drives.resize(self.rows.len(), Lanes3::ZERO);
        }

        // Where it was at the frame's start.
        let directions = self.directions[number.min(self.directions.len() - 1)];
        let (normal, tangent) = (directions.normal.get(lane), directions.tangent.get(lane));
        let anchors = &mut self.rest.anchors[number];
        let levers =
            [start_orientations[0] * point.anchor_first, start_orientations[1] * point.anchor_second];
        for side in 0..2 {
            anchors.levers[side].set(lane, levers[side]);
            anchors.rounding[side].set(lane, point.rounding[side]);
        }
        anchors.is_of_first.set(lane, point.sample.0);
        anchors.sample[lane] = point.sample.1;
        let apart = (self.rest.start_offset.get(lane) + levers[0] - levers[1]).dot(normal);
        anchors.gap.set(lane, apart - point.rounding[0] - point.rounding[1]);

        let row = &mut self.rows[number];
        row.is_there.set(lane, true);
        for (at, PointImpulse { normal: along, tangent: across, twist }) in impulses.into_iter().enumerate() {
            let across = across.as_dvec3();
            row.impulses[at].normal.set(lane, along.into());
            row.impulses[at].tangent[0].set(lane, across.dot(tangent));
            row.impulses[at].tangent[1].set(lane, across.dot(normal.cross(tangent)));
            if self.rolls {
                self.rest.twists[number][at].set(lane, twist.as_dvec3());
            }
        }
    }

    /// How a lane's bodies were turned at the frame's start.
    fn start_orientations(&self, movers: &Movers, lane: usize) -> [DQuat; 2] {
        [movers.start(self.locals[0][lane]).orientation, movers.start(self.locals[1][lane]).orientation]
    }

    /// Gives a lane's point its normal: all rows have the same ones as long as all points of each pair have.
    fn turn_lane(&mut self, lane: usize, number: usize, normal: DVec3) {
        if self.directions.is_empty() {
            self.directions.push(Directions::NONE);
        }
        let is_first = !self.rows.iter().any(|row| row.is_there.get(lane));
        if self.directions.len() == 1 {
            if is_first {
                self.directions[0].set(lane, normal);
            }
            if self.directions[0].is(lane, normal) {
                return;
            }
        }
        let last = self.directions[self.directions.len() - 1];
        self.directions.resize(self.rows.len().max(number + 1).max(2), last);
        self.directions[number].set(lane, normal);
    }

    /// Empties a lane; what it held.
    fn take(&mut self, lane: usize) -> Vec<Taken> {
        let mut taken = Vec::new();
        for at in 0..self.rows.len() {
            let row = &self.rows[at];
            if !row.is_there.get(lane) {
                continue;
            }
            let impulses = self.impulses_of(at, lane);
            let carried = Carried { sample: self.rest.anchors[at].sample(lane), forces: impulses };
            let met_at = row.has_met.get(lane).then_some(self.rest.met_at[at].get(lane));
            taken.push(Taken { carried, impulses, met_at, touched: row.touched.get(lane) });
            self.rows[at].clear(lane);
            if self.rolls {
                self.rest.twists[at].iter_mut().for_each(|twist| twist.set(lane, DVec3::ZERO));
            }
        }
        taken
    }

    /// What acts at a point.
    fn impulses_of(&self, at: usize, lane: usize) -> [PointImpulse; 2] {
        let directions = &self.directions[at.min(self.directions.len() - 1)];
        let (n, t) = (directions.normal.get(lane), directions.tangent.get(lane));
        [0, 1].map(|stage| {
            let RowImpulse { normal, tangent } = &self.rows[at].impulses[stage];
            PointImpulse {
                normal: normal.get(lane) as f32,
                tangent: (tangent[0].get(lane) * t + tangent[1].get(lane) * n.cross(t)).as_vec3(),
                twist: self
                    .rest
                    .twists
                    .get(at)
                    .map_or(Vec3::ZERO, |twists| twists[stage].get(lane).as_vec3()),
            }
        })
    }

    /// Finds the points of pairs anew that have moved too far since they were found; those that are the same go on. `rest` is what is
    /// left of the frame. Returns whether there were any: their rows have yet to follow.
    pub(crate) fn refresh(
        &mut self,
        bodies: &mut Bodies,
        movers: &Movers,
        finder: &mut ManifoldFinder,
        rest: &Frame,
    ) -> bool {
        let mut is_changed = false;
        for lane in 0..self.rest.patches.len() {
            let pair = [self.locals[0][lane], self.locals[1][lane]];
            let patch = &self.rest.patches[lane];
            let may_be_stale = movers.travel(pair) - patch.travel > STALE * patch.size;
            if may_be_stale {
                let (first, second) = placed(bodies, patch.pair, &bodies.poses);
                let found_at = match &patch.anew {
                    Some(anew) => anew.found_at,
                    None => movers.start_second_from_first(pair),
                };
                if moved_since(&found_at, first, second, 0.0) > STALE * patch.size {
                    pair.into_iter().for_each(|local| movers.hand_back_one(bodies, local));
                    self.find_anew(lane, (bodies, movers), finder, rest);
                    is_changed = true;
                }
                self.rest.patches[lane].travel = movers.travel(pair);
            }
        }
        is_changed
    }

    fn find_anew(
        &mut self,
        lane: usize,
        (bodies, movers): (&Bodies, &Movers),
        finder: &mut ManifoldFinder,
        rest: &Frame,
    ) {
        let pair = self.rest.patches[lane].pair;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let point = self.last_point(bodies, lane);
        let taken = self.take(lane);
        let patch = &mut self.rest.patches[lane];
        patch.anew = Some(Box::new(Anew { found_at: second_from_first(first, second), point }));
        patch.touched |= taken.iter().any(|taken| taken.touched);

        let mut warm = WarmStart::with_room(1);
        warm.keep(0, bodies, pair, taken.iter().filter(|taken| taken.touched).map(|taken| taken.carried));
        let manifold = finder.find(bodies, pair, &warm, rest);
        let points = manifold.map(|manifold| manifold.points).unwrap_or_default();
        let orientations = self.start_orientations(movers, lane);
        for (number, point) in points.iter().enumerate() {
            let same = taken.iter().find(|taken| taken.carried.sample == point.sample);
            let impulses = same.map(|same| same.impulses).unwrap_or_default();
            self.place(lane, (number, point), &orientations, impulses);
            if let Some(same) = same {
                let row = &mut self.rows[number];
                row.has_met.set(lane, same.met_at.is_some());
                row.touched.set(lane, same.touched);
                self.rest.met_at[number].set(lane, same.met_at.unwrap_or(0.0));
            }
        }
        self.soften(lane, points.len());
    }

    /// Follows the bodies to where they are now. After a drift, in a substep of `drifted` [s], what has parted is forgotten.
    #[inline(always)]
    pub(crate) fn follow(&mut self, movers: &Movers, drifted: Option<f64>) {
        let (sides, shared) = (self.sides(movers), self.shared_basis());
        let (first, second) = (movers.shifts(&self.locals[0]), movers.shifts(&self.locals[1]));
        self.offset = self.rest.start_offset + (first.translation - second.translation);
        if self.has_outside {
            self.rest.centre = self.rest.start + first.translation;
        }
        let stirred = first.stirred + second.stirred;
        let answers =
            drifted.is_none() || (stirred - self.rest.answered_at).above(Lanes::splat(STIRRED)).any();
        if answers {
            self.rest.answered_at = stirred;
        }
        for at in 0..self.rows.len() {
            let normal = self.basis(at, shared).normal;
            let anchors = &self.rest.anchors[at];
            let [lever, other_lever] = [anchors.levers[0].lanes(), anchors.levers[1].lanes()];
            let (turn, other_turn) = (first.turn(lever), second.turn(other_lever));
            let shift = first.translation - second.translation + turn - other_turn;
            let gap = anchors.gap.lanes() + shift.dot(normal);

            // Between the surfaces, beside the corner that slides along the other body.
            let half = Lanes::splat(0.5) * gap;
            let on_first = lever + turn - normal * (anchors.rounding[0].lanes() + half);
            let on_second = other_lever + other_turn + normal * (anchors.rounding[1].lanes() + half);
            let row = &mut self.rows[at];
            row.lever = anchors.is_of_first.select3(on_first, on_second - self.offset).kept();
            row.gap = gap.kept();
            let point = self.point(at, shared);
            if answers {
                self.rows[at].response = point.response(&sides, self.rows[at].is_there);
            }
            if let Some(dt) = drifted
                && !self.is_driven
            {
                self.forget_if_parted(at, Stage::AfterDrift, point.closing(&sides), dt);
            }
        }
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

    /// Asks for what a visit will need.
    #[inline(always)]
    pub(crate) fn prefetch(&self, movers: &Movers) {
        I::prefetch(&self.rows);
        I::prefetch(&self.directions);
        movers.prefetch::<I>(&self.locals[0]);
        movers.prefetch::<I>(&self.locals[1]);
    }

    #[inline(always)]
    pub(crate) fn sides(&self, movers: &Movers) -> [Side<I>; 2] {
        [movers.load(&self.locals[0]), movers.load(&self.locals[1])]
    }

    #[inline(always)]
    pub(crate) fn store(&self, movers: &mut Movers, sides: &[Side<I>; 2]) {
        movers.store(&self.locals[0], &sides[0]);
        movers.store(&self.locals[1], &sides[1]);
    }

    /// The directions of all rows, if they have the same ones.
    #[inline(always)]
    pub(crate) fn shared_basis(&self) -> Option<Basis<I>> {
        match self.directions.as_slice() {
            [directions] => Some(directions.basis()),
            _ => None,
        }
    }

    #[inline(always)]
    fn basis(&self, at: usize, shared: Option<Basis<I>>) -> Basis<I> {
        match shared {
            Some(basis) => basis,
            None => self.directions[at].basis(),
        }
    }

    /// A row as it acts.
    #[inline(always)]
    pub(crate) fn point(&self, at: usize, shared: Option<Basis<I>>) -> Point<I> {
        let lever = self.rows[at].lever.lanes();
        let drive = if self.is_driven { Some(self.rest.drives[at]) } else { None };
        Point { basis: self.basis(at, shared), levers: [lever, lever + self.offset], drive }
    }

    #[inline(always)]
    pub(crate) fn hold(&self) -> Hold<I> {
        let Softness { rate, mass_scale, impulse_scale } = &self.soft;
        let soft = Softness {
            rate: rate.lanes(),
            mass_scale: mass_scale.lanes(),
            impulse_scale: impulse_scale.lanes(),
        };
        Hold { soft, friction: self.friction.lanes() }
    }

    /// Where the first point of a pair is, in the world frame [m]; where one was, if it has none.
    fn last_point(&self, bodies: &Bodies, lane: usize) -> DVec3 {
        let patch = &self.rest.patches[lane];
        match self.rows.first() {
            Some(row) if row.is_there.get(lane) => {
                row.lever.get(lane) + bodies.poses[patch.pair.first].position
            }
            _ => patch.anew.as_ref().map_or(DVec3::ZERO, |anew| anew.point),
        }
    }

    /// Books what kinematic bodies did.
    pub(crate) fn book_work(&self, bodies: &Bodies, tally: &mut Tally) {
        if self.is_driven {
            for (lane, patch) in self.rest.patches.iter().enumerate() {
                let Pair { first, second } = patch.pair;
                let is_on_first = bodies.inertias[second].is_infinite();
                let [on, by] = if is_on_first { [first, second] } else { [second, first] };
                tally.book_outside(bodies, [on, by], (DVec3::ZERO, DVec3::ZERO), self.rest.work.get(lane));
            }
        }
    }

    /// What each pair gave in all, if anything: to be paid back where its first point acts.
    pub(crate) fn debt(&self, bodies: &Bodies, lane: usize) -> Option<Debt> {
        let patch = &self.rest.patches[lane];
        let ids = [patch.pair.first, patch.pair.second].map(|i| bodies.ids[i]);
        let energy = self.given.get(lane);
        (energy > 0.0).then(|| Debt { ids, point: self.last_point(bodies, lane), energy })
    }

    /// Whether a pair has exchanged impulses in this frame.
    pub(crate) fn touched(&self, lane: usize) -> bool {
        self.rest.patches[lane].touched || self.rows.iter().any(|row| row.touched.get(lane))
    }

    /// The points of a pair that acted, and what acts there.
    pub(crate) fn carried(&self, lane: usize) -> impl Iterator<Item = Carried> {
        let acted = move |&at: &usize| {
            let row = &self.rows[at];
            row.is_there.get(lane) && row.touched.get(lane)
        };
        (0..self.rows.len()).filter(acted).map(move |at| Carried {
            sample: self.rest.anchors[at].sample(lane),
            forces: self.impulses_of(at, lane).map(|impulse| impulse.scaled(1.0 / self.rest.dt)),
        })
    }
}

/// A point that was taken out of a lane.
struct Taken {
    carried: Carried,
    impulses: [PointImpulse; 2],
    met_at: Option<f64>,
    touched: bool,
}

impl<I: Instructions> Anchors<I> {
    fn empty() -> Self {
        Self {
            levers: [Kept3::ZERO; 2],
            rounding: [Kept::ZERO; 2],
            gap: Kept::ZERO,
            is_of_first: Mask::NONE,
            sample: [0; LANES],
        }
    }

    fn sample(&self, lane: usize) -> (bool, u64) {
        (self.is_of_first.get(lane), self.sample[lane])
    }
}
