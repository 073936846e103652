//! The points of contact as the substeps' solver sees them: one row for each, that acts on the velocities of two bodies.
//!
//! A pair's `Manifold` becomes a `Patch`, each of its points a `Row`; its `Arm` is where it acts at the poses of the present stage.

use crate::detection::{moved_since, radius, second_from_first};
use crate::manifold::{Manifold, ManifoldPoint, find_manifolds};
use crate::pair::{Pair, placed};
use crate::rotation::rotation_by;
use crate::tally::{Cause, Debt};
use crate::warm_start::{PointImpulse, WarmStart, sample_key};
use crate::{Bodies, Frame, Motion, PairContactant, Tally};
use frangible_geometry::RigidTransform;
use glam::{DMat3, DVec3};

/// A point of contact while the substeps run.
pub(crate) struct Row {
    pub(crate) point: ManifoldPoint,
    pub(crate) pair: Pair,
    pub(crate) surfaces: PairContactant,
    /// Where it acts at the present poses.
    pub(crate) arm: Arm,
    /// Part of the stiffness of four points that is its own.
    pub(crate) share: f64,
    /// Of this substep, before and after the drift.
    pub(crate) impulses: [PointImpulse; 2],
    /// Speed at which the surfaces met [m/s]; `None` before.
    pub(crate) met_at: Option<f64>,
    /// Whether it still has to bounce.
    pub(crate) bounces: bool,
    /// Whether it has acted.
    pub(crate) touched: bool,
    /// Energy that it has given to its bodies in this frame, beyond a kinematic body's work [J].
    pub(crate) given: f64,
}

/// The rows of one pair.
pub(crate) struct Patch {
    pub(crate) pair: Pair,
    pub(crate) rows: Vec<Row>,
    /// Energy that rows gave which have been replaced since [J].
    pub(crate) given: f64,
    /// Whether such rows acted.
    pub(crate) touched: bool,
    /// Where one of its rows was last, in the world frame [m].
    point: DVec3,
    /// `second_from_first` when its points were found.
    found_at: RigidTransform,
}

/// Relative motion after which a pair's points are found anew, relative to the size of the smaller body: within it a curved
/// surface's normal turns by no more than some degrees.
const STALE: f64 = 0.1;

impl Patch {
    /// The rows of a manifold, with the impulses that the same points had at the end of the last frame.
    pub(crate) fn new(bodies: &Bodies, manifold: &Manifold, warm: &WarmStart) -> Self {
        let pair = manifold.pair;
        let row = |&point: &ManifoldPoint| {
            let impulses = warm.get(&sample_key(bodies, pair, point.sample)).copied().unwrap_or_default();
            Row::new(bodies, pair, point, impulses)
        };
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let mut rows: Vec<Row> = manifold.points.iter().map(row).collect();
        share_stiffness(&mut rows);
        let point = rows.first().map(|row| row.arm.point).unwrap_or_default();
        Self { pair, rows, given: 0.0, touched: false, point, found_at: second_from_first(first, second) }
    }

    /// Finds the pair's points anew if it has moved too far since they were found; those that are the same go on. `rest` is what is
    /// left of the frame.
    pub(crate) fn refresh(&mut self, bodies: &Bodies, rest: &Frame) {
        let (first, second) = placed(bodies, self.pair, &bodies.poses);
        let size = radius(first.shape).min(radius(second.shape));
        if moved_since(&self.found_at, first, second, 0.0) <= STALE * size {
            return;
        }
        self.found_at = second_from_first(first, second);
        let old = std::mem::take(&mut self.rows);
        let carried =
            |row: &Row| row.touched.then(|| (sample_key(bodies, self.pair, row.point.sample), row.impulses));
        let warm: WarmStart = old.iter().filter_map(carried).collect();
        self.given += old.iter().map(|row| row.given).sum::<f64>();
        self.touched |= old.iter().any(|row| row.touched);
        self.point = old.first().map_or(self.point, |row| row.arm.point);
        for point in
            find_manifolds(bodies, &[self.pair], &warm, rest).into_iter().flat_map(|manifold| manifold.points)
        {
            let same = old.iter().find(|row| row.point.sample == point.sample);
            let impulses = same.map(|row| row.impulses).unwrap_or_default();
            let mut row = Row::new(bodies, self.pair, point, impulses);
            if let Some(same) = same {
                (row.met_at, row.touched) = (same.met_at, same.touched);
            }
            self.rows.push(row);
        }
        share_stiffness(&mut self.rows);
    }

