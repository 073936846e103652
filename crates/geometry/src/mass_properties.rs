//! Volume, centre of mass and inertia at unit density.

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
        // Cyclic Jacobi rotations [Golub & Van Loan, Matrix Computations, sec. 8.5]: they keep small moments accurate
        // beside large ones, and converge quadratically, so a dozen sweeps are more than ever needed.
        const MAX_SWEEPS: usize = 12;
        let mut tensor = self.inertia.to_cols_array_2d();
        let mut axes = DMat3::IDENTITY.to_cols_array_2d();
        for _ in 0..MAX_SWEEPS {
            let mut diagonal = true;
            for (p, q) in [(0, 1), (0, 2), (1, 2)] {
                diagonal &= !rotate_away(&mut tensor, &mut axes, p, q);
            }
            if diagonal {
                break;
            }
        }
        let moments = DVec3::new(tensor[0][0], tensor[1][1], tensor[2][2]);
        (moments, DQuat::from_mat3(&DMat3::from_cols_array_2d(&axes)).normalize())
    }
}

/// One Jacobi rotation in the plane of axes `p` and `q`, by at most 45 degrees, after which `tensor[p][q]` vanishes.
/// Columns of `axes` turn along. False if there was nothing to do.
fn rotate_away(tensor: &mut [[f64; 3]; 3], axes: &mut [[f64; 3]; 3], p: usize, q: usize) -> bool {
    let off = tensor[p][q];
    // Relative to both moments, so that a small one is resolved as well as a large one.
    let product = (tensor[p][p] * tensor[q][q]).abs();
    if off == 0.0 || off * off <= f64::EPSILON * f64::EPSILON * 1e-2 * product {
        return false;
    }
    let theta = (tensor[q][q] - tensor[p][p]) / (2.0 * off);
    let tangent = 1.0 / (theta.abs() + (theta * theta + 1.0).sqrt()) * if theta < 0.0 { -1.0 } else { 1.0 };
    let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
    let sine = tangent * cosine;

    tensor[p][p] -= tangent * off;
    tensor[q][q] += tangent * off;
    tensor[p][q] = 0.0;
    tensor[q][p] = 0.0;
    let r = 3 - p - q;
    let (along_p, along_q) = (tensor[r][p], tensor[r][q]);
    tensor[r][p] = cosine * along_p - sine * along_q;
    tensor[r][q] = sine * along_p + cosine * along_q;
    tensor[p][r] = tensor[r][p];
    tensor[q][r] = tensor[r][q];
    for row in 0..3 {
        let (along_p, along_q) = (axes[p][row], axes[q][row]);
        axes[p][row] = cosine * along_p - sine * along_q;
        axes[q][row] = sine * along_p + cosine * along_q;
    }
    true
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
