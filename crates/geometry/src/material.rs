//! What of a grid's voxels is material, row by row in runs.

use crate::{Grid, LevelSet};

/// Consecutive nodes of a row whose voxels are filled alike.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Span {
    /// Number of the first node, along x.
    pub start: u32,
    /// One past the last.
    pub end: u32,
    /// Fraction of each voxel that is material, in [0, 1].
    pub coverage: f32,
    /// Whether the nodes are inside: their signed distance is at most zero.
    pub inside: bool,
}

impl Span {
    /// Whether a span behind this one goes on in the same way.
    fn continues_in(&self, next: &Self) -> bool {
        self.end == next.start && self.coverage == next.coverage && self.inside == next.inside
    }
}

/// The spans of all rows of a grid, a row being the nodes along x. Nodes in no span are outside and hold nothing.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    spans: Vec<Span>,
    /// Where each row begins in `spans`, and one more entry at the end.
    first_of_row: Vec<u32>,
}

impl Material {
    /// From the distance at each node and the fraction of its voxel that is material.
    pub fn from_nodes(level_set: &LevelSet, coverage: &[f32]) -> Self {
        let grid = level_set.grid();
        let width = grid.dims[0];
        let rows = level_set.phi().chunks(width).zip(coverage.chunks(width)).enumerate();
        let spans = rows.flat_map(|(row, (phi, coverage))| {
            let nodes = phi.iter().zip(coverage).zip(0..);
            nodes.filter_map(move |((&phi, &coverage), i)| {
                let inside = phi <= 0.0;
                (inside || coverage > 0.0).then_some((row, Span { start: i, end: i + 1, coverage, inside }))
            })
        });
        Self::from_rows(grid.dims[1] * grid.dims[2], spans)
    }

    /// From spans with their rows, in order; what goes on in the same way is joined.
    pub fn from_rows(rows: usize, spans: impl Iterator<Item = (usize, Span)>) -> Self {
        let mut material = Self { spans: Vec::new(), first_of_row: Vec::with_capacity(rows + 1) };
        for (row, span) in spans {
            if material.first_of_row.len() <= row {
                material.first_of_row.resize(row + 1, material.spans.len() as u32);
            } else if let Some(last) = material.spans.last_mut().filter(|last| last.continues_in(&span)) {
                last.end = span.end;
                continue;
            }
            material.spans.push(span);
        }
        material.first_of_row.resize(rows + 1, material.spans.len() as u32);
        material
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.first_of_row.len() - 1
    }

    /// The spans of one row, `j + dims[1] * k`.
    #[inline]
    pub fn row(&self, row: usize) -> &[Span] {
        &self.spans[self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize]
    }

    /// Number of spans in all rows.
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// Whether there is nothing.
    pub fn is_empty(&self) -> bool {
        self.spans.is_empty()
    }

    /// The fraction of each node's voxel, x fastest.
    pub fn coverage(&self, grid: &Grid) -> Vec<f32> {
        let mut coverage = vec![0.0; grid.len()];
        for (row, nodes) in coverage.chunks_mut(grid.dims[0]).enumerate() {
            for span in self.row(row) {
                nodes[span.start as usize..span.end as usize].fill(span.coverage);
            }
        }
        coverage
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use proptest::prelude::*;

    proptest! {
        /// Spans hold what the nodes held, each is as long as it can be, and only nodes with something are in one.
        #[test]
        fn spans_are_the_nodes(
            phi in prop::collection::vec(prop::sample::select(vec![-1.0f32, 0.0, 1.0]), 60),
            coverage in prop::collection::vec(prop::sample::select(vec![0.0f32, 0.25, 1.0]), 60),
        ) {
            let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims: [5, 4, 3] };
            let level_set = LevelSet::new(grid, phi);
            let material = Material::from_nodes(&level_set, &coverage);
            prop_assert_eq!(material.rows(), 12);
            prop_assert_eq!(&material.coverage(&grid), &coverage);
            let mut held = vec![false; 60];
            for row in 0..12 {
                let spans = material.row(row);
                prop_assert!(spans.windows(2).all(|pair| pair[0].end <= pair[1].start && !pair[0].continues_in(&pair[1])));
                for span in spans {
                    for i in span.start as usize..span.end as usize {
                        held[row * 5 + i] = true;
                        prop_assert_eq!(span.inside, level_set.phi()[row * 5 + i] <= 0.0);
                    }
                }
            }
            for (node, held) in held.into_iter().enumerate() {
                prop_assert_eq!(held, coverage[node] > 0.0 || level_set.phi()[node] <= 0.0);
            }
        }
    }
}
