//! A pattern of cells of any form, laid onto the nodes of a body once for all of its pieces
//! [Su09 sec. 4.2].

use crate::pattern::{Cells, Pattern};
use crate::placement::Placement;
use crate::reach::{Reach, Rim};
use crate::rough::Moved;
use frangible_geometry::{Grid, GridSolid, HalfSpace, LevelSet};
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
    end: Option<End>,
}

/// Where a pattern ends on a body: what is beyond is one more cell.
enum End {
    /// Beyond any of these planes, in the grid frame.
    Bowl(Vec<HalfSpace>),
    /// In cells that do not come loose.
    Cells {
        /// For each cell of the pattern.
        is_loose: Vec<bool>,
    },
}

impl<'a> Laid<'a> {
    pub(crate) fn new(pattern: &'a Pattern, placement: Placement, body: &GridSolid) -> Self {
        let grid = body.grid().widened(GridSolid::MARGIN);
        let moved = match &pattern.cells {
            Cells::Rough(rough) => Some(rough.moved(&placement, &grid, pattern.half_extent)),
            Cells::Planar(_) | Cells::Drawn(_) => None,
        };
        Self { pattern, placement, grid, moved, end: None }
    }

    /// Leaves what is out of reach of a blow to one more cell.
    pub(crate) fn end_at(&mut self, reach: &Reach, body: &GridSolid) {
        self.end = Some(match reach.rim {
            Rim::Bowl => End::Bowl(reach.bowl(&self.placement)),
            Rim::Cells => {
                let centers = self.centers(body);
                let away = |center: &Option<DVec3>| {
                    center.map_or(f64::INFINITY, |at| at.distance(self.placement.point_grid))
                };
                let mut is_loose: Vec<bool> =
                    centers.iter().map(|center| away(center) <= reach.distance).collect();
                let struck = self.pattern_cell_at(self.placement.point_grid) as usize;
                if let Some(struck) = is_loose.get_mut(struck) {
                    *struck = true;
                }
                End::Cells { is_loose }
            }
        });
    }

    /// Number of cells, with what is out of reach.
    pub(crate) fn cells(&self) -> usize {
        self.pattern.len() + usize::from(self.end.is_some())
    }

    /// The cell of what is out of reach, if there is one.
    pub(crate) fn rest(&self) -> Option<u32> {
        self.end.is_some().then_some(self.pattern.len() as u32)
    }

    /// Mean of the nodes of a body in each cell of the pattern.
    fn centers(&self, body: &GridSolid) -> Vec<Option<DVec3>> {
        let mut sums = vec![(0.0, DVec3::ZERO); self.pattern.len()];
        let grid = body.grid();
        for row in 0..body.material().rows() {
            let place = [row % grid.dims[1], row / grid.dims[1]];
            for span in body.material().row(row) {
                let mut i = span.start as usize;
                self.pattern_cells_along(place, i..span.end as usize, |cell| {
                    let sum = &mut sums[cell as usize];
                    sum.0 += f64::from(span.coverage);
                    sum.1 += f64::from(span.coverage) * grid.node(i, place[0], place[1]);
                    i += 1;
                });
            }
        }
        sums.into_iter().map(|(weight, sum)| (weight > 0.0).then(|| sum / weight)).collect()
    }

    /// The cell of a point that lies in this one of the pattern's.
    fn ended(&self, cell: u32, point: DVec3) -> u32 {
        match &self.end {
            Some(End::Bowl(facets)) if beyond(facets, point) > 0.0 => self.pattern.len() as u32,
            Some(End::Cells { is_loose }) if !is_loose[cell as usize] => self.pattern.len() as u32,
            _ => cell,
        }
    }

    /// Signed distance to a cell at a point [m], by those to cells of the pattern.
    fn ended_distance(&self, cell: u32, point: DVec3, to: impl Fn(usize) -> f64) -> f64 {
        let is_rest = Some(cell) == self.rest();
        match &self.end {
            Some(End::Bowl(facets)) if is_rest => -beyond(facets, point),
            Some(End::Bowl(facets)) => to(cell as usize).max(beyond(facets, point)),
            Some(End::Cells { is_loose }) if is_rest => {
                let loose = (0..is_loose.len()).filter(|&cell| is_loose[cell]);
                -loose.map(to).fold(f64::INFINITY, f64::min)
            }
            _ => to(cell as usize),
        }
    }

