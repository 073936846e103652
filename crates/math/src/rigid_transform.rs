//! Rotation followed by translation.

use crate::check::{Check, Checked, finite_vector, unit_quaternion};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Maps `point_from` to `point_to` as `rotation * point_from + translation`; named `to_from_from`
/// where it is used.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidTransform {
    /// Unit quaternion.
    pub rotation: DQuat,
    /// Image of the origin [m].
    pub translation: DVec3,
}

impl Check for RigidTransform {
    fn check(&self) -> Checked {
        unit_quaternion(self.rotation)?;
        finite_vector(self.translation)
    }
}

impl RigidTransform {
    /// Changes nothing.
    pub const IDENTITY: Self = Self { rotation: DQuat::IDENTITY, translation: DVec3::ZERO };

    /// `rotation` must be a unit quaternion.
    #[inline]
    pub fn new(rotation: DQuat, translation: DVec3) -> Self {
        Self { rotation, translation }
    }

    /// Image of a point [m].
    #[inline]
    pub fn point(&self, point: DVec3) -> DVec3 {
        self.rotation * point + self.translation
    }

    /// Image of a direction: rotated only.
    #[inline]
    pub fn direction(&self, direction: DVec3) -> DVec3 {
        self.rotation * direction
    }

    /// `b_from_a` becomes `a_from_b`.
    #[inline]
    pub fn inverse(&self) -> Self {
        let rotation = self.rotation.conjugate();
        Self { rotation, translation: -(rotation * self.translation) }
    }

    /// `c_from_b.after(b_from_a)` is `c_from_a`.
    #[inline]
    pub fn after(&self, first: &Self) -> Self {
        Self {
            rotation: self.rotation * first.rotation,
            translation: self.point(first.translation),
        }
    }

    /// The rotation as a matrix.
    #[inline]
    pub fn matrix(&self) -> DMat3 {
        DMat3::from_quat(self.rotation)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn inverse_undoes_and_after_composes() {
        let a = RigidTransform::new(DQuat::from_rotation_y(0.7), DVec3::new(1.0, 2.0, 3.0));
        let b = RigidTransform::new(DQuat::from_rotation_x(-1.1), DVec3::new(-4.0, 0.5, 2.0));
        let point = DVec3::new(0.3, -0.2, 0.9);
        assert!((a.inverse().point(a.point(point)) - point).length() < 1e-15);
        assert!((a.after(&b).point(point) - a.point(b.point(point))).length() < 1e-15);
    }
}
