//! Volume, centre of mass and inertia at unit density.

use crate::symmetric::symmetric_eigen;
use glam::{DMat3, DQuat, DVec3};

/// Inertial properties at unit density; multiply by a density [kg/m^3] for a body's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// [m^3]
    pub volume: f64,
    /// Centre of mass [m].
    pub center: DVec3,
    /// Inertia tensor about the centre of mass [m^5].
    pub inertia: DMat3,
}

impl MassProperties {
    /// Principal moments [m^5] and the rotation `frame_from_principal`, a proper one: inertia is
    /// `R diag(moments) R^T`.
    ///
    /// The axes come in the order in which they lie nearest to the frame's own, so a tensor that is diagonal already
    /// gives no rotation. A moment that is not positive (no volume, or all of it on a line) is returned as it is.
    pub fn principal_axes(&self) -> (DVec3, DQuat) {
        let (moments, axes) = symmetric_eigen(&self.inertia);
        (moments, DQuat::from_mat3(&axes).normalize())
    }
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
                // The assembled tensor itself is rounded at its largest entry.
                prop_assert!((found - exact).abs() < 4e-16 * moments.max_element() + 1e-14 * exact);
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
        assert_eq!(with_inertia(DMat3::from_diagonal(moments)).principal_axes(), (moments, DQuat::IDENTITY));
    }

    #[test]
    fn a_body_without_extent_shows_in_its_moments() {
        let (moments, rotation) = with_inertia(DMat3::ZERO).principal_axes();
        assert_eq!((moments, rotation), (DVec3::ZERO, DQuat::IDENTITY));
        // Two points on a line along (1, 1, 0): no resistance about it.
        let along = DVec3::new(1.0, 1.0, 0.0);
        let line = DMat3::from_diagonal(DVec3::splat(along.length_squared()))
            - DMat3::from_cols(along * along.x, along * along.y, along * along.z);
        assert!(with_inertia(line).principal_axes().0.min_element().abs() < 1e-15);
    }
}
