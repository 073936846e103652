//! A concrete pillar, struck by a wrecking ball.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Concrete;
use frangible::{
    BodyDesc, BreakingDesc, LookDesc, MaterialName, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    StrengthDesc,
};
use glam::DVec3;

/// Concrete.
pub(crate) const CONCRETE: Shot = Shot {
    name: "concrete",
    caption: "a wrecking ball breaks a concrete pillar, whose cracks are rough",
    frames: 90,
    takes_mesh: false,
    is_large: true,
    build: concrete,
};

/// Edge lengths [m].
const PILLAR: [f64; 3] = [0.5, 3.0, 0.5];

/// Where it is sampled: cubes of 2 cm, finer than the bumps of the cracks.
const VOXELS: [usize; 3] = [25, 150, 25];

/// Of concrete [kg/m^3].
const CONCRETE_DENSITY: f64 = 2400.0;

/// Of the ball, of steel [kg/m^3].
const STEEL: f64 = 7800.0;

/// Of the ball [m].
const RADIUS: f64 = 0.3;

/// Of the ball [m/s].
const SPEED: f64 = 10.0;

fn concrete(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let pattern = Concrete {
        cells: 220,
        roughness: 1.0,
        grain: 0.3,
        clustering: 1.2,
        seed: options.seed,
        half_extent: DVec3::new(1.0, 0.4, 0.4),
    };
    let breaking = BreakingDesc::once(
        StrengthDesc::Named(MaterialName::Concrete),
        PatternDesc::Concrete(pattern),
    );
    let resolution = Resolution { voxels: Some(VOXELS), sample_spacing: None };
    let pillar = BodyDesc {
        position: [0.0, 0.5 * PILLAR[1], 0.0],
        density: CONCRETE_DENSITY,
        restitution: 0.1,
        breaking: Some(breaking),
        look: Some(LookDesc::Concrete),
        ..BodyDesc::new("pillar", ShapeDesc::Box { size: PILLAR, resolution })
    };
    let ball = ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        position: [2.0, 1.7, 0.05],
        linear_velocity: [-SPEED, 0.0, 0.0],
        density: STEEL,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new("ball", ball)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), pillar, ball];
    Ok(scene)
}
