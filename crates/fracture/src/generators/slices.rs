//! Parallel cracks.

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
        let regions = sides.map(|side| Region::from_half_spaces(&[side], half_extent));
        Self::planar_in_box(half_extent, regions.into())
    }

    /// Slices of a centred box.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn slices(slices: &Slices) -> Result<Self, PatternError> {
        let &Slices { cells, axis, jitter, seed, half_extent } = slices;
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
        let mut random = Pcg64Mcg::seed_from_u64(seed);

        // Extent of the box along the axis and across it.
        let along = half_extent.dot(axis.abs());
        let across = half_extent.length();
        let step = 2.0 * along / cells as f64;
        let (u, v) = axis.any_orthonormal_pair();

        // Each plane keeps within half a step from its place in all of the box, 0.2 by its offset
        // and 0.28 by its tilt.
        let planes: Vec<HalfSpace> = (1..cells)
            .map(|number| {
                let shift = 0.4 * jitter * step * deviation(&mut random);
                let tilt = u * deviation(&mut random) + v * deviation(&mut random);
                let slope = (0.4 * jitter * step / across).min(0.5);
                let normal = (axis + slope * tilt).normalize();
                let middle = axis * (number as f64 * step - along + shift);
                HalfSpace { normal, offset: normal.dot(middle) }
            })
            .collect();

        let regions = (0..cells)
            .map(|slice| {
                let below = slice.checked_sub(1).map(|before| planes[before].flipped());
                let above = planes.get(slice).copied();
                let sides: Vec<HalfSpace> = below.into_iter().chain(above).collect();
                Region::from_half_spaces(&sides, half_extent)
            })
            .collect();
        Ok(Self::planar_in_box(half_extent, regions))
    }
}
