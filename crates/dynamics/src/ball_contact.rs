//! Where a ball touches another body within a frame: the other's signed distance from its centre says, without samples.

use crate::flight::Flight;
use crate::manifold::{ManifoldPoint, reach};
use crate::pair::Pair;
use crate::{Bodies, Frame, Pose};
use glam::DVec3;

/// Steps along the ball's way through a frame; each goes as far as the distance allows.
const MOST_STEPS: u32 = 32;

/// What counts as touching, relative to the ball's radius.
const TOUCH: f64 = 1e-4;

/// Part of the distance that a step goes: a sampled distance can change a little faster than the way.
const CAUTION: f64 = 0.9;

/// A ball's point of contact with the pair's other body: where they first touch on their ballistic ways through the frame
/// (conservative advancement [Mir96]), or the nearest point at its start if they do not.
pub(crate) fn ball_point(
    bodies: &Bodies,
    pair: Pair,
    ball_is_first: bool,
    radius: f64,
    frame: &Frame,
) -> Option<ManifoldPoint> {
    let (ball, other) = if ball_is_first { (pair.first, pair.second) } else { (pair.second, pair.first) };
    let start = Gap::at(bodies, ball, other, radius, 0.0, frame);
    let reach = reach(bodies, pair, frame);
    if start.phi > reach {
        return None;
    }
    let gap = first_touch(bodies, ball, other, radius, reach, frame).unwrap_or(start);

    // The ball's centre, and the material point of the other that it touches or will touch.
    let on_ball = gap.pose_ball.position - radius * gap.outward;
    let on_other = on_ball - gap.phi * gap.outward;
    let anchor_other = gap.pose_other.world_from_body().inverse().point(on_other);
    let closing = -gap.outward.dot(gap.velocity(bodies, ball, other, on_ball, frame));
    let (normal, anchor_first, anchor_second, rounding) = if ball_is_first {
        (gap.outward, DVec3::ZERO, anchor_other, [radius, 0.0])
    } else {
        (-gap.outward, anchor_other, DVec3::ZERO, [0.0, radius])
    };
    let sample = (ball_is_first, u32::MAX);
    let approach = closing.max(0.0);
    Some(ManifoldPoint { anchor_first, anchor_second, rounding, normal, sample, approach })
}

/// A ball and another body at an instant of the frame, on their ballistic ways.
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

impl Gap {
    fn at(bodies: &Bodies, ball: usize, other: usize, radius: f64, time: f64, frame: &Frame) -> Self {
        let [pose_ball, pose_other] = [ball, other].map(|i| Flight::of(bodies, i, frame).pose(time));
        let center_other = pose_other.world_from_body().inverse().point(pose_ball.position);
        let (distance, gradient) = bodies.shapes[other].distance_and_gradient(center_other);
        let outward = pose_other.orientation * gradient;
        Self { time, pose_ball, pose_other, phi: distance - radius, outward }
    }

    /// Of the ball's material at a point less the other's [m/s].
    fn velocity(&self, bodies: &Bodies, ball: usize, other: usize, point: DVec3, frame: &Frame) -> DVec3 {
        let of = |i: usize| Flight::of(bodies, i, frame).velocity(point, self.time);
        of(ball) - of(other)
    }
}

/// The instant of the first touch within the frame; `None` if they pass or do not get there. `reach` [m] is more than any
/// of their points move relative to each other.
fn first_touch(
    bodies: &Bodies,
    ball: usize,
    other: usize,
    radius: f64,
    reach: f64,
    frame: &Frame,
) -> Option<Gap> {
    let fastest = reach / frame.dt;
    let mut time = 0.0;
    for _ in 0..MOST_STEPS {
        let gap = Gap::at(bodies, ball, other, radius, time, frame);
        if gap.phi <= TOUCH * radius {
            return Some(gap);
        }
        time += CAUTION * gap.phi / fastest;
        if time > frame.dt {
            break;
        }
    }
    None
}
