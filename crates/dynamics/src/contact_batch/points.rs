//! Which points of which pairs are in the lanes of a batch: gathered a line for each lane, row by row.

use super::{Anchors, Batch, Patch, Rest, Softness};
use crate::clusters::Member;
use crate::contact_rows::{Directions, Row, RowDirections, RowImpulse};
use crate::kept_pairs::CLOSE;
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask, Numbers, Single, Single3, Singles};
use crate::manifold::{MOST_POINTS, Manifold, ManifoldPoint, Solid};
use crate::moving::{Movers, Start};
use crate::pair::Pair;
use crate::warm_start::{Carried, PointImpulse};
use crate::{Bodies, Motion};

/// Natural frequency of soft contact at up to four points [Hz], limited to a quarter of the substeps' rate. More points share its
/// stiffness. At 30 an elevator's stack sinks by more than a millimetre, at 60 stacks sway.
const CONTACT_HERTZ: f64 = 42.0;

/// Damping ratio of soft contact [1]: ten times critical, so that overlaps close without bouncing back [Cat24].
const CONTACT_DAMPING: f64 = 10.0;

/// Of what is thinner of two bodies, so much may get into the other one by a blow before their points are looked for anew [1]: with less, heaps look for
/// many; a card that is struck at its edge must not get through.
const THIN: f64 = 0.25;

/// Of what is thinner of two polyhedra in a heap, so far a blow may drive one into the other until they are looked at anew, the substep included in which they are [1]: what has
/// come half of the way is pushed back to where it came from.
const GETS_THROUGH: f64 = 0.5;

/// What touches at a frame's start.
#[derive(Clone, Copy)]
pub(crate) struct Touching<'a> {
    pub(crate) manifolds: &'a [Manifold<'a>],
    /// What the points of each carried at the end of the last frame.
    pub(crate) carried: &'a [&'a [Carried]],
    /// See [`Encounter::near`](crate::encounter::Encounter::near): how far points were looked for beyond what the bodies' ways take [m].
    pub(crate) near: f64,
}

/// A point of a pair and what it carried in the last frame, by their places; [`NOWHERE`](Self::NOWHERE) if there is none.
#[derive(Clone, Copy)]
struct Place {
    point: u8,
    carried: u8,
}

impl Place {
    const NOWHERE: u8 = u8::MAX;
    const NONE: Self = Self { point: Self::NOWHERE, carried: Self::NOWHERE };
}

/// Points for a row, in some lanes.
pub(super) struct NewPoints<'a> {
    lanes: Mask,
    /// On the first and on the second body, each in its own frame and with its rounding [m].
    anchors: [Numbers; LANES],
    normals: [Singles; LANES],
    /// What acts there before and after the drift, in units of `by`.
    impulses: [&'a [PointImpulse; 2]; LANES],
    by: f64,
    is_of_first: Mask,
    sample: [u64; LANES],
}

impl<'a> NewPoints<'a> {
    const NOTHING: [PointImpulse; 2] = [PointImpulse::ZERO; 2];

    /// None yet; what acts there is told in units of `by`.
    pub(super) fn none(by: f64) -> Self {
        Self {
            lanes: Mask::NONE,
            anchors: [Numbers::ZERO; LANES],
            normals: [Singles::ZERO; LANES],
            impulses: [&Self::NOTHING; LANES],
            by,
            is_of_first: Mask::NONE,
            sample: [0; LANES],
        }
    }

    /// A lane's point, and what acts there, if anything does.
    #[inline(always)]
    pub(super) fn add(
        &mut self,
        lane: usize,
        point: &ManifoldPoint,
        impulses: Option<&'a [PointImpulse; 2]>,
    ) {
        let ManifoldPoint { anchor_first: a, anchor_second: b, rounding, normal: n, sample, .. } = *point;
        self.lanes.set(lane, true);
        self.anchors[lane] = Numbers([a.x, a.y, a.z, rounding[0], b.x, b.y, b.z, rounding[1]]);
        let n = n.as_vec3();
        self.normals[lane] = Singles([n.x, n.y, n.z, 0.0, 0.0, 0.0, 0.0, 0.0]);
        self.impulses[lane] = impulses.unwrap_or(&Self::NOTHING);
        self.is_of_first.set(lane, sample.0);
        self.sample[lane] = sample.1;
    }

