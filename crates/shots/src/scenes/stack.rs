//! Boxes fall into a stack, and a larger box scatters it [Su09 fig. 2].

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::{BodyDesc, Resolution, SceneDesc, ShapeDesc};

/// Figure 2.
pub(crate) const STACK: Shot = Shot {
    name: "stack",
    caption: "boxes fall into a stack, and a larger box scatters it (figure 2)",
    frames: 180,
    takes_mesh: false,
    is_large: false,
    build: stack,
};

/// Number of boxes in the stack.
const BOXES: u32 = 5;

/// Of a box of the stack [m].
const EDGE: f64 = 0.5;

/// Initial gap between boxes [m].
const GAP: f64 = 0.15;

/// Of the larger box [m].
const LARGE_EDGE: f64 = 1.0;

/// When the larger box arrives [s]: the stack has come to rest.
const ARRIVAL: f64 = 3.0;

/// Of the larger box along the ground [m/s].
const SPEED: f64 = 5.0;

fn cube(edge: f64) -> ShapeDesc {
    ShapeDesc::Box {
        size: [edge; 3],
        resolution: Resolution { voxels: None, sample_spacing: Some(edge / 5.0) },
    }
}

fn stack(_: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    for level in 0..BOXES {
        let height = 0.5 * EDGE + f64::from(level) * (EDGE + GAP) + GAP;
        let box_ = BodyDesc { restitution: 0.1, ..BodyDesc::new("box", cube(EDGE)) };
        scene.bodies.push(BodyDesc { position: [0.0, height, 0.0], ..box_ });
    }

    // Aim at the stack's middle at the time of arrival.
    let meets = 0.5 * f64::from(BOXES) * EDGE;
    let rise = 0.5 * 9.81 * ARRIVAL;
    scene.bodies.push(BodyDesc {
        position: [SPEED * ARRIVAL + 0.5 * (EDGE + LARGE_EDGE), meets, 0.0],
        linear_velocity: [-SPEED, rise, 0.0],
        ..BodyDesc::new("large box", cube(LARGE_EDGE))
    });
    Ok(scene)
}
