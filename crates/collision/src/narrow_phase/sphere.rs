//! Contact of a ball with another body within a frame, by the signed distance of the ball's centre;
//! without samples.

use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::pair_motion::{MOST_STEPS, PairMotion};
use frangible_bodies::{BallisticPath, Pose};
use glam::DVec3;

/// Separation of a touch, relative to the ball's radius [1].
const TOUCH: f64 = 1e-4;

/// Fraction of the distance per advancement step: a sampled distance may have a slope above 1.
/// Without it a ball at 6 m/s does not break on a wall, 24 voxels wide both.
const CAUTION: f64 = 0.9;

/// Bisections of a frame for the time of closest approach: the normal is accurate to a thousandth
/// of its rotation in the frame.
const HALVINGS: u32 = 10;

/// A ball and the other body's surface.
pub(crate) struct BallContact<'a> {
    pub(crate) pair_motion: &'a PairMotion<'a>,
    pub(crate) ball_is_first: bool,
    /// [m]
    pub(crate) radius: f64,
    /// The other body, or a part of it.
    pub(crate) other: ConvexShape<'a>,
    /// The ball is the core of a body, whose points touch first and turn it away: it advances by
    /// the largest speed while gravity bends its way. By the speed of the core, contacts in closed
    /// rooms gave 47 times the energy in play to one another in a frame.
    pub(crate) is_core: bool,
}

