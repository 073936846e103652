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

    /// Number of rows.
    pub(crate) fn rows(&self) -> usize {
        self.first_of_row.len() - 1
    }
}

/// Distance between a node and a plane in units of the spacing that counts as none.
const ON_CRACK: f64 = 1e-9;

/// Rows of a tile along y and along z: what is true of all of them is found out once.
const TILE: usize = 8;

/// Shares out a solid's material. A region is convex, so along a row of nodes it is one interval: its end points cost less
/// than its distance at each node. Nodes in no interval, or in several because they lie on a crack up to round-off, are
/// compared by distance.
pub(crate) fn share_out(solid: &GridSolid, regions: &[Region]) -> Shares {
    let (grid, material) = (solid.grid(), solid.material());
    let mut tiles = Tiles::new(solid, regions);
    let mut shares = Shares { all: Vec::with_capacity(4 * solid.runs().len()), first_of_row: Vec::new() };
    let mut claims = Vec::new();
    let mut runs = solid.runs();
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let spans = material.row(row);
        let of_row = runs.iter().take_while(|run| run.number(grid.dims[1]) == row).count();
        let (of_row, rest) = runs.split_at(of_row);
        runs = rest;
        let (Some(first), Some(last)) = (spans.first(), spans.last()) else { continue };
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        let bounds = (i64::from(first.start), i64::from(last.end) - 1);
        tiles.claim_row([j, k], bounds, &mut claims);
        settle(grid, [j, k], bounds, regions, &mut claims);
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
    for row in 0..material.rows() {
        shares.first_of_row.push(shares.all.len() as u32);
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        let nodes = material.row(row).iter().flat_map(|span| span.start..span.end);
        let claimed = nodes.map(|i| (i + 1, cell_at(grid.node(i as usize, j, k))));
        shares.cut_row(material, (row, [j, k]), claimed, (grid.dims[0], true));
    }
    shares.first_of_row.push(shares.all.len() as u32);
    shares
}

