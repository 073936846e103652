//! Natural rubble.

use crate::filling::Filling;
use crate::generators::parameters::{deviation, direction, require, require_box, require_count};
use crate::pattern::Pattern;
use crate::pattern::error::PatternError;
use crate::pattern::region::Region;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Rock that cracks again and again, each crack ending at the ones before it. The cells of such a
/// *primary mosaic* have 6 faces and 8 corners in the mean, as natural fragments do
/// [DKST15, DJKT20].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(default, deny_unknown_fields)]
pub struct Natural {
    /// Number of cells, from 1 to 10000.
    pub cells: usize,
    /// Spread of sizes, from 0 (the largest cell cracks) over 0.5 (probability proportional to
    /// volume) to 1 (equal probability).
    pub spread: f64,
    /// Gathers small cells around the centre, from 0 (everywhere alike) to 30: a cell cracks the
    /// more likely the nearer it is, by a Gaussian whose standard deviation is `half_extent /
    /// clustering`.
    pub clustering: f64,
    /// Of the random numbers.
    pub seed: u64,
    /// Shape of the pattern's box; only its proportions matter.
    #[schemars(with = "[f64; 3]")]
    pub half_extent: DVec3,
}

impl Default for Natural {
    fn default() -> Self {
        Self { cells: 25, spread: 0.7, clustering: 0.0, seed: 1, half_extent: DVec3::ONE }
    }
}

/// Number of random directions per cell; the cell cracks across the direction of its largest
/// extent, to avoid needles and plates.
const DIRECTIONS: usize = 5;

/// A crack lies at most this share of the cell's length off its middle.
const OFF_CENTER: f64 = 0.3;

/// Which cells crack.
struct Law {
    /// See [`Natural::spread`].
    spread: f64,
    /// Standard deviations of the Gaussian around the centre; infinite for none.
    deviation: DVec3,
}

/// A cell while the box is being cut up.
struct Part {
    hull: Hull,
    center: DVec3,
    /// Probability weight for the next cut.
    weight: f64,
}

impl Part {
    fn new(hull: Hull, law: &Law) -> Self {
        let properties = hull.mass_properties();
        let mut weight = if law.spread > 0.0 {
            libm::pow(properties.volume, 1.0 / law.spread - 1.0)
        } else {
            properties.volume
        };
        if law.deviation.is_finite() {
            // Its nearest corner counts: a large cell at the centre reaches far.
            let near = |corner: &DVec3| (*corner / law.deviation).length_squared();
            let nearest = hull.vertices().iter().map(near).fold(f64::INFINITY, f64::min);
            let middle = (properties.center / law.deviation).length_squared();
            weight *= libm::exp(-0.5 * middle.min(nearest));
        }
        Self { hull, center: properties.center, weight }
    }

    /// A plane near the middle, across a direction in which the cell is long.
    fn crack(&self, random: &mut Pcg64Mcg) -> HalfSpace {
        let mut longest = (DVec3::ZERO, [0.0; 2]);
        for _ in 0..DIRECTIONS {
            let normal = direction(random);
            let heights = self.hull.vertices().iter().map(|vertex| normal.dot(*vertex));
            let low = heights.clone().fold(f64::INFINITY, f64::min);
            let high = heights.fold(f64::NEG_INFINITY, f64::max);
            if high - low > longest.1[1] - longest.1[0] {
                longest = (normal, [low, high]);
            }
        }
        let (normal, [low, high]) = longest;
        let shift = 2.0 * OFF_CENTER * (high - low) * deviation(random);
        HalfSpace { normal, offset: normal.dot(self.center) + shift }
    }

    /// The two sides of a crack; `None` if rounding leaves nothing of one.
    fn split(&self, crack: HalfSpace, law: &Law) -> Option<[Self; 2]> {
        let side = |side: HalfSpace| Some(Self::new(self.hull.clipped(&side)?, law));
        Some([side(crack)?, side(crack.flipped())?])
    }
}

impl Pattern {
    /// A centred box, cut up by planes.
    ///
    /// # Errors
    /// If a parameter is out of its range.
    pub fn natural(natural: &Natural) -> Result<Self, PatternError> {
        let &Natural { cells, spread, clustering, seed, half_extent } = natural;
        require_count(cells, "cells")?;
        require((0.0..=1.0).contains(&spread), "spread", spread, "from 0 to 1")?;
        require((0.0..=30.0).contains(&clustering), "clustering", clustering, "from 0 to 30")?;
        require_box(half_extent)?;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        // Volumes relative to the box's keep their powers from under- and overflowing.
        let size = libm::cbrt(8.0 * half_extent.element_product());
        let half = half_extent / size;
        let law = Law { spread, deviation: half / clustering };
        let mut parts = vec![Part::new(Hull::cuboid(half), &law)];
        while parts.len() < cells {
            let weights = parts.iter().map(|part| part.weight);
            let chosen = choose(weights, spread, &mut random);
            let crack = parts[chosen].crack(&mut random);
            if let Some([inside, outside]) = parts[chosen].split(crack, &law) {
                parts[chosen] = inside;
                parts.push(outside);
            }
        }

        let region = |part: &Part| Region::of_hull(&part.hull, half).scaled(size);
        let regions = parts.iter().map(region).collect();
        Ok(Self::planar_in_box(half_extent, regions))
    }
}

