//! Which points of which pairs are in the lanes of a batch: put there at the frame's start, and found anew when their bodies have moved too
//! far since.

use super::{Anchors, Anew, Batch, Patch, Rest, Softness};
use crate::clusters::Member;
use crate::contact_rows::{Directions, Row};
use crate::detection::{moved_since, second_from_first};
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::lanes::{Instructions, Kept, LANES, Lanes, Lanes3};
use crate::manifold::{Manifold, ManifoldFinder, ManifoldPoint};
use crate::moving::Movers;
use crate::pair::Pair;
use crate::warm_start::{Carried, Part, PointImpulse, WarmStart};
use crate::{Bodies, Frame, Motion};
use glam::{DQuat, DVec3};

/// Natural frequency of soft contact at up to four points [Hz], limited to a quarter of the substeps' rate. More points share its
/// stiffness. At 30 an elevator's stack sinks by more than a millimetre, at 60 stacks sway.
const CONTACT_HERTZ: f64 = 42.0;

/// Damping ratio of soft contact [1]: ten times critical, so that overlaps close without bouncing back [Cat24].
const CONTACT_DAMPING: f64 = 10.0;

/// Relative motion after which a pair's points are found anew, relative to the size of the smaller body: within it a curved
/// surface's normal turns by no more than some degrees.
pub(crate) const STALE: f64 = 0.1;

/// A point that was taken out of a lane.
struct Taken {
    carried: Carried,
    impulses: [PointImpulse; 2],
    met_at: Option<f64>,
    touched: bool,
}

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
            batch.soften(lane, manifold.points.len(), member.stiffness);
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
            starts: Vec::new(),
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
            impacts: false,
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
            size: smaller(movers.size(locals[0]), movers.size(locals[1])),
            stiffness: member.stiffness,
            touched: false,
            anew: None,
        });
    }

    /// However many points a contact has, it is as stiff as with four: soft contact is a spring and a damper that no step size makes
    /// unstable [Cat24].
    fn soften(&mut self, lane: usize, points: usize, stiffness: f64) {
        let share = (4.0 / points as f64).min(1.0);
        let hertz = share.sqrt() * CONTACT_HERTZ;
        let omega = std::f64::consts::TAU * hertz.min(0.25 / self.rest.dt) * stiffness.sqrt();
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
            let impulses = self.impulses_of(at, lane, &self.lines(at));
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

    /// Finds the points of pairs anew that have moved too far since they were found; those that are the same go on. `rest` is what is
    /// left of the frame. Returns whether there were any: their rows have yet to follow.
    pub(crate) fn refresh(
        &mut self,
        (bodies, movers): (&Bodies, &Movers),
        finder: &mut ManifoldFinder,
        rest: &Frame,
    ) -> bool {
        let mut is_changed = false;
        for lane in 0..self.rest.patches.len() {
            let locals = [self.locals[0][lane], self.locals[1][lane]];
            let patch = &self.rest.patches[lane];
            if movers.travel(locals) - patch.travel <= STALE * patch.size {
                continue;
            }
            let pair = patch.pair;
            let flights = [(pair.first, locals[0]), (pair.second, locals[1])].map(|(i, local)| {
                let (pose, velocity) = movers.state(bodies, local);
                Flight::from(bodies, i, (pose, &velocity), rest)
            });
            let encounter = Encounter::new(bodies, pair, [&flights[0], &flights[1]], rest);
            let found_at = match &patch.anew {
                Some(anew) => anew.found_at,
                None => movers.start_second_from_first(locals),
            };
            let [first, second] = encounter.placed();
            if moved_since(&found_at, first, second, 0.0) > STALE * patch.size {
                self.find_anew(lane, movers, finder, &encounter);
                is_changed = true;
            }
            self.rest.patches[lane].travel = movers.travel(locals);
        }
        is_changed
    }

    fn find_anew(
        &mut self,
        lane: usize,
        movers: &Movers,
        finder: &mut ManifoldFinder,
        encounter: &Encounter,
    ) {
        let Encounter { bodies, pair, .. } = *encounter;
        let [first, second] = encounter.placed();
        let point = self.last_point(movers, lane);
        let taken = self.take(lane);
        let patch = &mut self.rest.patches[lane];
        patch.anew = Some(Box::new(Anew { found_at: second_from_first(first, second), point }));
        patch.touched |= taken.iter().any(|taken| taken.touched);

        let mut carried = Part::default();
        let touched = taken.iter().filter(|taken| taken.touched);
        carried.keep(0, bodies, pair, touched.map(|taken| taken.carried));
        let warm = WarmStart::of_parts(1, [carried]);
        let manifold = finder.of_encounter(encounter, &warm);
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
        self.soften(lane, points.len(), self.rest.patches[lane].stiffness);
    }
}

/// The smaller of two sizes, of which one may be 0 and infinite.
fn smaller(a: f64, b: f64) -> f64 {
    if a > 0.0 && b > 0.0 { a.min(b) } else { a.max(b) }
}
