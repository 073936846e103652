//! Consecutive nodes of a row, and what their voxels hold.

use serde::{Deserialize, Serialize};

/// Consecutive nodes of a row whose voxels are filled alike.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Span {
    /// Number of the first node, along x.
    pub start: u32,
    /// One past the last.
    pub end: u32,
    /// Fraction of each voxel that is material, in [0, 1].
    pub coverage: f32,
    /// True for inside nodes: signed distance at most zero.
    pub inside: bool,
}

impl Span {
    /// True if the next span continues this one unchanged.
    pub(crate) fn continues_in(&self, next: &Self) -> bool {
        self.end == next.start && self.coverage == next.coverage && self.inside == next.inside
    }
}

/// Consecutive nodes of a row, and what their voxels hold together.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// Numbers of its nodes along y and z.
    pub row: [u32; 2],
    /// Number of the first node, along x.
    pub start: u32,
    /// One past the last.
    pub end: u32,
    /// Number of inside nodes.
    pub inside: u32,
    /// Volume of the material and its first and second moments along x, which counts from the
    /// middle of the grid; the unit of length is the grid's spacing.
    pub moments: [f64; 3],
}

impl Run {
    /// No nodes yet, from `start` on.
    pub fn empty(row: [u32; 2], start: u32) -> Self {
        Self { row, start, end: start, inside: 0, moments: [0.0; 3] }
    }

    /// Adds a span of the same row, where the middle of the grid is `middle` nodes along x from the
    /// first one.
    #[inline]
    pub fn add(&mut self, span: &Span, middle: f64) {
        let count = span.end - span.start;
        self.end = span.end;
        self.inside += if span.inside { count } else { 0 };
        let place = 0.5 * f64::from(span.start + span.end - 1) - middle;
        let count = f64::from(count);
        let volume = count * f64::from(span.coverage);
        self.moments[0] += volume;
        self.moments[1] += volume * place;
        self.moments[2] += volume * (place * place + (count * count - 1.0) * (1.0 / 12.0));
    }

    /// True if nodes of a row, from `start` on, continue this run.
    pub(crate) fn is_followed_by(&self, row: [u32; 2], start: u32) -> bool {
        self.row == row && self.end == start
    }

    /// Sort key of runs: row along z and along y, then first node.
    #[inline]
    pub fn place(&self) -> [u32; 3] {
        [self.row[1], self.row[0], self.start]
    }

    /// Number of its row in a grid with `rows_y` of them along y.
    #[inline]
    pub fn number(&self, rows_y: usize) -> usize {
        self.row[0] as usize + rows_y * self.row[1] as usize
    }
}
