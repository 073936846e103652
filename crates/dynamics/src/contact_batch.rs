//! The points of contact as the substeps' solver sees them: several pairs side by side, one in each lane. No body that can move is in
//! two of them, so they act at the same time.

use crate::clusters::Member;
use crate::contact_rows::{Row, Stage};
use crate::detection::{moved_since, radius, second_from_first};
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask};
use crate::manifold::{Manifold, ManifoldFinder, ManifoldPoint};
use crate::moving::{Movers, Side, drive};
use crate::pair::{Pair, placed};
use crate::tally::Debt;
use crate::warm_start::{Carried, PointImpulse, WarmStart};
use crate::{Bodies, Frame, Motion};
use frangible_geometry::RigidTransform;
use glam::{DQuat, DVec3};

/// Where the points of a row are on their bodies: see [`ManifoldPoint`].
#[derive(Clone)]
struct Anchors<I> {
    on: [Lanes3<I>; 2],
    rounding: [Lanes<I>; 2],
    /// Whose sample or feature each is, and which.
    sample: [(bool, u64); LANES],
}

/// How a contact's normal impulses answer [Cat24].
#[derive(Clone, Copy)]
pub(crate) struct Softness<I> {
    /// Closing speed of an overlap per depth [1/s].
    pub(crate) rate: Lanes<I>,
    /// Of what a rigid point would add to its impulse [1].
    pub(crate) mass_scale: Lanes<I>,
    /// Of the impulse so far, that it takes back [1].
    pub(crate) impulse_scale: Lanes<I>,
}

/// Several pairs.
pub(crate) struct Batch<I> {
    /// Their bodies, by their place in the cluster.
    pub(crate) locals: [[u32; LANES]; 2],
    pub(crate) rows: Vec<Row<I>>,
    pub(crate) soft: Softness<I>,
    pub(crate) friction: Lanes<I>,
    pub(crate) restitution: Lanes<I>,
    /// Of rolling and of spinning friction [m].
    pub(crate) roll_lengths: [Lanes<I>; 2],
    /// Whether any of these is not zero.
    pub(crate) rolls: bool,
    /// What kinematic bodies add to the spin of the first bodies less that of the second ones [rad/s].
    pub(crate) spin: Lanes3<I>,
    /// Energy that they have given to their bodies in this frame, beyond a kinematic body's work [J].
    pub(crate) given: Lanes<I>,
    /// Whether a static or kinematic body is among them, and whether one moves.
    pub(crate) has_outside: bool,
    /// See `has_outside`.
    pub(crate) is_driven: bool,
    /// Whether any point has to bounce.
    pub(crate) bounces: bool,
    /// Sums of the impulses on the first bodies in a stage, and of their moments about those bodies' centres of mass.
    pub(crate) acted: [Lanes3<I>; 2],
    /// Of a substep [s].
    dt: f64,
    anchors: Vec<Anchors<I>>,
    /// One for each lane that is used.
    pub(crate) patches: Vec<Patch>,
}