/// The largest part without spread, else a random one by its weight.
fn choose(
    weights: impl ExactSizeIterator<Item = f64> + Clone,
    spread: f64,
    random: &mut Pcg64Mcg,
) -> usize {
    if spread == 0.0 {
        let largest = weights.enumerate().max_by(|a, b| a.1.total_cmp(&b.1));
        return largest.map_or(0, |(at, _)| at);
    }
    let last = weights.len() - 1;
    let mut left = weights.clone().sum::<f64>() * random.random::<f64>();
    for (at, weight) in weights.enumerate() {
        left -= weight;
        if left < 0.0 {
            return at;
        }
    }
    last
}

/// Cracks that are tried across a part of a solid before it stays whole.
const TRIES: usize = 8;

/// A part of a solid while that is being cut up, known by its points.
struct Share {
    half_spaces: Vec<HalfSpace>,
    points: Vec<DVec3>,
    weight: f64,
}

impl Share {
    /// `part` of the volume is one point's.
    fn new(
        (half_spaces, points): (Vec<HalfSpace>, Vec<DVec3>),
        (center, part): (DVec3, f64),
        law: &Law,
    ) -> Self {
        let volume = part * points.len() as f64;
        let mut weight =
            if law.spread > 0.0 { libm::pow(volume, 1.0 / law.spread - 1.0) } else { volume };
        if law.deviation.is_finite() {
            let near = |point: &DVec3| ((*point - center) / law.deviation).length_squared();
            let nearest = points.iter().map(near).fold(f64::INFINITY, f64::min);
            weight *= libm::exp(-0.5 * nearest);
        }
        Self { half_spaces, points, weight }
    }

    /// A plane near the middle, across a direction in which the points spread far.
    fn crack(&self, random: &mut Pcg64Mcg) -> HalfSpace {
        let mut longest = (DVec3::ZERO, 0.0);
        for _ in 0..DIRECTIONS {
            let normal = direction(random);
            let heights = self.points.iter().map(|point| normal.dot(*point));
            let (low, high) = heights
                .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| {
                    (low.min(at), high.max(at))
                });
            if high - low > longest.1 {
                longest = (normal, high - low);
            }
        }
        let (normal, length) = longest;
        let middle = self.points.iter().sum::<DVec3>() / self.points.len() as f64;
        let shift = 2.0 * OFF_CENTER * length * deviation(random);
        HalfSpace { normal, offset: normal.dot(middle) + shift }
    }

    /// Points and half-spaces of the two sides of a crack.
    fn sides(&self, crack: HalfSpace) -> [(Vec<HalfSpace>, Vec<DVec3>); 2] {
        [crack, crack.flipped()].map(|side| {
            let is_inside = |point: &&DVec3| side.distance(**point) <= 0.0;
            let own = self.half_spaces.iter().copied().chain([side]).collect();
            (own, self.points.iter().filter(is_inside).copied().collect())
        })
    }
}

impl Pattern {
    /// A solid, cut up by planes.
    pub fn natural_in(natural: &Natural, filling: &Filling) -> Self {
        let &Natural { cells, spread, clustering, seed, half_extent } = natural;
        let mut random = Pcg64Mcg::seed_from_u64(seed);
        let deviation = filling.scale(half_extent) * half_extent / clustering;
        let law = Law { spread, deviation };
        let part = (filling.center(), 1.0 / filling.points().len() as f64);
        let whole = (Vec::new(), filling.points().to_vec());
        let mut shares = vec![Share::new(whole, part, &law)];
        while shares.len() < cells {
            let weights = shares.iter().map(|share| share.weight);
            if weights.clone().all(|weight| weight <= 0.0) {
                break;
            }
            let chosen = choose(weights, spread, &mut random);
            let mut found = None;
            for _ in 0..TRIES {
                let crack = shares[chosen].crack(&mut random);
                let sides = shares[chosen].sides(crack);
                if sides.iter().all(|side| side.1.len() >= filling.sliver()) {
                    found = Some(sides);
                    break;
                }
            }
            match found {
                Some(sides) => {
                    let [inside, outside] = sides.map(|side| Share::new(side, part, &law));
                    shares[chosen] = inside;
                    shares.push(outside);
                }
                None => shares[chosen].weight = 0.0,
            }
        }
        let region =
            |share: &Share| Region::from_half_spaces(&share.half_spaces, filling.half_extent());
        filling.planar(shares.iter().filter_map(region).collect())
    }
}
