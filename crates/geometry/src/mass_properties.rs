//! Volume, centre of mass and inertia at unit density.

use frangible_math::check::{Check, Checked, finite_vector, require};
use frangible_math::{RigidTransform, symmetric_eigen};
use glam::{DMat3, DQuat, DVec3};
use serde::{Deserialize, Serialize};

/// Asked of a shape that has no volume, or whose mass lies on a line.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the shape has no volume or no moment of inertia: all three principal moments must be > 0")]
pub struct NoMass;

/// Inertial properties at unit density; multiply by a density [kg/m^3] for a body's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct MassProperties {
    /// [m^3]
    pub volume: f64,
    /// Centre of mass [m].
    pub center: DVec3,
    /// Inertia tensor about the centre of mass [m^5].
    pub inertia: DMat3,
}

impl Check for MassProperties {
    fn check(&self) -> Checked {
        require(self.volume > 0.0 && self.volume < 1e30, "a volume")?;
        finite_vector(self.center)?;
        self.inertia.to_cols_array_2d().into_iter().try_for_each(|axis| finite_vector(axis.into()))
    }
}

impl MassProperties {
    /// Principal moments [m^5] and the rotation `frame_from_principal`, a proper one: inertia is
    /// `R diag(moments) R^T`.
    ///
    /// The axes come in the order in which they lie nearest to the frame's own, so a tensor that is
    /// diagonal already gives no rotation. A moment that is not positive (no volume, or all of it
    /// on a line) is returned as it is.
    pub fn principal_axes(&self) -> (DVec3, DQuat) {
        let (moments, axes) = symmetric_eigen(&self.inertia);
        (moments, DQuat::from_mat3(&axes).normalize())
    }

    /// Principal moments [m^5], and the frame of the centre of mass and the principal axes:
    /// `body_from_frame`.
    ///
    /// # Errors
    /// If the volume or a moment is not positive.
    pub(crate) fn body_frame(&self) -> Result<(DVec3, RigidTransform), NoMass> {
        let (unit_moments, frame_from_principal) = self.principal_axes();
        if !(self.volume > 0.0 && unit_moments.min_element() > 0.0 && unit_moments.is_finite()) {
            return Err(NoMass);
        }
        Ok((unit_moments, RigidTransform::new(frame_from_principal, self.center).inverse()))
    }
}

/// `u v^T`.
pub fn outer(u: DVec3, v: DVec3) -> DMat3 {
    DMat3::from_cols(u * v.x, u * v.y, u * v.z)
}

/// Inertia tensor from the second moments, the sum of mass times `x x^T`, about the same point.
pub(crate) fn inertia_from_second_moments(second: DMat3) -> DMat3 {
    let trace = second.x_axis.x + second.y_axis.y + second.z_axis.z;
    let inertia = DMat3::from_diagonal(DVec3::splat(trace)) - second;
    // Sums round differently on the two sides of the diagonal.
    0.5 * (inertia + inertia.transpose())
}

/// Inertia tensor of a point mass at `lever` from the centre: Steiner's parallel-axis term.
pub fn parallel_axis(mass: f64, lever: DVec3) -> DMat3 {
    mass * (DMat3::from_diagonal(DVec3::splat(lever.length_squared())) - outer(lever, lever))
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn with_inertia(inertia: DMat3) -> MassProperties {
        MassProperties { volume: 1.0, center: DVec3::ZERO, inertia }
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(20_000))]

        /// A tensor assembled from known moments, up to a million apart, is taken apart again.
        #[test]
        fn axes_and_moments_rebuild_the_tensor(
            exponents in prop::array::uniform3(-6.0..0.0f64),
            axis in prop::array::uniform3(-1.0..1.0f64),
            angle in -3.2..3.2f64,
        ) {
            let moments = DVec3::from_array(exponents.map(libm::exp10));
            let rotation = DQuat::from_axis_angle(DVec3::from_array(axis).try_normalize().unwrap_or(DVec3::X), angle);
            let r = DMat3::from_quat(rotation);
            let tensor = r * DMat3::from_diagonal(moments) * r.transpose();
            let tensor = 0.5 * (tensor + tensor.transpose());
            let (found, frame_from_principal) = with_inertia(tensor).principal_axes();

            let sorted = |v: DVec3| { let mut a = v.to_array(); a.sort_by(f64::total_cmp); a };
            for (found, exact) in sorted(found).iter().zip(sorted(moments)) {
                // The assembled tensor itself is rounded at its largest entry, some times over.
                prop_assert!((found - exact).abs() < 2e-15 * moments.max_element() + 1e-14 * exact);
            }
            prop_assert!((frame_from_principal.length() - 1.0).abs() < 1e-15);
            let axes = DMat3::from_quat(frame_from_principal);
            prop_assert!((axes.determinant() - 1.0).abs() < 1e-14);
            let rebuilt = axes * DMat3::from_diagonal(found) * axes.transpose();
            prop_assert!((rebuilt - tensor).abs_diff_eq(DMat3::ZERO, 5e-15 * moments.max_element()));
        }
    }

    #[test]
    fn a_diagonal_tensor_gives_no_rotation() {
        let moments = DVec3::new(3.0, 1.0, 2.0);
        assert_eq!(
            with_inertia(DMat3::from_diagonal(moments)).principal_axes(),
            (moments, DQuat::IDENTITY)
        );
    }

    #[test]
    fn a_body_without_extent_shows_in_its_moments() {
        let (moments, rotation) = with_inertia(DMat3::ZERO).principal_axes();
        assert_eq!((moments, rotation), (DVec3::ZERO, DQuat::IDENTITY));
        // Two points on a line along (1, 1, 0): no resistance about it.
        let along = DVec3::new(1.0, 1.0, 0.0);
        assert!(
            with_inertia(parallel_axis(1.0, along)).principal_axes().0.min_element().abs() < 1e-15
        );
    }

    /// Two masses seen from their common centre, once by second moments and once by parallel axes.
    #[test]
    fn second_moments_and_parallel_axes_agree() {
        let levers = [DVec3::new(1.0, -2.0, 0.5), DVec3::new(-2.0, 4.0, -1.0)];
        let masses = [2.0, 1.0];
        let second =
            masses[0] * outer(levers[0], levers[0]) + masses[1] * outer(levers[1], levers[1]);
        let sum = parallel_axis(masses[0], levers[0]) + parallel_axis(masses[1], levers[1]);
        assert!(inertia_from_second_moments(second).abs_diff_eq(sum, 1e-14));
        assert_eq!(sum.x_axis, DVec3::new(2.0 * 4.25 + 17.0, 4.0 + 8.0, -1.0 - 2.0));
    }
}
