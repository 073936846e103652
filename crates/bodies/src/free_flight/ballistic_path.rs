//! Bodies on their ways through a frame, without contact.

use crate::bodies::{Bodies, Motion};
use crate::frame::Frame;
use crate::free_flight::rotation::rotation_by;
use crate::pair::Pair;
use crate::state::{Pose, Velocity};
use glam::DVec3;

/// A body's way from the frame's start: ballistic, its spin taken as constant.
#[derive(Clone, Copy)]
pub struct BallisticPath {
    /// At the frame's start.
    pub start: Pose,
    /// Of the centre of mass, at the start [m/s].
    pub linear: DVec3,
    /// [rad/s]
    pub angular: DVec3,
    /// [m/s^2]
    pub acceleration: DVec3,
    /// Of a ball around the centre of mass that holds the body [m]; infinite for a half-space.
    pub radius: f64,
    /// No part of the surface turns faster [m/s]; spin of a body of revolution about its axis moves
    /// none.
    pub spin_speed: f64,
}

impl BallisticPath {
    /// Of both bodies of a pair.
    #[inline]
    pub fn of_pair(bodies: &Bodies, pair: Pair, frame: &Frame) -> [Self; 2] {
        [pair.first, pair.second].map(|i| Self::of(bodies, i, frame))
    }

    /// Path of a body from its present state.
    #[inline]
    pub fn of(bodies: &Bodies, i: usize, frame: &Frame) -> Self {
        Self::from(bodies, i, (bodies.poses[i], &bodies.velocities[i]), frame)
    }

    /// Path of a body from another pose and velocity than in `bodies`.
    #[inline]
    pub fn from(
        bodies: &Bodies,
        i: usize,
        (start, velocity): (Pose, &Velocity),
        frame: &Frame,
    ) -> Self {
        let (linear, angular, acceleration) = match bodies.motions[i] {
            Motion::Static => (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO),
            Motion::Kinematic { linear, angular } => (linear, angular, DVec3::ZERO),
            Motion::Dynamic => {
                let angular = bodies.inertias[i]
                    .angular_velocity(start.orientation, velocity.angular_momentum);
                (velocity.linear, angular, frame.gravity)
            }
        };
        let across = bodies.sweeping_spin(i, &start, angular);
        let (spin, radius) = (across.length(), bodies.radii[i]);
        // Unbounded bodies have no spin.
        let spin_speed = if spin > 0.0 { spin * radius } else { 0.0 };
        Self { start, linear, angular, acceleration, radius, spin_speed }
    }

    /// The path without gravity: of a body that something carries.
    #[inline]
    pub fn straight(&self) -> Self {
        Self { acceleration: DVec3::ZERO, ..*self }
    }

    /// Where the body is after `time` [s].
    #[inline]
    pub fn pose(&self, time: f64) -> Pose {
        if time == 0.0 {
            return self.start;
        }
        Pose {
            position: self.position(time),
            orientation: (rotation_by(time * self.angular) * self.start.orientation).normalize(),
        }
    }

    #[inline]
    fn position(&self, time: f64) -> DVec3 {
        self.start.position + time * (self.linear + 0.5 * time * self.acceleration)
    }

    /// Velocity of its material at a point of the world [m/s] after `time` [s].
    #[inline]
    pub fn velocity(&self, point: DVec3, time: f64) -> DVec3 {
        let lever = point - self.position(time);
        self.linear + time * self.acceleration + self.angular.cross(lever)
    }
}