impl BallContact<'_> {
    /// Contact point of the ball: the first touch in ballistic motion (conservative advancement
    /// [Mir96]), or the closest approach without a touch. Along the normal of closest approach,
    /// passing bodies do not touch.
    pub(crate) fn point(&self) -> Option<ManifoldPoint> {
        let start = self.gap(0.0);
        if start.phi > self.pair_motion.reach {
            return None;
        }
        let gap = self.first_touch(start);

        // The ball's centre, and the material point of the other body at first touch. A second ball
        // has its centre too: its spin changes nothing.
        let (anchor_other, radius_other) = match self.other {
            ConvexShape::Ball(radius) => (DVec3::ZERO, radius),
            _ => {
                let on_ball = gap.pose_ball.position - self.radius * gap.outward;
                let on_other = on_ball - gap.phi * gap.outward;
                (gap.pose_other.world_from_body().inverse().point(on_other), 0.0)
            }
        };
        // Separation along this normal at the frame's start.
        let other_now = start.pose_other.world_from_body().point(anchor_other);
        let apart = (start.pose_ball.position - other_now).dot(gap.outward);
        let now = apart - self.radius - radius_other;
        let closing = -self.parting(&gap);
        let (normal, anchor_first, anchor_second, rounding) = if self.ball_is_first {
            (gap.outward, DVec3::ZERO, anchor_other, [self.radius, radius_other])
        } else {
            (-gap.outward, anchor_other, DVec3::ZERO, [radius_other, self.radius])
        };
        let feature = FeatureId { is_of_first: self.ball_is_first, index: u32::MAX.into() };
        let approach = closing.max(0.0);
        Some(ManifoldPoint {
            anchor_first,
            anchor_second,
            rounding,
            normal,
            feature,
            approach,
            gap: now,
        })
    }

    fn is_convex(&self) -> bool {
        !matches!(self.other, ConvexShape::Other(_) | ConvexShape::Mesh(_))
    }

    fn ball_and_other(&self) -> [&BallisticPath; 2] {
        let [first, second] = self.pair_motion.paths;
        if self.ball_is_first { [first, second] } else { [second, first] }
    }

    /// Both bodies at an instant of the frame.
    fn gap(&self, time: f64) -> Gap {
        let [pose_ball, pose_other] = self.ball_and_other().map(|path| path.pose(time));
        let center_other = pose_other.world_from_body().inverse().point(pose_ball.position);
        let (distance, gradient) = self.other.distance_and_gradient(center_other);
        let outward = pose_other.orientation * gradient;
        Gap { time, pose_ball, pose_other, phi: distance - self.radius, outward }
    }

    /// First touch within the frame after `start`, or the closest approach.
    fn first_touch(&self, start: Gap) -> Gap {
        // A touch that comes after a substep may pass, too.
        let (most_speed, end) = (self.pair_motion.most_speed, self.pair_motion.ahead);
        // A convex body that does not turn is no nearer than its plane at the closest point. A spin
        // of rounding is none.
        let [ball, other] = self.ball_and_other();
        let turns = !matches!(self.other, ConvexShape::Ball(_))
            && other.spin_speed * end > TOUCH * self.radius;
        let acceleration = other.acceleration - ball.acceleration;
        let keeps_plane =
            self.is_convex() && !turns && !(self.is_core && acceleration != DVec3::ZERO);
        let mut gap = start;
        for _ in 0..MOST_STEPS {
            if gap.phi <= TOUCH * self.radius {
                return self.grazing(gap);
            }
            let parting = self.parting(&gap);
            let falling = acceleration.dot(gap.outward) * (end - gap.time);
            let closing =
                if keeps_plane { falling.max(0.0) - parting } else { most_speed / CAUTION };
            let time = gap.time + gap.phi / closing;
            if parting >= 0.0 || time > end {
                return self.nearest(gap, end);
            }
            gap = self.gap(time);
        }
        gap
    }

    /// Closest approach of a ball that touches at `touch`, if it overlaps no deeper than grazing
    /// until the frame's end; else `touch`. Gravity is left out, as of bodies that something
    /// carries.
    fn grazing(&self, touch: Gap) -> Gap {
        let PairMotion { ahead, paths: [first, second], .. } = *self.pair_motion;
        let grazing = self.pair_motion.grazing();
        if !self.is_convex() || touch.phi <= -grazing {
            return touch;
        }
        let (first, second) = (first.straight(), second.straight());
        let pair_motion = &PairMotion { paths: [&first, &second], ..*self.pair_motion };
        let straight = BallContact { pair_motion, ..*self };
        let nearest = straight.nearest(straight.gap(touch.time), ahead);
        if nearest.phi > -grazing { nearest } else { touch }
    }

    /// Closest approach between an instant and `end` [s], by bisection.
    fn nearest(&self, from: Gap, end: f64) -> Gap {
        if self.parting(&from) >= 0.0 {
            return from;
        }
        let (mut before, mut after) = (from, self.gap(end));
        if self.parting(&after) < 0.0 {
            return after;
        }
        for _ in 0..HALVINGS {
            let middle = self.gap(0.5 * (before.time + after.time));
            if self.parting(&middle) < 0.0 { before = middle } else { after = middle }
        }
        // Of a curved surface the instant between both is exact to the square of their distance.
        // Where the ball passes the edge of a face, one of them is on the face: the other's normal
        // is that of a slope, and would let the ball sink or stop it.
        let [start, end] = [&before, &after].map(|gap| self.parting(gap));
        let between = self.gap(before.time - start / (end - start) * (after.time - before.time));
        let slowest = |a: &&Gap, b: &&Gap| self.parting(a).abs().total_cmp(&self.parting(b).abs());
        *[&before, &after, &between].into_iter().min_by(slowest).unwrap_or(&after)
    }

    /// Separating speed [m/s].
    fn parting(&self, gap: &Gap) -> f64 {
        let [ball, other] = self.ball_and_other();
        let on_ball = gap.pose_ball.position - self.radius * gap.outward;
        gap.outward.dot(ball.velocity(on_ball, gap.time) - other.velocity(on_ball, gap.time))
    }
}

/// A ball and another body at an instant of the frame.
#[derive(Clone, Copy)]
struct Gap {
    time: f64,
    pose_ball: Pose,
    pose_other: Pose,
    /// Separation of the surfaces [m].
    phi: f64,
    /// Unit, world frame, from the other body to the ball.
    outward: DVec3,
}