    /// What acts in the world, before and after the drift.
    #[inline(always)]
    fn acting<I: Instructions>(&self) -> [Single3<I>; 2] {
        let mut lines = [Singles::ZERO; LANES];
        for (line, [before, after]) in lines.iter_mut().zip(self.impulses) {
            let (a, b) = (before.force, after.force);
            line.0 = [a.x, a.y, a.z, 0.0, b.x, b.y, b.z, 0.0];
        }
        let by = Single::splat(self.by);
        let [x, y, z, _, tx, ty, tz, _] = Single::transposed(lines);
        [Single3 { x, y, z } * by, Single3 { x: tx, y: ty, z: tz } * by]
    }
}

impl<I: Instructions> Batch<I> {
    /// Of the contacts of at most [`LANES`] pairs, with the impulses that the same points had at the end of the last frame. A substep
    /// takes `dt` [s].
    pub(crate) fn new(
        (bodies, movers): (&Bodies, &Movers),
        group: &[Member],
        touching: Touching,
        dt: f64,
    ) -> Self {
        let count = |member: &Member| touching.manifolds[member.manifold].points.len();
        let rows = group.iter().map(count).max().unwrap_or(0);
        let mut batch = Self::empty([[movers.nobody(); LANES]; 2], rows, dt);
        for (lane, member) in group.iter().enumerate() {
            let manifold = &touching.manifolds[member.manifold];
            batch.add_pair(bodies, movers, lane, (member, manifold, touching.near));
        }
        I::run(
            #[inline(always)]
            || {
                let starts = batch.starts(movers);
                batch.begin(&starts);
                for (row, places) in touching.places(group).iter().take(rows).enumerate() {
                    batch.place(row, &touching.points((group, places), dt), &starts);
                }
                batch.soften();
                batch.find_reach();
            },
        );
        batch
    }

    /// Without pairs, but with memory for so many rows.
    fn empty(locals: [[u32; LANES]; 2], rows: usize, dt: f64) -> Self {
        let rest = Rest {
            start: Lanes3::ZERO,
            centre: Lanes3::ZERO,
            restitution: Single::ZERO,
            stiffness: Single::ZERO,
            roll_lengths: [Single::ZERO; 2],
            spin: Single3::ZERO,
            work: Lanes::ZERO,
            starts: Vec::new(),
            twists: Vec::new(),
            drives: Vec::new(),
            patches: Vec::with_capacity(LANES),
        };
        Self {
            locals,
            offset: Lanes3::ZERO,
            pending: [Single3::ZERO; 3],
            is_pending: false,
            given: Lanes::ZERO,
            soft: Softness { rate: Single::ZERO, mass_scale: Single::ZERO, impulse_scale: Single::ZERO },
            friction: Single::ZERO,
            rows: Vec::with_capacity(rows),
            anchors: Vec::with_capacity(rows),
            directions: RowDirections::Shared(Directions::NONE),
            rolls: false,
            is_driven: false,
            has_outside: false,
            bounces: false,
            rests: false,
            impacts: false,
            met_rows: 0,
            carrying_rows: [0; 2],
            near_rows: 0,
            room: Single::ZERO,
            sizes: [Single::ZERO; 2],
            start_offset: Lanes3::ZERO,
            answered_at: Lanes::ZERO,
            look_at: Lanes::splat(f64::INFINITY),
            looks: Mask::NONE,
            dt,
            rest: Box::new(rest),
        }
    }

