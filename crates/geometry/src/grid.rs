//! Uniform grids.

use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Nodes at `origin + spacing * (i, j, k)`. Each node stands for the cube of edge `spacing` around
/// it, its voxel.
///
/// A body "on a 150 x 10 x 100 grid" has so many voxels inside its bounding box.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Grid {
    /// Position of node (0, 0, 0) in the grid frame [m].
    pub origin: DVec3,
    /// Distance between neighbouring nodes, the same along each axis [m].
    pub spacing: f64,
    /// Number of nodes along x, y and z, at least 2 each.
    pub dims: [usize; 3],
}

impl Check for Grid {
    fn check(&self) -> Checked {
        let nodes = self.dims.iter().try_fold(1_usize, |nodes, &n| nodes.checked_mul(n));
        let fits = nodes.is_some_and(|nodes| nodes <= Self::MOST_NODES);
        require(fits && self.dims.iter().all(|&n| n >= 2), "a grid of two nodes or more")?;
        require(self.spacing > 0.0 && self.spacing < 1e9, "a grid with a spacing")?;
        finite_vector(self.origin)
    }
}

impl Grid {
    /// A grid may have so many nodes, 2^28. Sampling a solid takes at most 12 bytes for each at a
    /// time (distance, nearest triangle and winding number of a mesh; then distance, a copy of it
    /// and coverage), 3 GiB in all.
    pub const MOST_NODES: usize = 1 << 28;

    /// The grid whose voxels fill the box from `min` to `max` with `voxels` cells, or as many more
    /// as a cube needs, and `margin` further layers of voxels outside of each face. The box is
    /// centred on the grid.
    pub fn around_box(min: DVec3, max: DVec3, voxels: [usize; 3], margin: usize) -> Self {
        let extent = max - min;
        let along = |axis: usize| extent[axis] / voxels[axis] as f64;
        let spacing = along(0).max(along(1)).max(along(2));
        let dims = voxels.map(|n| n + 2 * margin);
        let half = DVec3::new((dims[0] - 1) as f64, (dims[1] - 1) as f64, (dims[2] - 1) as f64)
            * (0.5 * spacing);
        Self { origin: 0.5 * (min + max) - half, spacing, dims }
    }

    /// The grid with additional layers of nodes.
    pub fn widened(&self, layers: usize) -> Self {
        let origin = self.origin - DVec3::splat(layers as f64 * self.spacing);
        Self { origin, dims: self.dims.map(|n| n + 2 * layers), ..*self }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.dims[0] * self.dims[1] * self.dims[2]
    }

    /// True without nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of a node in arrays over the grid: x runs fastest.
    #[inline]
    pub fn index(&self, i: usize, j: usize, k: usize) -> usize {
        i + self.dims[0] * (j + self.dims[1] * k)
    }

    /// Coordinates of the node with index `index`; inverse of [`Grid::index`].
    #[inline]
    pub fn coordinates(&self, index: usize) -> [usize; 3] {
        let row = index / self.dims[0];
        [index % self.dims[0], row % self.dims[1], row / self.dims[1]]
    }

    /// Position of a node in the grid frame [m].
    #[inline]
    pub fn node(&self, i: usize, j: usize, k: usize) -> DVec3 {
        self.origin + self.spacing * DVec3::new(i as f64, j as f64, k as f64)
    }

    /// Grid-frame point [m] in units of the spacing, counted from node (0, 0, 0).
    #[inline]
    pub fn lattice_from_point(&self, point: DVec3) -> DVec3 {
        (point - self.origin) / self.spacing
    }

    /// Distance of the grid's middle from the first node along x, in units of the spacing.
    pub fn middle_along_x(&self) -> f64 {
        0.5 * (self.dims[0] - 1) as f64
    }

    /// Volume of one voxel [m^3].
    pub fn voxel_volume(&self) -> f64 {
        self.spacing * self.spacing * self.spacing
    }

    /// Lowest and highest node [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        (self.origin, self.node(self.dims[0] - 1, self.dims[1] - 1, self.dims[2] - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn voxels_of_the_wall_fill_it_exactly() {
        let half = DVec3::new(3.0, 0.2, 2.0);
        let grid = Grid::around_box(-half, half, [150, 10, 100], 2);
        assert!((grid.spacing - 0.04).abs() < 1e-15);
        assert_eq!(grid.dims, [154, 14, 104]);
        let first_inside = grid.node(2, 2, 2);
        assert!(
            (first_inside - (-half + 0.02)).length() < 1e-12,
            "voxel faces coincide with the wall's faces"
        );
        for index in [0, 17, 3001, grid.len() - 1] {
            let [i, j, k] = grid.coordinates(index);
            assert_eq!(grid.index(i, j, k), index);
        }
    }
}
