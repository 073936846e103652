//! Volume fraction of each voxel.

use crate::grid::Grid;
use crate::level_set::LevelSet;
use glam::DVec3;
use rayon::prelude::*;

/// The fraction of each node's voxel that lies inside, from samples: the part of the cube below the
/// plane through the mean of the distance over the voxel, along its central differences. One value
/// in [0, 1] for each node.
pub(crate) fn voxel_coverage(level_set: &LevelSet) -> Vec<f32> {
    let grid = level_set.grid();
    for_each_voxel(grid, |node| {
        let (mean, steps) = mean_and_steps(level_set, node);
        cube_below_plane(mean, steps)
    })
}

/// [`voxel_coverage`] from an exact signed distance [m] and its gradient: exact up to the curvature
/// within a quarter of a voxel.
pub(crate) fn exact_coverage(
    grid: &Grid,
    distance_and_gradient: impl Fn(DVec3) -> (f64, DVec3) + Sync,
) -> Vec<f32> {
    const PARTS: i32 = 4;
    let part = grid.spacing / f64::from(PARTS);
    let half_diagonal = 0.5 * 3.0f64.sqrt() * grid.spacing;
    let offset = |n: i32| (f64::from(n) + 0.5) * part - 0.5 * grid.spacing;
    for_each_voxel(grid, |[i, j, k]| {
        let node = grid.node(i, j, k);
        let (distance, _) = distance_and_gradient(node);
        if distance.abs() >= half_diagonal {
            return if distance < 0.0 { 1.0 } else { 0.0 };
        }
        let mut sum = 0.0;
        for n in 0..PARTS * PARTS * PARTS {
            let shift = DVec3::new(
                offset(n % PARTS),
                offset(n / PARTS % PARTS),
                offset(n / (PARTS * PARTS)),
            );
            let (distance, gradient) = distance_and_gradient(node + shift);
            sum += cube_below_plane(distance, gradient * part);
        }
        sum / f64::from(PARTS * PARTS * PARTS)
    })
}

/// Computes a value per node, x fastest.
fn for_each_voxel(grid: &Grid, fraction: impl Fn([usize; 3]) -> f64 + Sync) -> Vec<f32> {
    let [nx, ny, _] = grid.dims;
    let mut coverage = vec![0.0; grid.len()];
    coverage.par_chunks_mut(nx * ny).enumerate().for_each(|(k, slab)| {
        for (index, value) in slab.iter_mut().enumerate() {
            *value = fraction([index % nx, index / nx, k]) as f32;
        }
    });
    coverage
}

/// Mean of the distance over a node's voxel, and spacing times its gradient [m]: central
/// differences, one-sided at the border of the grid.
fn mean_and_steps(level_set: &LevelSet, node: [usize; 3]) -> (f64, DVec3) {
    let grid = level_set.grid();
    let phi = level_set.phi();
    let at = grid.index(node[0], node[1], node[2]);
    let here = f64::from(phi[at]);
    let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
    let mut mean = here;
    let mut steps = DVec3::ZERO;
    for axis in 0..3 {
        let below = (node[axis] > 0).then(|| f64::from(phi[at - strides[axis]]));
        let above = (node[axis] + 1 < grid.dims[axis]).then(|| f64::from(phi[at + strides[axis]]));
        steps[axis] = match (below, above) {
            (Some(below), Some(above)) => {
                // The mean of a quadratic over a unit interval exceeds its middle by 1/24 of its
                // second difference.
                mean += (below - 2.0 * here + above) / 24.0;
                0.5 * (above - below)
            }
            (Some(below), None) => here - below,
            (None, Some(above)) => above - here,
            (None, None) => 0.0,
        };
    }
    (mean, steps)
}

