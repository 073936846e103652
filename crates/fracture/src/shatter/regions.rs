//! Which region of the pattern each node lies in, row by row in spans.

use crate::pattern::{Region, nearest_region};
use frangible_geometry::{Grid, GridSolid, Material, Run};
use glam::DVec3;

/// No region, no component, no piece.
pub(crate) const NONE: u32 = u32::MAX;

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

    /// The runs of some shares.
    pub(crate) fn runs(&self, some: &[u32]) -> impl Iterator<Item = Run> + Clone {
        some.iter().map(|&share| self.all[share as usize].run)
    }

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.first_of_row.len() - 1
    }
}

/// Distance between a node and a plane in units of the spacing that counts as none.
const ON_CRACK: f64 = 1e-9;

/// Rows of a tile along y and along z: what is true of all of them is found out once.
const TILE: usize = 8;

/// Shares that there is room for at first, for each run of a solid.
const SHARES_OF_RUN: usize = 6;

/// Shares out a solid's material. A region is convex, so along a row of nodes it is one interval: its end points cost less
/// than its distance at each node. Nodes in no interval, or in several because they lie on a crack up to round-off, are
/// compared by distance.
pub(crate) fn share_out(solid: &GridSolid, regions: &[Region]) -> Shares {
    let (grid, material) = (solid.grid(), solid.material());
    let tiles = Tiles::new(solid, regions);
    let mut shares =
        Shares { all: Vec::with_capacity(SHARES_OF_RUN * solid.runs().len()), first_of_row: Vec::new() };
    let (mut intervals, mut claims) = (Vec::new(), Vec::new());
    let mut runs = solid.runs();
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        if j % TILE == 0 {
            tiles.cross([j, k], &mut intervals);
        }
        let spans = material.row(row);
        let (Some(first), Some(last)) = (spans.first(), spans.last()) else { continue };
        let bounds = (i64::from(first.start), i64::from(last.end) - 1);
        claim_row(&intervals, j % TILE, bounds, &mut claims);
        settle(grid, [j, k], bounds, regions, &mut claims);
        let of_row = runs.iter().take_while(|run| run.number(grid.dims[1]) == row).count();
        let (of_row, rest) = runs.split_at(of_row);
        runs = rest;
        if let ([run], [claim], true) = (of_row, claims.as_slice(), solid.is_convex()) {
            shares.all.push(Share { run: *run, region: claim.region });
            continue;
        }
        let claimed = claims.iter().map(|claim| (claim.high as u32 + 1, claim.region));
        shares.cut_row(material, (row, [j, k]), claimed, (grid.dims[0], !solid.is_convex()));
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}

/// Shares out a solid's material among cells of any form: `cell_at` says which one a point of the grid frame [m] lies in.
pub(crate) fn share_out_nodes(solid: &GridSolid, cell_at: impl Fn(DVec3) -> u32) -> Shares {
    let (grid, material) = (solid.grid(), solid.material());
    let mut shares = Shares::default();
    let mut stretches: Vec<(u32, u32)> = Vec::new();
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        stretches.clear();
        for i in material.row(row).iter().flat_map(|span| span.start..span.end) {
            let cell = cell_at(grid.node(i as usize, j, k));
            match stretches.last_mut().filter(|(_, last)| *last == cell) {
                Some((until, _)) => *until = i + 1,
                None => stretches.push((i + 1, cell)),
            }
        }
        shares.cut_row(material, (row, [j, k]), stretches.iter().copied(), (grid.dims[0], true));
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}

impl Shares {
    /// Cuts a row's spans where the regions change: `stretches` says in order where each ends and whose it is, neighbours being
    /// different regions'. With `by_span` no share holds parts of two spans, so that it is alike all along.
    fn cut_row(
        &mut self,
        material: &Material,
        (row, place): (usize, [usize; 2]),
        stretches: impl Iterator<Item = (u32, u32)>,
        (width, by_span): (usize, bool),
    ) {
        let place = place.map(|n| n as u32);
        let spans = material.row(row);
        // The span, and its first node, that no share holds yet.
        let (mut at, mut start) = (0, spans.first().map_or(0, |span| span.start));
        for (until, region) in stretches {
            while at < spans.len() && start < until {
                // As far as the spans go on without a gap.
                let mut run = Run::empty(place, start);
                loop {
                    let span = &spans[at];
                    let end = span.end.min(until);
                    run.add(span, start..end, width);
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
                self.all.push(Share { run, region });
            }
        }
    }
}

/// An interval of a row's nodes that lies in a region; both ends belong to it.
#[derive(Clone, Copy, Debug)]
struct Claim {
    low: i64,
    high: i64,
    region: u32,
}

/// A plane as a function on the lattice, in units of the spacing.
#[derive(Clone, Copy)]
struct LatticePlane {
    normal: DVec3,
    at_origin: f64,
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
    /// All of it or nothing: the plane lies along x, and the crossing's place is how deep inside the row is.
    Either,
}

impl Crossing {
    fn new(plane: &LatticePlane) -> Self {
        let slope = plane.normal.x;
        let (scale, side) = match slope {
            _ if slope.abs() < ON_CRACK * 1e-3 => (1.0, Side::Either),
            _ if slope > 0.0 => (1.0 / slope, Side::BelowCrossing),
            _ => (1.0 / slope, Side::AboveCrossing),
        };
        Self {
            at_origin: (ON_CRACK - plane.at_origin) * scale,
            along_y: -plane.normal.y * scale,
            along_z: -plane.normal.z * scale,
            side,
        }
    }
}

/// For each tile of rows the regions that reach into it, and those of their planes that pass through it.
struct Tiles {
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

/// The parts of neighbouring rows that lie inside of a region or on its cracks: none where the lower end is above the upper one.
struct Intervals {
    region: u32,
    low: [f64; TILE],
    high: [f64; TILE],
}

impl Tiles {
    fn new(solid: &GridSolid, regions: &[Region]) -> Self {
        let grid = solid.grid();
        let on_lattice = |region: &Region| -> Vec<LatticePlane> {
            let plane = |cut: &crate::Cut| LatticePlane {
                normal: cut.half_space.normal,
                at_origin: cut.half_space.distance(grid.origin) / grid.spacing,
            };
            region.cuts.iter().map(plane).collect()
        };
        let regions: Vec<Vec<LatticePlane>> = regions.iter().map(on_lattice).collect();
        let [count_y, count_z] = [grid.dims[1].div_ceil(TILE), grid.dims[2].div_ceil(TILE)];
        let mut tiles =
            Self { count_y, first_of_tile: Vec::new(), regions: Vec::new(), crossings: Vec::new() };
        for tile in 0..count_y * count_z {
            tiles.first_of_tile.push(tiles.regions.len() as u32);
            if let Some(bounds) = tile_bounds(solid, [tile % count_y, tile / count_y]) {
                tiles.add_tile(&regions, bounds);
            }
        }
        tiles.first_of_tile.push(tiles.regions.len() as u32);
        tiles
    }

