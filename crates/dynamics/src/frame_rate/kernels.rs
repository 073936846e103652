//! Kernels of a substep, per batch: warm starting, one soft sweep before the drift, one rigid sweep
//! after it [Cat24].

use super::constraints::MOST_POINTS;
use super::contact_batch::{ContactBatch, ENTRY};
use super::lane_bodies::{LaneDisplacements, LaneVelocities, displacements, velocities};
use super::sides::{Sides, shortened};
use super::solver_bodies::{Lines, SPINS, SolverBody};
use super::substep::Substep;
use frangible_math::{Instructions, Mask, Single, Single3};

/// Half of the angle [rad] up to which arms keep their direction within a frame: the separation is
/// then off by 1/500,000 of the arm. With 5 times this angle bodies on a turntable slip outward by
/// 17 mm in 10 s, instead of 0.2. From half to 5 times this angle the solver's time for 9,000
/// pieces at rest falls by a quarter.
const HALF_TURN: f32 = 1e-3;

/// Gauss-Seidel sweeps over a manifold's points in a visit, alternately forward and backward; one
/// point needs one sweep. With two, a wall at rest keeps ten times the motion and saves a fifteenth
/// of the time.
const POINT_SWEEPS: u32 = 4;

/// Squared sine below which an arm lies along the axis of rotation, and does not turn [1].
const ALONG_AXIS: f32 = 1e-4;

/// Point velocities and targets of eight manifolds during a visit.
struct Seen<I> {
    /// Moments of a unit impulse about both centres [m].
    arms: [[Single3<I>; 2]; MOST_POINTS],
    /// Velocity along the normal [m/s], and its target.
    velocity: [Single<I>; MOST_POINTS],
    target: [Single<I>; MOST_POINTS],
    /// Scale of the effective mass, and fraction of the impulse to remove [1].
    mass_scale: [Single<I>; MOST_POINTS],
    given_up: [Single<I>; MOST_POINTS],
    /// Lanes with any point below its target velocity.
    acts: Mask,
}

impl<I: Instructions> ContactBatch<I> {
    #[inline(always)]
    pub(super) fn sides(&self, lines: &Lines) -> Sides<I> {
        Sides { of: self.velocities(lines), inertia: self.inverse_inertias(lines) }
    }

    #[inline(always)]
    pub(super) fn store(&self, sides: &Sides<I>, lines: &mut Lines) {
        sides.of[0].store(lines.bodies, &self.ids[0]);
        sides.of[1].store(lines.bodies, &self.ids[1]);
    }

    /// Warm starting: applies the accumulated impulses of the last substep again, except in lanes
    /// with bodies that turn too far.
    #[inline(always)]
    pub(super) fn warm_start(&mut self, lines: &mut Lines, substep: &Substep<I>) {
        if self.is_quiet {
            return;
        }
        let mut sides = self.sides(lines);
        if self.is_turned {
            // Arms of balls are zero, and those of bodies of revolution lie along the axis:
            // rotation leaves them unchanged.
            let mut fastest = Single::ZERO;
            for side in 0..2 {
                let LaneVelocities { angular, radius, .. } = sides.of[side];
                let (turn, mut moved) = (angular.dot(angular), Single::ZERO);
                for point in &self.points[..self.point_count] {
                    let way = angular.cross(point.anchors[side]);
                    moved = moved.max(way.dot(way));
                }
                let moves = moved.above(turn * radius * radius * Single::same(ALONG_AXIS));
                fastest = fastest.max(moves.select(turn, Single::ZERO));
            }
            let fastest = fastest * substep.h * substep.h;
            let spins = fastest.above(Single::same(SPINS * SPINS));
            if spins.any() {
                self.forget(spins);
            }
        }
        let (mut sum, mut anchors) = (Single::ZERO, [Single3::ZERO; 2]);
        for point in &self.points[..self.point_count] {
            sum = sum + point.impulse;
            for side in 0..2 {
                anchors[side] = anchors[side] + point.anchors[side] * point.impulse;
            }
        }
        let n = self.normal;
        let mut centers = self.centers;
        if self.is_turned {
            let at = self.displacements(lines);
            for side in 0..2 {
                anchors[side] = anchors[side] + at[side].turn_of(anchors[side]);
                centers[side] = centers[side] + at[side].turn_of(centers[side]);
            }
        }
        let other = n.cross(self.tangent);
        let mut torque = n * self.twist;
        if let Some(rolling) = &self.rolling {
            torque = torque + self.tangent * rolling.impulse[0] + other * rolling.impulse[1];
        }
        let moments = [anchors[0].cross(n) + torque, anchors[1].cross(n) + torque];
        sides.push(n, sum, moments);
        let friction = self.tangent * self.friction[0] + other * self.friction[1];
        sides.push_at(self.with_offsets(centers), friction);
        self.store(&sides, lines);
    }

