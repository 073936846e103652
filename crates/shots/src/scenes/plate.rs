//! A thin plate flies into a thin wall, ten plates' lengths a frame.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc};
use glam::DQuat;

/// Flat on.
pub(crate) const PLATE: Shot = Shot {
    name: "plate",
    caption: "a wall of 1 cm stops a plate of 1 cm that comes at 100 m/s",
    frames: 60,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(plate(DQuat::IDENTITY, 0.0)),
};

/// Of the plate, which flies along its shortest side [m].
const PLATE_SIZE: [f64; 3] = [0.01, 0.3, 0.3];

/// Of the wall [m].
const WALL_SIZE: [f64; 3] = [0.01, 3.0, 3.0];

/// Of the plate [m/s]: 3.3 m a frame.
const SPEED: f64 = 100.0;

/// From the plate to the wall [m], `ahead` less.
const ROOM: f64 = 8.0;

/// A plate that is turned flies at a wall in the plane x = 0, `ahead` [m] of where it would else
/// be.
pub(crate) fn plate(orientation: DQuat, ahead: f64) -> SceneDesc {
    let body = |name: &str, size: [f64; 3]| BodyDesc {
        look: Some(LookDesc::Metal),
        ..BodyDesc::new(name, ShapeDesc::Box { size, resolution: Resolution::default() })
    };
    let height = 0.5 * WALL_SIZE[1];
    let wall = BodyDesc {
        motion: MotionDesc::Static,
        position: [0.0, height, 0.0],
        ..body("wall", WALL_SIZE)
    };
    let plate = BodyDesc {
        position: [ahead - ROOM, height, 0.0],
        orientation: orientation.to_array(),
        linear_velocity: [SPEED, 0.0, 0.0],
        density: 7850.0,
        ..body("plate", PLATE_SIZE)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies.extend([BodyDesc::ground(0.0), wall, plate]);
    scene
}
