//! Cells around random points.

use crate::filling::Filling;
use crate::generators::parameters::{deviation, require, require_box, require_count};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::{HalfSpace, Hull};
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
        Ok(Self::planar_in_box(half_extent, regions))
    }
}

impl Pattern {
    /// Voronoi cells of as many points of a solid.
    pub fn voronoi_in(voronoi: &Voronoi, filling: &Filling) -> Self {
        filling.planar(regions_in(&sites_in(voronoi, filling), filling.half_extent()))
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
    keys.sort_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    keys.iter().take(cells).map(|&(_, number)| points[number]).collect()
}

/// The cells of some points in the box.
pub(super) fn regions_in(sites: &[DVec3], half_extent: DVec3) -> Vec<Region> {
    (0..sites.len()).filter_map(|cell| region_in(sites, cell, half_extent)).collect()
}

/// The cell of one of some points in the box.
pub(super) fn region_in(sites: &[DVec3], cell: usize, half_extent: DVec3) -> Option<Region> {
    Region::bounded(&bisectors(sites, cell, half_extent), half_extent)
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
pub(super) fn voronoi_regions(sites: &[DVec3], half_extent: DVec3) -> Vec<Region> {
    (0..sites.len())
        .map(|cell| Region::from_half_spaces(&bisectors(sites, cell, half_extent), half_extent))
        .collect()
}

/// The points nearer to one site than to each other site; near sites first, because they cut most.
/// The list ends with the first site that is too far to cut anything.
fn bisectors(sites: &[DVec3], cell: usize, half_extent: DVec3) -> Vec<HalfSpace> {
    let site = sites[cell];
    let mut others: Vec<DVec3> = sites
        .iter()
        .enumerate()
        .filter(|&(other, _)| other != cell)
        .map(|(_, &other)| other)
        .collect();
    others.sort_by(|a, b| a.distance_squared(site).total_cmp(&b.distance_squared(site)));
    let mut around = Vec::new();
    let mut hull = Some(Hull::cuboid(half_extent));
    for other in others {
        let vertices = hull.iter().flat_map(Hull::vertices);
        let reach = vertices.map(|vertex| vertex.distance(site)).fold(0.0, f64::max);
        if other.distance(site) > 2.0001 * reach {
            break;
        }
        let Some(normal) = (other - site).try_normalize() else { continue };
        let half_space = HalfSpace { normal, offset: normal.dot(0.5 * (site + other)) };
        around.push(half_space);
        hull = hull.and_then(|hull| hull.clipped(&half_space));
    }
    around
}
