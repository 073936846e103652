//! What the cells of a pattern look like: faces, corners and sizes.

use crate::{
    Pattern,
    pattern::{Cells, Region},
    rough::Rough,
};

/// One cell, as a polyhedron within the pattern's box.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CellShape {
    /// Number of plane faces, those on the box included.
    pub faces: usize,
    /// Number of corners.
    pub corners: usize,
    /// In the pattern's unit, cubed.
    pub volume: f64,
    /// Whether none of its faces lies on the box.
    pub inner: bool,
}

impl Pattern {
    /// The shape of each cell; rough ones count as the plane regions behind them.
    pub fn cell_shapes(&self) -> Vec<CellShape> {
        let regions = match &self.cells {
            Cells::Planar(regions) | Cells::Rough(Rough { regions, .. }) => regions,
        };
        regions.iter().map(|region| self.shape_of(region)).collect()
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
