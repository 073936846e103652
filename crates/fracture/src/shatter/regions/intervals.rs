//! Which part of each row of nodes lies in which region, for neighbouring rows at a time.

use crate::pattern::region::Region;
use frangible_geometry::{Grid, GridSolid, HalfSpace};
use glam::DVec3;
use std::ops::Range;

/// No region, no component, no piece.
pub(crate) const NONE: u32 = u32::MAX;

/// Distance between a node and a plane in units of the spacing that counts as none.
const ON_CRACK: f64 = 1e-9;

/// Rows of a tile along y and along z: what is true of all of them is found out once.
pub(super) const TILE: usize = 8;

/// Where the material of each row is.
pub(super) struct RowEnds {
    /// First and last node of each row, as numbers along x; the first lies behind the last in a row
    /// without material.
    ends: Vec<[f64; 2]>,
    /// Run index of a row with a single gapless run.
    run: Vec<u32>,
}

impl RowEnds {
    pub(super) fn of(solid: &GridSolid) -> Self {
        let [_, rows_y, rows_z] = solid.grid().dims;
        let (runs, rows) = (solid.runs(), rows_y * rows_z);
        let (mut ends, mut run) =
            (vec![[f64::INFINITY, f64::NEG_INFINITY]; rows], vec![NONE; rows]);
        for (number, here) in (0..).zip(runs) {
            let row = here.number(rows_y);
            let is_first = ends[row][0] == f64::INFINITY;
            run[row] = if is_first { number } else { NONE };
            ends[row] = [f64::from(here.start).min(ends[row][0]), f64::from(here.end - 1)];
        }
        Self { ends, run }
    }

    /// Material interval of a row; `None` without material.
    #[inline]
    pub(super) fn of_row(&self, row: usize) -> Option<[f64; 2]> {
        let [first, last] = self.ends[row];
        (first <= last).then_some([first, last])
    }

    /// The numbers of the runs that some rows are; [`NONE`] where there is a gap or nothing.
    #[inline]
    pub(super) fn runs(&self, rows: Range<usize>) -> &[u32] {
        &self.run[rows]
    }

    /// First and last nodes of the rows from j on, along y: as many as there are.
    #[inline]
    pub(super) fn of_tile(&self, [j, k]: [usize; 2], rows_y: usize) -> ([f64; TILE], [f64; TILE]) {
        let (mut firsts, mut lasts) = ([f64::INFINITY; TILE], [f64::NEG_INFINITY; TILE]);
        let row = j + rows_y * k;
        let rows = &self.ends[row..row + TILE.min(rows_y - j)];
        for (&[first, last], row) in rows.iter().zip(0..TILE) {
            (firsts[row], lasts[row]) = (first, last);
        }
        (firsts, lasts)
    }

    /// The box of the material in a tile of rows, in lattice units.
    fn tile_bounds(&self, grid: &Grid, [tile_y, tile_z]: [usize; 2]) -> Option<(DVec3, DVec3)> {
        let [_, rows_y, rows_z] = grid.dims;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for k in tile_z * TILE..((tile_z + 1) * TILE).min(rows_z) {
            for j in tile_y * TILE..((tile_y + 1) * TILE).min(rows_y) {
                if let Some([first, last]) = self.of_row(j + rows_y * k) {
                    low = low.min(DVec3::new(first, j as f64, k as f64));
                    high = high.max(DVec3::new(last, j as f64, k as f64));
                }
            }
        }
        (low.x <= high.x).then_some((low, high))
    }
}

/// A plane as a function on the lattice, in units of the spacing.
struct LatticePlane {
    normal: DVec3,
    at_origin: f64,
    crossing: Crossing,
}

/// Where rows cross a plane: at `at_origin + along_y * j + along_z * k`, a little outside of it.
#[derive(Clone, Copy)]
struct Crossing {
    at_origin: f64,
    along_y: f64,
    along_z: f64,
    side: Side,
}