    /// Clears the accumulated impulses of some lanes.
    #[inline(always)]
    fn forget(&mut self, lanes: Mask) {
        let zero = Single::ZERO;
        for point in &mut self.points[..self.point_count] {
            point.impulse = lanes.select(zero, point.impulse);
        }
        self.twist = lanes.select(zero, self.twist);
        for k in 0..2 {
            self.friction[k] = lanes.select(zero, self.friction[k]);
            if let Some(rolling) = &mut self.rolling {
                rolling.impulse[k] = lanes.select(zero, rolling.impulse[k]);
            }
        }
    }

    #[inline(always)]
    pub(super) fn with_offsets(&self, centers: [Single3<I>; 2]) -> [Single3<I>; 2] {
        let n = self.normal;
        [centers[0] + n * self.offsets[0], centers[1] + n * self.offsets[1]]
    }

    /// Solves the normal impulses of each manifold's points by Gauss-Seidel; the rigid sweep (after
    /// the drift) also solves friction. Velocities are loaded and stored once.
    #[inline(always)]
    pub(super) fn solve<const SOFT: bool>(&mut self, lines: &mut Lines, substep: &Substep<I>) {
        let (one, zero) = (Single::<I>::same(1.0), Single::<I>::ZERO);
        if self.is_stale && !self.is_quiet {
            self.prepare(lines);
        }
        let n = self.normal;
        let of = self.velocities(lines);
        let at = self.displacements(lines);
        self.is_turned = has_turned(&at);
        let Seen { arms, mut velocity, target, mass_scale, given_up, acts } =
            self.see::<SOFT>(&of, &at, substep);
        if self.is_quiet {
            if !acts.any() {
                return;
            }
            if self.is_stale {
                self.prepare(lines);
            }
        }

        let mut sides = Sides { of, inertia: self.inverse_inertias(lines) };
        let start = velocity;
        let given = self.sweep_points(&mut velocity, &target, &mass_scale, &given_up);
        let (mut sum, mut moments) = (zero, [Single3::ZERO; 2]);
        for i in 0..self.point_count {
            sum = sum + given[i];
            for side in 0..2 {
                moments[side] = moments[side] + arms[i][side] * given[i];
            }
        }

        // K belongs to the poses of the last `prepare`. If the impulses' real work exceeds the
        // expectation from K, scale them down.
        if self.is_turned {
            let mut expected = zero;
            for i in 0..self.point_count {
                expected = expected + given[i] * (velocity[i] - start[i]);
            }
            let scale = shortened(sides.work_of(sum, moments), expected);
            sum = sum * scale;
            moments = [moments[0] * scale, moments[1] * scale];
            for i in 0..self.point_count {
                let impulse = &mut self.points[i].impulse;
                *impulse = *impulse - given[i] * (one - scale);
            }
        }
        let (mut total, mut twist_arm) = (zero, zero);
        for point in &self.points[..self.point_count] {
            total = total + point.impulse;
            twist_arm = twist_arm + point.impulse * point.radius;
        }
        let carries = total.above(zero);
        self.acted = self.acted.or(carries);
        self.is_quiet = false;
        sides.push(n, sum, moments);
        if !SOFT {
            self.solve_friction(&mut sides, &at, total, twist_arm);
            let rubs = self.friction.map(|impulse| (impulse * impulse).above(zero));
            self.is_quiet = !carries.or(rubs[0]).or(rubs[1]).any();
            self.frame_impulse[0] = self.frame_impulse[0] + total;
            self.frame_impulse[1] = self.frame_impulse[1] + self.friction[0];
            self.frame_impulse[2] = self.frame_impulse[2] + self.friction[1];
        }
        self.store(&sides, lines);
        if !SOFT && self.has_driven() {
            let impulses = self.points.map(|point| point.impulse);
            self.note_driven_work(lines, impulses, self.friction, self.twist);
        }
    }

