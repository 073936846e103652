//! Rigid and relative part of an island's motion.
//!
//! Velocities split into a rigid motion and the remainder relative to it. A free island's rigid
//! motion has the island's momentum and angular momentum; kinetic energy is then the sum of both
//! parts' [Koenig]. Scaling the relative part keeps both momenta, and no separating contact begins
//! to approach. The rigid motion of an island on a static or kinematic body is the motion of this
//! body.

use frangible_bodies::{Bodies, Pose, Velocity};
use frangible_geometry::parallel_axis;
use glam::{DMat3, DVec3};

/// A rigid motion.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Twist {
    /// World frame [m].
    pub(crate) origin: DVec3,
    /// Velocity of the origin [m/s].
    pub(crate) linear: DVec3,
    /// [rad/s]
    pub(crate) angular: DVec3,
}

impl Twist {
    /// Rigid motion with a momentum [kg m/s] and an angular momentum about the world's origin [kg
    /// m^2/s], for the given bodies.
    pub(crate) fn of_momentum(
        bodies: &Bodies,
        poses: &[Pose],
        members: &[usize],
        momentum: DVec3,
        angular_momentum: DVec3,
    ) -> Self {
        // Mass and inertia of all bodies frozen together.
        let mass: f64 = members.iter().map(|&i| bodies.masses[i]).sum();
        let origin =
            members.iter().map(|&i| bodies.masses[i] * poses[i].position).sum::<DVec3>() / mass;
        let mut inertia = DMat3::ZERO;
        for &i in members {
            inertia += bodies.inertias[i].tensor(poses[i].orientation);
            inertia += parallel_axis(bodies.masses[i], poses[i].position - origin);
        }
        let about_origin = angular_momentum - origin.cross(momentum);
        Self { origin, linear: momentum / mass, angular: inertia.inverse() * about_origin }
    }

    /// Work of an impulse [N s] with a moment about the world's origin [kg m^2/s], on a body in
    /// this rigid motion [J].
    pub(crate) fn work(&self, impulse: DVec3, moment: DVec3) -> f64 {
        self.linear.dot(impulse) + self.angular.dot(moment - self.origin.cross(impulse))
    }

    /// Velocity of a body in this rigid motion.
    pub(crate) fn velocity_of(&self, bodies: &Bodies, poses: &[Pose], i: usize) -> Velocity {
        let linear = self.linear + self.angular.cross(poses[i].position - self.origin);
        let tensor = bodies.inertias[i].tensor(poses[i].orientation);
        Velocity { linear, angular_momentum: tensor * self.angular }
    }

    /// Kinetic energy of the bodies relative to this motion [J].
    pub(crate) fn relative_energy(
        &self,
        bodies: &Bodies,
        poses: &[Pose],
        velocities: &[Velocity],
        members: &[usize],
    ) -> f64 {
        let of = |&i: &usize| {
            let along = self.velocity_of(bodies, poses, i);
            let linear = velocities[i].linear - along.linear;
            let angular = velocities[i].angular_momentum - along.angular_momentum;
            0.5 * bodies.masses[i] * linear.length_squared()
                + bodies.inertias[i].rotational_energy(poses[i].orientation, angular)
        };
        members.iter().map(of).sum()
    }

    /// Scales the velocities of the bodies relative to this motion.
    pub(crate) fn scale_relative(
        &self,
        bodies: &Bodies,
        poses: &[Pose],
        velocities: &mut [Velocity],
        members: &[usize],
        scale: f64,
    ) {
        for &i in members {
            let along = self.velocity_of(bodies, poses, i);
            let velocity = &mut velocities[i];
            velocity.linear = along.linear + scale * (velocity.linear - along.linear);
            velocity.angular_momentum = along.angular_momentum
                + scale * (velocity.angular_momentum - along.angular_momentum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, SurfaceProperties};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// Momentum and angular momentum are independent of the scale, and the energy is the sum of
    /// both parts.
    #[test]
    fn scaling_the_relative_part_keeps_both_momenta() {
        let mut bodies = Bodies::default();
        for i in 0..5 {
            let x = f64::from(i);
            let half = DVec3::new(0.1 + 0.1 * x, 0.5, 0.02);
            bodies.spawn(NewBody {
                shape: Arc::new(Shape::closed_form(ClosedForm::Box { half }, 0.2)),
                density: 1000.0,
                motion: Motion::Dynamic,
                pose: Pose {
                    position: DVec3::new(x, 2.0 - x * x, 0.3 * x),
                    orientation: DQuat::from_rotation_y(x) * DQuat::from_rotation_x(0.4 * x),
                },
                velocity: Velocity {
                    linear: DVec3::new(3.0 - x, x * x - 4.0, 1.0),
                    angular_momentum: DVec3::new(x, -3.0, 2.0 * x),
                },
                surface: SurfaceProperties::new(0.5, 0.5),
            });
        }
        let members: Vec<usize> = (0..5).collect();
        let sums = |velocities: &[Velocity]| {
            let mut sums = (DVec3::ZERO, DVec3::ZERO, 0.0);
            for (i, velocity) in velocities.iter().enumerate() {
                let momentum = bodies.masses[i] * velocity.linear;
                sums.0 += momentum;
                sums.1 += bodies.poses[i].position.cross(momentum) + velocity.angular_momentum;
                sums.2 += 0.5 * momentum.dot(velocity.linear)
                    + bodies.inertias[i]
                        .rotational_energy(bodies.poses[i].orientation, velocity.angular_momentum);
            }
            sums
        };
        let before = sums(&bodies.velocities);
        let twist = Twist::of_momentum(&bodies, &bodies.poses, &members, before.0, before.1);
        let relative = twist.relative_energy(&bodies, &bodies.poses, &bodies.velocities, &members);
        for scale in [0.0, 0.3, 0.999, 1.0] {
            let mut velocities = bodies.velocities.clone();
            twist.scale_relative(&bodies, &bodies.poses, &mut velocities, &members, scale);
            let after = sums(&velocities);
            assert!((after.0 - before.0).length() < 1e-12 * before.0.length());
            assert!((after.1 - before.1).length() < 1e-12 * before.1.length());
            let expected = before.2 - (1.0 - scale * scale) * relative;
            assert!((after.2 - expected).abs() < 1e-12 * before.2);
        }
    }
}