/// Which part of a row is inside of a plane.
#[derive(Clone, Copy)]
enum Side {
    BelowCrossing,
    AboveCrossing,
    /// All of it or nothing: the plane lies along x, and the crossing's place is how deep inside
    /// the row is.
    Either,
}

impl LatticePlane {
    fn new(half_space: &HalfSpace, grid: &Grid) -> Self {
        let (normal, at_origin) =
            (half_space.normal, half_space.distance(grid.origin) / grid.spacing);
        let slope = normal.x;
        let (scale, side) = match slope {
            _ if slope.abs() < ON_CRACK * 1e-3 => (1.0, Side::Either),
            _ if slope > 0.0 => (1.0 / slope, Side::BelowCrossing),
            _ => (1.0 / slope, Side::AboveCrossing),
        };
        let crossing = Crossing {
            at_origin: (ON_CRACK - at_origin) * scale,
            along_y: -normal.y * scale,
            along_z: -normal.z * scale,
            side,
        };
        Self { normal, at_origin, crossing }
    }
}

/// Per tile of rows, the regions that reach into it, with their planes through it.
pub(super) struct Tiles {
    /// Tiles along y.
    count_y: usize,
    /// Where each tile begins in `regions`, and one more entry at the end.
    first_of_tile: Vec<u32>,
    regions: Vec<TileRegion>,
    crossings: Vec<Crossing>,
}

/// A region that reaches into a tile.
struct TileRegion {
    number: u32,
    /// Where its planes begin and end.
    crossings: [u32; 2],
}

/// The nodes of neighbouring rows that lie inside of a region or on its cracks, within the rows'
/// ends: from the first to the last one, whole numbers; none where the first lies behind the last.
pub(super) struct Intervals {
    pub(super) region: u32,
    pub(super) first: [f64; TILE],
    pub(super) last: [f64; TILE],
}

/// Content of the regions in neighbouring rows.
#[derive(Default)]
pub(super) struct Found {
    pub(super) intervals: Vec<Intervals>,
    /// Which of the intervals come first along x, and where each is about.
    order: Vec<(usize, f64)>,
}

impl Found {
    /// The intervals, about in order along x.
    #[inline]
    pub(super) fn in_order(&self) -> impl Iterator<Item = &Intervals> {
        self.order.iter().map(|&(number, _)| &self.intervals[number])
    }
}

impl Tiles {
    pub(super) fn new(grid: &Grid, ends: &RowEnds, regions: &[Region]) -> Self {
        let on_lattice = |region: &Region| -> Vec<LatticePlane> {
            region.cuts.iter().map(|cut| LatticePlane::new(&cut.half_space, grid)).collect()
        };
        // Most regions of a fine pattern reach into no tile.
        let middle = 0.5 * DVec3::from_array(grid.dims.map(|n| (n - 1) as f64));
        let reaches_in = |planes: &Vec<LatticePlane>| {
            let beyond = |plane: &LatticePlane| {
                plane.normal.dot(middle) + plane.at_origin - plane.normal.abs().dot(middle)
                    > 2.0 * ON_CRACK
            };
            !planes.iter().any(beyond)
        };
        let regions =
            regions.iter().map(on_lattice).zip(0..).filter(|(planes, _)| reaches_in(planes));
        let regions: Vec<(Vec<LatticePlane>, u32)> = regions.collect();
        let [count_y, count_z] = [grid.dims[1].div_ceil(TILE), grid.dims[2].div_ceil(TILE)];
        let mut tiles =
            Self { count_y, first_of_tile: Vec::new(), regions: Vec::new(), crossings: Vec::new() };
        for tile in 0..count_y * count_z {
            tiles.first_of_tile.push(tiles.regions.len() as u32);
            if let Some(bounds) = ends.tile_bounds(grid, [tile % count_y, tile / count_y]) {
                tiles.add_tile(&regions, bounds);
            }
        }
        tiles.first_of_tile.push(tiles.regions.len() as u32);
        tiles
    }

