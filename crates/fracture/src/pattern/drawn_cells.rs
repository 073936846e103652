//! Patterns from user meshes.

use crate::mesh_pattern::{Drawn, bounds, parts};
use crate::pattern::error::PatternError;
use crate::pattern::{Cells, Pattern};
use frangible_geometry::TriMesh;
use glam::DVec3;

impl Pattern {
    /// A pattern of closed meshes that fill a box, each a cell: what an artist drew. Each is turned
    /// outward. `name` begins the sentence about what is wrong, in which places are in the meshes'
    /// own units.
    ///
    /// # Errors
    /// If a mesh is not closed, or if together they leave a gap in their bounding box, or
    /// overlap, by more than a hundredth of its longest edge.
    pub fn drawn(meshes: &[TriMesh], name: &str) -> Result<Self, PatternError> {
        let wrong = |reason: String| PatternError::File { path: name.to_owned(), reason };
        let (low, high) =
            bounds(meshes).ok_or_else(|| wrong("has no cells, must have at least 1".to_owned()))?;
        let middle = 0.5 * (low + high);
        let moved = meshes.iter().map(|mesh| TriMesh {
            positions: mesh.positions.iter().map(|&position| position - middle).collect(),
            triangles: mesh.triangles.clone(),
        });
        let drawn = Drawn::new(moved.collect(), middle).map_err(wrong)?;
        let half_extent = 0.5 * (high - low);
        Ok(Self { cells: Cells::Drawn(drawn), ..Self::planar_in_box(half_extent, Vec::new()) })
    }

    /// Cells that are pieces of a body, where they lie on it: they need not fill their bounding
    /// box, and space beyond belongs to the nearest.
    ///
    /// # Errors
    /// If a mesh is not closed, or too thin to be sampled.
    pub(crate) fn of_pieces(meshes: Vec<TriMesh>) -> Result<Self, String> {
        let (low, high) = bounds(&meshes).unwrap_or_default();
        let (drawn, _) = Drawn::sampled(meshes, DVec3::ZERO)?;
        let half_extent = low.abs().max(high.abs());
        Ok(Self { cells: Cells::Drawn(drawn), ..Self::planar_in_box(half_extent, Vec::new()) })
    }

    /// The cells of a mesh: its connected parts.
    ///
    /// # Errors
    /// See [`Pattern::drawn`].
    pub fn of_parts(mesh: &TriMesh, name: &str) -> Result<Self, PatternError> {
        let parts = parts::closed_parts(mesh);
        let parts = parts.map_err(|reason| PatternError::File { path: name.to_owned(), reason })?;
        Self::drawn(&parts, name)
    }
}
