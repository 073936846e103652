//! Shares of a solid's rows by region.

use super::intervals::Intervals;
use crate::pattern::region::{Region, nearest_region};
use frangible_geometry::{Grid, Run, Span, VoxelRuns};

/// Consecutive nodes of a row in one region.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Share {
    pub(crate) run: Run,
    pub(crate) region: u32,
}

/// A solid's material, shared out among the regions: the shares of all rows of its grid, in order.
#[derive(Clone, Debug, Default)]
pub(crate) struct Shares {
    pub(crate) all: Vec<Share>,
    /// Where each row begins in `all`, and one more entry at the end.
    pub(crate) first_of_row: Vec<u32>,
}

impl Shares {
    /// Indices of a row's shares.
    #[inline]
    pub(crate) fn row(&self, row: usize) -> std::ops::Range<usize> {
        self.first_of_row[row] as usize..self.first_of_row[row + 1] as usize
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.first_of_row.len() - 1
    }
}

impl Shares {
    /// Adds a row's shares; a share never spans two spans, hence is uniform.
    pub(super) fn cut_row(
        &mut self,
        of_grid: (&Grid, &VoxelRuns),
        row: usize,
        stretches: impl Iterator<Item = (u32, u32)>,
    ) {
        cut_row(of_grid, row, stretches, true, |run, region| self.all.push(Share { run, region }));
    }
}

/// Cuts a row's spans where the regions change: `stretches` says in order where each ends and whose
/// it is, neighbours being different regions'. With `by_span` no run holds parts of two spans.
pub(super) fn cut_row(
    (grid, material): (&Grid, &VoxelRuns),
    row: usize,
    stretches: impl Iterator<Item = (u32, u32)>,
    by_span: bool,
    mut add: impl FnMut(Run, u32),
) {
    let place = [row % grid.dims[1], row / grid.dims[1]].map(|n| n as u32);
    let middle = grid.middle_along_x();
    let spans = material.row(row);
    // The span, and its first node, that no run holds yet.
    let (mut at, mut start) = (0, spans.first().map_or(0, |span| span.start));
    for (until, region) in stretches {
        while at < spans.len() && start < until {
            // As far as the spans go on without a gap.
            let mut run = Run::empty(place, start);
            loop {
                let span = &spans[at];
                let end = span.end.min(until);
                run.add(&Span { start, end, ..*span }, middle);
                start = end;
                if end < span.end {
                    break;
                }
                at += 1;
                let Some(next) = spans.get(at) else { break };
                start = next.start;
                if start != end || end == until || by_span {
                    break;
                }
            }
            add(run, region);
        }
    }
}

/// An interval of a row's nodes that lies in a region; both ends belong to it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Claim {
    pub(super) low: i64,
    pub(super) high: i64,
    pub(super) region: u32,
}

/// The intervals of one of their rows, in order: where two begin with the same node, in that of
/// their regions.
pub(super) fn claim_row(intervals: &[Intervals], row: usize, claims: &mut Vec<Claim>) {
    claims.clear();
    let of_row = intervals.iter().map(|Intervals { region, first, last, .. }| Claim {
        low: first[row] as i64,
        high: last[row] as i64,
        region: *region,
    });
    claims.extend(of_row.filter(|claim| claim.low <= claim.high));
    claims.sort_by_key(|claim| (claim.low, claim.region));
}

/// Makes claims that are in order cover each node within the bounds once: the nearest region has
/// it.
pub(super) fn settle(
    grid: &Grid,
    [j, k]: [usize; 2],
    [first, last]: [i64; 2],
    regions: &[Region],
    claims: &mut Vec<Claim>,
) {
    let seamless = claims.windows(2).all(|pair| pair[0].high + 1 == pair[1].low);
    let ends = claims.first().map(|claim| claim.low) == Some(first)
        && claims.last().map(|claim| claim.high) == Some(last);
    if seamless && ends {
        return;
    }
    let nearest = |i: i64| {
        let nearest = nearest_region(regions, grid.node(i as usize, j, k));
        nearest.map_or(0, |region| region as u32)
    };
    let claimed = std::mem::take(claims);
    let mut push = |low: i64, high: i64, region: u32| match claims.last_mut() {
        Some(claim) if claim.region == region => claim.high = high,
        _ => claims.push(Claim { low, high, region }),
    };
    let mut next = first;
    for (at, claim) in claimed.iter().enumerate() {
        // Nodes unclaimed before this share, and nodes claimed twice.
        for i in next..claim.low {
            push(i, i, nearest(i));
        }
        let others = || claimed.iter().enumerate().filter(|&(other, _)| other != at);
        let mut i = next.max(claim.low);
        while i <= claim.high {
            if others().any(|(_, other)| other.low <= i && i <= other.high) {
                push(i, i, nearest(i));
                i += 1;
            } else {
                let next_other = others().map(|(_, other)| other.low).filter(|&low| low > i).min();
                let end = next_other.map_or(claim.high, |low| claim.high.min(low - 1));
                push(i, end, claim.region);
                i = end + 1;
            }
        }
        next = next.max(claim.high + 1);
    }
    for i in next..=last {
        push(i, i, nearest(i));
    }
}