impl Shares {
    /// Cuts a row's spans where the regions change: `claimed` says in order where each stretch ends and whose it is.
    /// With `by_span` no share holds parts of two spans, so that it is alike all along.
    fn cut_row(
        &mut self,
        material: &Material,
        (row, place): (usize, [usize; 2]),
        mut claimed: impl Iterator<Item = (u32, u32)>,
        (width, by_span): (usize, bool),
    ) {
        let place = place.map(|n| n as u32);
        let first = self.all.len();
        let (mut until, mut region) = (0, NONE);
        for span in material.row(row) {
            let mut start = span.start;
            while start < span.end {
                while until <= start {
                    let Some(next) = claimed.next() else { return };
                    (until, region) = next;
                }
                let end = span.end.min(until);
                let begins = by_span && start == span.start;
                let goes_on = |last: &&mut Share| last.region == region && last.run.end == start && !begins;
                match self.all[first..].last_mut().filter(goes_on) {
                    Some(last) => last.run.add(span, start..end, width),
                    None => {
                        let mut run = Run::empty(place, start);
                        run.add(span, start..end, width);
                        self.all.push(Share { run, region });
                    }
                }
                start = end;
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
    /// 1 / normal.x, zero for a plane along x.
    per_slope: f64,
}

/// For each tile of rows the regions that reach into it, and those of their planes that pass through it.
struct Tiles {
    /// Tiles along y.
    count_y: usize,
    /// Where each tile begins in `regions`, and one more entry at the end.
    first_of_tile: Vec<u32>,
    regions: Vec<TileRegion>,
    planes: Vec<LatticePlane>,
    /// Where in the list the region is that the last row began in.
    begin: u32,
}

/// A region that reaches into a tile.
struct TileRegion {
    number: u32,
    /// Where its planes begin and end.
    planes: [u32; 2],
    /// Where in the list the region is that the last row passed through behind this one.
    next: u32,
}

impl Tiles {
    fn new(solid: &GridSolid, regions: &[Region]) -> Self {
        let grid = solid.grid();
        let on_lattice = |region: &Region| -> Vec<LatticePlane> {
            let plane = |cut: &crate::Cut| {
                let normal = cut.half_space.normal;
                let along_x = normal.x.abs() < ON_CRACK * 1e-3;
                LatticePlane {
                    normal,
                    at_origin: cut.half_space.distance(grid.origin) / grid.spacing,
                    per_slope: if along_x { 0.0 } else { 1.0 / normal.x },
                }
            };
            region.cuts.iter().map(plane).collect()
        };
        let regions: Vec<Vec<LatticePlane>> = regions.iter().map(on_lattice).collect();
        let [count_y, count_z] = [grid.dims[1].div_ceil(TILE), grid.dims[2].div_ceil(TILE)];
        let mut tiles =
            Self { count_y, first_of_tile: Vec::new(), regions: Vec::new(), planes: Vec::new(), begin: NONE };
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
            let first = self.planes.len();
            let mut reaches_in = true;
            for plane in region {
                let distance = plane.normal.dot(middle) + plane.at_origin;
                let reach = plane.normal.abs().dot(half);
                if distance - reach > ON_CRACK {
                    reaches_in = false;
                    break;
                }
                if distance + reach > 0.0 {
                    self.planes.push(*plane);
                }
            }
            if reaches_in {
                let planes = [first, self.planes.len()].map(|plane| plane as u32);
                self.regions.push(TileRegion { number, planes, next: NONE });
            } else {
                self.planes.truncate(first);
            }
        }
    }

    /// The intervals of a row within the bounds that lie inside of a region or on its cracks, in order: from each to the one
    /// that holds the node behind it. There may be others where intervals overlap or leave a gap.
    fn claim_row(&mut self, [j, k]: [usize; 2], (first, last): (i64, i64), claims: &mut Vec<Claim>) {
        claims.clear();
        let tile = j / TILE + self.count_y * (k / TILE);
        let regions = self.first_of_tile[tile] as usize..self.first_of_tile[tile + 1] as usize;
        let (y, z) = (j as f64, k as f64);
        let (mut next, mut guess) = (first, self.begin);
        let mut before = None;
        while next <= last {
            // Rows beside each other pass through the same regions.
            let order = std::iter::once(guess as usize).filter(|at| regions.contains(at));
            let holds = |at: usize| {
                let interval = self.interval(at, [y, z], (first, last));
                (interval.low <= next && next <= interval.high).then_some((at, interval))
            };
            let Some((at, interval)) = order.chain(regions.clone()).find_map(holds) else {
                next += 1;
                continue;
            };
            if interval.grazes {
                claims.clear();
                let all = regions.map(|at| (at, self.interval(at, [y, z], (first, last))));
                let held = all.filter(|(_, interval)| interval.low <= interval.high);
                claims.extend(held.map(|(at, Interval { low, high, .. })| Claim {
                    low,
                    high,
                    region: self.regions[at].number,
                }));
                break;
            }
            *before.map_or(&mut self.begin, |before: usize| &mut self.regions[before].next) = at as u32;
            claims.push(Claim { low: interval.low, high: interval.high, region: self.regions[at].number });
            (next, guess, before) = (interval.high + 1, self.regions[at].next, Some(at));
        }
        claims.sort_by_key(|claim| claim.low);
    }

    /// The nodes of a row within the bounds that lie inside of a tile's region or on its cracks.
    #[inline]
    fn interval(&self, at: usize, [y, z]: [f64; 2], (first, last): (i64, i64)) -> Interval {
        let TileRegion { planes, .. } = &self.regions[at];
        let (mut low, mut high) = (first as f64, last as f64);
        let mut grazes = false;
        for plane in &self.planes[planes[0] as usize..planes[1] as usize] {
            let at_row = ON_CRACK - (plane.normal.y * y + plane.normal.z * z + plane.at_origin);
            let crossing = at_row * plane.per_slope;
            if plane.per_slope > 0.0 {
                high = if crossing < high { crossing } else { high };
            } else if plane.per_slope < 0.0 {
                low = if crossing > low { crossing } else { low };
            } else if at_row < 0.0 {
                high = f64::NEG_INFINITY;
            } else {
                grazes |= at_row <= 2.0 * ON_CRACK;
            }
        }
        if low > high {
            return Interval { low: 1, high: 0, grazes: false };
        }
        Interval { low: ceil(low), high: floor(high), grazes }
    }
}

/// What a row passes through of a region.
struct Interval {
    low: i64,
    high: i64,
    /// Whether it lies on a crack all along.
    grazes: bool,
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

/// The largest whole number that is not above `x`, without a call into the platform's library.
#[inline]
fn floor(x: f64) -> i64 {
    let towards_zero = x as i64;
    towards_zero - i64::from(x < towards_zero as f64)
}

/// The least whole number that is not below `x`.
#[inline]
fn ceil(x: f64) -> i64 {
    -floor(-x)
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
