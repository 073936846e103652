//! A brick wall, struck by a ball: mortar gives way where it is struck, and holds elsewhere.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Bricks;
use frangible::{
    AnchorDesc, BodyDesc, BondsDesc, LookDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
};
use glam::DVec3;

/// Bricks.
pub(crate) const MASONRY: Shot = Shot {
    name: "masonry",
    caption: "a ball knocks a hole in a mortared wall, and the rest stands",
    frames: 90,
    takes_mesh: false,
    is_large: true,
    build: masonry,
};

/// Width, height and thickness [m].
const WALL: [f64; 3] = [3.2, 2.2, 0.24];

/// Of fired clay [kg/m^3].
const CLAY: f64 = 1800.0;

/// Tensile strength of cement mortar joints [Pa]; along the joints the weight above adds friction.
const TENSION: f64 = 0.4e6;
const SHEAR: f64 = 0.6e6;

/// Of loose bricks on crumbled mortar, half of what whole joints have [EC6 3.6.2]. The bricks fill
/// their hole exactly: from 0.35 on they jam in it, and stop the ball.
const FRICTION: f64 = 0.2;

/// Of the ball, of steel [kg/m^3].
const STEEL: f64 = 7800.0;

/// Of the ball [m].
const RADIUS: f64 = 0.2;

/// Of the ball [m/s].
const SPEED: f64 = 11.0;

/// Width of the strips at both ends and at the foot of the wall that are built into a house [m].
const BUILT_IN: [f64; 2] = [0.2, 0.08];

fn masonry(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let pattern = Bricks {
        columns: 10,
        courses: 21,
        mortar: 0.14,
        seed: options.seed,
        half_extent: DVec3::new(1.0, 0.7, 0.25),
        ..Bricks::default()
    };
    let [half_width, foot] = [0.5 * WALL[0] - BUILT_IN[0], BUILT_IN[1]];
    let strip = |low: [f64; 2], high: [f64; 2]| AnchorDesc {
        low: [low[0], low[1], -WALL[2]],
        high: [high[0], high[1], WALL[2]],
    };
    let bonds = BondsDesc {
        pattern: Some(PatternDesc::Bricks(pattern)),
        point: None,
        normal: [0.0, 0.0, 1.0],
        tensile_strength: TENSION,
        shear_strength: SHEAR,
        anchors: vec![
            strip([-WALL[0], 0.0], [WALL[0], foot]),
            strip([-WALL[0], 0.0], [-half_width, WALL[1]]),
            strip([half_width, 0.0], [WALL[0], WALL[1]]),
        ],
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    };
    let wall = BodyDesc {
        position: [0.0, 0.5 * WALL[1], 0.0],
        density: CLAY,
        friction: FRICTION,
        restitution: 0.05,
        bonds: Some(bonds),
        look: Some(LookDesc::Masonry),
        ..BodyDesc::new("wall", ShapeDesc::Box { size: WALL, resolution: Resolution::default() })
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
