//! Thousands of pieces of rubble in piles, to be run at speed.

use crate::random::Random;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc};

/// Few others above and below each piece.
pub(crate) const SPREAD: Shot = Shot {
    name: "pile-spread",
    caption: "9248 pieces of rubble fall into two layers",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |options| pile([68, 2, 68], false, options),
};

/// As deep as rubble gets.
pub(crate) const DEEP: Shot = Shot {
    name: "pile-deep",
    caption: "9216 pieces of rubble fall into a pit, 16 layers deep",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |options| pile([24, 16, 24], true, options),
};

/// Points of a piece, before those inside of their hull are left out.
const POINTS: usize = 14;

/// Different pieces.
const KINDS: usize = 64;

/// Half the length of a piece [m]: as of a fist.
const RADIUS: f64 = 0.1;

/// Initial spacing of pieces, in units of `RADIUS`: without contact.
const APART: f64 = 2.05;

/// Thickness and height of the pit's walls [m].
const PIT: [f64; 2] = [0.5, 6.0];

/// Rubble of the options' seed in layers, each piece free of the others.
pub(crate) fn pile(
    counts: [usize; 3],
    in_pit: bool,
    options: &ShotOptions,
) -> Result<SceneDesc, ShotError> {
    let mut random = Random::new(options.seed);
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    let kinds: Vec<ShapeDesc> = (0..KINDS).map(|_| piece(&mut random)).collect();
    let pitch = APART * RADIUS;
    for number in 0..counts.iter().product() {
        let [i, j, k] =
            [number % counts[0], number / (counts[0] * counts[2]), number / counts[0] % counts[2]];
        let along =
            |place: usize, count: usize| (place as f64 - 0.5 * (count as f64 - 1.0)) * pitch;
        scene.bodies.push(BodyDesc {
            position: [along(i, counts[0]), RADIUS + (j as f64 + 0.1) * pitch, along(k, counts[2])],
            orientation: random.orientation().to_array(),
            density: 2400.0,
            friction: 0.5,
            ..BodyDesc::new("piece", kinds[random.index(KINDS)].clone())
        });
    }
    if in_pit {
        let [thickness, height] = PIT;
        let half = 0.5 * (counts[0] as f64 * pitch + thickness);
        for (x, z) in [(half, 0.0), (-half, 0.0), (0.0, half), (0.0, -half)] {
            let along = |other: f64| if other == 0.0 { thickness } else { 2.0 * half + thickness };
            let size = [along(z), height, along(x)];
            let wall = ShapeDesc::Box { size, resolution: Resolution::default() };
            scene.bodies.push(BodyDesc {
                motion: MotionDesc::Static,
                position: [x, 0.5 * height, z],
                ..BodyDesc::new("pit", wall)
            });
        }
    }
    Ok(scene)
}

/// Points on a ball that is squeezed along two axes.
fn piece(random: &mut Random) -> ShapeDesc {
    let squeezed = [1.0, random.between(0.6, 1.0), random.between(0.4, 0.8)];
    let point = |random: &mut Random| {
        let direction = random.direction().to_array();
        [0, 1, 2].map(|axis| RADIUS * squeezed[axis] * direction[axis])
    };
    let points = (0..POINTS).map(|_| point(random)).collect();
    ShapeDesc::Hull { points, resolution: Resolution::default() }
}