/// What is known of one pair.
pub(crate) struct Patch {
    pub(crate) pair: Pair,
    /// `second_from_first` when its points were found, and the bodies' travel then [m].
    found_at: RigidTransform,
    travel: f64,
    /// Of the smaller body [m].
    size: f64,
    /// Whether points acted that have been replaced since.
    touched: bool,
    /// Where one of its points was last, in the world frame [m].
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

impl<I: Instructions> Batch<I> {
    /// Of the contacts of at most [`LANES`] pairs, with the impulses that the same points had at the end of the last frame.
    pub(crate) fn new(
        bodies: &Bodies,
        movers: &Movers,
        group: &[Member],
        manifolds: &[Manifold],
        (warm, step): (&WarmStart, &Frame),
    ) -> Self {
        let mut locals = [[movers.nobody(); LANES]; 2];
        let mut batch = Self::empty(step.dt);
        for (lane, member) in group.iter().enumerate() {
            let manifold = &manifolds[member.manifold];
            let pair = manifold.pair;
            let (first, second) = placed(bodies, pair, &bodies.poses);
            [locals[0][lane], locals[1][lane]] = member.locals;
            let surfaces = bodies.pair_contactant(pair.first, pair.second);
            batch.friction.set(lane, surfaces.friction);
            batch.restitution.set(lane, surfaces.restitution);
            batch.roll_lengths[0].set(lane, surfaces.rolling_friction);
            batch.roll_lengths[1].set(lane, surfaces.spinning_friction);
            batch.rolls |= surfaces.rolling_friction > 0.0 || surfaces.spinning_friction > 0.0;
            let [motion, other] = [pair.first, pair.second].map(|i| bodies.motions[i]);
            batch.has_outside |= motion != Motion::Dynamic || other != Motion::Dynamic;
            let spin = |motion: Motion| match motion {
                Motion::Kinematic { angular, .. } => angular,
                Motion::Static | Motion::Dynamic => DVec3::ZERO,
            };
            batch.spin.set(lane, spin(motion) - spin(other));
            batch.is_driven |=
                [motion, other].iter().any(|motion| matches!(motion, Motion::Kinematic { .. }));
            batch.patches.push(Patch {
                pair,
                found_at: second_from_first(first, second),
                travel: 0.0,
                size: radius(first.shape).min(radius(second.shape)),
                touched: false,
                point: manifold.points.first().map_or(DVec3::ZERO, |point| point.middle(bodies, pair)),
            });
            let carried = warm.of_pair(bodies, pair);
            for (number, point) in manifold.points.iter().enumerate() {
                let same = carried.iter().find(|carried| carried.sample == point.sample);
                batch.place(lane, number, point, same.map(|same| same.impulses).unwrap_or_default());
            }
            batch.soften(lane, manifold.points.len());
        }
        batch.locals = locals;
        batch
    }

    /// However many points a contact has, it is as stiff as with four: soft contact is a spring and a damper that no step size makes
    /// unstable [Cat24].
    fn soften(&mut self, lane: usize, points: usize) {
        let share = (4.0 / points as f64).min(1.0);
        let hertz = share.sqrt() * CONTACT_HERTZ;
        let omega = std::f64::consts::TAU * hertz.min(0.25 / self.dt);
        let a = 2.0 * CONTACT_DAMPING + self.dt * omega;
        let b = self.dt * omega * a;
        self.soft.rate.set(lane, omega / a);
        self.soft.mass_scale.set(lane, b / (1.0 + b));
        self.soft.impulse_scale.set(lane, 1.0 / (1.0 + b));
    }

    fn empty(dt: f64) -> Self {
        Self {
            dt,
            locals: [[0; LANES]; 2],
            rows: Vec::new(),
            soft: Softness { rate: Lanes::ZERO, mass_scale: Lanes::ZERO, impulse_scale: Lanes::ZERO },
            friction: Lanes::ZERO,
            restitution: Lanes::ZERO,
            roll_lengths: [Lanes::ZERO; 2],
            rolls: false,
            spin: Lanes3::ZERO,
            given: Lanes::ZERO,
            bounces: false,
            acted: [Lanes3::ZERO; 2],
            has_outside: false,
            is_driven: false,
            anchors: Vec::new(),
            patches: Vec::with_capacity(LANES),
        }
    }

    /// Puts a point into a lane.
    fn place(&mut self, lane: usize, number: usize, point: &ManifoldPoint, impulses: [PointImpulse; 2]) {
        if number == self.rows.len() {
            self.rows.push(Row::empty());
            self.anchors.push(Anchors::empty());
        }
        let (row, anchors) = (&mut self.rows[number], &mut self.anchors[number]);
        anchors.on[0].set(lane, point.anchor_first);
        anchors.on[1].set(lane, point.anchor_second);
        for side in 0..2 {
            anchors.rounding[side].set(lane, point.rounding[side]);
        }
        anchors.sample[lane] = point.sample;
        row.is_there.set(lane, true);
        row.normal.set(lane, point.normal);
        for (of_row, of_point) in row.impulses.iter_mut().zip(impulses) {
            let PointImpulse { normal, tangent, twist } = of_point;
            of_row.normal.set(lane, normal);
            of_row.tangent.set(lane, tangent - tangent.dot(point.normal) * point.normal);
            of_row.twist.set(lane, twist);
        }
    }

