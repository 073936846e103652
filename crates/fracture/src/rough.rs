//! Cells with rough faces: planar regions, seen through a random displacement of space.

use crate::cell_mesh::CellMesh;
use crate::nearby::Nearby;
use crate::noise::Noise;
use crate::pattern::region::Region;
use crate::placement::Placement;
use frangible_geometry::Grid;
use frangible_math::threads;
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// A point belongs to the region that holds the place to which the noise moves it. As the noise is
/// one-to-one and keeps the box, the cells tile it as the regions do, and each stays in one piece.
///
/// Bodies break along the noise on the nodes of a lattice, linear between them, sampled once for
/// all breaks. A break lays it onto the nodes of the body, once for all pieces [Su09 sec. 4.2].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rough {
    /// Regions that tile the box.
    pub regions: Vec<Region>,
    /// Noise that roughens their faces.
    pub noise: Noise,
    /// Made from the others when a body breaks first.
    #[serde(skip)]
    sampled: Sampled,
}

/// Samples of a pattern, if they were made.
#[derive(Clone, Debug, Default)]
struct Sampled(OnceLock<Arc<Samples>>);

/// Where each node of a grid is moved, in the pattern's unit; an axis at a time, so that lanes
/// fill.
#[derive(Debug)]
pub(crate) struct Moved {
    x: Vec<f32>,
    y: Vec<f32>,
    z: Vec<f32>,
}

impl Moved {
    /// Of one node.
    #[inline]
    pub(crate) fn place(&self, node: usize) -> DVec3 {
        Vec3::new(self.x[node], self.y[node], self.z[node]).as_dvec3()
    }
}

/// Derived from all other fields.
impl PartialEq for Sampled {
    fn eq(&self, _: &Self) -> bool {
        true
    }
}