    /// Marks the speculative lanes that would act in this substep.
    #[inline(always)]
    pub(super) fn ask(&mut self, lines: &[SolverBody], substep: &Substep<I>) {
        if self.unconfirmed.any() {
            let of = [velocities(lines, &self.ids[0]), velocities(lines, &self.ids[1])];
            let at = [displacements(lines, &self.ids[0]), displacements(lines, &self.ids[1])];
            self.is_turned = has_turned(&at);
            self.see::<true>(&of, &at, substep);
        }
    }

    /// Computes point velocities and their targets.
    #[inline(always)]
    fn see<const SOFT: bool>(
        &mut self,
        of: &[LaneVelocities<I>; 2],
        at: &[LaneDisplacements<I>; 2],
        substep: &Substep<I>,
    ) -> Seen<I> {
        let (one, zero) = (Single::<I>::same(1.0), Single::<I>::ZERO);
        let n = self.normal;
        let linear = n.dot(of[1].linear - of[0].linear);
        let apart = n.dot(at[1].translation - at[0].translation);
        let mut arms = [[Single3::ZERO; 2]; MOST_POINTS];
        let (mut velocity, mut target) = ([zero; MOST_POINTS], [zero; MOST_POINTS]);
        let (mut mass_scale, mut given_up) = ([one; MOST_POINTS], [zero; MOST_POINTS]);
        let (mut comes, mut acts) = (Mask::NONE, Mask::NONE);
        for i in 0..self.point_count {
            let (turned, separation) = self.follow(i, at, apart);
            arms[i] = turned;
            velocity[i] = linear + turned[1].dot(of[1].angular) - turned[0].dot(of[0].angular);
            let is_open = separation.above(zero);
            let closing = separation * substep.per_second;
            if SOFT {
                let (depth, point) = (-separation, &self.points[i]);
                let carries = substep.soft.yielding * self.k[ENTRY[i][i]] * point.impulse;
                let recovers = (substep.recovery_rate * depth).min(substep.recovery_speed);
                let pushes = (substep.soft.rate * depth).min(carries + recovers);
                target[i] = is_open.select(-closing, pushes);
                mass_scale[i] = is_open.select(one, substep.soft.mass);
                given_up[i] = is_open.select(zero, substep.soft.impulse);
            } else {
                // Keep an approach that will bounce in the next substep.
                let bounce = substep.bounce_velocity;
                let passes = bounce.above(velocity[i]).and(self.bounces);
                let twice = velocity[i] + velocity[i];
                let may_meet = zero.above(separation + twice * substep.h);
                comes = comes.or(bounce.above(twice).and(may_meet).and(self.bounces));
                target[i] = passes.select(velocity[i], is_open.select(-closing, zero));
                let recovered = self.points[i].impulse * velocity[i];
                self.recovery = self.recovery + is_open.select(zero, recovered);
            }
            acts = acts.or(target[i].above(velocity[i]));
        }
        if self.unconfirmed.any() {
            let waits = self.unconfirmed;
            for i in 0..self.point_count {
                target[i] = waits.select(velocity[i], target[i]);
            }
            self.asks = self.asks.or(acts.and(waits).and(self.passes.not()));
            acts = acts.and(waits.not());
        }
        if !SOFT {
            self.may_bounce = comes.any();
        }
        Seen { arms, velocity, target, mass_scale, given_up, acts }
    }

