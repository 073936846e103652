//! Material of a grid's voxels, row by row in runs.

use crate::grid::Grid;
use crate::level_set::LevelSet;
use crate::mass_properties::MassProperties;
use crate::moments::{Portion, RunSums};
use crate::run_core::RunCore;
use crate::runs::Run;
use crate::runs::Span;
use frangible_math::check::{Check, Checked, finite, require};
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

/// Some of a solid's material, in runs: what is asked for is copied onto the holder's own grid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(crate) struct Held {
    /// In order; on the source's grid.
    taken: Vec<Run>,
    /// Of all runs, in the holder's grid frame.
    pub(crate) mass: MassProperties,
    #[serde(with = "frangible_math::shared")]
    source: Arc<VoxelRuns>,
    /// True for all of the source, on its own grid.
    is_all: bool,
    /// The first node of the holder's grid on the source's, and how many rows both have along y.
    shift: [i64; 3],
    rows_y: [usize; 2],
    rows: usize,
    /// Offset along x of the holder's grid middle from the source's.
    ahead: f64,
    #[serde(skip)]
    own: OnceLock<Arc<VoxelRuns>>,
    #[serde(skip)]
    moved: OnceLock<Vec<Run>>,
    #[serde(skip)]
    cores: OnceLock<Vec<RunCore>>,
}

impl Held {
    /// Whether all runs lie on the holder's grid and on the source's.
    pub(crate) fn check(&self, grid: &Grid) -> Checked {
        self.mass.check()?;
        let is_near = |n: i64| n.unsigned_abs() <= Grid::MOST_NODES as u64;
        require(self.shift.iter().all(|&n| is_near(n)), "runs near the grid")?;
        finite(self.ahead)?;
        let [rows_y, source_rows_y] = self.rows_y;
        let is_own = rows_y == grid.dims[1] && self.rows == grid.dims[1] * grid.dims[2];
        require(is_own, "runs of the grid's rows")?;
        if self.is_all {
            let is_whole = self.shift == [0; 3] && self.ahead == 0.0 && source_rows_y == rows_y;
            let holds = self.rows == self.source.rows() && self.source.width() <= grid.dims[0];
            require(is_whole && holds, "runs of all of the source")?;
        }
        let mut last = None;
        for run in &self.taken {
            let on_source = (run.row[0] as usize) < source_rows_y
                && run.number(source_rows_y) < self.source.rows()
                && run.start < run.end;
            let [along, across, up] = self.shift;
            let within = |n: u32, shift: i64, most: usize| {
                let at = i64::from(n).checked_sub(shift);
                at.is_some_and(|at| (0..most as i64).contains(&at))
            };
            let on_grid = within(run.start, along, grid.dims[0])
                && within(run.end.saturating_sub(1), along, grid.dims[0])
                && within(run.row[0], across, grid.dims[1])
                && within(run.row[1], up, grid.dims[2]);
            require(on_source && on_grid, "runs on the grid and in the source")?;
            let follows = last.is_none_or(|(place, end)| {
                let [z, y, start] = run.place();
                (place < [z, y]) || (place == [z, y] && end <= start)
            });
            require(follows && run.inside <= run.end - run.start, "runs in order")?;
            run.moments.into_iter().try_for_each(finite)?;
            last = Some(([run.row[1], run.row[0]], run.end));
        }
        Ok(())
    }
}

impl Check for VoxelRuns {
    fn check(&self) -> Checked {
        let rows = &self.first_of_row;
        let is_whole = rows.first() == Some(&0) && rows.last() == Some(&(self.spans.len() as u32));
        require(is_whole && rows.is_sorted(), "rows of all spans")?;
        let is_span = |span: &Span| span.start < span.end && (0.0..=1.0).contains(&span.coverage);
        require(self.spans.iter().all(is_span), "spans with nodes, at most full")?;
        let in_order =
            |row: usize| self.row(row).windows(2).all(|pair| pair[0].end <= pair[1].start);
        require((0..self.rows()).all(in_order), "spans in order")
    }
}

