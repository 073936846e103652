//! Content of a convex solid per region: most rows are cut without a look at their spans.

use super::intervals::{Found, Intervals, RowEnds, TILE, Tiles};
use crate::pattern::region::Region;
use crate::shatter::regions::shares::{claim_row, cut_row, settle};
use frangible_geometry::{GridSolid, Portion, RowSums};
use std::ops::Range;

/// Content of a convex solid per region. Convex regions are intervals along a row of nodes: two end
/// points cost less than a distance per node. Nodes in no interval, or in several (on a crack,
/// within round-off), are compared by distance.
pub(crate) fn portions_of_regions(solid: &GridSolid, regions: &[Region]) -> Vec<Portion> {
    let (grid, material) = (solid.grid(), solid.material());
    let ends = RowEnds::of(solid);
    let tiles = Tiles::new(grid, &ends, regions);
    let most_rows = tiles.most_rows(regions.len());
    let mut of_region: Vec<Portion> =
        most_rows.map(|rows| Portion::with_capacity(grid, rows)).collect();
    let (mut found, mut claims, mut sums) = (Found::default(), Vec::new(), Vec::new());
    let [_, rows_y, rows_z] = grid.dims;
    for k in 0..rows_z {
        for j in (0..rows_y).step_by(TILE) {
            tiles.cross(grid, &ends, [j, k], &mut found);
            let rows = 0..TILE.min(rows_y - j);
            if cut_rows((solid, &ends), &found, (rows.clone(), [j, k]), &mut sums, &mut of_region) {
                continue;
            }

            // There are gaps, or nodes in several intervals or in none.
            for row in rows {
                if cut_rows(
                    (solid, &ends),
                    &found,
                    (row..row + 1, [j, k]),
                    &mut sums,
                    &mut of_region,
                ) {
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
    of_region.iter_mut().for_each(|portion| portion.runs.shrink_to_fit());
    of_region
}

/// Cuts some of the rows from j on by their intervals, region by region. False, and nothing done,
/// if these do not cover each node once and in order, or a row is not one run. `sums` is room for
/// what each region holds of the rows.
fn cut_rows(
    (solid, ends): (&GridSolid, &RowEnds),
    found: &Found,
    (rows, [j, k]): (Range<usize>, [usize; 2]),
    sums: &mut Vec<RowSums>,
    of_region: &mut [Portion],
) -> bool {
    let (material, cores) = (solid.material(), solid.cores());
    let rows_y = solid.grid().dims[1];
    let (mut next, lasts) = ends.of_tile([j, k], rows_y);
    let number = j + rows_y * k;
    let runs = ends.runs(number + rows.start..number + rows.end);
    let mut is_covered = true;
    sums.clear();
    for Intervals { region, first, last } in found.in_order() {
        let parts = &mut of_region[*region as usize].runs;
        let mut own = RowSums::NONE;
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
                let part = core.cut([from, to], || material.row(number + row));
                own.add(row as f64, [from, to], &part);
                parts.push(part);
            }
        }
        sums.push(own);
    }
    is_covered &= rows.clone().all(|row| next[row] > lasts[row]);
    if is_covered {
        for (Intervals { region, .. }, own) in found.in_order().zip(sums.iter()) {
            of_region[*region as usize].sums.add_rows([j, k], own);
        }
    } else {
        let first = [k, j + rows.start, 0].map(|n| n as u32);
        for Intervals { region, .. } in &found.intervals {
            let parts = &mut of_region[*region as usize].runs;
            while parts.pop_if(|run| run.place() >= first).is_some() {}
        }
    }
    is_covered
}
