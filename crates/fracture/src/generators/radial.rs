//! Struck glass.

use crate::generators::parameters::{MOST_CELLS, deviation, require};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::HalfSpace;
use glam::{DVec2, DVec3};
use rand::SeedableRng;
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Cracks that run from the centre like spokes, crossed by rings: struck glass. Every crack
/// contains the direction of the collision normal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Radial {
    /// Number of wedges around the centre, at least 3; the paper's pattern has 12.
    pub spokes: usize,
    /// Number of rings around the centre, denser towards it; 0 is the paper's pattern.
    pub rings: usize,
    /// Irregularity, from 0 (regular) to 1.
    pub jitter: f64,
    /// Of the random numbers.
    pub seed: u64,
}

impl Default for Radial {
    fn default() -> Self {
        Self { spokes: 12, rings: 0, jitter: 0.5, seed: 1 }
    }
}

/// Half-space around the z axis' side of the vertical plane through `from` and `to`; both
/// counter-clockwise about the axis.
fn chord(from: DVec2, to: DVec2) -> HalfSpace {
    let along = (to - from).normalize();
    let normal = DVec3::new(along.y, -along.x, 0.0);
    HalfSpace { normal, offset: normal.dot(from.extend(0.0)) }
}

impl Pattern {
    /// Spokes and rings in the cube from -1 to 1, centred.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn radial(radial: &Radial) -> Result<Self, PatternError> {
        let is_known = (3..=MOST_CELLS).contains(&radial.spokes);
        require(is_known, "spokes", radial.spokes as f64, "from 3 to 10000")?;
        let cells = radial.rings.saturating_add(1).saturating_mul(radial.spokes);
        require(
            cells <= MOST_CELLS,
            "rings",
            radial.rings as f64,
            "so few that there are at most 10000 cells",
        )?;
        require((0.0..=1.0).contains(&radial.jitter), "jitter", radial.jitter, "from 0 to 1")?;
        let mut random = Pcg64Mcg::seed_from_u64(radial.seed);

        // Angles of the spokes. No step exceeds 1.4 times the regular one, which is less than half
        // a turn.
        let step = TAU / radial.spokes as f64;
        let directions: Vec<DVec2> = (0..radial.spokes)
            .map(|spoke| step * (spoke as f64 + 0.4 * radial.jitter * deviation(&mut random)))
            .map(|angle| DVec2::new(libm::cos(angle), libm::sin(angle)))
            .collect();

        // Corners of the cobweb, ring by ring outwards. They stay in order along each spoke, so
        // chords never cross.
        let corners: Vec<Vec<DVec2>> = (0..radial.rings)
            .map(|ring| {
                let corner = |&direction: &DVec2| {
                    let place = (ring as f64 + 1.0 + 0.6 * radial.jitter * deviation(&mut random))
                        / (radial.rings as f64 + 0.5);
                    // Radii grow as the power 3/2 of the ring's number, from a small middle to
                    // nearly the rim.
                    direction * (place * place.sqrt())
                };
                directions.iter().map(corner).collect()
            })
            .collect();

        // Each sector between two spokes and two chords is one region.
        let half_extent = DVec3::ONE;
        let mut regions = Vec::with_capacity(radial.spokes * (radial.rings + 1));
        for spoke in 0..radial.spokes {
            let next = (spoke + 1) % radial.spokes;
            let sides =
                [chord(DVec2::ZERO, directions[spoke]), chord(directions[next], DVec2::ZERO)];
            for ring in 0..=radial.rings {
                let mut half_spaces = sides.to_vec();
                if ring > 0 {
                    let inner = &corners[ring - 1];
                    half_spaces.push(chord(inner[next], inner[spoke]));
                }
                if ring < radial.rings {
                    let outer = &corners[ring];
                    half_spaces.push(chord(outer[spoke], outer[next]));
                }
                regions.push(Region::from_half_spaces(&half_spaces, half_extent));
            }
        }
        Ok(Self::planar_in_box(half_extent, regions))
    }
}
