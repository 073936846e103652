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

/// A sector with less than this part of a mean piece in the solid is a sliver there.
const SLIVER: f64 = 0.01;

/// Most sectors that are tried.
const MOST_SECTORS: usize = 4096;

/// Most points of a solid that sectors are counted by.
const MOST_PLACES: usize = 8192;

/// So many times the usual number of spokes, where most of them go past the solid.
const MOST_TIMES: usize = 4;

/// So many spokes more or fewer than usual are tried.
const STEPS: usize = 4;

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
        let regions = sectors(radial, |place| place * place.sqrt(), |_, _| true);
        let region = |sides: Vec<HalfSpace>| Region::from_half_spaces(&sides, half_extent);
        Ok(Self::planar_in_box(half_extent, regions.into_iter().filter_map(region).collect()))
    }

    /// Spokes and rings around the blow, `cells` of whose sectors meet a solid. Where whole rings do
    /// not come out even, some sectors lack the crack between them.
    pub fn radial_in(radial: &Radial, cells: usize, filling: &Filling) -> Self {
        if cells == 2 {
            return Self::halved(filling);
        }
        let center = filling.center();
        let cobweb = Cobweb::new(radial, cells, filling);
        let web = cobweb.parted();
        let is_left_out = cobweb.left_out(&web);
        let radial = Radial { spokes: web.spokes, rings: web.rings, ..radial.clone() };
        let has_crack = |spoke: usize, ring: usize| !is_left_out[spoke * web.rings + ring];
        let moved = |side: HalfSpace| {
            let offset = side.offset + side.normal.dot(center);
            HalfSpace { offset, ..side }
        };
        let region = |sides: Vec<HalfSpace>| {
            let sides: Vec<HalfSpace> = sides.into_iter().map(moved).collect();
            Region::from_half_spaces(&sides, filling.half_extent())
        };
        let regions = sectors(&radial, |place| web.radius(place), has_crack);
        filling.planar(regions.into_iter().filter_map(region).collect())
    }
}

impl Pattern {
    /// A crack through the blow and the middle of a solid.
    fn halved(filling: &Filling) -> Self {
        let points = filling.points();
        let middle = points.iter().sum::<DVec3>() / points.len() as f64;
        let way = (middle - filling.center()).truncate();
        let is_far = way.length() > NO_WAY * filling.half_extent().length();
        let crack = chord(DVec2::ZERO, if is_far { way } else { DVec2::Y });
        let offset = crack.normal.dot(filling.center());
        let sides = [crack, crack.flipped()]
            .map(|side| HalfSpace { offset: side.normal.dot(crack.normal) * offset, ..side });
        let region = |side| Region::from_half_spaces(&[side], filling.half_extent());
        filling.planar(sides.into_iter().filter_map(region).collect())
    }
}

/// Blows nearer to the middle than this part of a body's size have no way to it.
const NO_WAY: f64 = 0.02;

/// Directions of the spokes. No step exceeds 1.4 times the regular one, which is less than half a
/// turn.
fn angles(radial: &Radial, random: &mut Pcg64Mcg) -> Vec<f64> {
    let step = TAU / radial.spokes as f64;
    (0..radial.spokes)
        .map(|spoke| step * (spoke as f64 + 0.4 * radial.jitter * deviation(random)))
        .collect()
}

/// The sides of each sector between two spokes and two rings that have a crack there; a ring's
/// radius is given by its place, from 0 in the middle to 1 at the rim.
fn sectors(
    radial: &Radial,
    radius: impl Fn(f64) -> f64,
    has_crack: impl Fn(usize, usize) -> bool,
) -> Vec<Vec<HalfSpace>> {
    let mut random = Pcg64Mcg::seed_from_u64(radial.seed);
    let direction = |angle: f64| DVec2::new(libm::cos(angle), libm::sin(angle));
    let directions: Vec<DVec2> = angles(radial, &mut random).into_iter().map(direction).collect();

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
        let mut inner: Option<HalfSpace> = None;
        for ring in 0..=radial.rings {
            let outer = corners.get(ring).map(|ring| chord(ring[spoke], ring[next]));
            if outer.is_some() && !has_crack(spoke, ring) {
                continue;
            }
            let mut half_spaces = sides.to_vec();
            half_spaces.extend(inner);
            half_spaces.extend(outer);
            regions.push(half_spaces);
            inner = corners.get(ring).map(|ring| chord(ring[next], ring[spoke]));
        }
    }
    regions
}

/// Spokes and rings.
#[derive(Clone, Copy)]
struct Web {
    spokes: usize,
    rings: usize,
    /// Radii of the middle and of the whole [m].
    radii: [f64; 2],
}

impl Web {
    /// Of a place from 0 in the middle to 1 at the rim [m].
    fn radius(&self, place: f64) -> f64 {
        let [inner, outer] = self.radii;
        inner + (outer - inner) * place * place.sqrt()
    }

    /// The ring that a place is in, by its distance from the blow [m].
    fn ring(&self, distance: f64) -> usize {
        let [inner, outer] = self.radii;
        let part = ((distance - inner) / (outer - inner).max(f64::MIN_POSITIVE)).max(0.0);
        ((libm::cbrt(part * part) * (self.rings as f64 + 0.5)) as usize).min(self.rings)
    }
}

