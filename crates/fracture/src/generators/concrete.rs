//! Concrete: cells with rough faces.

use crate::filling::Filling;
use crate::generators::parameters::require;
use crate::generators::voronoi::{Voronoi, sites_in, voronoi_regions};
use crate::noise::Noise;
use crate::pattern::error::PatternError;
use crate::pattern::{Cells, Pattern};
use crate::rough::Rough;
use glam::DVec3;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Cells of random points, whose faces are rough: concrete, whose cracks run around the gravel.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Concrete {
    /// Number of cells, from 1 to 10000.
    pub cells: usize,
    /// Roughness of the faces, from 0 (planar) to 1 (the limit for connected cells).
    pub roughness: f64,
    /// Size of the largest bumps, relative to that of a cell; from 0.05 to 2.
    pub grain: f64,
    /// As of [`Voronoi`].
    pub clustering: f64,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Concrete {
    fn default() -> Self {
        Self {
            cells: 25,
            roughness: 0.7,
            grain: 0.7,
            clustering: 0.0,
            seed: 1,
            half_extent: DVec3::ONE,
        }
    }
}

/// Steepness of the roughest faces: at 1 space could fold, and close to it points crowd together.
const MOST_STEEPNESS: f64 = 0.95;

impl Pattern {
    /// Rough Voronoi cells in a centred box; plane ones for no roughness.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn concrete(concrete: &Concrete) -> Result<Self, PatternError> {
        let &Concrete { cells, roughness, grain, clustering, seed, half_extent } = concrete;
        require((0.0..=1.0).contains(&roughness), "roughness", roughness, "from 0 to 1")?;
        require((0.05..=2.0).contains(&grain), "grain", grain, "from 0.05 to 2")?;
        let plane =
            Self::voronoi(&Voronoi { cells, clustering, grading: DVec3::ZERO, seed, half_extent })?;
        if roughness == 0.0 {
            return Ok(plane);
        }
        let Cells::Planar(regions) = plane.cells else { return Ok(plane) };
        let size = libm::cbrt(8.0 * half_extent.element_product() / cells as f64);
        let noise = Noise { wavelength: grain * size, steepness: MOST_STEEPNESS * roughness, seed };
        Ok(Self { cells: Cells::Rough(Rough::new(regions, noise)), ..plane })
    }
    /// Rough Voronoi cells of as many points of a solid.
    pub fn concrete_in(concrete: &Concrete, filling: &Filling) -> Self {
        let &Concrete { cells, roughness, grain, clustering, seed, half_extent } = concrete;
        let plain = Voronoi { cells, clustering, grading: DVec3::ZERO, seed, half_extent };
        let regions = voronoi_regions(&sites_in(&plain, filling), filling.half_extent());
        let mut made = filling.planar(regions.into_iter().flatten().collect());
        if roughness > 0.0
            && let Cells::Planar(regions) = made.cells
        {
            let size = libm::cbrt(filling.volume() / cells as f64);
            let steepness = MOST_STEEPNESS * roughness;
            let noise = Noise { wavelength: grain * size, steepness, seed };
            made.cells = Cells::Rough(Rough::new(regions, noise));
        }
        made
    }
}