/// The fraction of a cube below a plane: of `[-1/2, 1/2]^3` where `value + steps . x < 0`, with
/// `value` the distance at the cube's middle and `steps` its gradient times the cube's edge [SZ00
/// sec. 2.1].
fn cube_below_plane(value: f64, steps: DVec3) -> f64 {
    // Distances are f32: a face on the plane is off by a few of its ulps, here in units of the
    // cube.
    const ON_A_FACE: f64 = 1e-6;
    let steps = steps.abs();
    let sum = steps.element_sum();
    if value.abs() >= 0.5 * sum || sum == 0.0 {
        return if value < 0.0 { 1.0 } else { 0.0 };
    }
    let [m1, m2, m3] = sorted(steps / sum);
    let alpha = 0.5 - value / sum;
    if alpha < ON_A_FACE {
        0.0
    } else if alpha > 1.0 - ON_A_FACE {
        1.0
    } else if alpha <= 0.5 {
        cube_below_half(alpha, m1, m2, m3)
    } else {
        1.0 - cube_below_half(1.0 - alpha, m1, m2, m3)
    }
}

/// The part of the unit cube where `m . x < alpha`, for `0 <= m1 <= m2 <= m3` of sum 1 and `alpha
/// <= 1/2`.
///
/// The cubic formulas of [SZ00] with the factor `m1` divided out by hand: each quotient by `m1` is
/// at most 1, so that nothing happens when it vanishes.
fn cube_below_half(alpha: f64, m1: f64, m2: f64, m3: f64) -> f64 {
    let cube_over_m1 = |x: f64| if x > 0.0 { x * x * (x / m1) } else { 0.0 };
    if alpha < m1 {
        return cube_over_m1(alpha) / (6.0 * m2 * m3);
    }
    if alpha < m2 {
        return (alpha * (alpha - m1) + m1 * m1 / 3.0) / (2.0 * m2 * m3);
    }
    if alpha >= m1 + m2 {
        return (alpha - 0.5 * (m1 + m2)) / m3;
    }
    let without_corner =
        3.0 * alpha * (alpha - m1) + m1 * m1 - cube_over_m1(alpha - m2) - cube_over_m1(alpha - m3);
    without_corner / (6.0 * m2 * m3)
}