    /// Empties a lane; what it held.
    fn take(&mut self, lane: usize) -> Vec<Taken> {
        let mut taken = Vec::new();
        for (row, anchors) in self.rows.iter_mut().zip(&self.anchors) {
            if !row.is_there.get(lane) {
                continue;
            }
            let carried = Carried { sample: anchors.sample[lane], impulses: row.impulses_of(lane) };
            let met_at = row.has_met.get(lane).then_some(row.met_at.get(lane));
            taken.push(Taken { carried, met_at, touched: row.touched.get(lane) });
            row.clear(lane);
        }
        taken
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
        for lane in 0..self.patches.len() {
            let pair = [self.locals[0][lane], self.locals[1][lane]];
            let patch = &self.patches[lane];
            let may_be_stale = movers.travel(pair) - patch.travel > STALE * patch.size;
            if may_be_stale {
                let (first, second) = placed(bodies, patch.pair, &bodies.poses);
                if moved_since(&patch.found_at, first, second, 0.0) > STALE * patch.size {
                    pair.into_iter().for_each(|local| movers.hand_back_one(bodies, local));
                    self.find_anew(lane, bodies, finder, rest);
                    is_changed = true;
                }
                self.patches[lane].travel = movers.travel(pair);
            }
        }
        is_changed
    }

    fn find_anew(&mut self, lane: usize, bodies: &Bodies, finder: &mut ManifoldFinder, rest: &Frame) {
        let pair = self.patches[lane].pair;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let point = self.point(bodies, lane);
        let taken = self.take(lane);
        let patch = &mut self.patches[lane];
        patch.found_at = second_from_first(first, second);
        patch.touched |= taken.iter().any(|taken| taken.touched);
        patch.point = point;

        let mut warm = WarmStart::default();
        warm.keep(bodies, pair, taken.iter().filter(|taken| taken.touched).map(|taken| taken.carried));
        let manifold = finder.find(bodies, pair, &warm, rest);
        let points = manifold.map(|manifold| manifold.points).unwrap_or_default();
        for (number, point) in points.iter().enumerate() {
            let same = taken.iter().find(|taken| taken.carried.sample == point.sample);
            self.place(lane, number, point, same.map(|same| same.carried.impulses).unwrap_or_default());
            if let Some(same) = same {
                let row = &mut self.rows[number];
                row.has_met.set(lane, same.met_at.is_some());
                row.met_at.set(lane, same.met_at.unwrap_or(0.0));
                row.touched.set(lane, same.touched);
            }
        }
        self.soften(lane, points.len());
    }

