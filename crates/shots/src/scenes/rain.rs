//! Balls rain on a table and break; then a larger one breaks the table [Su09 fig. 8].

use crate::random::Random;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::{Natural, Voronoi};
use frangible::{BodyDesc, BreakingDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc};

/// Figure 8 with a small rain.
pub(crate) const RAIN_25: Shot = Shot {
    name: "rain-25",
    caption: "25 balls break on a table, then a larger ball breaks the table (figure 8)",
    frames: 240,
    takes_mesh: false,
    is_large: true,
    build: |options| rain(25, options),
};

/// Figure 8 with a shower.
pub(crate) const RAIN_100: Shot = Shot {
    name: "rain-100",
    caption: "100 balls break on a table, then a larger ball breaks the table (figure 8)",
    frames: 300,
    takes_mesh: false,
    is_large: true,
    build: |options| rain(100, options),
};

/// Figure 8: nearly nine thousand pieces.
pub(crate) const RAIN_1000: Shot = Shot {
    name: "rain-1000",
    caption: "1000 balls break on a table, then a larger ball breaks the table (figure 8)",
    frames: 420,
    takes_mesh: false,
    is_large: true,
    build: |options| rain(1000, options),
};

/// Edge lengths of the table's top [m]; its legs stand on the ground.
const TABLE: [f64; 3] = [6.0, 0.4, 4.0];

/// Where it is sampled: cubes of 4 cm [Su09 fig. 8].
const TABLE_VOXELS: [usize; 3] = [150, 10, 100];

/// Length of a leg [m].
const LEG: f64 = 2.0;

/// Of a leg [m].
const LEG_RADIUS: f64 = 0.2;

/// Of the legs from the table's middle [m].
const LEGS: [f64; 2] = [2.6, 1.5];

/// Radius of the raining balls [m].
const RADIUS: f64 = 0.35;

/// Sampling grid [Su09 fig. 8].
const BALL_VOXELS: [usize; 3] = [55; 3];

/// Of the larger ball [m].
const LARGE: f64 = 1.0;

/// Density of the raining balls [kg/m^3]: light, as in the authors' scene, to spare the table.
const LIGHT: f64 = 100.0;

/// Of the larger ball, a rock [kg/m^3].
const HEAVY: f64 = 2600.0;

/// Balls beside each other over the table, along its two sides.
const ABREAST: [usize; 2] = [7, 5];

/// From layer to layer of the rain, and of its balls from each other [m]: they do not touch as they
/// fall.
const APART: f64 = 0.82;

/// Strength of a raining ball [N s]: less than its impact after a fall of half a metre.
const WEAK: f64 = 25.0;

/// Strength of the table [N s]: more than the impact of a raining ball, much less than the larger
/// ball's.
const STRONG: f64 = 2e4;

/// Cells of all of prescored space around a ball of the rain, of which it has about nine.
const BALL_CELLS: usize = 24;

/// The same for the table.
const TABLE_CELLS: usize = 90;

/// When the larger ball comes down [s]: this long after the last of the rain has.
const PAUSE: f64 = 1.5;

/// Gravity [m/s^2], as the authors have it.
const GRAVITY: f64 = 9.8;

fn rain(balls: usize, options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut random = Random::new(options.seed);
    let mut scene = SceneDesc::new("");
    scene.gravity = [0.0, -GRAVITY, 0.0];
    scene.bodies.push(BodyDesc::ground(0.0));
    table(&mut scene, options);

    // The rain, in layers of a grid that are shifted at random.
    let top = LEG + TABLE[1];
    let mut highest = top;
    for index in 0..balls {
        let (layer, place) = (index / (ABREAST[0] * ABREAST[1]), index % (ABREAST[0] * ABREAST[1]));
        let along =
            |place: usize, count: usize| (place as f64 - 0.5 * (count as f64 - 1.0)) * APART;
        let mut jitter = || random.between(-0.5, 0.5) * (APART - 2.0 * RADIUS);
        let [x, z] = [along(place % ABREAST[0], ABREAST[0]), along(place / ABREAST[0], ABREAST[1])];
        highest = top + 2.0 + layer as f64 * APART;
        let position = [x + jitter(), highest + jitter(), z + jitter()];
        let resolution = Resolution { voxels: Some(BALL_VOXELS), sample_spacing: None };
        let pattern = PatternDesc::Voronoi(Voronoi {
            cells: BALL_CELLS,
            clustering: 0.0,
            seed: options.seed.wrapping_add(index as u64 % 8),
            ..Voronoi::default()
        });
        scene.bodies.push(BodyDesc {
            position,
            orientation: random.orientation().to_array(),
            density: LIGHT,
            friction: 0.2,
            breaking: Some(BreakingDesc::once(WEAK, pattern)),
            ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: RADIUS, resolution })
        });
    }

    // Throw the larger ball up, to come down after the rain.
    let rained = (2.0 * (highest - top) / GRAVITY).sqrt();
    let time = rained + PAUSE;
    let start = highest + 3.0;
    let upward = (top + LARGE - start) / time + 0.5 * GRAVITY * time;
    scene.bodies.push(BodyDesc {
        position: [0.0, start, 0.0],
        linear_velocity: [0.0, upward, 0.0],
        density: HEAVY,
        friction: 0.2,
        restitution: 0.0,
        ..BodyDesc::new(
            "large",
            ShapeDesc::Sphere { radius: LARGE, resolution: Resolution::default() },
        )
    });
    Ok(scene)
}

/// The top on four legs.
fn table(scene: &mut SceneDesc, options: &ShotOptions) {
    let resolution = Resolution { voxels: Some(TABLE_VOXELS), sample_spacing: None };
    let pattern = PatternDesc::Natural(Natural {
        cells: TABLE_CELLS,
        seed: options.seed,
        ..Natural::default()
    });
    scene.bodies.push(BodyDesc {
        position: [0.0, LEG + 0.5 * TABLE[1], 0.0],
        restitution: 0.0,
        breaking: Some(BreakingDesc::once(STRONG, pattern)),
        ..BodyDesc::new("table", ShapeDesc::Box { size: TABLE, resolution })
    });
    for (x, z) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
        let shape = ShapeDesc::Cylinder {
            radius: LEG_RADIUS,
            height: LEG,
            resolution: Resolution::default(),
        };
        scene.bodies.push(BodyDesc {
            position: [x * LEGS[0], 0.5 * LEG, z * LEGS[1]],
            restitution: 0.0,
            ..BodyDesc::new("leg", shape)
        });
    }
}
