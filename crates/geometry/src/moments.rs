//! The sums over a solid's material, and over parts of it.

use crate::grid::Grid;
use crate::mass_properties::{MassProperties, inertia_from_second_moments, outer};
use crate::runs::Run;
use glam::{DMat3, DVec3};

/// Moments of material in voxels, in units of the spacing and of full voxels, about the origin of
/// the points that go in.
///
/// Additive: the sums over the parts of a partition of the voxels give the sums over the whole, so
/// that mass, momentum, angular momentum and kinetic energy are equal before and after a break.
/// Sums over full voxels at whole or half places are exact: a symmetric body's moments are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct VoxelMoments {
    pub(crate) volume: f64,
    /// Volume times position.
    pub(crate) first: DVec3,
    /// Volume times x x, y y, z z of the voxels' middles.
    pub(crate) squares: DVec3,
    /// Volume times x y, y z, z x.
    pub(crate) products: DVec3,
}

impl VoxelMoments {
    /// Of nothing.
    pub(crate) const ZERO: Self =
        Self { volume: 0.0, first: DVec3::ZERO, squares: DVec3::ZERO, products: DVec3::ZERO };

    /// Adds voxels along x at some y and z: the sums of their coverage, and of coverage times x and
    /// times x^2.
    #[inline]
    pub(crate) fn add_row(&mut self, [y, z]: [f64; 2], [volume, along, square]: [f64; 3]) {
        let (along_y, along_z) = (volume * y, volume * z);
        self.volume += volume;
        self.first += DVec3::new(along, along_y, along_z);
        self.squares += DVec3::new(square, along_y * y, along_z * z);
        self.products += DVec3::new(along * y, along_y * z, along * z);
    }

    /// Adds those of other voxels about the same origin.
    fn merge(&mut self, other: &Self) {
        self.volume += other.volume;
        self.first += other.first;
        self.squares += other.squares;
        self.products += other.products;
    }

    /// Adds neighbouring rows' voxels: the sums as in [`Self::add_row`], and those of coverage
    /// times `r`, times `r^2`, and times `x r`, where `r` counts from the row at y.
    fn add_rows(&mut self, [y, z]: [f64; 2], rows: &RowSums) {
        let RowSums { along: [volume, along, square], across: [first, second, mixed], .. } = *rows;
        let (along_y, along_z) = (volume * y + first, volume * z);
        self.volume += volume;
        self.first += DVec3::new(along, along_y, along_z);
        self.squares += DVec3::new(square, second + y * (first + along_y), along_z * z);
        self.products += DVec3::new(along * y + mixed, along_y * z, along * z);
    }

    /// Mass properties about the centre of mass, in the frame in which the moments' origin is at
    /// `origin` [m], of voxels of edge `spacing` [m], each with the self-inertia of a cube (h^2/6
    /// on the diagonal per unit mass). Without volume, the centre is the origin.
    pub(crate) fn mass_properties(&self, origin: DVec3, spacing: f64) -> MassProperties {
        if self.volume <= 0.0 {
            return MassProperties { volume: 0.0, center: origin, inertia: DMat3::ZERO };
        }
        let center = self.first / self.volume;
        let own = DMat3::from_diagonal(DVec3::splat(self.volume / 12.0));
        let second = DMat3::from_cols(
            DVec3::new(self.squares.x, self.products.x, self.products.z),
            DVec3::new(self.products.x, self.squares.y, self.products.y),
            DVec3::new(self.products.z, self.products.y, self.squares.z),
        );
        let inertia = inertia_from_second_moments(second - outer(self.first, center) + own);
        let voxel = spacing * spacing * spacing;
        MassProperties {
            volume: self.volume * voxel,
            center: origin + spacing * center,
            inertia: inertia * (voxel * spacing * spacing),
        }
    }
}

/// Content of runs of a grid, and their bounding box.
#[derive(Clone, Copy, Debug)]
pub struct RunSums {
    grid: Grid,
    /// Of the middle of the grid along y and z, in units of the spacing.
    middle: [f64; 2],
    moments: VoxelMoments,
    has_inside: bool,
    /// Lowest and highest node.
    low: [f64; 3],
    high: [f64; 3],
}

impl RunSums {
    /// Of none yet.
    pub fn new(grid: &Grid) -> Self {
        // Positions count from the middle of the grid: squares of a far origin's coordinates would
        // cancel.
        let [_, y, z] = grid.dims.map(|n| 0.5 * (n - 1) as f64);
        Self {
            grid: *grid,
            middle: [y, z],
            moments: VoxelMoments::ZERO,
            has_inside: false,
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
        }
    }

    /// Sums over runs of a grid.
    pub(crate) fn of(grid: &Grid, runs: &[Run]) -> Self {
        let mut sums = Self::new(grid);
        runs.iter().for_each(|run| sums.add(run));
        sums
    }

    /// Adds a run.
    #[inline]
    pub fn add(&mut self, run: &Run) {
        let [y, z] = run.row.map(f64::from);
        let [start, end] = [run.start, run.end].map(f64::from);
        self.moments.add_row([y - self.middle[0], z - self.middle[1]], run.moments);
        self.has_inside |= run.inside > 0;
        self.stretch([start, y, z], [end - 1.0, y, z]);
    }