    /// Gives a lane its pair.
    fn add_pair(
        &mut self,
        bodies: &Bodies,
        movers: &Movers,
        lane: usize,
        (member, touching, near): (&Member, &Manifold, f64),
    ) {
        let pair = touching.pair;
        let locals = member.locals;
        [self.locals[0][lane], self.locals[1][lane]] = locals;

        // How its surfaces hold.
        let surfaces = bodies.pair_contactant(pair.first, pair.second);
        self.friction.set(lane, surfaces.friction);
        self.rest.restitution.set(lane, surfaces.restitution);
        self.rest.stiffness.set(lane, member.stiffness);
        self.rest.roll_lengths[0].set(lane, surfaces.rolling_friction);
        self.rest.roll_lengths[1].set(lane, surfaces.spinning_friction);
        self.rolls |= surfaces.rolling_friction > 0.0 || surfaces.spinning_friction > 0.0;

        // What comes from outside.
        for (local, i, sign) in [(locals[0], pair.first, 1.0), (locals[1], pair.second, -1.0)] {
            if !movers.is_mobile(local) {
                self.has_outside = true;
                if let Motion::Kinematic { angular, .. } = bodies.motions[i] {
                    self.is_driven = true;
                    self.rest.spin.set(lane, self.rest.spin.get(lane) + sign * angular);
                }
            }
        }
        let manifold = member.manifold;
        let (struck, near) = self.watch(bodies, (member, touching), near);
        let patch = Patch {
            pair,
            manifold,
            size: 0.0,
            near,
            struck,
            are_in_heap: member.is_in_heap && are_hulls(bodies, pair),
            has_few: touching.points.len() <= 1,
            is_watched: false,
            touched: false,
            anew: None,
        };
        self.rest.patches.push(patch);
    }

    /// How much faster a pair may come against each other because it is struck, as far as that matters [m/s]: in a heap nobody sees which polyhedron strikes which next, unless it
    /// gets through. And how far it may move, if it may be struck, until points are missed that were too far away at the frame's start: not at all if it is watched and has none, else
    /// as far as they were looked for, which without points in a heap is [`CLOSE`] of that, or by [`THIN`] of what is thinner, or if it is not watched by what the blow leaves of
    /// [`GETS_THROUGH`] [m].
    fn watch(
        &self,
        bodies: &Bodies,
        (member, &Manifold { pair, points, struck }): (&Member, &Manifold),
        near: f64,
    ) -> (f64, f64) {
        if struck == 0.0 {
            return (0.0, f64::INFINITY);
        }
        let thinner = thinner(bodies, pair);
        let left = GETS_THROUGH * thinner - struck * self.dt;
        if member.is_in_heap && left >= 0.0 && are_hulls(bodies, pair) {
            return (0.0, left.max(if points.is_empty() { CLOSE * near } else { near }));
        }
        (struck, if points.is_empty() { 0.0 } else { near.max(THIN * thinner) })
    }

    /// How its bodies began the frame.
    #[inline(always)]
    pub(super) fn starts(&self, movers: &Movers) -> [Start<I>; 2] {
        [movers.starts(&self.locals[0]), movers.starts(&self.locals[1])]
    }

    #[inline(always)]
    fn begin(&mut self, [first, second]: &[Start<I>; 2]) {
        self.rest.start = first.centre;
        self.start_offset = first.centre - second.centre;
        self.sizes = [first.size.single(), second.size.single()];
        for (lane, patch) in self.rest.patches.iter_mut().enumerate() {
            patch.size = smaller(first.size.get(lane), second.size.get(lane));
            // What may be struck and has no points, or may need others at once, is looked at first.
            patch.is_watched = patch.struck * self.dt > patch.rests_for();
            self.look_at.set(lane, if patch.is_watched { -1.0 } else { patch.rests_for() });
        }
    }

