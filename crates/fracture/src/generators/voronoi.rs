//! Cells around random points.

use crate::filling::Filling;
use crate::generators::nearest_sites::{NearestSites, SiteTree};
use crate::generators::parameters::{deviation, require, require_box, require_count};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::{CellCutter, HalfSpace, Hull, Kept};
use frangible_math::threads;
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cells of random points: stone.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Voronoi {
    /// Number of cells, from 1 to 10000.
    pub cells: usize,
    /// From 0 to 30. 0 spreads the points evenly over the box; any other number gathers them around
    /// the centre, in a Gaussian whose standard deviation is `half_extent / clustering`.
    pub clustering: f64,
    /// From -10 to 10 along each axis. The points are `exp(2 grading)` times as dense at the box's
    /// upper end of an axis as at its lower, growing exponentially: small pieces at one end, large
    /// ones at the other.
    #[schemars(with = "[f64; 3]")]
    pub grading: DVec3,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter. A flat one suits walls that are
    /// struck on their face.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Voronoi {
    fn default() -> Self {
        Self { cells: 25, clustering: 0.0, grading: DVec3::ZERO, seed: 1, half_extent: DVec3::ONE }
    }
}

impl Pattern {
    /// Voronoi cells of random points in a centred box.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn voronoi(voronoi: &Voronoi) -> Result<Self, PatternError> {
        let half_extent = voronoi.half_extent;
        require_count(voronoi.cells, "cells")?;
        require(
            (0.0..=30.0).contains(&voronoi.clustering),
            "clustering",
            voronoi.clustering,
            "from 0 to 30",
        )?;
        let steepest = voronoi.grading.abs().max_element();
        require(steepest <= 10.0, "grading", steepest, "from -10 to 10")?;
        require_box(half_extent)?;

        let regions = voronoi_regions(&draw_sites(voronoi), half_extent);
        Ok(Self::planar_in_box(half_extent, regions.into_iter().flatten().collect()))
    }
}

impl Pattern {
    /// Voronoi cells of as many points of a solid.
    pub fn voronoi_in(voronoi: &Voronoi, filling: &Filling) -> Self {
        let regions = voronoi_regions(&sites_in(voronoi, filling), filling.half_extent());
        filling.planar(regions.into_iter().flatten().collect())
    }
}

/// Points of a solid, and more of them where clustering and grading would have more.
pub(super) fn sites_in(voronoi: &Voronoi, filling: &Filling) -> Vec<DVec3> {
    let &Voronoi { cells, clustering, grading, seed, .. } = voronoi;
    let points = filling.points();
    if clustering == 0.0 && grading == DVec3::ZERO {
        return points.iter().take(cells).copied().collect();
    }
    let deviation = filling.scale(voronoi.half_extent) * voronoi.half_extent
        / clustering.max(f64::MIN_POSITIVE);
    let mut random = Pcg64Mcg::seed_from_u64(seed);

    // The largest of such keys are a choice by weights without repeats [ES06].
    let mut keys: Vec<(f64, usize)> = Vec::with_capacity(points.len());
    for (number, &point) in points.iter().enumerate() {
        let from_blow = (point - filling.center()) / deviation;
        let along = grading.dot(point / filling.half_extent());
        let chance = -libm::log(1.0 - random.random::<f64>());
        keys.push((along - 0.5 * from_blow.length_squared() - libm::log(chance), number));
    }
    let order = |a: &(f64, usize), b: &(f64, usize)| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1));
    if cells < keys.len() {
        keys.select_nth_unstable_by(cells, order);
        keys.truncate(cells);
    }
    keys.sort_unstable_by(order);
    keys.iter().map(|&(_, number)| points[number]).collect()
}

/// Points in the box: distributed along each axis as the grading says, kept with the Gaussian's
/// probability.
fn draw_sites(voronoi: &Voronoi) -> Vec<DVec3> {
    let mut random = Pcg64Mcg::seed_from_u64(voronoi.seed);
    let mut sites = Vec::with_capacity(voronoi.cells);
    while sites.len() < voronoi.cells {
        let shares =
            DVec3::new(deviation(&mut random), deviation(&mut random), deviation(&mut random));
        let place = graded(2.0 * shares, voronoi.grading);
        let deviations = place * voronoi.clustering;
        if random.random::<f64>() < libm::exp(-0.5 * deviations.length_squared()) {
            sites.push(place * voronoi.half_extent);
        }
    }
    sites
}

