//! A cube slides down an incline and stops by friction [Su09 fig. 3].

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc};
use glam::{DQuat, DVec3};

/// Figure 3.
pub(crate) const INCLINE: Shot = Shot {
    name: "incline",
    caption: "a cube slides down an incline and stops where friction says (figure 3)",
    frames: 180,
    takes_mesh: false,
    is_large: false,
    build: incline,
};

/// Of the incline [rad]: 10 degrees.
const SLOPE: f64 = 10.0 * std::f64::consts::PI / 180.0;

/// Coulomb's coefficient: more than the slope's tangent, to stop the cube.
const FRICTION: f64 = 0.2;

/// Edge of the cube [m].
const EDGE: f64 = 0.1;

/// [m/s^2]
const GRAVITY: f64 = 9.8;

/// Of the cube at first, down the incline [m/s].
const SPEED: f64 = 1.0;

fn incline(_: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let world_from_incline = DQuat::from_rotation_z(-SLOPE);
    let orientation = world_from_incline.to_array();
    let mut scene = SceneDesc::new("");
    scene.gravity = [0.0, -GRAVITY, 0.0];
    scene.bodies.push(BodyDesc { orientation, friction: FRICTION, ..BodyDesc::ground(0.0) });
    let shape = ShapeDesc::Box { size: [EDGE; 3], resolution: Resolution::default() };
    scene.bodies.push(BodyDesc {
        position: (world_from_incline * DVec3::new(0.0, 0.5 * EDGE, 0.0)).to_array(),
        orientation,
        linear_velocity: (world_from_incline * DVec3::new(SPEED, 0.0, 0.0)).to_array(),
        friction: FRICTION,
        restitution: 0.0,
        ..BodyDesc::new("cube", shape)
    });

    // A half sphere beside the place where the analytic solution stops.
    let brake = GRAVITY * (FRICTION * libm::cos(SLOPE) - libm::sin(SLOPE));
    let stop = DVec3::new(SPEED * SPEED / (2.0 * brake), 0.0, EDGE);
    let marker = ShapeDesc::Sphere { radius: 0.3 * EDGE, resolution: Resolution::default() };
    scene.bodies.push(BodyDesc {
        motion: MotionDesc::Static,
        position: (world_from_incline * stop).to_array(),
        ..BodyDesc::new("analytic solution", marker)
    });
    Ok(scene)
}
