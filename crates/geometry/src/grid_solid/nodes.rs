//! Distances of a solid on a grid at its own nodes, sampled from what it was clipped from.

use crate::grid_solid::GridSolid;
use crate::level_set::LevelSet;
use crate::outline_clip::{RowScratch, larger};

/// At nodes where another fragment's inside would read as this one's: the least distance, in units
/// of the spacing. Large enough to be seen in f32, too small to move a surface.
const OUTSIDE: f64 = 1e-3;

impl GridSolid {
    /// Distances at the nodes of the grid: the largest one of the field's, the parts' and `cell`'s.
    /// Own nodes are inside if they were inside of the field. Nodes of others are not: of another
    /// component of the same region, or of what a sliver was cut off from.
    pub(super) fn sample_nodes(&self, cell: Option<&LevelSet>) -> LevelSet {
        let [width, rows_y, rows_z] = self.grid.dims;
        let [on_crack, half_cell] = [OUTSIDE, 0.5].map(|part| (part * self.grid.spacing) as f32);
        let mut phi = Vec::with_capacity(self.grid.len());
        let mut scratch = RowScratch::default();
        let mut region = vec![0.0; width];
        for row in 0..rows_y * rows_z {
            let [j, k] = [row % rows_y, row / rows_y];
            let start = self.grid.node(0, j, k);
            region.fill(if self.parts.is_empty() { f32::NEG_INFINITY } else { f32::INFINITY });
            for part in &self.parts {
                part.lower_row(start, self.grid.spacing, &mut scratch, &mut region);
            }
            let first = phi.len();
            if let Some(cell) = cell {
                let of_cell = &cell.phi()[row * width..(row + 1) * width];
                for (region, &of_cell) in region.iter_mut().zip(of_cell) {
                    *region = larger(*region, of_cell);
                }
            }
            match self.row_of_field([j, k]) {
                Some(of_field) => {
                    phi.extend(
                        of_field.iter().zip(&region).map(|(&field, &region)| larger(field, region)),
                    );
                }
                None => {
                    let nodes = region.iter().enumerate();
                    phi.extend(nodes.map(|(i, &region)| larger(self.field_at([i, j, k]), region)));
                }
            }

            // Signs by ownership.
            let mut next = 0;
            for span in self.material().row(row) {
                let own = span.start as usize..span.end as usize;
                force_outside(&mut phi[first + next..first + own.start], on_crack, half_cell);
                next = own.end;
                if span.inside {
                    for phi in &mut phi[first + own.start..first + own.end] {
                        *phi = phi.min(0.0);
                    }
                }
            }
            force_outside(&mut phi[first + next..first + width], on_crack, half_cell);
        }
        LevelSet::new(self.grid, phi)
    }

    /// The field's distances [m] at a row of the grid's nodes, if all of them are the field's.
    fn row_of_field(&self, row: [usize; 2]) -> Option<&[f32]> {
        let field = self.field.grid();
        let place = |node: usize, axis: usize| usize::try_from(node as i64 + self.shift[axis]).ok();
        let (i, j, k) = (place(0, 0)?, place(row[0], 1)?, place(row[1], 2)?);
        let is_inside =
            i + self.grid.dims[0] <= field.dims[0] && j < field.dims[1] && k < field.dims[2];
        let first = is_inside.then(|| field.index(i, j, k))?;
        Some(&self.field.phi()[first..first + self.grid.dims[0]])
    }

    /// The field's distance at a node of the grid [m]; beyond its lattice the value at the nearest
    /// node and the way to it.
    #[inline]
    fn field_at(&self, node: [usize; 3]) -> f32 {
        let dims = self.field.grid().dims;
        let at: [i64; 3] = std::array::from_fn(|axis| node[axis] as i64 + self.shift[axis]);
        let nearest: [i64; 3] =
            std::array::from_fn(|axis| at[axis].clamp(0, dims[axis] as i64 - 1));
        let value = self.field.at(nearest[0] as usize, nearest[1] as usize, nearest[2] as usize);
        if at == nearest {
            return value;
        }
        let square: i64 =
            at.iter().zip(nearest).map(|(at, nearest)| (at - nearest) * (at - nearest)).sum();
        value + ((square as f64).sqrt() * self.grid.spacing) as f32
    }
}

/// Makes nodes of other pieces outside: barely on a crack, else by at least half a cell. Two pieces
/// without a crack between them then meet halfway between their nodes.
fn force_outside(phi: &mut [f32], on_crack: f32, half_cell: f32) {
    for phi in phi {
        if *phi <= -on_crack {
            *phi = larger(-*phi, half_cell);
        } else if *phi <= 0.0 {
            *phi = on_crack;
        }
    }
}
