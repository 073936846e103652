//! A brick wall, struck by a ball: it comes apart along its joints.

use crate::{Shot, ShotError, ShotOptions};
use frangible::fracture::Bricks;
use frangible::{
    BodyDesc, BreakingDesc, LookDesc, MaterialName, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    StrengthDesc,
};
use glam::DVec3;

/// Bricks.
pub(crate) const MASONRY: Shot = Shot {
    name: "masonry",
    caption: "a ball knocks a hole into a brick wall",
    frames: 90,
    takes_mesh: false,
    is_large: true,
    build: masonry,
};

/// Width, height and thickness [m].
const WALL: [f64; 3] = [3.2, 2.2, 0.24];

/// Of fired clay [kg/m^3].
const CLAY: f64 = 1800.0;

/// Of the ball, of steel [kg/m^3].
const STEEL: f64 = 7800.0;

/// Of the ball [m].
const RADIUS: f64 = 0.2;

/// Of the ball [m/s].
const SPEED: f64 = 11.0;

fn masonry(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let pattern = Bricks {
        columns: 10,
        courses: 21,
        mortar: 0.14,
        seed: options.seed,
        half_extent: DVec3::new(1.0, 0.7, 0.25),
        ..Bricks::default()
    };
    let breaking = BreakingDesc::once(StrengthDesc::Named(MaterialName::Brick), PatternDesc::Bricks(pattern));
    let resolution = Resolution { voxels: Some([160, 110, 12]), sample_spacing: None };
    let wall = BodyDesc {
        position: [0.0, 0.5 * WALL[1], 0.0],
        density: CLAY,
        friction: 0.7,
        restitution: 0.05,
        breaking: Some(breaking),
        look: Some(LookDesc::Brick),
        ..BodyDesc::new("wall", ShapeDesc::Box { size: WALL, resolution })
    };
    let ball = ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        position: [0.2, 1.25, 2.0],
        linear_velocity: [0.0, 0.8, -SPEED],
        density: STEEL,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new("ball", ball)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), wall, ball];
    Ok(scene)
}
