//! Bodies on their ways through a frame, without contact.

use crate::rotation::rotation_by;
use crate::{Bodies, Frame, Motion, Pose};
use glam::DVec3;

/// A body's way from the frame's start: ballistic, its spin taken as constant.
#[derive(Clone, Copy)]
pub(crate) struct Flight {
    start: Pose,
    /// Of the centre of mass, at the start [m/s].
    pub(crate) linear: DVec3,
    /// [rad/s]
    pub(crate) angular: DVec3,
    /// [m/s^2]
    pub(crate) acceleration: DVec3,
}

impl Flight {
    pub(crate) fn of(bodies: &Bodies, i: usize, frame: &Frame) -> Self {
        let (start, velocity) = (bodies.poses[i], &bodies.velocities[i]);
        let (linear, angular, acceleration) = match bodies.motions[i] {
            Motion::Static => (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO),
            Motion::Kinematic { linear, angular } => (linear, angular, DVec3::ZERO),
            Motion::Dynamic => {
                let angular =
                    bodies.inertias[i].angular_velocity(start.orientation, velocity.angular_momentum);
                (velocity.linear, angular, frame.gravity)
            }
        };
        Self { start, linear, angular, acceleration }
    }

    /// Where the body is after `time` [s].
    pub(crate) fn pose(&self, time: f64) -> Pose {
        if time == 0.0 {
            return self.start;
        }
        Pose {
            position: self.start.position + time * (self.linear + 0.5 * time * self.acceleration),
            orientation: (rotation_by(time * self.angular) * self.start.orientation).normalize(),
        }
    }

    /// Velocity of its material at a point of the world [m/s] after `time` [s].
    pub(crate) fn velocity(&self, point: DVec3, time: f64) -> DVec3 {
        let lever = point - self.pose(time).position;
        self.linear + time * self.acceleration + self.angular.cross(lever)
    }
}