    /// Adds the regions that reach into the box from `low` to `high`, in lattice units.
    fn add_tile(&mut self, regions: &[Vec<LatticePlane>], (low, high): (DVec3, DVec3)) {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        for (region, number) in regions.iter().zip(0..) {
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
                    self.crossings.push(Crossing::new(plane));
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

    /// What the rows from j on, along y, hold of each region that reaches into their tile.
    fn cross(&self, [j, k]: [usize; 2], intervals: &mut Vec<Intervals>) {
        let tile = j / TILE + self.count_y * (k / TILE);
        let regions = self.first_of_tile[tile] as usize..self.first_of_tile[tile + 1] as usize;
        let rows: [f64; TILE] = std::array::from_fn(|row| (j + row) as f64);
        intervals.clear();
        intervals.extend(self.regions[regions].iter().map(
            |&TileRegion { number, crossings: [from, to] }| {
                let (mut low, mut high) = ([f64::NEG_INFINITY; TILE], [f64::INFINITY; TILE]);
                for crossing in &self.crossings[from as usize..to as usize] {
                    let at_z = crossing.at_origin + crossing.along_z * k as f64;
                    let at: [f64; TILE] = std::array::from_fn(|row| at_z + crossing.along_y * rows[row]);
                    for row in 0..TILE {
                        match crossing.side {
                            Side::BelowCrossing => {
                                high[row] = if at[row] < high[row] { at[row] } else { high[row] }
                            }
                            Side::AboveCrossing => {
                                low[row] = if at[row] > low[row] { at[row] } else { low[row] }
                            }
                            Side::Either => {
                                high[row] = if at[row] < 0.0 { f64::NEG_INFINITY } else { high[row] }
                            }
                        }
                    }
                }
                Intervals { region: number, low, high }
            },
        ));
    }
}

/// The intervals of one of a tile's rows within the bounds, in order. There may be nodes in several of them or in none.
fn claim_row(intervals: &[Intervals], row: usize, (first, last): (i64, i64), claims: &mut Vec<Claim>) {
    claims.clear();
    let (lowest, highest) = (first as f64, last as f64);
    for Intervals { region, low, high } in intervals {
        let low = if low[row] > lowest { low[row] } else { lowest };
        let high = if high[row] < highest { high[row] } else { highest };
        if low <= high {
            let (low, high) = (ceil(low), high as i64);
            if low <= high {
                let behind = claims.iter().rev().take_while(|claim| claim.low > low).count();
                claims.insert(claims.len() - behind, Claim { low, high, region: *region });
            }
        }
    }
}

/// The box of the material in a tile of rows, in lattice units.
fn tile_bounds(solid: &GridSolid, [tile_y, tile_z]: [usize; 2]) -> Option<(DVec3, DVec3)> {
    let dims = solid.grid().dims;
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for k in tile_z * TILE..((tile_z + 1) * TILE).min(dims[2]) {
        for j in tile_y * TILE..((tile_y + 1) * TILE).min(dims[1]) {
            let spans = solid.material().row(j + dims[1] * k);
            if let (Some(first), Some(last)) = (spans.first(), spans.last()) {
                low = low.min(DVec3::new(f64::from(first.start), j as f64, k as f64));
                high = high.max(DVec3::new(f64::from(last.end - 1), j as f64, k as f64));
            }
        }
    }
    (low.x <= high.x).then_some((low, high))
}

/// The least whole number that is not below `x`, which is not negative: without a call into the platform's library.
#[inline]
fn ceil(x: f64) -> i64 {
    let below = x as i64;
    below + i64::from(x > below as f64)
}

/// Makes claims that are in order cover each node within the bounds once: the nearest region has it.
fn settle(
    grid: &Grid,
    [j, k]: [usize; 2],
    (first, last): (i64, i64),
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
        // What nobody claims before this one, and what it shares with others.
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