    /// What its rows gave in all, if anything: to be paid back where its first row acts.
    pub(crate) fn debt(&self, bodies: &Bodies) -> Option<Debt> {
        let energy = self.given + self.rows.iter().map(|row| row.given).sum::<f64>();
        let ids = [self.pair.first, self.pair.second].map(|i| bodies.ids[i]);
        let point = self.rows.first().map_or(self.point, |row| row.arm.point);
        (energy > 0.0).then_some(Debt { ids, point, energy })
    }
}

/// However many points a contact has, it is as stiff as with four.
fn share_stiffness(rows: &mut [Row]) {
    let share = (4.0 / rows.len() as f64).min(1.0);
    rows.iter_mut().for_each(|row| row.share = share);
}

/// A body's velocities and how they answer impulses, at the poses of one stage.
#[derive(Clone, Copy)]
pub(crate) struct Moving {
    inverse_mass: f64,
    inverse_tensor: DMat3,
    linear: DVec3,
    angular: DVec3,
    /// What a lever's end does beyond `angular x lever` [1/s]: a kinematic body's points are followed along their chords.
    chord: DMat3,
    /// What gravity has added to the velocity since the state whose energy counts [m/s].
    kick: DVec3,
}

impl Moving {
    /// Velocity of the material at a lever from the centre of mass [m/s].
    fn at(&self, lever: DVec3) -> DVec3 {
        self.linear + self.angular.cross(lever) + self.chord * lever
    }
}

/// What rows act on at one stage of a substep.
pub(crate) struct Solver<'a> {
    pub(crate) bodies: &'a mut Bodies,
    pub(crate) moving: Vec<Moving>,
    pub(crate) tally: &'a mut Tally,
}

/// All bodies as they are, half a kick of gravity into a substep that is about to drift; or at its end, if `drifts` is false.
pub(crate) fn moving_bodies(bodies: &Bodies, step: &Frame, drifts: bool) -> Vec<Moving> {
    let of = |i: usize| {
        let (inertia, pose, velocity) = (&bodies.inertias[i], &bodies.poses[i], &bodies.velocities[i]);
        let inverse_tensor = inertia.inverse_tensor(pose.orientation);
        let mut chord = DMat3::ZERO;
        let (linear, angular) = match bodies.motions[i] {
            Motion::Static => (DVec3::ZERO, DVec3::ZERO),
            Motion::Kinematic { linear, angular } => {
                if drifts {
                    chord = chord_of(angular, step.dt);
                }
                (linear, angular)
            }
            Motion::Dynamic => (velocity.linear, inverse_tensor * velocity.angular_momentum),
        };
        let kick = if drifts && !inertia.is_infinite() { 0.5 * step.dt * step.gravity } else { DVec3::ZERO };
        Moving { inverse_mass: inertia.inverse_mass, inverse_tensor, linear, angular, chord, kick }
    };
    (0..bodies.len()).map(of).collect()
}

/// The mean velocity of a lever's end over `dt` [s] of turning at `angular` [rad/s] is `(angular x + chord) lever` [1/s].
fn chord_of(angular: DVec3, dt: f64) -> DMat3 {
    if angular == DVec3::ZERO {
        return DMat3::ZERO;
    }
    let turned = DMat3::from_quat(rotation_by(dt * angular));
    let of = |axis: DVec3| (turned * axis - axis) / dt - angular.cross(axis);
    DMat3::from_cols(of(DVec3::X), of(DVec3::Y), of(DVec3::Z))
}

/// Where a row acts at the poses of one stage.
#[derive(Clone, Copy)]
pub(crate) struct Arm {
    /// World frame [m]: one point for both bodies, so that angular momentum is exact.
    pub(crate) point: DVec3,
    /// From the centres of mass to it [m].
    levers: [DVec3; 2],
    /// Between the surfaces, along the normal [m].
    pub(crate) gap: f64,
}

impl Arm {
    pub(crate) fn of(point: &ManifoldPoint, pair: Pair, bodies: &Bodies) -> Self {
        let [on_first, on_second] = point.on_surfaces(bodies, pair);
        let gap = (on_first - on_second).dot(point.normal);
        // Between the surfaces, beside the corner that slides along the other body.
        let half = 0.5 * gap * point.normal;
        let middle = if point.sample.0 { on_first - half } else { on_second + half };
        let levers = [pair.first, pair.second].map(|i| middle - bodies.poses[i].position);
        Self { point: middle, levers, gap }
    }
}

impl Row {
    fn new(bodies: &Bodies, pair: Pair, point: ManifoldPoint, mut impulses: [PointImpulse; 2]) -> Self {
        for impulse in &mut impulses {
            impulse.tangent -= impulse.tangent.dot(point.normal) * point.normal;
        }
        let surfaces = bodies.pair_contactant(pair.first, pair.second);
        let arm = Arm::of(&point, pair, bodies);
        Self {
            point,
            pair,
            surfaces,
            arm,
            share: 1.0,
            impulses,
            met_at: None,
            bounces: false,
            touched: false,
            given: 0.0,
        }
    }

