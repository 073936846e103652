//! A wooden plank on two trestles, broken by what falls on its middle.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Splinters;
use frangible::{
    BodyDesc, BreakingDesc, LookDesc, MaterialName, MotionDesc, PatternDesc, Resolution, SceneDesc,
    ShapeDesc, StrengthDesc,
};
use glam::DVec3;

/// Wood.
pub(crate) const TIMBER: Shot = Shot {
    name: "timber",
    caption: "a ball falls on a wooden plank, which splinters along its grain",
    frames: 90,
    takes_mesh: false,
    is_large: true,
    build: timber,
};

/// Length, thickness and width [m].
const PLANK: [f64; 3] = [2.4, 0.05, 0.24];

/// Height of the trestles, and how far they stand from the middle [m].
const TRESTLE: [f64; 2] = [0.7, 0.95];

/// Of spruce [kg/m^3].
const SPRUCE: f64 = 450.0;

/// Of the ball, of steel [kg/m^3].
const STEEL: f64 = 7800.0;

/// Of the ball [m].
const RADIUS: f64 = 0.11;

fn timber(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    // Long, sharp splinters: the grain runs along the plank.
    let pattern = Splinters {
        fibres: 44,
        pieces: 2,
        sharpness: 14.0,
        spread: 0.3,
        seed: options.seed,
        half_extent: DVec3::new(1.0, 0.1, 0.06),
        ..Splinters::default()
    };
    let breaking = BreakingDesc::once(
        StrengthDesc::Named(MaterialName::Wood),
        PatternDesc::Splinters(pattern),
    );
    let resolution = Resolution { voxels: Some([240, 5, 24]), sample_spacing: None };
    let plank = BodyDesc {
        position: [0.0, TRESTLE[0] + 0.5 * PLANK[1], 0.0],
        density: SPRUCE,
        restitution: 0.1,
        breaking: Some(breaking),
        look: Some(LookDesc::Wood),
        ..BodyDesc::new("plank", ShapeDesc::Box { size: PLANK, resolution })
    };
    let trestle = |side: f64| BodyDesc {
        motion: MotionDesc::Static,
        position: [side * TRESTLE[1], 0.5 * TRESTLE[0], 0.0],
        look: Some(LookDesc::Stone),
        ..BodyDesc::new(
            "trestle",
            ShapeDesc::Box { size: [0.1, TRESTLE[0], 0.4], resolution: Resolution::default() },
        )
    };
    let ball = ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        position: [0.05, TRESTLE[0] + 1.2, 0.02],
        linear_velocity: [0.0, -7.0, 0.0],
        density: STEEL,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new("ball", ball)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), plank, trestle(-1.0), trestle(1.0), ball];
    Ok(scene)
}