    /// Puts points into a row, with what acts there. The other lanes keep theirs.
    #[inline(always)]
    pub(super) fn place(&mut self, at: usize, points: &NewPoints, starts: &[Start<I>; 2]) {
        self.make_room(at + 1);
        let lanes = points.lanes;
        let [x, y, z, ..] = Single::transposed(points.normals);
        let normal = Single3 { x, y, z };
        let directions = Directions { normal, tangent: normal.across() };
        self.directions.set((at, self.rows.len()), lanes, directions);
        let basis = self.directions.of(at).basis();

        // Where they were at the frame's start.
        let [x, y, z, rounding, bx, by, bz, other_rounding] = Lanes::transposed(points.anchors);
        let lever = starts[0].orientation.turn(Lanes3 { x, y, z });
        let other_lever = starts[1].orientation.turn(Lanes3 { x: bx, y: by, z: bz });
        let apart = (self.start_offset + lever - other_lever).dot(basis.normal.double());
        let gap = apart - rounding - other_rounding;
        self.anchors[at].put(lanes, [lever, other_lever], [rounding, other_rounding], gap);
        self.anchors[at].name(lanes, points.is_of_first, &points.sample);

        // What acts there.
        let [before, after] = points.acting();
        let (before, after) = (RowImpulse::new(before, &basis), RowImpulse::new(after, &basis));
        let row = &mut self.rows[at];
        row.is_there = row.is_there.or(lanes);
        row.impulses = [row.impulses[0].but(lanes, before), row.impulses[1].but(lanes, after)];
        for (impulse, carrying) in row.impulses.iter().zip(&mut self.carrying_rows) {
            if impulse.is_any() {
                *carrying = at + 1;
            }
        }
        if self.rolls {
            for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
                let [before, after] = points.impulses[lane].map(|impulse| impulse.scaled(points.by));
                self.rest.twists[at][0].set(lane, before.twist.as_dvec3());
                self.rest.twists[at][1].set(lane, after.twist.as_dvec3());
            }
        }
    }

    /// Has at least so many rows.
    #[inline(always)]
    pub(super) fn make_room(&mut self, rows: usize) {
        let more = rows.saturating_sub(self.rows.len());
        self.rows.reserve_exact(more);
        self.anchors.reserve_exact(more);
        while self.rows.len() < rows {
            self.rows.push(Row::empty());
            self.anchors.push(Anchors::empty());
            if self.rolls {
                self.rest.twists.push([Single3::ZERO; 2]);
            }
            if self.is_driven {
                self.rest.drives.push(Single3::ZERO);
            }
        }
    }

    /// How near the surfaces were at the frame's start, from the last row on.
    #[inline(always)]
    pub(super) fn find_reach(&mut self) {
        let mut nearest = Single::splat(f64::INFINITY);
        for (row, anchors) in self.rows.iter().zip(&mut self.anchors).rev() {
            nearest = row.is_there.select(nearest.min(anchors.gap), nearest);
            anchors.reach = nearest;
        }
    }

    /// However many points a contact has, it is as stiff as with four: soft contact is a spring and a damper that no step size makes
    /// unstable [Cat24].
    #[inline(always)]
    pub(super) fn soften(&mut self) {
        let (one, dt) = (Single::splat(1.0), Single::splat(self.dt));
        let mut points = Single::ZERO;
        for row in &self.rows {
            points = points + row.is_there.select(one, Single::ZERO);
        }
        let share = (Single::splat(4.0) / points).min(one);
        let hertz = share.sqrt() * Single::splat(CONTACT_HERTZ);
        let most = Single::splat(0.25 / self.dt);
        let omega = Single::splat(std::f64::consts::TAU) * hertz.min(most) * self.rest.stiffness.sqrt();
        let a = Single::splat(2.0 * CONTACT_DAMPING) + dt * omega;
        let b = dt * omega * a;
        self.soft =
            Softness { rate: (omega / a), mass_scale: (b / (one + b)), impulse_scale: (one / (one + b)) };
    }
}

