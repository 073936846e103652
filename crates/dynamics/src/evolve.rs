//! Where bodies get to in one frame at a given velocity.

use crate::{Bodies, Frame, Motion, Pose, Velocity, rotation, threads};
use glam::DVec3;

/// Pose of body `i` one frame after `pose`, at a constant linear velocity and torque-free [Su09 sec. 2].
pub fn evolve(bodies: &Bodies, i: usize, pose: &Pose, velocity: &Velocity, frame: &Frame) -> Pose {
    match bodies.motions[i] {
        Motion::Static => *pose,
        Motion::Kinematic { linear, angular } => Pose {
            position: pose.position + frame.dt * linear,
            orientation: (rotation::rotation_by(frame.dt * angular) * pose.orientation).normalize(),
        },
        Motion::Dynamic => {
            rotation::advance(pose, velocity, &bodies.inertias[i], frame.dt, frame.settings.rotation)
        }
    }
}

/// [`evolve`] for all bodies: `poses` and `velocities` may belong to different time levels.
pub fn evolve_all(bodies: &Bodies, poses: &[Pose], velocities: &[Velocity], frame: &Frame) -> Vec<Pose> {
    threads::list(bodies.len(), |i| evolve(bodies, i, &poses[i], &velocities[i], frame))
}

/// Velocities after `duration` [s] of gravity alone; bodies of infinite mass do not fall.
pub fn accelerate(bodies: &Bodies, velocities: &[Velocity], duration: f64, frame: &Frame) -> Vec<Velocity> {
    velocities
        .iter()
        .zip(&bodies.inertias)
        .map(|(velocity, inertia)| {
            let gain = if inertia.is_infinite() { DVec3::ZERO } else { duration * frame.gravity };
            Velocity { linear: velocity.linear + gain, ..*velocity }
        })
        .collect()
}