    /// Number of sweeps; see [`POINT_SWEEPS`].
    #[inline(always)]
    pub(super) fn point_sweeps(&self) -> u32 {
        if self.point_count > 1 { POINT_SWEEPS } else { 1 }
    }

    /// Gauss-Seidel over the points, alternately forward and backward for symmetry. Returns the
    /// change of each impulse.
    #[inline(always)]
    fn sweep_points(
        &mut self,
        velocity: &mut [Single<I>; MOST_POINTS],
        target: &[Single<I>; MOST_POINTS],
        mass_scale: &[Single<I>; MOST_POINTS],
        given_up: &[Single<I>; MOST_POINTS],
    ) -> [Single<I>; MOST_POINTS] {
        let mut given = [Single::ZERO; MOST_POINTS];
        for turn in 0..self.point_sweeps() {
            for at in 0..self.point_count {
                let i = if turn % 2 == 0 { at } else { self.point_count - 1 - at };
                let point = &mut self.points[i];
                let change = point.effective_mass * mass_scale[i] * (velocity[i] - target[i]);
                let impulse =
                    (point.impulse - change - given_up[i] * point.impulse).max(Single::ZERO);
                let added = impulse - point.impulse;
                given[i] = given[i] + added;
                point.impulse = impulse;
                for j in 0..self.point_count {
                    velocity[j] = velocity[j] + self.k[ENTRY[i][j]] * added;
                }
            }
        }
        given
    }

    /// Moments of a unit impulse at a point about both centres, and the point's separation [m].
    #[inline(always)]
    fn follow(
        &self,
        i: usize,
        at: &[LaneDisplacements<I>; 2],
        apart: Single<I>,
    ) -> ([Single3<I>; 2], Single<I>) {
        let (n, point) = (self.normal, &self.points[i]);
        let mut separation = point.separation + apart;
        let mut anchors = point.anchors;
        if self.is_turned {
            let turns = [at[0].turn_of(anchors[0]), at[1].turn_of(anchors[1])];
            separation = separation + n.dot(turns[1] - turns[0]);
            anchors = [anchors[0] + turns[0], anchors[1] + turns[1]];
            ([anchors[0].cross(n), anchors[1].cross(n)], separation)
        } else {
            let arms = [anchors[0].cross(n), anchors[1].cross(n)];
            let half = arms[1].dot(at[1].vector) - arms[0].dot(at[0].vector);
            (arms, separation + half + half)
        }
    }

    /// Adds the work of kinematic bodies by the impulses of a substep or an impact.
    #[inline(always)]
    pub(super) fn note_driven_work(
        &mut self,
        lines: &Lines,
        impulses: [Single<I>; MOST_POINTS],
        friction: [Single<I>; 2],
        twist: Single<I>,
    ) {
        let n = self.normal;
        let of = self.velocities(lines);
        let at = self.displacements(lines);
        let centers = self.turned_centers(&at);
        let across = self.tangent * friction[0] + n.cross(self.tangent) * friction[1];
        for side in 0..2 {
            let LaneVelocities { linear, angular, .. } = of[side];
            let mut work = twist * n.dot(angular);
            for i in 0..self.point_count {
                let anchor = self.points[i].anchors[side];
                let arm = (anchor + at[side].turn_of(anchor)).cross(n);
                work = work + impulses[i] * (n.dot(linear) + arm.dot(angular));
            }
            work = work + across.dot(linear + angular.cross(centers[side]));
            let given = if side == 0 { work } else { -work };
            let given = self.is_driven[side].select(given, Single::ZERO);
            self.driven_work = self.driven_work + given;
        }
    }

    /// True if any lane has a kinematic body.
    pub(super) fn has_driven(&self) -> bool {
        self.is_driven[0].or(self.is_driven[1]).any()
    }
}

/// True if any body has turned beyond [`HALF_TURN`].
#[inline(always)]
fn has_turned<I: Instructions>(at: &[LaneDisplacements<I>; 2]) -> bool {
    let squared = at[0].vector.dot(at[0].vector).max(at[1].vector.dot(at[1].vector));
    squared.above(Single::same(HALF_TURN * HALF_TURN)).any()
}
