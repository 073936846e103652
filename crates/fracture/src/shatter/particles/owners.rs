//! Owners of the voxels around a point [Su09 sec. 4.2 "Surface Particles"].

use super::super::laid::Laid;
use crate::shatter::regions::intervals::NONE;
use frangible_geometry::{BodyFrame, Grid, GridSolid};
use glam::DVec3;

/// The piece of each node of a parent's grid.
pub(super) struct Owners {
    grid: Grid,
    pieces: Vec<u32>,
}

impl Owners {
    pub(super) fn new(parent: &GridSolid, pieces: &[(GridSolid, BodyFrame)]) -> Self {
        let grid = *parent.grid();
        let mut owners = vec![NONE; grid.len()];
        for ((solid, _), piece) in pieces.iter().zip(0..) {
            // All lie on one lattice.
            let shift = grid.lattice_from_point(solid.grid().origin);
            let [x, y, z] = shift.to_array().map(|along| libm::round(along) as i64);
            for run in solid.runs() {
                let row =
                    [i64::from(run.row[0]) + y, i64::from(run.row[1]) + z].map(|n| n as usize);
                let ends = [run.start, run.end].map(|end| (i64::from(end) + x) as usize);
                let first = grid.index(0, row[0], row[1]);
                owners[first + ends[0]..first + ends[1]].fill(piece);
            }
        }
        Self { grid, pieces: owners }
    }

    /// Visits where cracks cross the ways between neighbouring nodes of two pieces, with these: on
    /// every so many rows along each axis, and on all of them where three pieces meet or the body's
    /// surface is near.
    pub(super) fn for_each_crossing(
        &self,
        spacing: usize,
        laid: &Laid,
        mut visit: impl FnMut([u32; 2], DVec3),
    ) {
        let [nx, ny, _] = self.grid.dims;
        let strides = [1, nx, nx * ny];
        for (axis, stride) in strides.into_iter().enumerate() {
            let across = [strides[(axis + 1) % 3], strides[(axis + 2) % 3]];
            for node in 0..self.pieces.len().saturating_sub(stride) {
                let pieces = [self.pieces[node], self.pieces[node + stride]];
                if pieces[0] == pieces[1] || pieces.contains(&NONE) {
                    continue;
                }
                // The last node of a row is followed by another row's first.
                let low = self.grid.coordinates(node);
                if low[axis] + 1 == self.grid.dims[axis] {
                    continue;
                }
                let is_on_row =
                    [1, 2].iter().all(|turn| low[(axis + turn) % 3].is_multiple_of(spacing));
                let around = || {
                    let steps = [across[0], across[1], across[0] + across[1]];
                    steps.into_iter().flat_map(move |step| [node + step, node.wrapping_sub(step)])
                };
                let is_other =
                    |at: usize| self.pieces.get(at).is_none_or(|other| !pieces.contains(other));
                if !is_on_row
                    && !around().any(|at| is_other(at) || is_other(at.wrapping_add(stride)))
                {
                    continue;
                }
                let mut high = low;
                high[axis] += 1;
                if let Some(part) = laid.crossing([low, high]) {
                    let [from, to] = [low, high].map(|[i, j, k]| self.grid.node(i, j, k));
                    visit(pieces, from.lerp(to, part));
                }
            }
        }
    }

    /// The pieces of the voxels around a point, each once: of those whose nodes are at most a
    /// spacing away along each axis, or, if these are nobody's, two.
    pub(super) fn around(&self, point: DVec3) -> Vec<usize> {
        let at = self.grid.lattice_from_point(point).floor();
        for reach in 0..2 {
            let near = self.within(at, reach);
            if !near.is_empty() {
                return near;
            }
        }
        Vec::new()
    }

    fn within(&self, at: DVec3, reach: i64) -> Vec<usize> {
        let ends: [[usize; 2]; 3] = std::array::from_fn(|axis| {
            let last = self.grid.dims[axis] as i64 - 1;
            let here = (at[axis] as i64).clamp(-reach, last + reach);
            [here - reach, here + 1 + reach].map(|end| end.clamp(0, last) as usize)
        });
        let [[x, to_x], [y, to_y], [z, to_z]] = ends;
        let mut near = Vec::new();
        for (k, j) in (z..=to_z).flat_map(|k| (y..=to_y).map(move |j| (k, j))) {
            for i in x..=to_x {
                let piece = self.pieces[self.grid.index(i, j, k)];
                if piece != NONE && !near.contains(&(piece as usize)) {
                    near.push(piece as usize);
                }
            }
        }
        near.sort_unstable();
        near
    }
}