    /// Follows the bodies to where they are now.
    pub(crate) fn follow(&mut self, bodies: &Bodies) {
        self.arm = Arm::of(&self.point, self.pair, bodies);
    }

    /// What its normal impulses are booked as.
    pub(crate) fn cause(&self) -> Cause {
        if self.bounces { Cause::Collision } else { Cause::Contact }
    }

    /// Velocity of the first body's material at the arm's point less the second's [m/s].
    pub(crate) fn relative_velocity(&self, moving: &[Moving]) -> DVec3 {
        moving[self.pair.first].at(self.arm.levers[0]) - moving[self.pair.second].at(self.arm.levers[1])
    }

    /// Angular velocity of the first body less the second's [rad/s].
    pub(crate) fn relative_spin(&self, moving: &[Moving]) -> DVec3 {
        moving[self.pair.first].angular - moving[self.pair.second].angular
    }

    /// Change of the relative velocity along a unit axis per impulse along it [1/kg].
    pub(crate) fn answer_along(&self, moving: &[Moving], axis: DVec3) -> f64 {
        let of = |body: &Moving, lever: DVec3| {
            let turn = lever.cross(axis);
            body.inverse_mass + turn.dot(body.inverse_tensor * turn)
        };
        of(&moving[self.pair.first], self.arm.levers[0]) + of(&moving[self.pair.second], self.arm.levers[1])
    }

    /// Change of the relative angular velocity about a unit axis per angular impulse about it [1/(kg m^2)].
    pub(crate) fn answer_about(&self, moving: &[Moving], axis: DVec3) -> f64 {
        let of = |body: &Moving| axis.dot(body.inverse_tensor * axis);
        of(&moving[self.pair.first]) + of(&moving[self.pair.second])
    }

    /// Applies an impulse at the arm's point to the first body and its opposite to the second, and books it.
    pub(crate) fn apply(&mut self, on: &mut Solver, impulse: DVec3, cause: Cause) {
        let Solver { bodies, moving, tally } = on;
        if impulse == DVec3::ZERO {
            return;
        }
        let before = self.relative_velocity(moving);
        for ((body, other, j), lever) in self.sides(impulse).into_iter().zip(self.arm.levers) {
            turn(bodies, &mut moving[body], body, lever.cross(j));
            push(bodies, &mut moving[body], body, j);
            let work = j.dot(moving[other].at(self.arm.point - bodies.poses[other].position));
            tally.book_outside(bodies, [body, other], (j, self.arm.point.cross(j)), work);
        }
        let after = self.relative_velocity(moving);
        // An impulse in the middle of gravity's kick works against what gravity will do, too.
        let kick = moving[self.pair.first].kick - moving[self.pair.second].kick;
        let given = impulse.dot(0.5 * (before + after) - kick);
        self.touched = true;
        self.given += given;
        tally.causes.add(cause, given);
        tally.impulses += 1;
    }

    /// The same for an angular impulse.
    pub(crate) fn twist(&mut self, on: &mut Solver, angular_impulse: DVec3) {
        let Solver { bodies, moving, tally } = on;
        if angular_impulse == DVec3::ZERO {
            return;
        }
        let before = self.relative_spin(moving);
        for (body, other, moment) in self.sides(angular_impulse) {
            turn(bodies, &mut moving[body], body, moment);
            let work = moment.dot(moving[other].angular);
            tally.book_outside(bodies, [body, other], (DVec3::ZERO, moment), work);
        }
        let given = 0.5 * angular_impulse.dot(before + self.relative_spin(moving));
        self.touched = true;
        self.given += given;
        tally.causes.add(Cause::Friction, given);
    }

    /// What acts on each body: on the first, and its opposite on the second.
    fn sides(&self, vector: DVec3) -> [(usize, usize, DVec3); 2] {
        let Pair { first, second } = self.pair;
        [(first, second, vector), (second, first, -vector)]
    }
}

fn push(bodies: &mut Bodies, moving: &mut Moving, i: usize, impulse: DVec3) {
    bodies.velocities[i].linear += moving.inverse_mass * impulse;
    moving.linear += moving.inverse_mass * impulse;
}

fn turn(bodies: &mut Bodies, moving: &mut Moving, i: usize, angular_impulse: DVec3) {
    if !bodies.inertias[i].is_infinite() {
        bodies.velocities[i].angular_momentum += angular_impulse;
        moving.angular += moving.inverse_tensor * angular_impulse;
    }
}
