//! Parallel cracks.

use crate::filling::Filling;
use crate::generators::parameters::{deviation, require, require_box, require_count};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::HalfSpace;
use glam::DVec3;
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Slices across an axis: bread, slate, a log that is sawn up.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Slices {
    /// Number of slices, from 1 to 10000.
    pub cells: usize,
    /// Normal of the slices; any length except zero. z is the collision normal, x the longest
    /// direction across it.
    #[schemars(with = "[f64; 3]")]
    pub axis: DVec3,
    /// Irregularity, from 0 (equally thick, parallel) to 1 (neighbours nearly touch at an edge of
    /// the box).
    pub jitter: f64,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Slices {
    fn default() -> Self {
        Self { cells: 8, axis: DVec3::X, jitter: 0.3, seed: 1, half_extent: DVec3::ONE }
    }
}

impl Pattern {
    /// Space in two, above and below the fracture centre: z is the normal of the crack.
    pub fn halves() -> Self {
        let half_extent = DVec3::ONE;
        let above = HalfSpace { normal: -DVec3::Z, offset: 0.0 };
        let sides = [above, above.flipped()];
        let region = |side: HalfSpace| Region::from_half_spaces(&[side], half_extent);
        Self::planar_in_box(half_extent, sides.into_iter().filter_map(region).collect())
    }

    /// Slices of a centred box.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn slices(slices: &Slices) -> Result<Self, PatternError> {
        let &Slices { cells, axis, jitter, half_extent, .. } = slices;
        require_count(cells, "cells")?;
        require((0.0..=1.0).contains(&jitter), "jitter", jitter, "from 0 to 1")?;
        require_box(half_extent)?;
        let length = axis.length();
        require(
            length > 1e-9 && length < 1e9,
            "axis",
            length,
            "three finite numbers that are not all 0",
        )?;
        let axis = axis / length;

        // Extent of the box along the axis and across it.
        let along = half_extent.dot(axis.abs());
        let step = 2.0 * along / cells as f64;
        let places: Vec<f64> = (1..cells).map(|number| number as f64 * step - along).collect();
        let planes = cracks(slices, &places, (step, half_extent.length()));
        let region = |sides: Vec<HalfSpace>| Region::from_half_spaces(&sides, half_extent);
        Ok(Self::planar_in_box(half_extent, between(&planes).filter_map(region).collect()))
    }

    /// As many slices of a solid.
    pub fn slices_in(slices: &Slices, filling: &Filling) -> Self {
        let axis = slices.axis.normalize();
        let mut heights: Vec<f64> = filling.points().iter().map(|point| axis.dot(*point)).collect();
        heights.sort_by(f64::total_cmp);
        let (places, step) = places_in(&heights, slices.cells);
        let planes = cracks(slices, &places, (step, filling.half_extent().length()));
        let region =
            |sides: Vec<HalfSpace>| Region::from_half_spaces(&sides, filling.half_extent());
        filling.planar(between(&planes).filter_map(region).collect())
    }
}

/// Where sorted heights part into about `cells` slices that are equally thick, none of them empty,
/// and how thick they are.
fn places_in(heights: &[f64], cells: usize) -> (Vec<f64>, f64) {
    // Thickness is halved down to rounding.
    const HALVINGS: usize = 40;
    let parted = |step: f64| {
        let mut places = Vec::new();
        let mut start = 0;
        loop {
            let end = heights.partition_point(|&height| height < heights[start] + step);
            if end >= heights.len() || end == start {
                return places;
            }
            places.push(0.5 * (heights[end - 1] + heights[end]));
            start = end;
        }
    };
    let whole = heights[heights.len() - 1] - heights[0];
    let (mut thin, mut thick) = (0.0, 2.0 * whole);
    for _ in 0..HALVINGS {
        let step = 0.5 * (thin + thick);
        if parted(step).len() + 1 > cells { thin = step } else { thick = step }
    }
    (parted(thick), thick)
}

/// Planes at places along the axis. Each keeps within half a step from its place in all of the box,
/// 0.2 by its offset and 0.28 by its tilt.
fn cracks(slices: &Slices, places: &[f64], (step, across): (f64, f64)) -> Vec<HalfSpace> {
    let axis = slices.axis / slices.axis.length();
    let (u, v) = axis.any_orthonormal_pair();
    let mut random = Pcg64Mcg::seed_from_u64(slices.seed);
    let crack = |&place: &f64| {
        let shift = 0.4 * slices.jitter * step * deviation(&mut random);
        let tilt = u * deviation(&mut random) + v * deviation(&mut random);
        let slope = (0.4 * slices.jitter * step / across).min(0.5);
        let normal = (axis + slope * tilt).normalize();
        let middle = axis * (place + shift);
        HalfSpace { normal, offset: normal.dot(middle) }
    };
    places.iter().map(crack).collect()
}

/// The sides of each slice between planes.
fn between(planes: &[HalfSpace]) -> impl Iterator<Item = Vec<HalfSpace>> {
    (0..=planes.len()).map(|slice| {
        let below = slice.checked_sub(1).map(|before| planes[before].flipped());
        below.into_iter().chain(planes.get(slice).copied()).collect()
    })
}
