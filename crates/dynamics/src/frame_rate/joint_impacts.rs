//! Impacts of several constraints of a pair along one normal, where all fixed bodies count as one.
//! They are solved together, as the points of one constraint are: one after the other they would
//! spin what falls flat onto a seam.

use super::constraints::{MOST_POINTS, SAME_NORMAL};
use super::contact_batch::ContactBatch;
use super::joint_friction::rub_jointly;
use super::joint_lanes::{FIXED, Member, inverses, partner};
use super::meeting::Meeting;
use super::outline::corners;
use super::solver_bodies::{SPINS, SolverBodies, SolverBody, symmetric};
use super::substep::Substep;
use super::timeline::{BatchLines, Timeline};
use super::touching::{Place, Touching};
use frangible_math::{Instructions, LANES, Mask, Singles};
use glam::{DMat3, DVec2, DVec3, Vec3};

/// Maximum number of Gauss-Seidel sweeps over the points of a joint impact.
const SWEEPS: usize = 200;

/// Change of velocities in a sweep, relative to the fastest approach, at which the sweeps end [1].
const CLOSE: f64 = 1e-6;

/// A point in a joint impact; the first body is the one whose impacts they are.
struct JointPoint {
    /// Index of its member, and its number in the constraint.
    member: usize,
    number: usize,
    /// World frame, from the second body to the first.
    normal: DVec3,
    /// Moments of a unit impulse about both bodies' centres [m].
    moments: [DVec3; 2],
    /// Along the normal, and its target [m/s].
    velocity: f64,
    target: f64,
    /// Time of impact [s].
    time: f64,
    impulse: f64,
}

/// A joint impact of a body with its partner.
pub(super) struct JointImpact {
    lines: [usize; 2],
    members: Vec<Member>,
    points: Vec<JointPoint>,
}

impl JointImpact {
    /// The impact of a lane with all lanes of the same pair and normal that meet within the
    /// substep; `None` if no other does.
    pub(super) fn of_lane<I: Instructions>(
        batches: &[ContactBatch<I>],
        bodies: &mut SolverBodies,
        (timeline, touching): (&Timeline, &Touching),
        (place, meeting): (Place, &Meeting<I>),
        substep: &Substep<I>,
    ) -> Option<Self> {
        let lines = batches[place.batch()].lines_of(place.lane());
        let line = lines.into_iter().find(|&line| bodies.lines[line].is_movable())?;
        let with = partner(batches, bodies, (line, place));
        let mut joint = Self { lines: [line, with], members: Vec::new(), points: Vec::new() };
        joint.take(&batches[place.batch()], place, meeting);
        for &other in touching.lanes(line) {
            let batch = &batches[other.batch()];
            let is_other = other.batch() != place.batch();
            if is_other
                && partner(batches, bodies, (line, other)) == with
                && joint.fits(batch, other)
            {
                let lines = &bodies.lines(batch.first_line..bodies.lines.len());
                let clocks = BatchLines::new(batch).clocks(timeline);
                joint.take(batch, other, &batch.meeting(lines, clocks, substep));
            }
        }
        (joint.members.len() > 1).then_some(joint)
    }

    /// Work of the impact, in visits to batches [1]: each of two points sees the other in each of
    /// some sweeps.
    pub(super) fn work(&self) -> usize {
        self.members.len() + self.points.len() * self.points.len() / 16
    }

    /// Side of the first body in a lane, and the normal that points to it.
    fn seen_in<I: Instructions>(&self, batch: &ContactBatch<I>, lane: usize) -> (usize, DVec3) {
        let is_first = batch.lines_of(lane)[0] == self.lines[0];
        let normal = batch.normal.get(lane);
        if is_first { (0, -normal) } else { (1, normal) }
    }

    /// True if a lane may act, and has the same normal.
    fn fits<I: Instructions>(&self, batch: &ContactBatch<I>, place: Place) -> bool {
        let (_, normal) = self.seen_in(batch, place.lane());
        let is_along = |point: &JointPoint| point.normal.dot(normal) > SAME_NORMAL;
        !batch.unconfirmed.get(place.lane()) && self.points.first().is_some_and(is_along)
    }

