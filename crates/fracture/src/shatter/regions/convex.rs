//! What each region holds of a convex solid: most rows are cut without looking at their spans.

use super::intervals::{Found, Intervals, RowEnds, TILE, Tiles};
use super::{claim_row, cut_row, settle};
use crate::pattern::Region;
use frangible_geometry::{GridSolid, Run};
use std::ops::Range;

/// The runs of a convex solid that lie in each region, in order. A region is convex, so along a row of nodes it is one interval: its
/// end points cost less than its distance at each node. Nodes in no interval, or in several because they lie on a crack up to
/// round-off, are compared by distance.
pub(crate) fn runs_of_regions(solid: &GridSolid, regions: &[Region]) -> Vec<Vec<Run>> {
    let (grid, material) = (solid.grid(), solid.material());
    let ends = RowEnds::of(solid);
    let tiles = Tiles::new(grid, &ends, regions);
    let mut of_region: Vec<Vec<Run>> = tiles.most_rows(regions.len()).map(Vec::with_capacity).collect();
    let (mut found, mut claims) = (Found::default(), Vec::new());
    let [_, rows_y, rows_z] = grid.dims;
    for k in 0..rows_z {
        for j in (0..rows_y).step_by(TILE) {
            tiles.cross(grid, &ends, [j, k], &mut found);
            let rows = 0..TILE.min(rows_y - j);
            if cut_rows(solid, &ends, &found, (rows.clone(), [j, k]), &mut of_region) {
                continue;
            }

            // There are gaps, or nodes in several intervals or in none.
            for row in rows {
                if cut_rows(solid, &ends, &found, (row..row + 1, [j, k]), &mut of_region) {
                    continue;
                }
                let number = j + row + rows_y * k;
                let Some(of_row) = ends.of_row(number) else { continue };
                claim_row(&found.intervals, row, &mut claims);
                settle(grid, [j + row, k], of_row.map(|end| end as i64), regions, &mut claims);
                let claimed = claims.iter().map(|claim| (claim.high as u32 + 1, claim.region));
                cut_row((grid, material), number, claimed, false, |run, region| {
                    of_region[region as usize].push(run);
                });
            }
        }
    }
    of_region.iter_mut().for_each(Vec::shrink_to_fit);
    of_region
}

/// Cuts some of the rows from j on by their intervals, region by region. False, and nothing done, if these do not cover each node
/// once and in order, or a row is not one run.
fn cut_rows(
    solid: &GridSolid,
    ends: &RowEnds,
    found: &Found,
    (rows, [j, k]): (Range<usize>, [usize; 2]),
    of_region: &mut [Vec<Run>],
) -> bool {
    let (material, cores) = (solid.material(), solid.cores());
    let rows_y = solid.grid().dims[1];
    let (mut next, lasts) = ends.of_tile([j, k], rows_y);
    let number = j + rows_y * k;
    let runs = ends.runs(number + rows.start..number + rows.end);
    let mut is_covered = true;
    for Intervals { region, first, last } in found.in_order() {
        let parts = &mut of_region[*region as usize];
        let intervals = first[rows.clone()].iter().zip(&last[rows.clone()]);
        for (((&from, &to), next), (&run, row)) in
            intervals.zip(&mut next[rows.clone()]).zip(runs.iter().zip(rows.start..))
        {
            if from <= to {
                let core = cores.get(run as usize).filter(|_| from == *next);
                let Some(core) = core else {
                    is_covered = false;
                    break;
                };
                *next = to + 1.0;
                core.cut([from, to], parts, || material.row(number + row));
            }
        }
    }
    is_covered &= rows.clone().all(|row| next[row] > lasts[row]);
    if !is_covered {
        let first = [k, j + rows.start, 0].map(|n| n as u32);
        for Intervals { region, .. } in &found.intervals {
            let parts = &mut of_region[*region as usize];
            while parts.pop_if(|run| run.place() >= first).is_some() {}
        }
    }
    is_covered
}
