//! Signed distance sampled on a grid: negative inside.

use crate::grid::Grid;
use frangible_math::check::{Check, Checked, require};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// Signed distance [m] at each node of a grid, trilinear between nodes.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct LevelSet {
    grid: Grid,
    phi: Vec<f32>,
}

/// The two lattice nodes around a coordinate and the weight of the upper one; clamped to the grid.
#[inline]
fn bracket(coordinate: f32, count: usize) -> (usize, f32) {
    let clamped = coordinate.clamp(0.0, (count - 1) as f32);
    let lower = (clamped as usize).min(count - 2);
    (lower, clamped - lower as f32)
}

impl Check for LevelSet {
    fn check(&self) -> Checked {
        self.grid.check()?;
        require(self.phi.len() == self.grid.len(), "one distance for each node")?;
        require(!self.phi.iter().any(|distance| distance.is_nan()), "distances that are numbers")
    }
}

impl LevelSet {
    /// `phi` holds one signed distance [m] for each node, x fastest.
    ///
    /// # Panics
    /// If `phi` and `grid` differ in length, or an axis has fewer than two nodes.
    pub fn new(grid: Grid, phi: Vec<f32>) -> Self {
        assert_eq!(phi.len(), grid.len(), "one distance for each node");
        assert!(
            grid.dims.iter().all(|&n| n >= 2),
            "trilinear interpolation needs two nodes along each axis"
        );
        Self { grid, phi }
    }

    /// Samples `distance(point)` at each node; `point` is in the grid frame [m].
    pub fn sample(grid: Grid, distance: impl Fn(DVec3) -> f64) -> Self {
        let mut phi = Vec::with_capacity(grid.len());
        for k in 0..grid.dims[2] {
            for j in 0..grid.dims[1] {
                for i in 0..grid.dims[0] {
                    phi.push(distance(grid.node(i, j, k)) as f32);
                }
            }
        }
        Self::new(grid, phi)
    }

    /// Where the samples lie.
    pub fn grid(&self) -> &Grid {
        &self.grid
    }

    /// One signed distance [m] for each node, x fastest.
    pub fn phi(&self) -> &[f32] {
        &self.phi
    }

    /// Signed distance at a node [m].
    #[inline]
    pub fn at(&self, i: usize, j: usize, k: usize) -> f32 {
        self.phi[self.grid.index(i, j, k)]
    }

    /// The eight distances around a lattice point and the weights of the upper nodes.
    #[inline]
    fn corners(&self, lattice: Vec3) -> ([f32; 8], [f32; 3]) {
        let [nx, ny, nz] = self.grid.dims;
        let (i, u) = bracket(lattice.x, nx);
        let (j, v) = bracket(lattice.y, ny);
        let (k, w) = bracket(lattice.z, nz);
        let at = i + nx * (j + ny * k);
        let (up_y, up_z) = (nx, nx * ny);
        let phi = &self.phi;
        let corner = [
            phi[at],
            phi[at + 1],
            phi[at + up_y],
            phi[at + up_y + 1],
            phi[at + up_z],
            phi[at + up_z + 1],
            phi[at + up_z + up_y],
            phi[at + up_z + up_y + 1],
        ];
        (corner, [u, v, w])
    }

    /// Distance from a lattice point to the box of the nodes [m]; zero inside.
    #[inline]
    fn beyond(&self, lattice: Vec3) -> f32 {
        let [nx, ny, nz] = self.grid.dims;
        let top = Vec3::new((nx - 1) as f32, (ny - 1) as f32, (nz - 1) as f32);
        (lattice - lattice.clamp(Vec3::ZERO, top)).length() * self.grid.spacing as f32
    }

    /// Trilinear signed distance [m] at a point in lattice units; outside of the grid the value at
    /// the nearest point of the grid plus the way to it.
    #[inline]
    pub fn value_at_lattice(&self, lattice: Vec3) -> f32 {
        let (c, [u, v, w]) = self.corners(lattice);
        let low = lerp(lerp(c[0], c[1], u), lerp(c[2], c[3], u), v);
        let high = lerp(lerp(c[4], c[5], u), lerp(c[6], c[7], u), v);
        lerp(low, high, w) + self.beyond(lattice)
    }

    /// Signed distance [m] and the analytic gradient of the trilinear interpolant, not normalised
    /// (clamped to the grid), at a point in lattice units.
    #[inline]
    pub(crate) fn value_and_gradient_at_lattice(&self, lattice: Vec3) -> (f32, Vec3) {
        let (c, [u, v, w]) = self.corners(lattice);
        let x00 = lerp(c[0], c[1], u);
        let x10 = lerp(c[2], c[3], u);
        let x01 = lerp(c[4], c[5], u);
        let x11 = lerp(c[6], c[7], u);
        let value = lerp(lerp(x00, x10, v), lerp(x01, x11, v), w) + self.beyond(lattice);
        let along_x = lerp(lerp(c[1] - c[0], c[3] - c[2], v), lerp(c[5] - c[4], c[7] - c[6], v), w);
        let along_y = lerp(x10 - x00, x11 - x01, w);
        let along_z = lerp(x01, x11, v) - lerp(x00, x10, v);
        (value, Vec3::new(along_x, along_y, along_z) / self.grid.spacing as f32)
    }

    /// [`LevelSet::value_at_lattice`] at a grid-frame point [m].
    pub fn value(&self, point: DVec3) -> f32 {
        self.value_at_lattice(self.grid.lattice_from_point(point).as_vec3())
    }

    /// [`LevelSet::value_and_gradient_at_lattice`] at a grid-frame point [m].
    pub fn value_and_gradient(&self, point: DVec3) -> (f32, Vec3) {
        self.value_and_gradient_at_lattice(self.grid.lattice_from_point(point).as_vec3())
    }
}

#[inline]
fn lerp(a: f32, b: f32, t: f32) -> f32 {
    a + t * (b - a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn trilinear_field() -> LevelSet {
        let grid = Grid { origin: DVec3::new(-1.0, 0.0, 2.0), spacing: 0.25, dims: [9, 7, 5] };
        LevelSet::sample(grid, |p| {
            0.3 + p.x - 2.0 * p.y + 0.5 * p.z + p.x * p.y - p.y * p.z + 0.7 * p.x * p.y * p.z
        })
    }

    proptest! {
        /// A trilinear function is reproduced, and so is its gradient.
        #[test]
        fn interpolation_is_exact_for_trilinear_functions(x in -1.0..1.0f64, y in 0.0..1.5f64, z in 2.0..3.0f64) {
            let (value, gradient) = trilinear_field().value_and_gradient(DVec3::new(x, y, z));
            let expected = 0.3 + x - 2.0 * y + 0.5 * z + x * y - y * z + 0.7 * x * y * z;
            prop_assert!((f64::from(value) - expected).abs() < 1e-5);
            let slope = DVec3::new(1.0 + y + 0.7 * y * z, -2.0 + x - z + 0.7 * x * z, 0.5 - y + 0.7 * x * y);
            prop_assert!((gradient.as_dvec3() - slope).length() < 1e-4);
        }
    }

    #[test]
    fn outside_of_the_grid_the_way_to_it_is_added() {
        let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims: [3, 3, 3] };
        let level_set = LevelSet::sample(grid, |p| p.x - 1.0);
        assert_eq!(level_set.value(DVec3::new(5.0, 1.0, 1.0)), 1.0 + 3.0);
    }
}