    /// Follows the bodies to where they are now. After a drift, in a substep of `drifted` [s], what has parted is forgotten.
    #[inline(always)]
    pub(crate) fn follow(&mut self, bodies: &Bodies, movers: &Movers, drifted: Option<f64>) {
        let poses = |second: bool| {
            let of = |lane: usize| {
                let pair = self.patches.get(lane).map(|patch| patch.pair);
                pair.map(|pair| &bodies.poses[if second { pair.second } else { pair.first }])
            };
            let position = Lanes3::of(|lane| of(lane).map_or(DVec3::ZERO, |pose| pose.position));
            let turn = |lane: usize| of(lane).map_or(DQuat::IDENTITY, |pose| pose.orientation);
            let axis = Lanes3::of(|lane| turn(lane).xyz());
            (position, axis, Lanes::of(|lane| turn(lane).w))
        };
        let (first, second) = (poses(false), poses(true));
        let sides = self.sides(movers);
        for (row, anchors) in self.rows.iter_mut().zip(&self.anchors) {
            let on_first = placed_at(first, anchors.on[0]) - row.normal * anchors.rounding[0];
            let on_second = placed_at(second, anchors.on[1]) + row.normal * anchors.rounding[1];
            row.gap = (on_first - on_second).dot(row.normal);
            // Between the surfaces, beside the corner that slides along the other body.
            let half = row.normal * (Lanes::splat(0.5) * row.gap);
            let is_of_first = Mask::of(|lane| anchors.sample[lane].0);
            let middle = is_of_first.select3(on_first - half, on_second + half);
            row.levers = [middle - first.0, middle - second.0];
            row.answer =
                sides[0].answer(row.levers[0], row.normal) + sides[1].answer(row.levers[1], row.normal);
            row.mass = row.is_there.select(Lanes::splat(1.0) / row.answer, Lanes::ZERO);
            if let Some(dt) = drifted
                && !self.is_driven
            {
                row.forget_if_parted(Stage::AfterDrift, &sides, dt);
            }
        }
    }

    /// What kinematic bodies do at the points, now or in the mean over `chord` [s]: their points are followed along their chords.
    pub(crate) fn be_driven(&mut self, bodies: &Bodies, chord: Option<f64>) {
        if !self.is_driven {
            return;
        }
        for (lane, patch) in self.patches.iter().enumerate() {
            let motions = [patch.pair.first, patch.pair.second].map(|i| &bodies.motions[i]);
            for row in &mut self.rows {
                let of = |side: usize| drive(motions[side], row.levers[side].get(lane), chord);
                row.drive.set(lane, of(0) - of(1));
            }
        }
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

    /// Where the first point of a pair is, in the world frame [m]; where one was, if it has none.
    fn point(&self, bodies: &Bodies, lane: usize) -> DVec3 {
        let patch = &self.patches[lane];
        match self.rows.first() {
            Some(row) if row.is_there.get(lane) => {
                row.levers[0].get(lane) + bodies.poses[patch.pair.first].position
            }
            _ => patch.point,
        }
    }

    /// What each pair gave in all, if anything: to be paid back where its first point acts.
    pub(crate) fn debt(&self, bodies: &Bodies, lane: usize) -> Option<Debt> {
        let patch = &self.patches[lane];
        let ids = [patch.pair.first, patch.pair.second].map(|i| bodies.ids[i]);
        let energy = self.given.get(lane);
        (energy > 0.0).then(|| Debt { ids, point: self.point(bodies, lane), energy })
    }

    /// Whether a pair has exchanged impulses in this frame.
    pub(crate) fn touched(&self, lane: usize) -> bool {
        self.patches[lane].touched || self.rows.iter().any(|row| row.touched.get(lane))
    }

    /// The points of a pair that acted, and what acts there.
    pub(crate) fn carried(&self, lane: usize) -> impl Iterator<Item = Carried> {
        self.rows
            .iter()
            .zip(&self.anchors)
            .filter(move |(row, _)| row.is_there.get(lane) && row.touched.get(lane))
            .map(move |(row, anchors)| Carried {
                sample: anchors.sample[lane],
                impulses: row.impulses_of(lane),
            })
    }
}

/// A point that was taken out of a lane.
struct Taken {
    carried: Carried,
    met_at: Option<f64>,
    touched: bool,
}

impl<I: Instructions> Anchors<I> {
    fn empty() -> Self {
        Self { on: [Lanes3::ZERO; 2], rounding: [Lanes::ZERO; 2], sample: [(false, 0); LANES] }
    }
}

/// A point of a body, of which position and orientation are given, in the world.
#[inline(always)]
fn placed_at<I: Instructions>(
    (position, axis, w): (Lanes3<I>, Lanes3<I>, Lanes<I>),
    point: Lanes3<I>,
) -> Lanes3<I> {
    let twice = axis.cross(point) * Lanes::splat(2.0);
    position + point + twice * w + axis.cross(twice)
}