    /// Takes the meeting points of a lane.
    fn take<I: Instructions>(&mut self, batch: &ContactBatch<I>, place: Place, of: &Meeting<I>) {
        let lane = place.lane();
        let (side, normal) = self.seen_in(batch, lane);
        let sign = if side == 0 { -1.0 } else { 1.0 };
        let member = self.members.len();
        for number in (0..batch.point_count).filter(|&number| of.meets[number].get(lane)) {
            let arms = &of.arms[number];
            self.points.push(JointPoint {
                member,
                number,
                normal,
                moments: [sign * arms[side].get(lane), sign * arms[1 - side].get(lane)],
                velocity: of.approach[number].get(lane),
                target: of.target[number].get(lane),
                time: of.time[number].get(lane),
                impulse: 0.0,
            });
        }
        if self.points.last().is_some_and(|point| point.member == member) {
            self.members.push(Member { place, side, impulses: [0.0; MOST_POINTS], twist_arm: 0.0 });
        }
    }

    /// Bounces the bodies. Returns the lines whose velocities change, and upper bounds of their
    /// points' changes [m/s].
    pub(super) fn bounce<I: Instructions>(
        mut self,
        batches: &mut [ContactBatch<I>],
        bodies: &mut SolverBodies,
        timeline: &mut Timeline,
        substep: &Substep<I>,
    ) -> Vec<(usize, f32)> {
        let movable: Vec<usize> = self.lines.into_iter().filter(|&line| line != FIXED).collect();
        let before: Vec<SolverBody> = movable.iter().map(|&line| bodies.lines[line]).collect();
        self.keep_corners();
        self.solve(bodies);
        let (mut sum, mut when, mut moment) = (0.0, 0.0, DVec3::ZERO);
        for point in &self.points {
            sum += point.impulse;
            when += point.impulse * point.time;
            moment += point.impulse * point.moments[0];
        }
        let share = if sum > 0.0 { 1.0 / sum } else { 0.0 };
        let when = (share * when) as f32;
        for point in &self.points {
            let member = &mut self.members[point.member];
            member.impulses[point.number] = point.impulse;
            member.twist_arm += point.impulse * (point.moments[0] - share * moment).length();
        }
        for Member { place, impulses, .. } in &self.members {
            let (batch, lane) = (&batches[place.batch()], place.lane());
            if batch.breakable.get(lane) {
                let bodies = batch.lines().map(|lines| bodies.lines[lines[lane]]);
                timeline.impacts.note(batch, lane, bodies, *impulses, when.into());
            }
        }
        for (side, &line) in movable.iter().enumerate() {
            self.push(&mut bodies.lines[line], &bodies.inverse_inertias[line], side);
        }
        rub_jointly(&self.members, (self.lines, self.points[0].normal), batches, bodies);
        for place in self.members.iter().map(|member| member.place) {
            let batch = &mut batches[place.batch()];
            batch.may_bounce = true;
            let mut lane = Mask::NONE;
            lane.set(place.lane(), true);
            BatchLines::new(batch).mark(timeline, lane, [when; LANES]);
        }
        let h = substep.h.to_array()[0];
        let change = |(&line, before): (&usize, &SolverBody)| {
            (line, bodies.lines[line].end_impact(before, when, h))
        };
        movable.iter().zip(&before).map(change).collect()
    }

    /// Leaves out the points between others, whose velocities follow from those: the impulses then
    /// act where they do on a single body, and resist twisting as much.
    fn keep_corners(&mut self) {
        let [along, across] = {
            let normal = self.points[0].normal;
            let along = normal.any_orthonormal_vector();
            [along, normal.cross(along)]
        };
        let flat = |point: &JointPoint| {
            DVec2::new(point.moments[0].dot(along), point.moments[0].dot(across))
        };
        let mut is_corner = corners(&self.points.iter().map(flat).collect::<Vec<_>>()).into_iter();
        self.points.retain(|_| is_corner.next().unwrap_or(true));
    }