    /// Adds runs of neighbouring rows, which are counted from row j on.
    #[inline]
    pub fn add_rows(&mut self, [j, k]: [usize; 2], rows: &RowSums) {
        let [y, z] = [j, k].map(|row| row as f64);
        self.moments.add_rows([y - self.middle[0], z - self.middle[1]], rows);
        self.has_inside |= rows.inside > 0;
        self.stretch([rows.ends[0], y + rows.rows[0], z], [rows.ends[1], y + rows.rows[1], z]);
    }

    /// Adds other runs of the same grid.
    pub fn merge(&mut self, other: &Self) {
        self.moments.merge(&other.moments);
        self.has_inside |= other.has_inside;
        self.stretch(other.low, other.high);
    }

    #[inline]
    fn stretch(&mut self, low: [f64; 3], high: [f64; 3]) {
        for axis in 0..3 {
            self.low[axis] = if low[axis] < self.low[axis] { low[axis] } else { self.low[axis] };
            self.high[axis] =
                if high[axis] > self.high[axis] { high[axis] } else { self.high[axis] };
        }
    }

    /// Material [voxels].
    pub fn material(&self) -> f64 {
        self.moments.volume
    }

    /// True if any node is inside.
    pub fn has_inside(&self) -> bool {
        self.has_inside
    }

    /// Lowest and highest node; all zero of nothing.
    pub(crate) fn nodes(&self) -> [[usize; 3]; 2] {
        [self.low, self.high]
            .map(|corner| corner.map(|n| if n.is_finite() { n as usize } else { 0 }))
    }

    /// Of all that was added, in the grid's frame.
    pub(crate) fn mass_properties(&self) -> MassProperties {
        let (low, high) = self.grid.bounds();
        self.moments.mass_properties(0.5 * (low + high), self.grid.spacing)
    }
}

/// Content of runs of neighbouring rows.
#[derive(Clone, Copy, Debug)]
pub struct RowSums {
    /// Nodes inside.
    inside: u32,
    /// Lowest and highest node along x, and lowest and highest row.
    ends: [f64; 2],
    rows: [f64; 2],
    /// Sums of the runs' moments.
    along: [f64; 3],
    /// Sums of volume times row and row^2, and of first moment times row.
    across: [f64; 3],
}

impl RowSums {
    /// Of none yet.
    pub const NONE: Self = Self {
        inside: 0,
        ends: [f64::INFINITY, f64::NEG_INFINITY],
        rows: [f64::INFINITY, f64::NEG_INFINITY],
        along: [0.0; 3],
        across: [0.0; 3],
    };

    /// Adds the run of a row, in order of the rows, that goes from one node to another.
    #[inline]
    pub fn add(&mut self, row: f64, [first, last]: [f64; 2], run: &Run) {
        let [volume, along, square] = run.moments;
        let [own_volume, own_along, own_square] = self.along;
        let [own_first, own_second, own_mixed] = self.across;
        self.inside += run.inside;
        self.ends = [
            if first < self.ends[0] { first } else { self.ends[0] },
            if last > self.ends[1] { last } else { self.ends[1] },
        ];
        self.rows = [if row < self.rows[0] { row } else { self.rows[0] }, row];
        self.along = [own_volume + volume, own_along + along, own_square + square];
        let across = volume * row;
        self.across = [own_first + across, own_second + across * row, own_mixed + along * row];
    }
}

/// A part of a solid's material: runs, in order, and what they hold together.
#[derive(Clone, Debug)]
pub struct Portion {
    /// On the solid's grid.
    pub runs: Vec<Run>,
    /// Of all runs.
    pub sums: RunSums,
}

impl Portion {
    /// Empty sums of a grid, with capacity for `runs`.
    pub fn with_capacity(grid: &Grid, runs: usize) -> Self {
        Self { runs: Vec::with_capacity(runs), sums: RunSums::new(grid) }
    }

    /// Adds a run behind all others.
    #[inline]
    pub fn push(&mut self, run: Run) {
        self.sums.add(&run);
        self.runs.push(run);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Sums of neighbouring rows equal the sums of their runs.
        #[test]
        fn rows_together_hold_what_each_does(
            runs in prop::collection::vec((0..30_u32, 1..9_u32, 0.0..1.0_f64, 0..3_u32), 1..8),
            (first_row, z) in (0..40_usize, 0..50_usize),
        ) {
            let grid = Grid { origin: DVec3::new(0.3, -7.0, 2.0), spacing: 0.5, dims: [40, 50, 60] };
            let (mut each, mut together, mut rows) = (RunSums::new(&grid), RunSums::new(&grid), RowSums::NONE);
            for (row, (start, length, coverage, inside)) in (0_u32..).zip(runs) {
                let (y, count) = (first_row as u32 + row, f64::from(length));
                let place = f64::from(start) + 0.5 * (count - 1.0) - grid.middle_along_x();
                let square = place * place + (count * count - 1.0) / 12.0;
                let moments = [1.0, place, square].map(|moment| count * coverage * moment);
                let run = Run { row: [y, z as u32], start, end: start + length, inside, moments };
                each.add(&run);
                rows.add(f64::from(row), [start, start + length - 1].map(f64::from), &run);
            }
            together.add_rows([first_row, z], &rows);
            prop_assert_eq!(each.nodes(), together.nodes());
            prop_assert_eq!(each.has_inside(), together.has_inside());
            let (a, b) = (each.mass_properties(), together.mass_properties());
            prop_assert!((a.volume - b.volume).abs() < 1e-12 && (a.center - b.center).length() < 1e-10);
            prop_assert!((a.inertia - b.inertia).abs_diff_eq(DMat3::ZERO, 1e-9), "{a:?} {b:?}");
        }
    }
}
