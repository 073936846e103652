//! Wood.

use super::nearest_sites::{NearestSites, SiteTree};
use super::voronoi::voronoi_regions;
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
use std::f64::consts::TAU;

/// Long splinters along a grain, with irregular cross sections and pointed ends: wood.
///
/// Cracks run along the grain around random lines, and each splinter between them is broken across,
/// where it pleases, at a steep angle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Splinters {
    /// Number of splinters side by side, from 1 to 10000 with their pieces.
    pub fibres: usize,
    /// Number of pieces that each splinter is broken into along its length, at least 1.
    pub pieces: usize,
    /// Along what the splinters lie: 0, 1 or 2 for the pattern's x, y or z. x follows the body's
    /// longest side.
    pub grain: usize,
    /// Length of the pointed ends relative to the splinter's width, from 0 (cut square) to 20.
    pub sharpness: f64,
    /// Displacement of the splinters' breaks from their regular places, from 0 (all in the same
    /// place) to 1, in piece lengths.
    pub spread: f64,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter. A long one suits what is long along
    /// the grain.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Splinters {
    fn default() -> Self {
        Self {
            fibres: 24,
            pieces: 2,
            grain: 0,
            sharpness: 4.0,
            spread: 0.5,
            seed: 1,
            half_extent: DVec3::new(1.0, 0.25, 0.25),
        }
    }
}

impl Pattern {
    /// Splinters in a centred box.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn splinters(splinters: &Splinters) -> Result<Self, PatternError> {
        let &Splinters { fibres, pieces, grain, sharpness, spread, seed, half_extent } = splinters;
        require_count(fibres, "fibres")?;
        require_count(pieces, "pieces")?;
        require_count(fibres.saturating_mul(pieces), "pieces")?;
        require(grain <= 2, "grain", grain as f64, "0, 1 or 2")?;
        require((0.0..=20.0).contains(&sharpness), "sharpness", sharpness, "from 0 to 20")?;
        require((0.0..=1.0).contains(&spread), "spread", spread, "from 0 to 1")?;
        require_box(half_extent)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);

        // Lines along the grain, whose Voronoi cells are the splinters.
        let axis = DVec3::AXES[grain];
        let (u, v) = (DVec3::AXES[(grain + 1) % 3], DVec3::AXES[(grain + 2) % 3]);
        let sites: Vec<DVec3> = (0..fibres)
            .map(|_| (u * deviation(&mut random) + v * deviation(&mut random)) * 2.0 * half_extent)
            .collect();
        let columns = voronoi_regions(&sites, half_extent);

        // Break each across.
        let mut regions = Vec::with_capacity(fibres * pieces);
        for (column, &site) in columns.iter().zip(&sites) {
            let Some(column) = column else { continue };
            let half_length = half_extent[grain];
            let width = reach_across(column, site, axis, half_extent);
            let (start, length) = (-half_length, 2.0 * half_length);
            let splinter = Splinter { column, site, width, start, length };
            for around in splinter.broken(splinters, pieces, &mut random) {
                regions.extend(Region::from_half_spaces(&around, half_extent));
            }
        }
        Ok(Self::planar_in_box(half_extent, regions))
    }

    /// Splinters of a solid, `cells` pieces of them in all.
    pub fn splinters_in(splinters: &Splinters, cells: usize, filling: &Filling) -> Self {
        let half_extent = filling.half_extent();
        let axis = DVec3::AXES[splinters.grain];
        let most = splinters.pieces.clamp(1, cells.div_ceil(2));
        let fibres = cells.div_ceil(most);
        let points = filling.points();
        let sites: Vec<DVec3> =
            points.iter().take(fibres).map(|point| point.reject_from(axis)).collect();

        // How far each goes along the grain.
        let mut ends = vec![(f64::INFINITY, f64::NEG_INFINITY); sites.len()];
        let tree = SiteTree::new(&sites);
        let mut nearest = NearestSites::new(&tree);
        for &point in points.iter().take(POINTS_OF_A_FIBRE * sites.len()) {
            let place = axis.dot(point);
            nearest.begin(point.reject_from(axis));
            if let Some(end) = nearest.next(|_, _| true).map(|fibre| &mut ends[fibre]) {
                *end = (end.0.min(place), end.1.max(place));
            }
        }
        let mut random = Pcg64Mcg::seed_from_u64(splinters.seed);
        let mut regions = Vec::with_capacity(cells);
        let columns = voronoi_regions(&sites, half_extent);
        for (fibre, (column, &site)) in columns.iter().zip(&sites).enumerate() {
            let Some(column) = column else { continue };
            let (start, end) = ends[fibre];
            let width = reach_across(column, site, axis, half_extent);
            let length = (end - start).max(0.0);
            let splinter = Splinter { column, site, width, start, length };
            // The first make up for what does not divide evenly.
            let pieces = most - usize::from(fibre < fibres * most - cells);
            for around in splinter.broken(splinters, pieces, &mut random) {
                regions.extend(Region::from_half_spaces(&around, half_extent));
            }
        }
        filling.planar(regions)
    }
}

/// Points of a solid by which the ends of each fibre are known.
const POINTS_OF_A_FIBRE: usize = 96;

/// One before it is broken across.
struct Splinter<'a> {
    column: &'a Region,
    /// On its line.
    site: DVec3,
    /// Extent from its line.
    width: f64,
    /// Where it begins along the grain, and how long it is.
    start: f64,
    length: f64,
}

impl Splinter<'_> {
    /// The sides of each of its pieces.
    fn broken(
        &self,
        splinters: &Splinters,
        pieces: usize,
        random: &mut Pcg64Mcg,
    ) -> Vec<Vec<HalfSpace>> {
        let &Splinters { grain, sharpness, spread, .. } = splinters;
        let axis = DVec3::AXES[grain];
        let (u, v) = (DVec3::AXES[(grain + 1) % 3], DVec3::AXES[(grain + 2) % 3]);
        let sides: Vec<HalfSpace> = self.column.cuts.iter().map(|cut| cut.half_space).collect();
        let piece = self.length / pieces as f64;
        // Steep, but so that the cracks of one splinter meet neither each other nor its ends.
        let room = 0.25 * piece;
        let slope = (sharpness * (0.5 + random_share(random))).min(room / self.width);
        let breaks: Vec<HalfSpace> = (1..pieces)
            .map(|number| {
                let angle = TAU * deviation(random);
                let tilt = u * libm::cos(angle) + v * libm::sin(angle);
                let shift = spread * (piece - 2.0 * slope * self.width) * deviation(random);
                let middle = self.site.reject_from(axis)
                    + axis * (number as f64 * piece + self.start + shift);
                let normal = (axis + slope * tilt).normalize();
                HalfSpace { normal, offset: normal.dot(middle) }
            })
            .collect();
        let around = |number: usize| {
            let mut around = sides.clone();
            around.extend(number.checked_sub(1).map(|before| breaks[before].flipped()));
            around.extend(breaks.get(number));
            around
        };
        (0..pieces).map(around).collect()
    }
}

/// Uniform in [0, 1).
fn random_share(random: &mut Pcg64Mcg) -> f64 {
    deviation(random) + 0.5
}

/// Extent of a splinter from its line.
fn reach_across(column: &Region, site: DVec3, axis: DVec3, half_extent: DVec3) -> f64 {
    let hull = column.hull(half_extent);
    let corners = hull.iter().flat_map(|hull| hull.vertices());
    corners
        .map(|&corner| (corner - site).reject_from(axis).length())
        .fold(0.0, f64::max)
        .max(1e-9 * half_extent.max_element())
}
