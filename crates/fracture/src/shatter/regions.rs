//! Which region of the pattern each node lies in, row by row in spans.

pub(crate) mod convex;
pub(crate) mod intervals;
pub(crate) mod shares;

use super::laid::Laid;
use crate::pattern::region::Region;
use crate::shatter::regions::shares::Shares;
use crate::shatter::regions::shares::claim_row;
use crate::shatter::regions::shares::settle;
use frangible_geometry::GridSolid;
use intervals::{Found, RowEnds, TILE, Tiles};

/// Shares that there is room for at first, for each run of a solid.
const SHARES_OF_RUN: usize = 6;

/// Shares out a solid's material, convex or not, among convex regions; see [`portions_of_regions`].
pub(crate) fn share_out(solid: &GridSolid, regions: &[Region]) -> Shares {
    let (grid, material) = (solid.grid(), solid.material());
    let ends = RowEnds::of(solid);
    let tiles = Tiles::new(grid, &ends, regions);
    let mut shares = Shares {
        all: Vec::with_capacity(SHARES_OF_RUN * solid.runs().len()),
        first_of_row: Vec::with_capacity(material.rows() + 1),
    };
    let (mut found, mut claims) = (Found::default(), Vec::new());
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        if j % TILE == 0 {
            tiles.cross(grid, &ends, [j, k], &mut found);
        }
        let Some(of_row) = ends.of_row(row) else { continue };
        claim_row(&found.intervals, j % TILE, &mut claims);
        settle(grid, [j, k], of_row.map(|end| end as i64), regions, &mut claims);
        let claimed = claims.iter().map(|claim| (claim.high as u32 + 1, claim.region));
        shares.cut_row((grid, material), row, claimed);
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}

/// Shares out a solid's material among cells of any form.
pub(crate) fn share_out_nodes(solid: &GridSolid, laid: &Laid) -> Shares {
    let (grid, material) = (solid.grid(), solid.material());
    let mut shares = Shares::default();
    let mut stretches: Vec<(u32, u32)> = Vec::new();
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let place = [row % grid.dims[1], row / grid.dims[1]];
        stretches.clear();
        for whole in material.row(row).chunk_by(|a, b| a.end == b.start) {
            let (Some(first), Some(last)) = (whole.first(), whole.last()) else { continue };
            let mut i = first.start;
            laid.cells_along(place, first.start as usize..last.end as usize, |cell| {
                i += 1;
                match stretches.last_mut().filter(|(_, last)| *last == cell) {
                    Some((until, _)) => *until = i,
                    None => stretches.push((i, cell)),
                }
            });
        }
        shares.cut_row((grid, material), row, stretches.iter().copied());
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}