/// Places of a solid as a cobweb around the blow sees them.
struct Cobweb<'a> {
    radial: &'a Radial,
    /// Number of sectors that are to meet the solid.
    cells: usize,
    /// Angle [rad] from 0 to a turn and distance from the blow [m], by distance.
    places: Vec<(f64, f64)>,
}

impl<'a> Cobweb<'a> {
    fn new(radial: &'a Radial, cells: usize, filling: &Filling) -> Self {
        let place = |&point: &DVec3| {
            let from = (point - filling.center()).truncate();
            let angle = libm::atan2(from.y, from.x);
            (if angle < 0.0 { angle + TAU } else { angle }, from.length())
        };
        let mut places: Vec<(f64, f64)> =
            filling.points().iter().take(MOST_PLACES).map(place).collect();
        places.sort_by(|a, b| a.1.total_cmp(&b.1));
        Self { radial, cells, places }
    }

    /// A middle, whose sectors are no slivers among so many cells, and a whole with rings.
    fn web(&self, spokes: usize, rings: usize) -> Web {
        let part = LEAST_SECTOR * spokes as f64 / self.cells as f64;
        let last = self.places.len() - 1;
        let radii = [((part * last as f64) as usize).min(last), last].map(|at| self.places[at].1);
        Web { spokes, rings, radii }
    }

    /// How many places each sector holds, spoke by spoke.
    fn held(&self, web: &Web) -> Vec<usize> {
        let mut random = Pcg64Mcg::seed_from_u64(self.radial.seed);
        let radial = Radial { spokes: web.spokes, ..self.radial.clone() };
        let angles = angles(&radial, &mut random);
        let mut held = vec![0_usize; web.spokes * (web.rings + 1)];
        for &(angle, distance) in &self.places {
            // The first spoke may lie on either side of the axis.
            let angle = if angle >= angles[0] + TAU { angle - TAU } else { angle };
            let before = angles.partition_point(|&spoke| spoke <= angle);
            let spoke = (before + web.spokes - 1) % web.spokes;
            held[spoke * (web.rings + 1) + web.ring(distance)] += 1;
        }
        held
    }

    /// More places than this are no sliver.
    fn least(&self) -> usize {
        (SLIVER * self.places.len() as f64 / self.cells as f64) as usize
    }

    /// How many sectors meet the solid in more than a sliver.
    fn count(&self, spokes: usize, rings: usize) -> usize {
        let held = self.held(&self.web(spokes, rings));
        held.into_iter().filter(|&points| points > self.least()).count()
    }

    /// Spokes and rings with few more than the sectors that are to meet the solid, and about as
    /// many spokes there as usual.
    fn parted(&self) -> Web {
        let usual = self.radial.spokes.min(self.cells).max(3);
        let met = self.count(usual, 0).max(1);
        let usual = usual * usual.div_ceil(met).min(MOST_TIMES);
        let most_rings = (MOST_SECTORS / usual).min(8 * self.cells);
        let (mut few, mut many) = (0, 1);
        while many < most_rings && self.count(usual, many) < self.cells {
            (few, many) = (many, (2 * many).min(most_rings));
        }
        while few + 1 < many {
            let middle = usize::midpoint(few, many);
            if self.count(usual, middle) < self.cells { few = middle } else { many = middle }
        }
        // More spokes or fewer do the rest.
        let mut best = (f64::INFINITY, self.web(usual, many));
        for rings in [few, many] {
            for spokes in (usual - usual.min(STEPS)).max(3)..=usual + STEPS {
                let count = self.count(spokes, rings);
                let over = count as f64 / self.cells as f64 - 1.0;
                let can_do = over == 0.0 || over > 0.0 && rings > 0;
                let unusual = (spokes as f64 / usual as f64 - 1.0).abs();
                let off = 4.0 * over.abs() + unusual + if can_do { 0.0 } else { 100.0 };
                if off < best.0 {
                    best = (off, self.web(spokes, rings));
                }
            }
        }
        best.1
    }

    /// Cracks along rings that are left out, spoke by spoke: beside the smallest sectors, until
    /// there are as many as are wanted.
    fn left_out(&self, web: &Web) -> Vec<bool> {
        let mut held = self.held(web);
        let least = self.least();
        let rings = web.rings;
        let mut is_left_out = vec![false; web.spokes * rings];
        let count = held.iter().filter(|&&points| points > least).count();
        for _ in self.cells..count {
            let sum = |crack: usize| {
                let first = crack / rings * (rings + 1) + crack % rings;
                let pair = [held[first], held[first + 1]];
                (pair.iter().all(|&points| points > least)).then_some(pair[0] + pair[1])
            };
            let open = (0..is_left_out.len()).filter(|&crack| !is_left_out[crack]);
            let smallest = open.filter_map(|crack| Some((sum(crack)?, crack))).min();
            let Some((all, crack)) = smallest else { break };
            let first = crack / rings * (rings + 1) + crack % rings;
            is_left_out[crack] = true;
            // Those that are one already count once, by the outer one.
            held[first + 1] = all;
            held[first] = 0;
        }
        is_left_out
    }
}