/// Numbers that are uniform in [-1, 1), distributed with density proportional to `exp(grading
/// number)` instead.
fn graded(uniform: DVec3, grading: DVec3) -> DVec3 {
    let along = |u: f64, g: f64| {
        let (low, high) = (libm::exp(-g), libm::exp(g));
        if g == 0.0 { u } else { libm::log(0.5 * ((1.0 - u) * low + (1.0 + u) * high)) / g }
    };
    let along = |axis: usize| along(uniform[axis], grading[axis]).clamp(-1.0, 1.0);
    DVec3::new(along(0), along(1), along(2))
}

/// The cells of some points: of each, the part of the box that is nearer to it than to the others.
/// `None` for a point in the place of one before it, and for a cell thinner than rounding. The same
/// on any number of threads.
pub(super) fn voronoi_regions(sites: &[DVec3], half_extent: DVec3) -> Vec<Option<Region>> {
    let whole = Hull::cuboid(half_extent);
    let tree = SiteTree::new(sites);
    let maker = || CellMaker {
        sites,
        nearest: NearestSites::new(&tree),
        cutter: CellCutter::new(&whole),
        corners: Corners::default(),
        half_extent,
    };
    let numbers: Vec<usize> = (0..sites.len()).collect();
    threads::map_with(numbers, sites.len() * WORTH, maker, |maker, cell| maker.region(cell))
}

/// Things that a cell is worth, for sharing cells out.
const WORTH: usize = 32;

/// Two squared distances are told apart if their ratio is at least this: far above rounding.
const MARGIN: f64 = 1.0001;

/// Makes one cell after the other.
struct CellMaker<'a> {
    sites: &'a [DVec3],
    nearest: NearestSites<'a>,
    /// Of the box.
    cutter: CellCutter<'a>,
    corners: Corners,
    half_extent: DVec3,
}

/// Corners of a cell, and their squared distances from its site [m^2]. A site cuts a corner off if
/// it is nearer to it.
#[derive(Debug, Default)]
struct Corners {
    of_cell: Vec<(DVec3, f64)>,
    farthest: f64,
}

impl Corners {
    fn update(&mut self, site: DVec3, corners: impl Iterator<Item = DVec3>) {
        self.of_cell.clear();
        self.of_cell.extend(corners.map(|corner| (corner, corner.distance_squared(site))));
        self.farthest = self.of_cell.iter().fold(0.0, |most, &(_, away)| away.max(most));
    }

    /// True if a site in the box from `low` to `high` may be nearer to a corner than the cell's.
    fn may_be_cut_from(&self, low: DVec3, high: DVec3) -> bool {
        self.of_cell
            .iter()
            .any(|&(corner, away)| corner.distance_squared(corner.clamp(low, high)) < MARGIN * away)
    }
}

