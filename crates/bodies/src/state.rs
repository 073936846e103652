//! State of a body, split by time of change.

use frangible_geometry::Shape;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector, unit_quaternion};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Pose of a body at one time level.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Pose {
    /// Centre of mass, world frame [m].
    pub position: DVec3,
    /// `world_from_body`, a unit quaternion.
    pub orientation: DQuat,
}

/// Velocity of a body at one time level. Storing angular momentum and deriving angular velocity
/// makes free flight conserve angular momentum by construction.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Velocity {
    /// Of the centre of mass, world frame [m/s].
    pub linear: DVec3,
    /// About the centre of mass, world frame [kg m^2/s].
    pub angular_momentum: DVec3,
}

/// Mass and inertia of a body; infinite for static and kinematic bodies.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Inertia {
    /// [1/kg]; zero for infinite mass.
    pub inverse_mass: f64,
    /// Reciprocals of the principal moments, body frame [1/(kg m^2)]; zero for infinite mass.
    pub inverse_moments: DVec3,
}

impl Check for Pose {
    fn check(&self) -> Checked {
        finite_vector(self.position)?;
        unit_quaternion(self.orientation)
    }
}

impl Check for Velocity {
    fn check(&self) -> Checked {
        finite_vector(self.linear)?;
        finite_vector(self.angular_momentum)
    }
}

impl Pose {
    /// The same as a transform.
    #[inline]
    pub fn world_from_body(&self) -> RigidTransform {
        RigidTransform::new(self.orientation, self.position)
    }
}

impl Velocity {
    /// Of a body at a density [kg/m^3], from its linear [m/s] and angular velocity [rad/s] in the
    /// world frame: `L = I omega`.
    pub fn spinning(
        linear: DVec3,
        angular: DVec3,
        orientation: DQuat,
        shape: &Shape,
        density: f64,
    ) -> Self {
        let moments = density * shape.unit_moments;
        Self {
            linear,
            angular_momentum: orientation * (moments * (orientation.conjugate() * angular)),
        }
    }
}

impl Inertia {
    /// Inertia of immovable bodies.
    pub const INFINITE: Self = Self { inverse_mass: 0.0, inverse_moments: DVec3::ZERO };

    /// From a mass [kg] and principal moments [kg m^2], all positive.
    pub fn new(mass: f64, moments: DVec3) -> Self {
        Self { inverse_mass: 1.0 / mass, inverse_moments: moments.recip() }
    }

    /// Of a shape with a volume, at a density [kg/m^3].
    pub fn of(shape: &Shape, density: f64) -> Self {
        Self::new(density * shape.volume, density * shape.unit_moments)
    }

    /// True for bodies immovable by impulses.
    #[inline]
    pub fn is_infinite(&self) -> bool {
        self.inverse_mass == 0.0
    }

    /// Inverse of the inertia tensor in the world frame: `R I0^-1 R^T` [1/(kg m^2)].
    #[inline]
    pub fn inverse_tensor(&self, orientation: DQuat) -> DMat3 {
        turned(self.inverse_moments, orientation)
    }

    /// Inertia tensor in the world frame: `R I0 R^T` [kg m^2]; for finite masses only.
    #[inline]
    pub fn tensor(&self, orientation: DQuat) -> DMat3 {
        turned(self.inverse_moments.recip(), orientation)
    }

    /// Angular velocity `I^-1 L` in the world frame [rad/s].
    #[inline]
    pub fn angular_velocity(&self, orientation: DQuat, angular_momentum: DVec3) -> DVec3 {
        orientation * (self.inverse_moments * (orientation.conjugate() * angular_momentum))
    }

    /// Kinetic energy of rotation, `L . I^-1 L / 2` [J] [Su09 sec. 2.1].
    #[inline]
    pub fn rotational_energy(&self, orientation: DQuat, angular_momentum: DVec3) -> f64 {
        let body = orientation.conjugate() * angular_momentum;
        0.5 * body.dot(self.inverse_moments * body)
    }
}

/// `R D R^T` of a diagonal matrix.
#[inline]
fn turned(diagonal: DVec3, orientation: DQuat) -> DMat3 {
    let r = DMat3::from_quat(orientation);
    r * DMat3::from_diagonal(diagonal) * r.transpose()
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_geometry::ClosedForm;

    /// Angular velocity to angular momentum and back, by the body's axes and by the world's
    /// tensors.
    #[test]
    fn spin_and_tensors_agree() {
        let shape = Shape::closed_form(ClosedForm::Box { half: DVec3::new(0.5, 0.2, 0.1) }, 0.1);
        let inertia = Inertia::of(&shape, 500.0);
        assert!((1.0 / inertia.inverse_mass - 500.0 * 0.08).abs() < 1e-12);
        let orientation = DQuat::from_rotation_y(0.7) * DQuat::from_rotation_x(-1.9);
        let (linear, angular) = (DVec3::new(1.0, 2.0, 3.0), DVec3::new(-3.0, 0.5, 2.0));
        let velocity = Velocity::spinning(linear, angular, orientation, &shape, 500.0);
        assert_eq!(velocity.linear, linear);
        let momentum = velocity.angular_momentum;
        assert!(
            (inertia.tensor(orientation) * angular - momentum).length() < 1e-14 * momentum.length()
        );
        for back in [
            inertia.angular_velocity(orientation, momentum),
            inertia.inverse_tensor(orientation) * momentum,
        ] {
            assert!((back - angular).length() < 1e-14 * angular.length());
        }
    }
}