    /// The cell that a point of the grid frame [m] lies in.
    pub(crate) fn cell_at(&self, point: DVec3) -> u32 {
        self.ended(self.pattern_cell_at(point), point)
    }

    /// The pattern's cell at a point of the grid frame [m].
    fn pattern_cell_at(&self, point: DVec3) -> u32 {
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
        let (margin, mut i) = (GridSolid::MARGIN, nodes.start);
        self.pattern_cells_along([j, k], nodes, |cell| {
            found(self.ended(cell, self.grid.node(i + margin, j + margin, k + margin)));
            i += 1;
        });
    }

    /// The same of the pattern's cells.
    fn pattern_cells_along(
        &self,
        [j, k]: [usize; 2],
        nodes: Range<usize>,
        mut found: impl FnMut(u32),
    ) {
        let margin = GridSolid::MARGIN;
        let [j, k] = [j + margin, k + margin];
        let (Cells::Rough(rough), Some(moved)) = (&self.pattern.cells, &self.moved) else {
            nodes.for_each(|i| found(self.pattern_cell_at(self.grid.node(i + margin, j, k))));
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
            let place = self.grid.node(i, j, k);
            let point = self.placement.pattern_from_grid(place);
            let to = self.moved.as_ref().map(|moved| moved.place(self.grid.index(i, j, k)));
            (place, point, to)
        });
        let cell = |(place, point, to): (DVec3, DVec3, Option<DVec3>)| {
            let cell = match (&self.pattern.cells, to) {
                (Cells::Rough(rough), Some(to)) => {
                    rough.nearest(point, to, self.pattern.half_extent)[0].0
                }
                _ => self.pattern.region_at(point).unwrap_or(0),
            };
            self.ended(cell as u32, place)
        };
        let [own, other] = nodes.map(cell);
        if own == other {
            return None;
        }
        // Difference of the distances to the second and to the first cell.
        let [from, until] = nodes.map(|(place, point, to)| {
            let to_cell = |cell: usize| match (&self.pattern.cells, to) {
                (Cells::Rough(rough), Some(to)) => rough.regions[cell].distance(to),
                _ => self.pattern.distance(cell, point),
            };
            let distance = |cell: u32| match &self.end {
                None => to_cell(cell as usize),
                Some(_) => {
                    self.ended_distance(cell, place, |cell| self.placement.scale * to_cell(cell))
                }
            };
            distance(other) - distance(own)
        });
        Some(if from > until { (from / (from - until)).clamp(0.0, 1.0) } else { 0.5 })
    }

    /// Signed distance [m] to some cells together, at the nodes of a part of the body's lattice:
    /// half of how much nearer they are than the others. Cracks between them are no surface.
    pub(crate) fn distances_to_union(&self, is_own: &[bool], part: Grid) -> LevelSet {
        let scale = 0.5 * self.placement.scale;
        LevelSet::sample(part, |place| {
            let point = self.placement.pattern_from_grid(place);
            let [own, other] = self.pattern.distances_to(is_own, point);
            scale * (own - other)
        })
    }

    /// Signed distance [m] to the nearest of some cells, at the nodes of a part of the body's
    /// lattice.
    pub(crate) fn distances(&self, cells: &[u32], part: Grid) -> LevelSet {
        if self.end.is_some() {
            return LevelSet::sample(part, |place| {
                let point = self.placement.pattern_from_grid(place);
                let to_cell =
                    |cell: usize| self.placement.scale * self.pattern.distance(cell, point);
                let to = |&cell: &u32| self.ended_distance(cell, place, to_cell);
                cells.iter().map(to).fold(f64::INFINITY, f64::min)
            });
        }
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

/// Largest signed distance to planes [m], negative inside of all.
fn beyond(planes: &[HalfSpace], point: DVec3) -> f64 {
    planes.iter().map(|plane| plane.distance(point)).fold(f64::NEG_INFINITY, f64::max)
}