    /// Impulses of all points towards their targets, never negative.
    fn solve(&mut self, bodies: &SolverBodies) {
        let inverse = inverses(self.lines, bodies);
        let k = |a: &JointPoint, b: &JointPoint| {
            let of_side = |(side, (mass, inertia)): (usize, &(f64, DMat3))| {
                mass * a.normal.dot(b.normal) + a.moments[side].dot(*inertia * b.moments[side])
            };
            inverse.iter().enumerate().map(of_side).sum::<f64>()
        };
        let points = &mut self.points;
        let matrix: Vec<Vec<f64>> =
            points.iter().map(|a| points.iter().map(|b| k(a, b)).collect()).collect();

        // Equal impulses are a good guess of flat impacts.
        let missing: f64 = points.iter().map(|point| point.target - point.velocity).sum();
        let equal = (missing / matrix.iter().flatten().sum::<f64>()).max(0.0);
        let fastest = points.iter().map(|point| point.velocity.abs()).fold(0.0, f64::max);
        for (point, row) in points.iter_mut().zip(&matrix) {
            point.impulse = equal;
            point.velocity += equal * row.iter().sum::<f64>();
        }
        for _ in 0..SWEEPS {
            let mut largest = 0.0_f64;
            for (i, row) in matrix.iter().enumerate() {
                let point = &mut points[i];
                let change = (point.target - point.velocity) / row[i];
                let change = change.max(-point.impulse);
                point.impulse += change;
                largest = largest.max(change.abs() * row[i]);
                for (other, &k) in points.iter_mut().zip(row) {
                    other.velocity += k * change;
                }
            }
            if largest <= CLOSE * fastest {
                break;
            }
        }
    }

    /// Applies the normal impulses to the body of one side.
    fn push(&self, body: &mut SolverBody, inverse_inertia: &Singles, side: usize) {
        let sign = if side == 0 { 1.0 } else { -1.0 };
        let (mut impulse, mut moment) = (DVec3::ZERO, DVec3::ZERO);
        for point in &self.points {
            impulse += sign * point.impulse * point.normal;
            moment += sign * point.impulse * point.moments[side];
        }
        body.push(impulse, moment, inverse_inertia);
    }
}

impl SolverBody {
    /// Applies an impulse [N s] with its moment about the centre [N m s].
    pub(super) fn push(&mut self, impulse: DVec3, moment: DVec3, inverse_inertia: &Singles) {
        let Singles(v) = &mut self.velocity;
        let linear = f64::from(v[6]) * impulse;
        let angular = symmetric(inverse_inertia) * moment;
        for (k, change) in linear.to_array().into_iter().chain(angular.to_array()).enumerate() {
            v[k] = (f64::from(v[k]) + change) as f32;
        }
    }

    /// Moves the body back to where it would be if it had had its velocity since `time` [s] after
    /// the substep's start, and the one of `before` until then. Returns an upper bound of the change
    /// of its points' velocities [m/s] in a substep of `h` [s].
    pub(super) fn end_impact(&mut self, before: &Self, time: f32, h: f32) -> f32 {
        let part = |body: &Self, k: usize| {
            let Singles(v) = body.velocity;
            Vec3::new(v[k], v[k + 1], v[k + 2])
        };
        let (spin, radius) = (part(self, 3), self.velocity.0[7]);
        let [linear, angular] = [0, 3].map(|k| part(self, k) - part(before, k));
        let turn = (0.5 * time * angular).clamp_length_max(0.5 * SPINS);
        let Singles(d) = &mut self.displacement;
        for k in 0..3 {
            d[k] -= time * linear[k];
            d[k + 3] -= turn[k];
        }
        let turns = angular.length() * radius;
        linear.length() + turns + turns * spin.length() * h
    }
}