impl Held {
    /// All of a grid's material.
    pub(crate) fn all(grid: &Grid, material: VoxelRuns) -> Self {
        let middle = grid.middle_along_x();
        let mut runs: Vec<Run> = Vec::new();
        for row in 0..material.rows() {
            for span in material.row(row) {
                let place = [row % grid.dims[1], row / grid.dims[1]].map(|n| n as u32);
                match runs.last_mut().filter(|run| run.is_followed_by(place, span.start)) {
                    Some(run) => run.add(span, middle),
                    None => {
                        let mut run = Run::empty(place, span.start);
                        run.add(span, middle);
                        runs.push(run);
                    }
                }
            }
        }
        let source = Arc::new(material);
        let held = Self {
            mass: RunSums::of(grid, &runs).mass_properties(),
            is_all: true,
            rows_y: [grid.dims[1]; 2],
            rows: source.rows(),
            taken: runs,
            source,
            shift: [0; 3],
            ahead: 0.0,
            own: OnceLock::new(),
            moved: OnceLock::new(),
            cores: OnceLock::new(),
        };
        held.cores(grid);
        held
    }

    /// A portion of it, on a grid whose first node is `from` here.
    pub(crate) fn part(
        &self,
        portion: Portion,
        from: [i64; 3],
        (grid, own): (&Grid, &Grid),
    ) -> Self {
        Self {
            taken: portion.runs,
            mass: portion.sums.mass_properties(),
            source: self.material().clone(),
            is_all: false,
            shift: from,
            rows_y: [own.dims[1], grid.dims[1]],
            rows: own.dims[1] * own.dims[2],
            ahead: 0.5 * (own.dims[0] as f64 - grid.dims[0] as f64) + from[0] as f64,
            own: OnceLock::new(),
            moved: OnceLock::new(),
            cores: OnceLock::new(),
        }
    }

    /// In order, on the grid that they were taken from, and the first node of the holder's grid
    /// there.
    pub(crate) fn taken(&self) -> (&[Run], [i64; 3]) {
        (&self.taken, self.shift)
    }

    /// In order; on the holder's own grid.
    pub(crate) fn runs(&self) -> &[Run] {
        if self.shift == [0; 3] && self.ahead == 0.0 {
            return &self.taken;
        }
        self.moved.get_or_init(|| self.taken.iter().map(|run| self.moved(run)).collect())
    }

    /// A run of the source's grid, on the holder's own.
    fn moved(&self, run: &Run) -> Run {
        let along = |i: u32| (i64::from(i) - self.shift[0]) as u32;
        let across = |axis: usize| (i64::from(run.row[axis]) - self.shift[axis + 1]) as u32;
        // Offsets from a grid's middle shrink by the distance between both middles.
        let [volume, first, second] = run.moments;
        let ahead = self.ahead;
        Run {
            row: [across(0), across(1)],
            start: along(run.start),
            end: along(run.end),
            inside: run.inside,
            moments: [
                volume,
                first - ahead * volume,
                second + ahead * (ahead * volume - 2.0 * first),
            ],
        }
    }

    /// Where most cuts go through each run, on the holder's grid; made when something breaks that
    /// is itself a piece.
    pub(crate) fn cores(&self, grid: &Grid) -> &[RunCore] {
        self.cores.get_or_init(|| {
            let material = self.material();
            let runs = self.runs();
            let mut cores = Vec::with_capacity(runs.len());
            cores.extend(runs.iter().map(|run| {
                let of_row = material.row(run.number(grid.dims[1]));
                let first = of_row.partition_point(|span| span.end <= run.start);
                let after = of_row.partition_point(|span| span.start < run.end);
                RunCore::of(run, &of_row[first..after], grid.middle_along_x())
            }));
            cores
        })
    }

    /// In spans, of the holder's grid.
    pub(crate) fn material(&self) -> &Arc<VoxelRuns> {
        if self.is_all {
            return &self.source;
        }
        self.own.get_or_init(|| {
            let [rows_y, source_rows_y] = self.rows_y;
            let spans = self.taken.iter().flat_map(|run| {
                let row = self.moved(run).number(rows_y);
                let along = |i: u32| (i64::from(i) - self.shift[0]) as u32;
                let cut = move |span: &Span| {
                    let (start, end) = (span.start.max(run.start), span.end.min(run.end));
                    (start < end)
                        .then(|| (row, Span { start: along(start), end: along(end), ..*span }))
                };
                self.source.row(run.number(source_rows_y)).iter().filter_map(cut)
            });
            Arc::new(VoxelRuns::from_rows(self.rows, spans))
        })
    }
}

/// The spans of all rows of a grid, a row being the nodes along x. Nodes in no span are outside and
/// hold nothing.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct VoxelRuns {
    spans: Vec<Span>,
    /// Where each row begins in `spans`, and one more entry at the end.
    first_of_row: Vec<u32>,
}

