//! Cells with rough faces: planar regions, seen through a random displacement of space.

use crate::{
    cell_mesh::CellMesh,
    noise::Noise,
    pattern::{Region, nearest_region},
};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A point belongs to the region that holds the place to which the noise moves it. As the noise is one-to-one and keeps the box,
/// the cells tile it as the regions do, and each stays in one piece.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Rough {
    /// They tile the box.
    pub regions: Vec<Region>,
    /// What makes their faces rough.
    pub noise: Noise,
}

impl Rough {
    /// See [`crate::Pattern::region_at`].
    pub(crate) fn region_at(&self, point: DVec3, half_extent: DVec3) -> Option<usize> {
        nearest_region(&self.regions, point + self.noise.displacement(point, half_extent))
    }

    /// See [`crate::Pattern::distance`]. Two points are moved apart by at most 1 + steepness times the way between them, and the
    /// distance is divided by that.
    pub(crate) fn distance(&self, cell: usize, point: DVec3, half_extent: DVec3) -> f64 {
        let moved = point + self.noise.displacement(point, half_extent);
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
}
