//! Boxes fall into a stack on a plank, and a larger box that falls on the plank's other end throws
//! them off [Su09 fig. 2]: the scene of the authors' collection that fits the caption, with sizes
//! and masses from there and lower falls.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc};
use glam::DQuat;

/// Figure 2.
pub(crate) const PLANK: Shot = Shot {
    name: "plank",
    caption: "boxes fall into a stack on a plank, and a larger box on its other end scatters them (figure 2)",
    frames: 180,
    takes_mesh: false,
    is_large: false,
    build: plank,
};

/// Half of the base's edge [m]; the plank lies across one of its upper edges.
const BASE: f64 = 2.0;

/// Edge lengths of the plank [m].
const PLANK_SIZE: [f64; 3] = [10.0, 0.5, 3.0];

/// Of a box of the stack [m].
const EDGE: f64 = 1.0;

/// Of the larger box [m].
const LARGE_EDGE: f64 = 2.0;

/// Drop height of the larger box [m]: four seconds, for the stack to come to rest.
const DROP: f64 = 70.0;

/// Where the boxes of the stack start, from the middle of the base's upper side [m]: a third of
/// their edge above where they come to rest.
const STACK: [[f64; 3]; 7] = [
    [-0.65, 1.3, 0.0],
    [0.65, 1.6, 0.0],
    [0.05, 2.9, 0.0],
    [0.0, 4.2, 0.05],
    [-0.05, 5.5, -0.05],
    [0.0, 6.8, 0.0],
    [0.0, 8.1, 0.0],
];

/// Edge lengths [m] and mass [kg].
fn block(name: &str, size: [f64; 3], mass: f64) -> BodyDesc {
    let longest = size.iter().fold(0.0_f64, |longest, &edge| longest.max(edge));
    let spacing = if longest > LARGE_EDGE { 0.5 } else { longest / 5.0 };
    let resolution = Resolution { voxels: None, sample_spacing: Some(spacing) };
    BodyDesc {
        density: mass / size.iter().product::<f64>(),
        ..BodyDesc::new(name, ShapeDesc::Box { size, resolution })
    }
}

fn plank(_: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut scene = SceneDesc::new("");
    scene.gravity = [0.0, -9.8, 0.0];
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.push(BodyDesc {
        motion: MotionDesc::Static,
        position: [0.0, BASE, 0.0],
        friction: 0.3,
        restitution: 0.1,
        ..block("base", [2.0 * BASE; 3], 1.0)
    });
    let top = 2.0 * BASE + PLANK_SIZE[1];
    scene.bodies.push(BodyDesc {
        position: [BASE, top - 0.5 * PLANK_SIZE[1], 0.0],
        restitution: 0.1,
        ..block("plank", PLANK_SIZE, 10.0)
    });
    for (level, [x, y, z]) in STACK.into_iter().enumerate() {
        // The last one falls turned by an eighth.
        let turn = if level + 1 == STACK.len() { std::f64::consts::FRAC_PI_4 } else { 0.0 };
        scene.bodies.push(BodyDesc {
            position: [x, 2.0 * BASE + y, z],
            orientation: DQuat::from_rotation_y(turn).to_array(),
            restitution: 0.3,
            ..block("box", [EDGE; 3], 1.0)
        });
    }
    scene.bodies.push(BodyDesc {
        position: [BASE + 0.5 * PLANK_SIZE[0] - 1.2, top + 0.5 * LARGE_EDGE + DROP, 0.0],
        restitution: 0.05,
        ..block("large box", [LARGE_EDGE; 3], 100.0)
    });
    Ok(scene)
}