impl Touching<'_> {
    /// Which points of some pairs go into which row, a place for each lane: first what carries, then what is nearest, so that the rows behind
    /// hold nothing that does, and need no visit while they are far from touching.
    #[inline(always)]
    fn places(&self, group: &[Member]) -> [[Place; LANES]; MOST_POINTS] {
        let mut places = [[Place::NONE; LANES]; MOST_POINTS];
        for (lane, member) in group.iter().enumerate() {
            let (points, carried) = (self.manifolds[member.manifold].points, self.carried[member.manifold]);
            let points = &points[..points.len().min(MOST_POINTS)];
            let mut found = [(i64::MAX, Place::NONE); MOST_POINTS];
            for (point, found) in found.iter_mut().enumerate().take(points.len()) {
                let ManifoldPoint { sample, gap, .. } = points[point];
                let (mut same, mut presses) = (Place::NOWHERE, false);
                for (place, Carried { sample: other, forces: [before, after] }) in carried.iter().enumerate()
                {
                    let is_same = (sample.1 == other.1) & (sample.0 == other.0);
                    same = if is_same { place as u8 } else { same };
                    presses |= is_same & ((before.normal > 0.0) | (after.normal > 0.0));
                }
                let nearness = if presses { f64::NEG_INFINITY } else { gap };
                *found = (in_order(nearness), Place { point: point as u8, carried: same });
            }

            // Each behind those that are nearer, or as near and before it: counted without branches, which nobody could foresee.
            for point in 0..points.len() {
                let (nearness, place) = found[point];
                let nearer = |&(other, _): &(i64, Place)| usize::from(other < nearness);
                let as_near = |&(other, _): &(i64, Place)| usize::from(other <= nearness);
                let before: usize = found[..point].iter().map(as_near).sum();
                let behind: usize = found[point + 1..points.len()].iter().map(nearer).sum();
                places[before + behind][lane] = place;
            }
        }
        places
    }

    /// Points of some pairs that go into one row.
    #[inline(always)]
    fn points(&self, (group, places): (&[Member], &[Place; LANES]), dt: f64) -> NewPoints<'_> {
        let mut points = NewPoints::none(dt);
        for (lane, member) in group.iter().enumerate() {
            let Place { point, carried } = places[lane];
            if let Some(point) = self.manifolds[member.manifold].points.get(usize::from(point)) {
                let carried = self.carried[member.manifold].get(usize::from(carried));
                points.add(lane, point, carried.map(|carried| &carried.forces));
            }
        }
        points
    }

    /// Asks for where the points of some pairs are.
    pub(crate) fn prefetch<I: Instructions>(&self, group: &[Member]) {
        for &Member { manifold, .. } in group {
            I::prefetch(&self.manifolds[manifold..][..1]);
            I::prefetch(&self.carried[manifold..][..1]);
        }
    }

    /// Asks for what a batch of some pairs is made of.
    pub(crate) fn prefetch_points<I: Instructions>(
        &self,
        (bodies, movers): (&Bodies, &Movers),
        group: &[Member],
    ) {
        for &Member { manifold, locals, .. } in group {
            let Manifold { pair, points, .. } = self.manifolds[manifold];
            I::prefetch(points);
            I::prefetch(self.carried[manifold]);
            I::prefetch(&bodies.contactants[pair.first..][..1]);
            I::prefetch(&bodies.contactants[pair.second..][..1]);
            movers.prefetch::<I>(&locals);
            movers.prefetch_starts::<I>(&locals);
        }
    }
}

impl<I: Instructions> Anchors<I> {
    fn empty() -> Self {
        Self {
            levers: [Single3::ZERO; 2],
            rounding: [Single::ZERO; 2],
            gap: Single::ZERO,
            reach: Single::ZERO,
            met_at: Single::ZERO,
            is_of_first: Mask::NONE,
            sample: [0; LANES],
        }
    }

    /// Other ones in some lanes.
    #[inline(always)]
    fn put(&mut self, lanes: Mask, levers: [Lanes3<I>; 2], rounding: [Lanes<I>; 2], gap: Lanes<I>) {
        for side in 0..2 {
            self.levers[side] = self.levers[side].but(lanes, levers[side].single());
            self.rounding[side] = self.rounding[side].but(lanes, rounding[side].single());
        }
        self.gap = self.gap.but(lanes, gap.single());
    }

    /// Which samples or features they are, in some lanes.
    #[inline(always)]
    fn name(&mut self, lanes: Mask, is_of_first: Mask, sample: &[u64; LANES]) {
        self.is_of_first = self.is_of_first.and(lanes.not()).or(is_of_first.and(lanes));
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            self.sample[lane] = sample[lane];
        }
    }
}

/// A whole number in the order of [`f64::total_cmp`].
#[inline(always)]
fn in_order(x: f64) -> i64 {
    let bits = x.to_bits() as i64;
    bits ^ ((bits >> 63) as u64 >> 1) as i64
}

/// Whether both of a pair are polyhedra.
fn are_hulls(bodies: &Bodies, pair: Pair) -> bool {
    [pair.first, pair.second].iter().all(|&i| matches!(Solid::of(&bodies.shapes[i]), Solid::Hull(_)))
}

/// Thickness of the thinner one of a pair [m].
fn thinner(bodies: &Bodies, pair: Pair) -> f64 {
    let thickness = |i: usize| {
        let (low, high) = bodies.shapes[i].bounds;
        (high - low).min_element()
    };
    thickness(pair.first).min(thickness(pair.second))
}

/// The smaller of two sizes, of which one may be 0 and infinite.
fn smaller(a: f64, b: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a.min(b) } else { a.max(b) }
}