/// Components in ascending order.
fn sorted(v: DVec3) -> [f64; 3] {
    let (low, high) = (v.x.min(v.y), v.x.max(v.y));
    [low.min(v.z), low.max(v.z.min(high)), high.max(v.z)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::closed_form::ClosedForm;
    use crate::mass_properties::MassProperties;
    use crate::moments::VoxelMoments;
    use crate::voxel_runs::{Held, VoxelRuns};
    use frangible_math::RigidTransform;
    use glam::{DMat3, DQuat};
    use proptest::prelude::*;

    fn dense_mass_properties(grid: &Grid, coverage: &[f32]) -> MassProperties {
        let outside = LevelSet::new(*grid, vec![1.0; grid.len()]);
        Held::all(grid, VoxelRuns::from_nodes(&outside, coverage)).mass
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(2000))]

        /// The derivative of the volume by the offset is the area of the cut: the volume is
        /// monotonic, and integrates.
        #[test]
        fn plane_cuts_the_cube_as_counting_says(value in -0.9..0.9f64, steps in prop::array::uniform3(-1.0..1.0f64)) {
            let steps = DVec3::from_array(steps);
            // Exact along x, midpoints along y and z.
            let n = 100;
            let mut counted = 0.0;
            for j in 0..n {
                for k in 0..n {
                    let at = |i: i32| (f64::from(i) + 0.5) / f64::from(n) - 0.5;
                    let rest = value + steps.y * at(j) + steps.z * at(k);
                    let share = if steps.x == 0.0 { if rest < 0.0 { 1.0 } else { 0.0 } }
                        else { (0.5 - rest / steps.x.abs()).clamp(0.0, 1.0) };
                    counted += share / f64::from(n * n);
                }
            }
            let exact = cube_below_plane(value, steps);
            prop_assert!((exact - counted).abs() < 2e-3, "{exact} {counted}");
        }

        /// With vanishing components the volume tends to the plane's without them.
        #[test]
        fn vanishing_components_change_nothing(value in -0.6..0.6f64, y in 0.0..1.0f64, tiny in -300.0..-14.0f64) {
            let tiny = libm::exp10(tiny);
            let two = cube_below_plane(value, DVec3::new(1.0, y, 0.0));
            let almost = cube_below_plane(value, DVec3::new(1.0, y, tiny));
            prop_assert!((two - almost).abs() < 1e-12);
            let one = cube_below_plane(value, DVec3::new(0.0, 1.0, 0.0));
            let almost = cube_below_plane(value, DVec3::new(-tiny, 1.0, tiny));
            prop_assert!((one - almost).abs() < 1e-12);
            prop_assert!((one - (0.5 - value).clamp(0.0, 1.0)).abs() < 1e-12);
        }
    }

    #[test]
    fn a_plane_along_voxel_faces_leaves_them_full_or_empty() {
        let grid = Grid { origin: DVec3::new(0.123, -7.0, 3.3), spacing: 0.04, dims: [9, 4, 5] };
        let plane = grid.origin.x + 3.5 * grid.spacing;
        let coverage = voxel_coverage(&LevelSet::sample(grid, |p| p.x - plane));
        for (index, &fraction) in coverage.iter().enumerate() {
            assert_eq!(fraction, if grid.coordinates(index)[0] <= 3 { 1.0 } else { 0.0 });
        }
    }

    /// Relative errors of volume (signed) and inertia of a solid that is turned and moved against
    /// its grid.
    fn errors(
        form: &ClosedForm,
        voxels: usize,
        shift: DVec3,
        coverage_of: &dyn Fn(&LevelSet) -> Vec<f32>,
    ) -> [f64; 2] {
        let exact = form.mass_properties().unwrap();
        let axis = DVec3::new(0.3, 1.0, -0.4).normalize();
        let grid = Grid::around_box(DVec3::splat(-1.4), DVec3::splat(1.4), [voxels; 3], 2);
        let form_from_grid =
            RigidTransform::new(DQuat::from_axis_angle(axis, 0.8), shift * grid.spacing);
        let level_set =
            LevelSet::sample(grid, |p| form.distance_and_gradient(form_from_grid.point(p)).0);
        let found = dense_mass_properties(&grid, &coverage_of(&level_set));
        let r = form_from_grid.matrix();
        let inertia_form = r * found.inertia * r.transpose();
        let inertia_error = (inertia_form - exact.inertia)
            .to_cols_array()
            .iter()
            .fold(0.0, |a: f64, b| a.max(b.abs()));
        [found.volume / exact.volume - 1.0, inertia_error / exact.inertia.x_axis.x]
    }

    /// Over many positions of the solid between the nodes: mean size of both errors, and the spread
    /// of the volume.
    fn error_statistics(
        form: &ClosedForm,
        voxels: usize,
        coverage_of: &dyn Fn(&LevelSet) -> Vec<f32>,
    ) -> [f64; 3] {
        let shifts = 8;
        let (mut mean, mut low, mut high) = ([0.0; 2], f64::INFINITY, f64::NEG_INFINITY);
        for n in 0..shifts {
            let n = f64::from(n);
            let [volume, inertia] =
                errors(form, voxels, DVec3::new(0.13, 0.29, 0.41) * n, coverage_of);
            mean =
                [mean[0] + volume.abs() / f64::from(shifts), mean[1] + inertia / f64::from(shifts)];
            (low, high) = (low.min(volume), high.max(volume));
        }
        [mean[0], mean[1], high - low]
    }

    #[test]
    fn volume_and_inertia_converge_with_second_order() {
        let forms = [
            ClosedForm::Sphere { radius: 1.0 },
            ClosedForm::Box { half: DVec3::new(1.0, 0.5, 0.8) },
            ClosedForm::Cylinder { radius: 0.8, half_height: 0.9 },
        ];
        let by_sign = |level_set: &LevelSet| {
            level_set
                .phi()
                .iter()
                .map(|&phi| if phi < 0.0 { 1.0 } else { 0.0 })
                .collect::<Vec<f32>>()
        };
        for form in &forms {
            let [coarse, middle, fine] =
                [16, 32, 64].map(|voxels| error_statistics(form, voxels, &voxel_coverage));
            let crude = error_statistics(form, 64, &by_sign);
            for quantity in 0..2 {
                let order = 0.5 * libm::log2(coarse[quantity] / fine[quantity]);
                assert!(order > 1.8, "{form:?}: order {order}");
                assert!(
                    fine[quantity] < middle[quantity] && fine[quantity] < [5e-5, 3e-3][quantity]
                );
            }
            // Counting nodes inside, the mass depends on where the solid lies between the nodes.
            assert!(crude[2] > 5.0 * fine[2], "{form:?}: {crude:?} {fine:?}");
        }
    }

    #[test]
    fn a_box_along_the_grid_is_filled_exactly() {
        let half = DVec3::new(0.3, 0.1, 0.2);
        let grid = Grid::around_box(-half, half, [15, 5, 10], 2);
        let form = ClosedForm::Box { half };
        let coverage = exact_coverage(&grid, |point| form.distance_and_gradient(point));
        assert!(coverage.iter().all(|&fraction| fraction == 0.0 || fraction == 1.0));
        let (found, exact) =
            (dense_mass_properties(&grid, &coverage), form.mass_properties().unwrap());
        assert!((found.volume / exact.volume - 1.0).abs() < 1e-12);
        assert!(
            (found.inertia - exact.inertia)
                .abs_diff_eq(DMat3::ZERO, 1e-12 * exact.inertia.x_axis.x)
        );

        // From a formula a ball is fuller known than from its samples, by the square of the finer
        // step.
        let ball = ClosedForm::Sphere { radius: 0.9 };
        let grid = Grid::around_box(DVec3::NEG_ONE, DVec3::ONE, [16; 3], 2);
        let volume = dense_mass_properties(
            &grid,
            &exact_coverage(&grid, |point| ball.distance_and_gradient(point)),
        )
        .volume;
        assert!((volume / ball.mass_properties().unwrap().volume - 1.0).abs() < 4e-4);
    }

    #[test]
    fn parts_sum_to_the_whole_far_from_the_origin() {
        let form = ClosedForm::Box { half: DVec3::new(1.0, 0.7, 0.8) };
        let offset = DVec3::new(300.0, -200.0, 500.0);
        let grid = Grid::around_box(offset - 1.0, offset + 1.0, [20; 3], 2);
        let coverage =
            voxel_coverage(&LevelSet::sample(grid, |p| form.distance_and_gradient(p - offset).0));
        let mut parts = [VoxelMoments::ZERO; 7];
        for (index, &fraction) in coverage.iter().enumerate() {
            let [i, j, k] = grid.coordinates(index);
            let place = (grid.node(i, j, k) - offset) / grid.spacing;
            let volume = f64::from(fraction);
            let moments = [volume, volume * place.x, volume * place.x * place.x];
            parts[index * 31 % 7].add_row([place.y, place.z], moments);
        }
        let summed = VoxelMoments {
            volume: parts.iter().map(|part| part.volume).sum(),
            first: parts.iter().map(|part| part.first).sum(),
            squares: parts.iter().map(|part| part.squares).sum(),
            products: parts.iter().map(|part| part.products).sum(),
        }
        .mass_properties(offset, grid.spacing);
        let whole = dense_mass_properties(&grid, &coverage);
        assert!((summed.volume / whole.volume - 1.0).abs() < 1e-13);
        assert!((summed.center - whole.center).length() < 1e-12);
        assert!((summed.inertia - whole.inertia).abs_diff_eq(DMat3::ZERO, 1e-13));
        assert_eq!(whole.inertia, whole.inertia.transpose());
    }

    #[test]
    fn one_voxel_has_the_inertia_of_a_cube() {
        let grid = Grid { origin: DVec3::ZERO, spacing: 0.5, dims: [2, 2, 2] };
        let mut coverage = vec![0.0; 8];
        coverage[5] = 1.0;
        let one = dense_mass_properties(&grid, &coverage);
        assert_eq!(one.center, DVec3::new(0.5, 0.0, 0.5));
        assert!(
            (one.inertia - DMat3::from_diagonal(DVec3::splat(0.125 * 0.25 / 6.0)))
                .abs_diff_eq(DMat3::ZERO, 1e-16)
        );
        assert_eq!(dense_mass_properties(&grid, &[0.0; 8]).volume, 0.0);
    }
}