impl VoxelRuns {
    /// From the distance at each node and the fraction of its voxel that is material.
    pub(crate) fn from_nodes(level_set: &LevelSet, coverage: &[f32]) -> Self {
        let grid = level_set.grid();
        let width = grid.dims[0];
        let rows = level_set.phi().chunks(width).zip(coverage.chunks(width)).enumerate();
        let spans = rows.flat_map(|(row, (phi, coverage))| {
            let nodes = phi.iter().zip(coverage).zip(0..);
            nodes.filter_map(move |((&phi, &coverage), i)| {
                let inside = phi <= 0.0;
                (inside || coverage > 0.0)
                    .then_some((row, Span { start: i, end: i + 1, coverage, inside }))
            })
        });
        Self::from_rows(grid.dims[1] * grid.dims[2], spans)
    }

    /// From spans with their rows, in order; what goes on in the same way is joined.
    pub(crate) fn from_rows(rows: usize, spans: impl Iterator<Item = (usize, Span)>) -> Self {
        let mut material = Self { spans: Vec::new(), first_of_row: Vec::with_capacity(rows + 1) };
        for (row, span) in spans {
            if material.first_of_row.len() <= row {
                material.first_of_row.resize(row + 1, material.spans.len() as u32);
            } else if let Some(last) =
                material.spans.last_mut().filter(|last| last.continues_in(&span))
            {
                last.end = span.end;
                continue;
            }
            material.spans.push(span);
        }
        material.first_of_row.resize(rows + 1, material.spans.len() as u32);
        material
    }

    /// One past the last node of any row.
    fn width(&self) -> usize {
        self.spans.iter().fold(0, |width, span| width.max(span.end as usize))
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.first_of_row.len() - 1
    }

    /// Spans of one row, `j + dims[1] * k`.
    #[inline]
    pub fn row(&self, row: usize) -> &[Span] {
        &self.spans[self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize]
    }

    /// Number of spans in all rows.
    pub fn len(&self) -> usize {
        self.spans.len()
    }

    /// True without material.
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
        /// A part on a grid of its own has the content of its runs in the whole, moments included.
        #[test]
        fn runs_of_a_part_are_those_of_its_spans(
            phi in prop::collection::vec(prop::sample::select(vec![-1.0f32, 1.0]), 60),
            coverage in prop::collection::vec(prop::sample::select(vec![0.0f32, 0.25, 1.0]), 60),
            (low, high) in (0..3u32, 3..6u32),
        ) {
            let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims: [5, 4, 3] };
            let material = VoxelRuns::from_nodes(&LevelSet::new(grid, phi), &coverage);
            let whole = Held::all(&grid, material.clone());
            let mut share = Vec::new();
            for run in whole.runs() {
                let mut cut = Run::empty(run.row, run.start.max(low));
                for span in material.row(run.number(4)) {
                    let nodes = span.start.max(cut.start)..span.end.min(run.end).min(high);
                    if nodes.start < nodes.end {
                        cut.add(&Span { start: nodes.start, end: nodes.end, ..*span }, grid.middle_along_x());
                    }
                }
                share.extend((cut.start < cut.end).then_some(cut));
            }
            let own = Grid { dims: [10, 7, 6], ..grid };
            let portion = Portion { sums: RunSums::of(&grid, &share), runs: share };
            let part = whole.part(portion, [-2, -1, -3], (&grid, &own));
            let again = Held::all(&own, part.material().as_ref().clone());
            prop_assert_eq!(part.runs().len(), again.runs().len());
            for (a, b) in part.runs().iter().zip(again.runs()) {
                prop_assert_eq!((a.row, a.start, a.end, a.inside), (b.row, b.start, b.end, b.inside));
                for (a, b) in a.moments.iter().zip(b.moments) {
                    prop_assert!((a - b).abs() < 1e-12, "{} {}", a, b);
                }
            }
        }

        /// Spans have the content of their nodes, are maximal, and only nodes with content are in
        /// spans.
        #[test]
        fn spans_are_the_nodes(
            phi in prop::collection::vec(prop::sample::select(vec![-1.0f32, 0.0, 1.0]), 60),
            coverage in prop::collection::vec(prop::sample::select(vec![0.0f32, 0.25, 1.0]), 60),
        ) {
            let grid = Grid { origin: DVec3::ZERO, spacing: 1.0, dims: [5, 4, 3] };
            let level_set = LevelSet::new(grid, phi);
            let material = VoxelRuns::from_nodes(&level_set, &coverage);
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
