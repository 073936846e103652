//! A pattern of cells of any form, laid onto the nodes of a body once for all of its pieces
//! [Su09 sec. 4.2].

use crate::pattern::{Cells, Pattern};
use crate::placement::Placement;
use crate::rough::Moved;
use frangible_geometry::{Grid, GridSolid, LevelSet};
use glam::DVec3;
use std::ops::Range;

/// A pattern on a body's nodes.
pub(crate) struct Laid<'a> {
    pattern: &'a Pattern,
    placement: Placement,
    /// Nodes of the body, with a margin for layers around its pieces.
    grid: Grid,
    /// Where the noise of rough cells moves each node.
    moved: Option<Moved>,
}

impl<'a> Laid<'a> {
    pub(crate) fn new(pattern: &'a Pattern, placement: Placement, body: &GridSolid) -> Self {
        let grid = body.grid().widened(GridSolid::MARGIN);
        let moved = match &pattern.cells {
            Cells::Rough(rough) => Some(rough.moved(&placement, &grid, pattern.half_extent)),
            Cells::Planar(_) | Cells::Drawn(_) => None,
        };
        Self { pattern, placement, grid, moved }
    }

    /// The cell that a point of the grid frame [m] lies in.
    pub(crate) fn cell_at(&self, point: DVec3) -> u32 {
        let cell = self.pattern.region_at(self.placement.pattern_from_grid(point));
        cell.map_or(0, |cell| cell as u32)
    }

    /// The cells that consecutive nodes of a row of the body lie in: `found` is told of each node.
    pub(crate) fn cells_along(
        &self,
        [j, k]: [usize; 2],
        nodes: Range<usize>,
        mut found: impl FnMut(u32),
    ) {
        let margin = GridSolid::MARGIN;
        let [j, k] = [j + margin, k + margin];
        let (Cells::Rough(rough), Some(moved)) = (&self.pattern.cells, &self.moved) else {
            nodes.for_each(|i| found(self.cell_at(self.grid.node(i + margin, j, k))));
            return;
        };
        // The nearest stays that as long as nodes are moved to places that are nearer to the last
        // one looked at than half of how much farther the second was.
        let (mut cell, mut last, mut gap) = (0, DVec3::ZERO, f64::NEG_INFINITY);
        for i in nodes {
            let to = moved.place(self.grid.index(i + margin, j, k));
            if gap <= 0.0 || 4.0 * to.distance_squared(last) >= gap * gap {
                let point = self.grid.node(i + margin, j, k);
                let point = self.placement.pattern_from_grid(point);
                let [first, second] = rough.nearest(point, to, self.pattern.half_extent);
                (cell, last, gap) = (first.0, to, second.1 - first.1);
            }
            found(cell as u32);
        }
    }

    /// Where a crack crosses the way from one node of the body to another, as a part of it; `None`
    /// if both lie in one cell.
    pub(crate) fn crossing(&self, nodes: [[usize; 3]; 2]) -> Option<f64> {
        let nodes = nodes.map(|node| {
            let [i, j, k] = node.map(|n| n + GridSolid::MARGIN);
            let point = self.placement.pattern_from_grid(self.grid.node(i, j, k));
            let to = self.moved.as_ref().map(|moved| moved.place(self.grid.index(i, j, k)));
            (point, to)
        });
        let cell = |(point, to): (DVec3, Option<DVec3>)| match (&self.pattern.cells, to) {
            (Cells::Rough(rough), Some(to)) => {
                rough.nearest(point, to, self.pattern.half_extent)[0].0
            }
            _ => self.pattern.region_at(point).unwrap_or(0),
        };
        let [own, other] = nodes.map(cell);
        if own == other {
            return None;
        }
        // Difference of the distances to the second and to the first cell.
        let [from, until] = nodes.map(|(point, to)| {
            let distance = |cell: usize| match (&self.pattern.cells, to) {
                (Cells::Rough(rough), Some(to)) => rough.regions[cell].distance(to),
                _ => self.pattern.distance(cell, point),
            };
            distance(other) - distance(own)
        });
        Some(if from > until { (from / (from - until)).clamp(0.0, 1.0) } else { 0.5 })
    }

    /// Signed distance [m] to the nearest of some cells, at the nodes of a part of the body's
    /// lattice.
    pub(crate) fn distances(&self, cells: &[u32], part: Grid) -> LevelSet {
        let (Cells::Rough(rough), Some(moved)) = (&self.pattern.cells, &self.moved) else {
            return LevelSet::sample(part, |point| {
                let point = self.placement.pattern_from_grid(point);
                let to = |&cell: &u32| self.pattern.distance(cell as usize, point);
                self.placement.scale * cells.iter().map(to).fold(f64::INFINITY, f64::min)
            });
        };
        let shift = self.grid.lattice_from_point(part.origin).to_array();
        let [x, y, z] = shift.map(|along| libm::round(along).max(0.0) as usize);
        let mut phi = vec![f32::INFINITY; part.len()];
        let mut own = vec![0.0; part.dims[0]];
        for (row, phi) in phi.chunks_mut(part.dims[0]).enumerate() {
            let first = self.grid.index(x, y + row % part.dims[1], z + row / part.dims[1]);
            for &cell in cells {
                rough.distances(cell as usize, moved, first, &mut own);
                for (phi, own) in phi.iter_mut().zip(&own) {
                    *phi = if own < phi { *own } else { *phi };
                }
            }
            phi.iter_mut().for_each(|phi| *phi *= self.placement.scale as f32);
        }
        LevelSet::new(part, phi)
    }
}
