//! Where a ball touches another body within a frame: the other's signed distance from its centre says, without samples.

use crate::Pose;
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::manifold::ManifoldPoint;
use glam::DVec3;

/// Steps along the ball's way through a frame; each goes as far as the distance allows.
const MOST_STEPS: u32 = 32;

/// What counts as touching, relative to the ball's radius.
const TOUCH: f64 = 1e-4;

/// Part of the distance that a step goes: a sampled distance can change a little faster than the way.
const CAUTION: f64 = 0.9;

/// A ball and what it may touch.
pub(crate) struct BallContact<'a> {
    pub(crate) encounter: &'a Encounter<'a>,
    pub(crate) ball_is_first: bool,
    /// [m]
    pub(crate) radius: f64,
    /// Of the other body, or of a part of it: signed distance [m] and unit gradient, in the body frame.
    pub(crate) surface: &'a dyn Fn(DVec3) -> (f64, DVec3),
}

impl BallContact<'_> {
    /// The ball's point of contact: where the two first touch on their ballistic ways through the frame (conservative advancement
    /// [Mir96]), or the nearest point at its start if they do not.
    pub(crate) fn point(&self) -> Option<ManifoldPoint> {
        let [ball, other] = self.ball_and_other();
        let start = self.gap(0.0);
        if start.phi > self.encounter.reach {
            return None;
        }
        let now = start.phi;
        let gap = self.first_touch(start).unwrap_or(start);

        // The ball's centre, and the material point of the other that it touches or will touch.
        let on_ball = gap.pose_ball.position - self.radius * gap.outward;
        let on_other = on_ball - gap.phi * gap.outward;
        let anchor_other = gap.pose_other.world_from_body().inverse().point(on_other);
        let velocity = |flight: &Flight| flight.velocity(on_ball, gap.time);
        let closing = -gap.outward.dot(velocity(ball) - velocity(other));
        let (normal, anchor_first, anchor_second, rounding) = if self.ball_is_first {
            (gap.outward, DVec3::ZERO, anchor_other, [self.radius, 0.0])
        } else {
            (-gap.outward, anchor_other, DVec3::ZERO, [0.0, self.radius])
        };
        let sample = (self.ball_is_first, u32::MAX.into());
        let approach = closing.max(0.0);
        Some(ManifoldPoint { anchor_first, anchor_second, rounding, normal, sample, approach, gap: now })
    }

    fn ball_and_other(&self) -> [&Flight; 2] {
        let [first, second] = self.encounter.flights;
        if self.ball_is_first { [first, second] } else { [second, first] }
    }

    /// The two at an instant of the frame, on their ballistic ways.
    fn gap(&self, time: f64) -> Gap {
        let [pose_ball, pose_other] = self.ball_and_other().map(|flight| flight.pose(time));
        let center_other = pose_other.world_from_body().inverse().point(pose_ball.position);
        let (distance, gradient) = (self.surface)(center_other);
        let outward = pose_other.orientation * gradient;
        Gap { time, pose_ball, pose_other, phi: distance - self.radius, outward }
    }

    /// The instant of the first touch within the frame, after `start`; `None` if they pass or do not get there.
    fn first_touch(&self, start: Gap) -> Option<Gap> {
        let (most_speed, dt) = (self.encounter.most_speed, self.encounter.frame.dt);
        let mut gap = start;
        for _ in 0..MOST_STEPS {
            if gap.phi <= TOUCH * self.radius {
                return Some(gap);
            }
            let time = gap.time + CAUTION * gap.phi / most_speed;
            if time > dt {
                break;
            }
            gap = self.gap(time);
        }
        None
    }
}

/// A ball and another body at an instant of the frame.
#[derive(Clone, Copy)]
struct Gap {
    time: f64,
    pose_ball: Pose,
    pose_other: Pose,
    /// Between the surfaces [m].
    phi: f64,
    /// Unit, world frame, from the other body to the ball.
    outward: DVec3,
}
