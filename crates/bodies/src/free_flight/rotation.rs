//! Free flight over one time step: the path is exact, and so may the rotation be; else it is second
//! order.

use crate::frame::Rotation;
use crate::free_flight::energy_fix::fix_rotational_energy;
use crate::free_flight::exact_rotation::rotate_exact;
use crate::state::{Inertia, Pose, Velocity};
use frangible_math::Turn;
use glam::{DQuat, DVec3};

/// Moves a pose over `dt` [s]: the centre by its linear velocity, the orientation by `rotation`.
/// Angular momentum is an input only, hence conserved by construction; the energy fix aims at the
/// energy at the start of this very step [Su09 sec. 2]. Bodies with infinite inertia keep their
/// orientation here.
#[inline]
pub fn advance(
    pose: &Pose,
    velocity: &Velocity,
    inertia: &Inertia,
    dt: f64,
    rotation: Rotation,
) -> Pose {
    let position = pose.position + dt * velocity.linear;
    if inertia.is_infinite() {
        return Pose { position, orientation: pose.orientation };
    }

    let angular_momentum = velocity.angular_momentum;
    let orientation = match rotation {
        Rotation::Exact => rotate_exact(pose.orientation, angular_momentum, inertia, dt),
        Rotation::SecondOrder { energy_fix } => {
            let rotated = rotate_second_order(pose.orientation, angular_momentum, inertia, dt);
            if energy_fix {
                let kinetic_energy_0 =
                    inertia.rotational_energy(pose.orientation, angular_momentum);
                fix_rotational_energy(rotated, angular_momentum, inertia, kinetic_energy_0).0
            } else {
                rotated
            }
        }
    };
    Pose { position, orientation }
}

/// Rotates `orientation` (`world_from_body`) over `dt` [s] without torque, to second order [SSF08]:
/// `exp(theta) R` with `theta = dt (omega - dt/2 I^-1 (omega x L))`. `angular_momentum` L is in the
/// world frame [kg m^2/s]. Does not conserve kinetic energy.
pub fn rotate_second_order(
    orientation: DQuat,
    angular_momentum: DVec3,
    inertia: &Inertia,
    dt: f64,
) -> DQuat {
    // In the body frame the inertia is diagonal; exp(theta) R is R exp(R^T theta).
    let momentum_body = orientation.conjugate() * angular_momentum;
    let omega_body = inertia.inverse_moments * momentum_body;
    let acceleration_body = -(inertia.inverse_moments * omega_body.cross(momentum_body));
    let theta_body = dt * (omega_body + 0.5 * dt * acceleration_body);
    (orientation * rotation_by(theta_body)).normalize()
}

/// The rotation `exp(theta*)` by `|theta|` [rad] about `theta`.
pub fn rotation_by(theta: DVec3) -> DQuat {
    let squared = theta.length_squared();
    if squared < 1e-4 {
        return Turn::by_little(theta).into();
    }
    let angle = squared.sqrt();
    let (sine, cosine) = libm::sincos(0.5 * angle);
    DQuat::from_vec4((sine / angle * theta).extend(cosine))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The series near zero meets the formula, and both are unit quaternions.
    #[test]
    fn rotation_by_agrees_with_glam_on_both_sides_of_the_series() {
        for angle in [0.0, 1e-300, 1e-9, 0.999e-2, 1.001e-2, 0.1, 3.0, 7.0] {
            let theta = angle * DVec3::new(2.0, -1.0, 2.0) / 3.0;
            let rotation = rotation_by(theta);
            let expected = if angle == 0.0 {
                DQuat::IDENTITY
            } else {
                DQuat::from_axis_angle(theta / angle, angle)
            };
            assert!(
                (rotation - expected).length() < 4e-16 * (1.0 + angle),
                "{angle}: {rotation} is not {expected}"
            );
        }
    }

    /// A symmetric top precesses: its axis goes around L at the rate |L|/I1 [Goldstein, Classical
    /// Mechanics, sec. 5.7], which the second-order rule meets with an error that falls as dt^2.
    #[test]
    fn symmetric_top_precesses_at_the_analytic_rate_to_second_order() {
        let inertia = Inertia::new(1.0, DVec3::new(2.0, 2.0, 0.5));
        let momentum = DVec3::new(0.0, 3.0, 0.0);
        let start = Pose { position: DVec3::ZERO, orientation: DQuat::from_rotation_x(0.4) };
        let velocity = Velocity { linear: DVec3::new(1.0, 2.0, 3.0), angular_momentum: momentum };
        let time = 1.0;
        let expected_axis =
            DQuat::from_rotation_y(momentum.y / 2.0 * time) * (start.orientation * DVec3::Z);

        let error = |steps: u32, energy_fix: bool| {
            let dt = time / f64::from(steps);
            let end = (0..steps).fold(start, |pose, _| {
                advance(&pose, &velocity, &inertia, dt, Rotation::SecondOrder { energy_fix })
            });
            assert!((end.position - DVec3::new(1.0, 2.0, 3.0) * time).length() < 1e-12);
            (end.orientation * DVec3::Z - expected_axis).length()
        };
        for energy_fix in [false, true] {
            let order = (error(64, energy_fix) / error(128, energy_fix)).log2();
            assert!((order - 2.0).abs() < 0.1, "order {order}, energy fix {energy_fix}");
            assert!(error(128, energy_fix) < 1e-3);
        }
    }

    #[test]
    fn infinite_inertia_keeps_its_orientation_and_moves() {
        let pose = Pose { position: DVec3::X, orientation: DQuat::from_rotation_z(1.0) };
        let velocity = Velocity { linear: DVec3::Y, angular_momentum: DVec3::splat(7.0) };
        for rotation in [Rotation::Exact, Rotation::SecondOrder { energy_fix: true }] {
            let moved = advance(&pose, &velocity, &Inertia::INFINITE, 0.5, rotation);
            assert_eq!(moved, Pose { position: DVec3::new(1.0, 0.5, 0.0), ..pose });
        }
    }
}