impl CellMaker<'_> {
    fn region(&mut self, cell: usize) -> Option<Region> {
        self.cut_out(cell)?;
        Some(Region::of_hull(&self.cutter.hull()?, self.half_extent))
    }

    /// Cuts the cell out of the box, by near sites first, because they cut most. Returns the number
    /// of planes tried; `None` if nothing is left.
    fn cut_out(&mut self, cell: usize) -> Option<usize> {
        let Self { sites, nearest, cutter, corners, .. } = self;
        let site = sites[cell];
        cutter.begin();
        nearest.begin(site);
        corners.update(site, cutter.vertices());
        let mut tried = 0;
        while let Some(number) = nearest.next(|low, high| corners.may_be_cut_from(low, high)) {
            let other = sites[number];
            // From twice as far as the farthest corner no site is nearer to one.
            if other.distance_squared(site) > 4.0 * MARGIN * corners.farthest {
                break;
            }
            let Some(normal) = (other - site).try_normalize() else {
                // The first of those in one place has the cell.
                if number < cell {
                    return None;
                }
                continue;
            };
            tried += 1;
            let half_space = HalfSpace { normal, offset: normal.dot(0.5 * (site + other)) };
            match cutter.keep_inside(&half_space) {
                Kept::Whole => {}
                Kept::Part => corners.update(site, cutter.vertices()),
                Kept::Nothing => return None,
            }
        }
        Some(tried)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// A cube, a flat box and a needle.
    fn boxes() -> impl Strategy<Value = DVec3> {
        prop::sample::select(vec![
            DVec3::ONE,
            DVec3::new(1.0, 1.0, 0.05),
            DVec3::new(1.0, 0.01, 0.01),
        ])
    }

    fn place() -> impl Strategy<Value = DVec3> {
        (-1.0..1.0f64, -1.0..1.0f64, -1.0..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
    }

    /// Sites anywhere, close to the centre, or on a lattice, where they coincide and their cells'
    /// corners lie on more than three bisectors.
    fn sites() -> impl Strategy<Value = Vec<DVec3>> {
        let spread = |kind: usize, place: DVec3| match kind {
            0 => place,
            1 => 0.02 * place,
            _ => (4.0 * place).round() / 4.0,
        };
        (prop::collection::vec(place(), 1..100), 0..3_usize)
            .prop_map(move |(places, kind)| places.into_iter().map(|at| spread(kind, at)).collect())
    }

    fn pattern(sites: &[DVec3], half_extent: DVec3) -> Pattern {
        let regions = voronoi_regions(sites, half_extent).into_iter().flatten();
        Pattern::planar_in_box(half_extent, regions.collect())
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// Cells fill the box, each point is in the cell of the first of its nearest sites, and
        /// threads change no bit.
        #[test]
        fn cells_fill_the_box_and_hold_what_is_nearest(
            sites in sites(), half_extent in boxes(), points in prop::collection::vec(place(), 50),
        ) {
            let sites: Vec<DVec3> = sites.into_iter().map(|site| site * half_extent).collect();
            let defect = pattern(&sites, half_extent).tiling_defect();
            prop_assert!(defect < 1e-12, "{defect}");
            let regions = voronoi_regions(&sites, half_extent);
            for point in points.into_iter().map(|point| point * half_extent) {
                let away = |site: usize| sites[site].distance_squared(point);
                let nearest = (0..sites.len()).min_by(|&a, &b| away(a).total_cmp(&away(b)));
                let cell = nearest.and_then(|nearest| regions[nearest].as_ref());
                prop_assert!(cell.is_some_and(|cell| cell.distance(point) < 1e-12));
            }
            let shared = threads::in_pool(|| voronoi_regions(&sites, half_extent));
            prop_assert_eq!(shared, regions);
        }

        /// Sites may lie as close to each other as rounding, or in the same place.
        #[test]
        fn cells_of_sites_in_one_place_fill_the_box(
            sites in sites(), half_extent in boxes(), twins in prop::collection::vec(place(), 1..20),
            apart in prop::sample::select(vec![0.0, 1e-16, 1e-12, 1e-10, 1e-8]),
        ) {
            let twins = sites.iter().zip(twins).map(|(&site, way)| site + apart * way);
            let all: Vec<DVec3> = sites.iter().copied().chain(twins).collect();
            let all: Vec<DVec3> = all.into_iter().map(|site| site * half_extent).collect();
            let defect = pattern(&all, half_extent).tiling_defect();
            prop_assert!(defect < 1e-8, "{defect}");
        }
    }

    /// A cell of 5000 is cut by a hundred planes or so, wherever sites lie.
    #[test]
    fn few_planes_are_tried_for_a_cell() {
        let layouts = [
            (DVec3::ONE, 0.0),
            (DVec3::new(1.0, 1.0, 0.05), 0.0),
            (DVec3::new(1.0, 0.01, 0.01), 0.0),
            (DVec3::ONE, 8.0),
        ];
        for (half_extent, clustering) in layouts {
            let voronoi = Voronoi { cells: 5000, clustering, half_extent, ..Voronoi::default() };
            let (sites, whole) = (draw_sites(&voronoi), Hull::cuboid(half_extent));
            let tree = SiteTree::new(&sites);
            let (nearest, cutter) = (NearestSites::new(&tree), CellCutter::new(&whole));
            let corners = Corners::default();
            let mut maker = CellMaker { sites: &sites, nearest, cutter, corners, half_extent };
            let tried: usize = (0..sites.len()).filter_map(|cell| maker.cut_out(cell)).sum();
            let mean = tried as f64 / sites.len() as f64;
            assert!((10.0..160.0).contains(&mean), "{half_extent} {clustering}: {mean}");
        }
    }
}