    /// Upper bound of rows per region, from the tiles it reaches into.
    pub(super) fn most_rows(&self, regions: usize) -> impl Iterator<Item = usize> {
        let mut rows = vec![0; regions];
        for region in &self.regions {
            rows[region.number as usize] += TILE * TILE;
        }
        rows.into_iter()
    }

    /// Adds the regions that reach into the box from `low` to `high`, in lattice units.
    fn add_tile(&mut self, regions: &[(Vec<LatticePlane>, u32)], (low, high): (DVec3, DVec3)) {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        for &(ref region, number) in regions {
            let first = self.crossings.len();
            let mut reaches_in = true;
            for plane in region {
                let distance = plane.normal.dot(middle) + plane.at_origin;
                let reach = plane.normal.abs().dot(half);
                if distance - reach > ON_CRACK {
                    reaches_in = false;
                    break;
                }
                if distance + reach > 0.0 {
                    self.crossings.push(plane.crossing);
                }
            }
            if reaches_in {
                let crossings = [first, self.crossings.len()].map(|crossing| crossing as u32);
                self.regions.push(TileRegion { number, crossings });
            } else {
                self.crossings.truncate(first);
            }
        }
    }

    /// Content of each region in rows from j on, along y, within their tile.
    pub(super) fn cross(&self, grid: &Grid, ends: &RowEnds, [j, k]: [usize; 2], found: &mut Found) {
        found.intervals.clear();
        found.order.clear();
        let (firsts, lasts) = ends.of_tile([j, k], grid.dims[1]);
        let tile = j / TILE + self.count_y * (k / TILE);
        let regions = self.first_of_tile[tile] as usize..self.first_of_tile[tile + 1] as usize;
        let at_y: [f64; TILE] = std::array::from_fn(|row| (j + row) as f64);
        for &TileRegion { number, crossings: [from, to] } in &self.regions[regions] {
            let (mut low, mut high) = (firsts, lasts);
            for crossing in &self.crossings[from as usize..to as usize] {
                let at_z = crossing.at_origin + crossing.along_z * k as f64;
                let at: [f64; TILE] =
                    std::array::from_fn(|row| at_z + crossing.along_y * at_y[row]);
                match crossing.side {
                    Side::BelowCrossing => {
                        high = std::array::from_fn(|row| {
                            if at[row] < high[row] { at[row] } else { high[row] }
                        });
                    }
                    Side::AboveCrossing => {
                        low = std::array::from_fn(|row| {
                            if at[row] > low[row] { at[row] } else { low[row] }
                        });
                    }
                    Side::Either => {
                        high = std::array::from_fn(|row| {
                            if at[row] < 0.0 { f64::NEG_INFINITY } else { high[row] }
                        });
                    }
                }
            }
            let (first, last) = (low.map(ceil), high.map(floor));
            if let Some(row) = (0..TILE).find(|&row| first[row] <= last[row]) {
                let place = first[row] + last[row];
                let behind =
                    found.order.iter().rev().take_while(|(_, other)| *other > place).count();
                found.order.insert(found.order.len() - behind, (found.intervals.len(), place));
                found.intervals.push(Intervals { region: number, first, last });
            }
        }
    }
}

/// Floats of this size are integers: adding it rounds to the nearest integer.
const WHOLE: f64 = (1_u64 << (f64::MANTISSA_DIGITS - 1)) as f64;

/// The least whole number that is not below `x`, of an `x` from zero to [`WHOLE`] or infinite: in
/// instructions for several at a time.
#[inline]
fn ceil(x: f64) -> f64 {
    let nearest = (x + WHOLE) - WHOLE;
    nearest + if nearest < x { 1.0 } else { 0.0 }
}

/// Largest integer not above `x`, by the same trick; negative for negative `x`.
#[inline]
fn floor(x: f64) -> f64 {
    let nearest = (x + WHOLE) - WHOLE;
    nearest - if nearest > x { 1.0 } else { 0.0 }
}
