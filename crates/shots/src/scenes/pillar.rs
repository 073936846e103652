//! A prescored pillar falls on the ground [Su09 fig. 1].

use crate::random::Random;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::geometry::{HalfSpace, Hull};
use frangible::{BodyDesc, Resolution, SceneDesc, ShapeDesc};
use glam::DVec3;

/// Figure 1.
pub(crate) const PILLAR: Shot = Shot {
    name: "pillar",
    caption: "a prescored pillar falls apart on the ground, and its shards stay low (figure 1)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: pillar,
};

/// Number of pieces of the pillar [Su09 fig. 1].
const PIECES: usize = 94;

/// Half of the pillar's edge lengths [m]: 1 m thick, 6 m high.
pub(crate) const HALF: DVec3 = DVec3::new(0.5, 3.0, 0.5);

/// Drop height [m].
const DROP: f64 = 0.5;

/// Height above the pillar's middle and thickness [m] of the layers that are in plates, from below.
const LAYERS: [(f64, f64); 3] = [(-1.4, 0.08), (0.1, 0.04), (1.6, 0.02)];

/// Of one layer.
const PLATES: usize = 6;

/// Slope of the layers, at most.
const TILT: f64 = 0.2;

/// Number of corners chipped off the blocks.
const CHIPS: usize = 12;

/// Depth of a chip, in units of the block's own depth.
const CHIP_DEPTH: f64 = 0.15;

/// Volume of a chip, at most, in units of its block's: a corner, not a side.
const CHIP_SHARE: f64 = 0.02;

/// Distance of surface samples [m]: some along a side of most pieces.
const SAMPLES: f64 = 0.15;

fn pillar(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let body = |(kind, hull): (&str, Hull)| {
        let points = hull.vertices().iter().map(DVec3::to_array).collect();
        let resolution = Resolution { voxels: None, sample_spacing: Some(SAMPLES) };
        BodyDesc {
            position: [0.0, HALF.y + DROP, 0.0],
            ..BodyDesc::new(kind, ShapeDesc::Hull { points, resolution })
        }
    };
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(pieces(options.seed).into_iter().map(body));
    Ok(scene)
}

/// Pieces of the pillar, centred at the origin, with their names: they fit without gaps.
fn pieces(seed: u64) -> Vec<(&'static str, Hull)> {
    let mut random = Random::new(seed);

    // Thin layers, a little tilted, are cut out and cut up into plates.
    let (mut blocks, mut plates) = (Vec::new(), Vec::new());
    let mut above = Hull::cuboid(HALF);
    for (height, thickness) in LAYERS {
        let tilt =
            DVec3::new(random.between(-TILT, TILT), 1.0, random.between(-TILT, TILT)).normalize();
        let floor = HalfSpace { normal: tilt, offset: height * tilt.y };
        let ceiling = HalfSpace { offset: floor.offset + thickness, ..floor };
        if let Some([below, rest]) = split(&above, &floor)
            && let Some([layer, rest]) = split(&rest, &ceiling)
        {
            blocks.push(below);
            let mut layer = vec![layer];
            cut_up(&mut layer, PLATES, &mut random, |direction| direction.reject_from(tilt));
            plates.extend(layer);
            above = rest;
        }
    }
    blocks.push(above);

    // Cut the remainder mostly along the pillar, to break up the column, and chip its corners.
    let count = PIECES - CHIPS - plates.len();
    cut_up(&mut blocks, count, &mut random, |direction| direction * DVec3::new(1.0, 0.5, 1.0));
    let mut chips = Vec::new();
    while chips.len() < CHIPS {
        let block = random.index(blocks.len());
        let normal = random.direction();
        let (low, high) = reach(&blocks[block], normal);
        let offset = high - random.between(0.3 * CHIP_DEPTH, CHIP_DEPTH) * (high - low);
        if let Some([rest, chip]) = split(&blocks[block], &HalfSpace { normal, offset })
            && volume(&chip) < CHIP_SHARE * volume(&rest)
        {
            blocks[block] = rest;
            chips.push(chip);
        }
    }
    let named = |name: &'static str| move |hull: Hull| (name, hull);
    let named_plates = plates.into_iter().map(named("plate"));
    named_plates
        .chain(blocks.into_iter().map(named("block")))
        .chain(chips.into_iter().map(named("chip")))
        .collect()
}

/// [m^3]
fn volume(hull: &Hull) -> f64 {
    hull.mass_properties().volume
}

/// The parts of a hull inside and outside of a half-space, if there are both.
fn split(hull: &Hull, cut: &HalfSpace) -> Option<[Hull; 2]> {
    let inside = hull.clipped(cut)?;
    let outside = hull.clipped(&cut.flipped())?;
    Some([inside, outside])
}

/// Splits always the largest piece, near its middle, until there are `count`. `stretch` shapes a
/// random normal.
pub(crate) fn cut_up(
    pieces: &mut Vec<Hull>,
    count: usize,
    random: &mut Random,
    stretch: impl Fn(DVec3) -> DVec3,
) {
    let mut sized: Vec<(f64, Hull)> = pieces.drain(..).map(|hull| (volume(&hull), hull)).collect();
    while sized.len() < count {
        sized.sort_by(|a, b| a.0.total_cmp(&b.0));
        let Some((size, largest)) = sized.pop() else { break };
        let normal = stretch(random.direction()).normalize_or(DVec3::Y);
        let (low, high) = reach(&largest, normal);
        let offset = low + random.between(0.35, 0.65) * (high - low);
        match split(&largest, &HalfSpace { normal, offset }) {
            Some(parts) => sized.extend(parts.map(|part| (volume(&part), part))),
            None => sized.push((size, largest)),
        }
    }
    pieces.extend(sized.into_iter().map(|(_, hull)| hull));
}

/// The lowest and the highest offset of a hull along a direction [m].
fn reach(hull: &Hull, direction: DVec3) -> (f64, f64) {
    let offsets = || hull.vertices().iter().map(|vertex| direction.dot(*vertex));
    (offsets().fold(f64::INFINITY, f64::min), offsets().fold(f64::NEG_INFINITY, f64::max))
}
