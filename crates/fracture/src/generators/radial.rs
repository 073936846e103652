//! Struck glass.

use crate::filling::Filling;
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

/// A sector of a pattern that is made for a solid has at least this part of a mean piece.
const LEAST_SECTOR: f64 = 0.025;

/// Most sectors that are tried.
const MOST_SECTORS: usize = 4096;

/// Most points of a solid that sectors are counted by.
const MOST_PLACES: usize = 8192;

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

        let half_extent = DVec3::ONE;
        let regions = sectors(radial, |place| place * place.sqrt());
        let region = |sides: Vec<HalfSpace>| Region::from_half_spaces(&sides, half_extent);
        Ok(Self::planar_in_box(half_extent, regions.into_iter().map(region).collect()))
    }

    /// Spokes and rings around the blow, about `cells` of which meet a solid.
    pub fn radial_in(radial: &Radial, cells: usize, filling: &Filling) -> Self {
        let center = filling.center();
        let cobweb = Cobweb::new(filling);
        let (spokes, rings) = cobweb.parted_into(cells, radial.spokes);
        let [inner, outer] = cobweb.radii(spokes, cells);
        let radial = Radial { spokes, rings, ..radial.clone() };
        let radius = |place: f64| inner + (outer - inner) * place * place.sqrt();
        let moved =
            |side: HalfSpace| HalfSpace { offset: side.offset + side.normal.dot(center), ..side };
        let region = |sides: Vec<HalfSpace>| {
            let sides: Vec<HalfSpace> = sides.into_iter().map(moved).collect();
            Region::bounded(&sides, filling.half_extent())
        };
        let regions = sectors(&radial, radius).into_iter().filter_map(region).collect();
        filling.planar(regions)
    }
}

/// The sides of each sector between two spokes and two rings; a ring's radius is given by its
/// place, from 0 in the middle to 1 at the rim.
fn sectors(radial: &Radial, radius: impl Fn(f64) -> f64) -> Vec<Vec<HalfSpace>> {
    let mut random = Pcg64Mcg::seed_from_u64(radial.seed);

    // Angles of the spokes. No step exceeds 1.4 times the regular one, which is less than half a
    // turn.
    let step = TAU / radial.spokes as f64;
    let directions: Vec<DVec2> = (0..radial.spokes)
        .map(|spoke| step * (spoke as f64 + 0.4 * radial.jitter * deviation(&mut random)))
        .map(|angle| DVec2::new(libm::cos(angle), libm::sin(angle)))
        .collect();

    // Corners of the cobweb, ring by ring outwards. They stay in order along each spoke, so chords
    // never cross.
    let corners: Vec<Vec<DVec2>> = (0..radial.rings)
        .map(|ring| {
            let corner = |&direction: &DVec2| {
                let place = (ring as f64 + 1.0 + 0.6 * radial.jitter * deviation(&mut random))
                    / (radial.rings as f64 + 0.5);
                // Radii grow as the power 3/2 of the ring's number, from a small middle to nearly
                // the rim.
                direction * radius(place)
            };
            directions.iter().map(corner).collect()
        })
        .collect();

    // Each sector between two spokes and two chords is one region.
    let mut regions = Vec::with_capacity(radial.spokes * (radial.rings + 1));
    for spoke in 0..radial.spokes {
        let next = (spoke + 1) % radial.spokes;
        let sides = [chord(DVec2::ZERO, directions[spoke]), chord(directions[next], DVec2::ZERO)];
        for ring in 0..=radial.rings {
            let mut half_spaces = sides.to_vec();
            if radial.spokes == 2 {
                // Halves of a disc.
                let side = chord(DVec2::ZERO, directions[0]);
                half_spaces = vec![if spoke == 0 { side } else { side.flipped() }];
            }
            if ring > 0 {
                let inner = &corners[ring - 1];
                half_spaces.push(chord(inner[next], inner[spoke]));
            }
            if ring < radial.rings {
                let outer = &corners[ring];
                half_spaces.push(chord(outer[spoke], outer[next]));
            }
            regions.push(half_spaces);
        }
    }
    regions
}

/// Places of a solid as a cobweb around the blow sees them.
struct Cobweb {
    /// Angle [turns] and distance from the blow [m], by distance.
    places: Vec<(f64, f64)>,
}

impl Cobweb {
    fn new(filling: &Filling) -> Self {
        let place = |&point: &DVec3| {
            let from = (point - filling.center()).truncate();
            (libm::atan2(from.y, from.x) / TAU + 0.5, from.length())
        };
        // A cell is known by some dozens of points.
        let mut places: Vec<(f64, f64)> =
            filling.points().iter().take(MOST_PLACES).map(place).collect();
        places.sort_by(|a, b| a.1.total_cmp(&b.1));
        Self { places }
    }

    /// Radii of a middle, whose sectors are no slivers among so many cells, and of the whole [m].
    fn radii(&self, spokes: usize, cells: usize) -> [f64; 2] {
        let part = LEAST_SECTOR * spokes as f64 / cells as f64;
        let last = self.places.len() - 1;
        [((part * last as f64) as usize).min(last), last].map(|at| self.places[at].1)
    }

    /// How many sectors meet the solid in more than a sliver.
    fn count(&self, (spokes, rings): (usize, usize), cells: usize) -> usize {
        let [inner, outer] = self.radii(spokes, cells);
        let width = (outer - inner).max(f64::MIN_POSITIVE);
        let mut held = vec![0_usize; spokes * (rings + 1)];
        for &(angle, radius) in &self.places {
            let place = ((radius - inner) / width).max(0.0);
            let place = libm::cbrt(place * place) * (rings as f64 + 0.5);
            let ring = (place as usize).min(rings);
            let spoke = ((angle * spokes as f64) as usize).min(spokes - 1);
            held[spoke * (rings + 1) + ring] += 1;
        }
        let least = (LEAST_SECTOR * self.places.len() as f64 / cells as f64) as usize;
        held.into_iter().filter(|&points| points > least).count()
    }

    /// Spokes and rings with about so many sectors in the solid, and about as many spokes as
    /// `usual`.
    fn parted_into(&self, cells: usize, usual: usize) -> (usize, usize) {
        if cells == 2 {
            return (2, 0);
        }
        let usual = usual.min(cells).max(3);
        let most_rings = MOST_SECTORS.min(8 * cells) / usual;
        let (mut few, mut many) = (0, 1);
        while many < most_rings && self.count((usual, many), cells) < cells {
            (few, many) = (many, (2 * many).min(most_rings));
        }
        while few + 1 < many {
            let middle = usize::midpoint(few, many);
            if self.count((usual, middle), cells) < cells { few = middle } else { many = middle }
        }
        // More spokes or fewer do the rest.
        let mut best = ((usual, few), usize::MAX);
        for rings in [few, many] {
            let mut steps: Vec<usize> = ((usual / 2).max(3)..=2 * usual).collect();
            steps.sort_by_key(|spokes| spokes.abs_diff(usual));
            for spokes in steps {
                let off = self.count((spokes, rings), cells).abs_diff(cells);
                if off < best.1 {
                    best = ((spokes, rings), off);
                }
            }
        }
        best.0
    }
}
