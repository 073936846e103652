//! Shapes of a pattern's cells: faces, corners and sizes.

use crate::cell_mesh::CellMesh;
use crate::mesh_pattern::Drawn;
use crate::pattern::region::Region;
use crate::pattern::{Cells, Pattern};
use crate::rough::Rough;
use glam::DVec3;

/// One cell, as a polyhedron within the pattern's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellShape {
    /// Number of plane faces, those on the box included.
    pub faces: usize,
    /// Number of corners.
    pub corners: usize,
    /// In the pattern's unit, cubed.
    pub volume: f64,
    /// True without faces on the box.
    pub inner: bool,
}

impl Pattern {
    /// The shape of each cell; rough cells count as their planar regions.
    pub fn cell_shapes(&self) -> Vec<CellShape> {
        match &self.cells {
            Cells::Planar(regions) | Cells::Rough(Rough { regions, .. }) => {
                regions.iter().map(|region| self.shape_of(region)).collect()
            }
            Cells::Drawn(drawn) => {
                (0..drawn.meshes().len()).map(|cell| self.shape_of_drawn(cell, drawn)).collect()
            }
        }
    }

    /// Counts the planes of the triangles, and the vertices at which three of them meet.
    fn shape_of_drawn(&self, cell: usize, drawn: &Drawn) -> CellShape {
        let CellMesh { mesh, crack } = drawn.cell_mesh(cell, self.half_extent);
        // Triangles of one plane in a file of single-precision numbers.
        let close = 1e-4 * self.half_extent.max_element();
        let mut planes: Vec<(DVec3, f64)> = Vec::new();
        let mut planes_at = vec![Vec::new(); mesh.positions.len()];
        for triangle in 0..mesh.triangles.len() {
            let [a, b, c] = mesh.corners(triangle);
            let Some(normal) = (b - a).cross(c - a).try_normalize() else { continue };
            let offset = normal.dot(a);
            let same = |plane: &(DVec3, f64)| {
                plane.0.distance(normal) < 1e-3 && (plane.1 - offset).abs() < close
            };
            let number = planes.iter().position(same).unwrap_or_else(|| {
                planes.push((normal, offset));
                planes.len() - 1
            });
            for vertex in mesh.triangles[triangle] {
                let known: &mut Vec<usize> = &mut planes_at[vertex as usize];
                if !known.contains(&number) {
                    known.push(number);
                }
            }
        }
        CellShape {
            faces: planes.len(),
            corners: planes_at.iter().filter(|planes| planes.len() > 2).count(),
            volume: mesh.mass_properties().volume,
            inner: crack.into_iter().all(|crack| crack),
        }
    }

    fn shape_of(&self, region: &Region) -> CellShape {
        let Some(hull) = region.hull(self.half_extent) else {
            return CellShape { faces: 0, corners: 0, volume: 0.0, inner: true };
        };
        let is_cut = |plane| region.cuts.iter().any(|cut| cut.half_space == plane);
        CellShape {
            faces: hull.faces().len(),
            corners: hull.vertices().len(),
            volume: hull.mass_properties().volume,
            inner: hull.planes().iter().all(|&plane| is_cut(plane)),
        }
    }
}
