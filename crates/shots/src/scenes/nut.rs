//! A nut on a bolt: two threads, given as triangles and sampled as level sets, that turn by sliding
//! down each other.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc};
use std::f64::consts::TAU;

/// Down a smooth thread.
pub(crate) const NUT: Shot = Shot {
    name: "nut",
    caption: "a nut turns down a bolt by its weight",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(nut(0.0)),
};

/// Pitch of the thread [m].
pub(crate) const PITCH: f64 = 0.3;

/// Of the bolt, in the middle of its thread [m].
const RADIUS: f64 = 0.5;

/// Of the thread, up and down from the middle [m].
const DEPTH: f64 = 0.08;

/// Between bolt and nut [m].
const CLEARANCE: f64 = 0.01;

/// Of the bolt [m].
const BOLT: f64 = 3.0;

/// Height of the nut, and its outer radius [m].
pub(crate) const NUT_SIZE: [f64; 2] = [0.6, 0.9];

/// Where the nut begins, above the bolt's middle [m]: a whole number of turns.
const START: f64 = 3.0 * PITCH;

/// Corners around, and layers in each turn of the thread.
const AROUND: usize = 96;

/// See `AROUND`.
const LAYERS: usize = 24;

/// Edge of the voxels [m].
const VOXEL: f64 = 0.025;

/// Of the thread at a height and an angle, `clearance` off the bolt's [m].
fn thread(y: f64, angle: f64, clearance: f64) -> f64 {
    RADIUS + DEPTH * libm::cos(TAU * y / PITCH - angle) + clearance
}

/// A surface around the y axis: `outer` and, if it is hollow, `inner` are its radii [m] at a height
/// and an angle.
fn turned(
    height: f64,
    outer: impl Fn(f64, f64) -> f64,
    inner: Option<&dyn Fn(f64, f64) -> f64>,
) -> ShapeDesc {
    let layers = (height / PITCH * LAYERS as f64).round() as usize;
    let y_of = |layer: usize| (layer as f64 / layers as f64 - 0.5) * height;
    let mut positions = Vec::new();
    let mut ring = |radius: &dyn Fn(f64, f64) -> f64, y: f64| {
        positions.extend((0..AROUND).map(|step| {
            let angle = TAU * step as f64 / AROUND as f64;
            let radius = radius(y, angle);
            [radius * libm::cos(angle), y, -radius * libm::sin(angle)]
        }));
    };
    // Up on the outside, and down on the inside, or to the axis.
    (0..=layers).for_each(|layer| ring(&outer, y_of(layer)));
    if let Some(inner) = inner {
        (0..=layers).rev().for_each(|layer| ring(inner, y_of(layer)));
    }
    let rings = positions.len() / AROUND;
    let bands = if inner.is_some() { rings } else { rings - 1 };
    let at = |ring: usize, step: usize| ((ring % rings) * AROUND + step % AROUND) as u32;
    let mut triangles = Vec::new();
    for step in 0..AROUND {
        for ring in 0..bands {
            let [a, b] = [at(ring, step), at(ring, step + 1)];
            let [c, d] = [at(ring + 1, step), at(ring + 1, step + 1)];
            triangles.extend([[a, b, d], [a, d, c]]);
        }
        if inner.is_none() {
            let [low, high] = [positions.len() as u32, positions.len() as u32 + 1];
            triangles.push([at(0, step + 1), at(0, step), low]);
            triangles.push([at(layers, step), at(layers, step + 1), high]);
        }
    }
    if inner.is_none() {
        positions.extend([0, layers].map(|layer| [0.0, y_of(layer), 0.0]));
    }
    let across = |size: f64| (size / VOXEL).ceil() as usize;
    let radius = if inner.is_some() { NUT_SIZE[1] } else { RADIUS + DEPTH };
    let resolution = Resolution {
        voxels: Some([across(2.0 * radius), across(height), across(2.0 * radius)]),
        sample_spacing: Some(2.0 * VOXEL),
    };
    ShapeDesc::Triangles { positions, triangles, thickness: None, sides: None, resolution }
}

/// A fixed bolt and a nut, with `friction` between them.
pub(crate) fn nut(friction: f64) -> SceneDesc {
    let metal = |name: &str, shape: ShapeDesc| BodyDesc {
        friction,
        restitution: 0.0,
        density: 7850.0,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new(name, shape)
    };
    let bolt = BodyDesc {
        motion: MotionDesc::Static,
        position: [0.0, 0.5 * BOLT, 0.0],
        ..metal("bolt", turned(BOLT, |y, angle| thread(y, angle, 0.0), None))
    };
    let hexagon = |_: f64, angle: f64| {
        let sector = TAU / 6.0;
        let from_middle = angle - sector * (angle / sector).round();
        NUT_SIZE[1] * libm::cos(0.5 * sector) / libm::cos(from_middle)
    };
    let nut = BodyDesc {
        position: [0.0, 0.5 * BOLT + START - 0.5 * CLEARANCE, 0.0],
        ..metal("nut", turned(NUT_SIZE[0], hexagon, Some(&|y, angle| thread(y, angle, CLEARANCE))))
    };
    let mut scene = SceneDesc::new("");
    scene.bodies.extend([BodyDesc::ground(0.0), bolt, nut]);
    scene
}