/// The noise on a lattice, and the neighbourhoods of cells.
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
        let to = point + samples.displacement(point, half_extent);
        let [(cell, _), _] = self.nearest(point, to, half_extent);
        (cell < self.regions.len()).then_some(cell)
    }

    /// The two regions that are nearest to the place `to` which a point is moved to, and how far
    /// they are; the first of equals first.
    pub(crate) fn nearest(&self, point: DVec3, to: DVec3, half_extent: DVec3) -> [(usize, f64); 2] {
        let mut nearest = [(usize::MAX, f64::INFINITY); 2];
        let around = self.samples(half_extent).nearby.around(point);
        let all = 0..if around.is_some() { 0 } else { self.regions.len() };
        for cell in around.unwrap_or_default().iter().map(|&cell| cell as usize).chain(all) {
            let distance = self.regions[cell].distance(to);
            if distance < nearest[0].1 {
                nearest = [(cell, distance), nearest[0]];
            } else if distance < nearest[1].1 {
                nearest[1] = (cell, distance);
            }
        }
        nearest
    }

    /// Where the nodes of a grid are moved, onto which the pattern is laid: at nodes about as far
    /// apart as those that the noise is sampled on, and linear between them.
    pub(crate) fn moved(&self, placement: &Placement, grid: &Grid, half_extent: DVec3) -> Moved {
        let samples = self.samples(half_extent);
        let step = (samples.grid.spacing * placement.scale / grid.spacing).max(1.0) as usize;
        let dims = grid.dims.map(|n| (n - 1) / step + 2);
        let coarse = Grid { spacing: grid.spacing * step as f64, dims, ..*grid };
        let displacement = |node: usize| {
            let [i, j, k] = coarse.coordinates(node);
            let point = placement.pattern_from_grid(coarse.node(i, j, k));
            samples.displacement(point, half_extent).as_vec3()
        };
        let displacements: Vec<Vec3> = (0..coarse.len()).map(displacement).collect();

        // Rows between the coarse ones, then nodes between.
        let part = |n: usize| (n / step, (n % step) as f32 / step as f32);
        let along_row: Vec<(usize, f32)> = (0..grid.dims[0]).map(part).collect();
        let [first, second] = [0, 1].map(|i| placement.pattern_from_grid(grid.node(i, 0, 0)));
        let along = (second - first).as_vec3();
        let [x, y, z] = std::array::from_fn(|_| vec![0.0; grid.len()]);
        let mut moved = Moved { x, y, z };
        let mut of_row = vec![Vec3::ZERO; dims[0]];
        let rows = moved.x.chunks_mut(grid.dims[0]).zip(moved.y.chunks_mut(grid.dims[0]));
        for (row, ((x, y), z)) in rows.zip(moved.z.chunks_mut(grid.dims[0])).enumerate() {
            let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
            let ((near, along_y), (low, along_z)) = (part(j), part(k));
            let of = |j: usize, k: usize| &displacements[coarse.index(0, j, k)..][..dims[0]];
            let rows = of(near, low).iter().zip(of(near + 1, low));
            let above = of(near, low + 1).iter().zip(of(near + 1, low + 1));
            for (to, (low, high)) in of_row.iter_mut().zip(rows.zip(above)) {
                *to = low.0.lerp(*low.1, along_y).lerp(high.0.lerp(*high.1, along_y), along_z);
            }
            let start = placement.pattern_from_grid(grid.node(0, j, k)).as_vec3();
            let nodes = x.iter_mut().zip(y).zip(z).zip(&along_row).enumerate();
            for (i, (((x, y), z), &(at, weight))) in nodes {
                let to = start + along * i as f32 + of_row[at].lerp(of_row[at + 1], weight);
                (*x, *y, *z) = (to.x, to.y, to.z);
            }
        }
        moved
    }

    /// [`Rough::distance`] at nodes from `first` on.
    pub(crate) fn distances(&self, cell: usize, moved: &Moved, first: usize, of_nodes: &mut [f32]) {
        let nodes = first..first + of_nodes.len();
        let [x, y, z] = [&moved.x, &moved.y, &moved.z].map(|axis| &axis[nodes.clone()]);
        of_nodes.fill(f32::NEG_INFINITY);
        for cut in &self.regions[cell].cuts {
            let (normal, offset) = (cut.half_space.normal.as_vec3(), cut.half_space.offset as f32);
            for (((distance, x), y), z) in of_nodes.iter_mut().zip(x).zip(y).zip(z) {
                let beyond = normal.x * x + normal.y * y + normal.z * z - offset;
                *distance = if beyond > *distance { beyond } else { *distance };
            }
        }
        let part = 1.0 / (1.0 + self.noise.steepness) as f32;
        of_nodes.iter_mut().for_each(|distance| *distance *= part);
    }

    /// See [`crate::Pattern::distance`]. Two points are moved apart by at most 1 + steepness times
    /// the way between them, and the distance is divided by that.
    pub(crate) fn distance(&self, cell: usize, point: DVec3, half_extent: DVec3) -> f64 {
        self.regions[cell].distance(self.moved_point(point, half_extent))
            / (1.0 + self.noise.steepness)
    }

    /// Where the noise moves a point.
    pub(crate) fn moved_point(&self, point: DVec3, half_extent: DVec3) -> DVec3 {
        point + self.samples(half_extent).displacement(point, half_extent)
    }

    /// See [`crate::Pattern::region_mesh`]; fine enough to show the noise, but for a `coarseness`
    /// above 1.
    pub(crate) fn cell_mesh(
        &self,
        cell: usize,
        longest_edge: f64,
        half_extent: DVec3,
        coarseness: f64,
    ) -> CellMesh {
        let edge = longest_edge.min(coarseness * self.noise.resolution());
        let mut made = CellMesh::planar(&self.regions, half_extent, cell).refined(edge);
        for vertex in &mut made.mesh.positions {
            *vertex = self.noise.origin_of(*vertex, half_extent);
        }
        made
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
        let spacing =
            (wave / NODES).max(libm::cbrt(volume / MOST_NODES)).min(half_extent.min_element());
        let along =
            (2.0 * half_extent / spacing).to_array().map(|count| libm::ceil(count) as usize + 1);
        let grid = Grid { origin: -half_extent, spacing, dims: along };
        // The last nodes lie on the walls or beyond, where the noise is as on the walls.
        let node = |index: usize| {
            let [i, j, k] = grid.coordinates(index);
            rough.noise.displacement(grid.node(i, j, k).min(half_extent), half_extent).as_vec3()
        };
        let displacements = threads::list(grid.len(), node);
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
        let (first, place) = self.cell(point, half_extent);
        let [nx, ny, _] = self.grid.dims;
        let along_x =
            |node: usize| self.displacements[node].lerp(self.displacements[node + 1], place.x);
        let along_y = |node: usize| along_x(node).lerp(along_x(node + nx), place.y);
        along_y(first).lerp(along_y(first + nx * ny), place.z).as_dvec3()
    }

    /// The first node of the lattice's cube around a point of the box, and where in it the point
    /// lies.
    #[inline]
    fn cell(&self, point: DVec3, half_extent: DVec3) -> (usize, Vec3) {
        let [nx, ny, nz] = self.grid.dims;
        let lattice =
            (point.clamp(-half_extent, half_extent) - self.grid.origin) / self.grid.spacing;
        let most = [nx - 2, ny - 2, nz - 2];
        let at: [usize; 3] = std::array::from_fn(|axis| (lattice[axis] as usize).min(most[axis]));
        let place = (lattice - DVec3::from(at.map(|n| n as f64))).as_vec3();
        (self.grid.index(at[0], at[1], at[2]), place)
    }
}
