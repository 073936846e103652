//! Which region of the pattern each node lies in.

use crate::pattern::{Cut, Region, nearest_region};
use frangible_geometry::{Grid, GridSolid, HalfSpace};
use glam::DVec3;

/// No region, no component.
pub(crate) const NONE: u32 = u32::MAX;

/// Region of each node that is inside of the solid or whose voxel holds material; [`NONE`] elsewhere.
///
/// A region is convex, so along a row of nodes it is one interval: its end points cost less than its distance at each
/// node. Nodes in no interval, or in several because they lie on a crack up to round-off, are compared by distance.
pub(crate) fn assign_voxels(solid: &GridSolid, regions: &[Region]) -> Vec<u32> {
    let grid = solid.level_set.grid();
    let phi = solid.level_set.phi();
    let mut region_of_node = vec![NONE; grid.len()];
    let width = grid.dims[0];
    for row in 0..grid.dims[1] * grid.dims[2] {
        // The part of the row from its first to its last node with material.
        let start = row * width;
        let active = |i: &usize| phi[start + i] <= 0.0 || solid.coverage[start + i] > 0.0;
        let Some(first) = (0..width).find(active) else { continue };
        let Some(last) = (first..width).rev().find(active) else { continue };
        let [_, j, k] = grid.coordinates(start);

        let labels = &mut region_of_node[start..start + width];
        label_row(grid, [j, k], (first, last), regions, labels);
        for i in first..=last {
            if !active(&i) {
                labels[i] = NONE;
            }
        }
    }
    region_of_node
}

/// A node that several regions claim.
const CONTESTED: u32 = u32::MAX - 1;

/// Labels the nodes from `first` to `last` of the row at (j, k).
fn label_row(
    grid: &Grid,
    [j, k]: [usize; 2],
    (first, last): (usize, usize),
    regions: &[Region],
    labels: &mut [u32],
) {
    let origin = grid.node(0, j, k);
    for (region, label) in regions.iter().zip(0..) {
        let Some((low, high)) = row_interval(&region.cuts, origin, grid.spacing, (first as f64, last as f64))
        else {
            continue;
        };
        for claimed in &mut labels[low..=high] {
            *claimed = if *claimed == NONE { label } else { CONTESTED };
        }
    }
    for i in first..=last {
        if labels[i] >= CONTESTED {
            let nearest = nearest_region(regions, grid.node(i, j, k));
            labels[i] = nearest.map_or(0, |region| region as u32);
        }
    }
}

/// First and last node within the bounds, counted along x from `origin`, that lie inside of all cuts or on them.
fn row_interval(cuts: &[Cut], origin: DVec3, spacing: f64, bounds: (f64, f64)) -> Option<(usize, usize)> {
    // In units of the spacing: a node this close to a crack counts as on it.
    const ON_CRACK: f64 = 1e-9;
    let (mut low, mut high) = bounds;
    for cut in cuts {
        let HalfSpace { normal, .. } = cut.half_space;
        let at_origin = cut.half_space.distance(origin) / spacing;
        let slope = normal.x;
        if slope.abs() < ON_CRACK * 1e-3 {
            if at_origin > ON_CRACK {
                return None;
            }
        } else if slope > 0.0 {
            high = high.min((ON_CRACK - at_origin) / slope);
        } else {
            low = low.max((ON_CRACK - at_origin) / slope);
        }
        if low > high {
            return None;
        }
    }
    let (low, high) = (low.ceil() as usize, high.floor() as usize);
    (low <= high).then_some((low, high))
}
