//! Bounds of a solid on a grid.

use crate::grid_solid::GridSolid;
use crate::sample_clusters::bounds_of;
use frangible_math::RigidTransform;
use glam::{DVec3, Vec3};

/// Lowest and highest corner, in the body frame, around all voxels with material and all samples.
pub(crate) fn bounds_in_body(
    solid: &GridSolid,
    body_from_grid: &RigidTransform,
    samples: &[Vec3],
) -> (DVec3, DVec3) {
    let grid = solid.grid();
    let rotation = body_from_grid.matrix();
    let half_voxel = 0.5
        * grid.spacing
        * (rotation.x_axis.abs() + rotation.y_axis.abs() + rotation.z_axis.abs());
    // The voxels of a run lie on a line, so that its two ends bound them all. With axes turned so
    // that the places rise along x, the lower one is the start, for all runs. Two runs at a time
    // fill lanes.
    let steps = rotation * grid.spacing;
    let turns =
        DVec3::from_array(steps.x_axis.to_array().map(|step| if step < 0.0 { -1.0 } else { 1.0 }));
    let [along_x, along_y, along_z] =
        [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| step * turns);
    let (mut lows, mut highs) = ([[f64::INFINITY; 2]; 3], [[f64::NEG_INFINITY; 2]; 3]);
    let (runs, from) = solid.taken_runs();
    let from = from.map(|n| n as f64);
    let (pairs, rest) = runs.as_chunks::<2>();
    let rest = rest.first().map(|run| [*run; 2]);
    for pair in pairs.iter().chain(&rest) {
        let [j, k] = [0, 1].map(|axis| pair.map(|run| f64::from(run.row[axis]) - from[axis + 1]));
        let start = pair.map(|run| f64::from(run.start) - from[0]);
        let length = pair.map(|run| f64::from(run.end - 1 - run.start));
        for axis in 0..3 {
            for n in 0..2 {
                let first = along_y[axis] * j[n] + along_z[axis] * k[n] + along_x[axis] * start[n];
                let last = first + along_x[axis] * length[n];
                lows[axis][n] = if first < lows[axis][n] { first } else { lows[axis][n] };
                highs[axis][n] = if last > highs[axis][n] { last } else { highs[axis][n] };
            }
        }
    }
    let turned_low = turns * DVec3::from_array(lows.map(|[a, b]| a.min(b)));
    let turned_high = turns * DVec3::from_array(highs.map(|[a, b]| a.max(b)));
    let origin = body_from_grid.point(grid.origin);
    let low = turned_low.min(turned_high) + (origin - half_voxel);
    let high = turned_low.max(turned_high) + (origin + half_voxel);
    let (lowest, highest) = bounds_of(samples);
    (low.min(lowest.as_dvec3()), high.max(highest.as_dvec3()))
}
