//! Cells with rough faces: planar regions, seen through a random displacement of space.

use crate::{
    cell_mesh::CellMesh,
    nearby::Nearby,
    noise::Noise,
    pattern::{Region, nearest_region},
};
use frangible_geometry::Grid;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// A point belongs to the region that holds the place to which the noise moves it. As the noise is one-to-one and keeps the box,
/// the cells tile it as the regions do, and each stays in one piece.
///
/// Bodies break along the noise on the nodes of a lattice, linear between them, sampled once for
/// all breaks. The paper samples whole patterns and lays the nodes on the body's own, half a voxel
/// off at most [Su09 sec. 4.2]; here the lattice may lie askew in the body, and the samples are as
/// far apart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rough {
    /// They tile the box.
    pub regions: Vec<Region>,
    /// What makes their faces rough.
    pub noise: Noise,
    /// Made from the others when a body breaks first.
    #[serde(skip)]
    sampled: Sampled,
}

/// Samples of a pattern, if they were made.
#[derive(Clone, Debug, Default)]
struct Sampled(OnceLock<Arc<Samples>>);

/// They follow from all else.
impl PartialEq for Sampled {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The noise on a lattice, and who is near whom.
#[derive(Debug)]
struct Samples {
    grid: Grid,
    displacements: Vec<Vec3>,
    nearby: Nearby,
}

/// Nodes along the shortest wave of the noise, and the most nodes in the box: finer bumps than
/// those of a body of 64 voxels a side cannot be seen.
const NODES: f64 = 4.0;
const MOST_NODES: f64 = 4e5;

/// Linear between its nodes, a displacement changes by as much along each of three axes.
const THREE_AXES: f64 = 1.7321;

impl Rough {
    /// Regions, seen through a noise.
    pub fn new(regions: Vec<Region>, noise: Noise) -> Self {
        Self { regions, noise, sampled: Sampled::default() }
    }

    /// See [`crate::Pattern::region_at`].
    pub(crate) fn region_at(&self, point: DVec3, half_extent: DVec3) -> Option<usize> {
        let samples = self.samples(half_extent);
        if let Some(cell) = samples.nearby.sure(point) {
            return Some(cell);
        }
        let moved = point + samples.displacement(point, half_extent);
        let Some(around) = samples.nearby.around(point) else { return nearest_region(&self.regions, moved) };
        let mut nearest = (None, f64::INFINITY);
        for &cell in around {
            let distance = self.regions[cell as usize].distance(moved);
            if distance < nearest.1 {
                nearest = (Some(cell as usize), distance);
            }
        }
        nearest.0
    }

    /// See [`crate::Pattern::distance`]. Two points are moved apart by at most 1 + steepness times the way between them, and the
    /// distance is divided by that.
    pub(crate) fn distance(&self, cell: usize, point: DVec3, half_extent: DVec3) -> f64 {
        let moved = point + self.samples(half_extent).displacement(point, half_extent);
        self.regions[cell].distance(moved) / (1.0 + self.noise.steepness)
    }

    /// See [`crate::Pattern::region_mesh`]; fine enough to show the noise.
    pub(crate) fn cell_mesh(&self, cell: usize, longest_edge: f64, half_extent: DVec3) -> CellMesh {
        let edge = longest_edge.min(self.noise.resolution());
        let mut made = CellMesh::planar(&self.regions, half_extent, cell).refined(edge);
        for vertex in &mut made.mesh.positions {
            *vertex = self.noise.origin_of(*vertex, half_extent);
        }
        made
    }

    /// See [`crate::Pattern::crack_samples`].
    pub(crate) fn crack_samples(&self, cell: usize, spacing: f64, half_extent: DVec3) -> Vec<DVec3> {
        let samples = self.samples(half_extent);
        let flat = CellMesh::planar(&self.regions, half_extent, cell).refined(spacing);
        let vertices = flat.crack_vertices().into_iter();
        vertices.map(|vertex| samples.origin_of(vertex, half_extent)).collect()
    }

    /// Samples the noise, if that has not been done.
    pub(crate) fn prepare(&self, half_extent: DVec3) {
        self.samples(half_extent);
    }

    fn samples(&self, half_extent: DVec3) -> &Samples {
        self.sampled.0.get_or_init(|| Arc::new(Samples::new(self, half_extent)))
    }
}

impl Samples {
    fn new(rough: &Rough, half_extent: DVec3) -> Self {
        let volume = 8.0 * half_extent.element_product();
        let wave = 2.0 * rough.noise.resolution();
        let spacing = (wave / NODES).max(libm::cbrt(volume / MOST_NODES)).min(half_extent.min_element());
        let along = (2.0 * half_extent / spacing).to_array().map(|count| libm::ceil(count) as usize + 1);
        let grid = Grid { origin: -half_extent, spacing, dims: along };
        // The last nodes lie on the walls or beyond, where the noise is as on the walls.
        let node = |index: usize| {
            let [i, j, k] = grid.coordinates(index);
            rough.noise.displacement(grid.node(i, j, k).min(half_extent), half_extent).as_vec3()
        };
        let displacements = (0..grid.len()).map(node).collect();
        let without = Nearby::new(half_extent, 0, 1.0, |_, _| 0.0);
        let mut samples = Self { grid, displacements, nearby: without };
        let slope = 1.0 + THREE_AXES * rough.noise.steepness;
        samples.nearby = Nearby::new(half_extent, rough.regions.len(), slope, |cell, point| {
            rough.regions[cell].distance(point + samples.displacement(point, half_extent))
        });
        samples
    }

    /// Displacement of a point of the box; beyond it, that of the nearest point of a wall.
    #[inline]
    fn displacement(&self, point: DVec3, half_extent: DVec3) -> DVec3 {
        let [nx, ny, nz] = self.grid.dims;
        let lattice = (point.clamp(-half_extent, half_extent) - self.grid.origin) / self.grid.spacing;
        let most = [nx - 2, ny - 2, nz - 2];
        let at: [usize; 3] = std::array::from_fn(|axis| (lattice[axis] as usize).min(most[axis]));
        let place = (lattice - DVec3::from(at.map(|n| n as f64))).as_vec3();
        let first = self.grid.index(at[0], at[1], at[2]);
        let along_x = |node: usize| self.displacements[node].lerp(self.displacements[node + 1], place.x);
        let along_y = |node: usize| along_x(node).lerp(along_x(node + nx), place.y);
        along_y(first).lerp(along_y(first + nx * ny), place.z).as_dvec3()
    }

    /// The point that is moved to `target`.
    fn origin_of(&self, target: DVec3, half_extent: DVec3) -> DVec3 {
        // Steep noise takes hundreds of rounds to the last digit; a crack's sample is good enough
        // long before.
        const MOST_ROUNDS: usize = 60;
        const CLOSE: f64 = 1e-6;
        let mut point = target;
        for _ in 0..MOST_ROUNDS {
            let next = target - self.displacement(point, half_extent);
            let done = next.abs_diff_eq(point, CLOSE * half_extent.max_element());
            point = next;
            if done {
                break;
            }
        }
        point
    }
}
