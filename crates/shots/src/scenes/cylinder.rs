//! A cylinder that a ball shatters [Su09 fig. 5].

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Natural;
use frangible::{
    BodyDesc, BreakingDesc, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
};

/// Figure 5.
pub(crate) const CYLINDER: Shot = Shot {
    name: "cylinder",
    caption: "a ball shatters a cylinder (figure 5)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: cylinder,
};

/// [m]
const RADIUS: f64 = 0.5;

/// [m]
const HEIGHT: f64 = 1.9;

/// Where it is sampled: cubes of 1.8 cm [Su09 fig. 5].
const VOXELS: [usize; 3] = [55, 105, 55];

/// Of the ball [m].
const BALL_RADIUS: f64 = 0.35;

/// Of the ball [m/s].
const SPEED: f64 = 10.0;

/// Cells of all of prescored space, half of which lies beside the cylinder: the struck half has the
/// pieces.
const CELLS: usize = 110;

fn cylinder(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let resolution = Resolution { voxels: Some(VOXELS), sample_spacing: None };
    let shape = ShapeDesc::Cylinder { radius: RADIUS, height: HEIGHT, resolution };
    let pattern =
        PatternDesc::Natural(Natural { cells: CELLS, seed: options.seed, ..Natural::default() });
    let cylinder = BodyDesc {
        position: [0.0, 0.5 * HEIGHT, 0.0],
        breaking: Some(BreakingDesc::once(100.0, pattern)),
        ..BodyDesc::new("cylinder", shape)
    };
    let shape = ShapeDesc::Sphere { radius: BALL_RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [3.0, 0.6 * HEIGHT, 0.0],
        linear_velocity: [-SPEED, 0.0, 0.0],
        ..BodyDesc::new("ball", shape)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), cylinder, ball];
    Ok(scene)
}
