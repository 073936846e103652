//! A pane of glass, and the ball that flies through it.

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Radial;
use frangible::{
    BodyDesc, BreakingDesc, LookDesc, MaterialName, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    StrengthDesc,
};

/// Glass.
pub(crate) const PANE: Shot = Shot {
    name: "pane",
    caption: "a steel ball flies through a pane of glass",
    frames: 90,
    takes_mesh: false,
    is_large: true,
    build: pane,
};

/// Width, height and thickness [m].
const PANE_SIZE: [f64; 3] = [1.6, 1.2, 0.008];

/// Of soda-lime glass [kg/m^3].
const GLASS: f64 = 2500.0;

/// Of the ball, of steel [kg/m^3].
const STEEL: f64 = 7800.0;

/// Of the ball [m].
const RADIUS: f64 = 0.06;

/// Of the ball [m/s].
const SPEED: f64 = 12.0;

fn pane(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let pattern = Radial { spokes: 26, rings: 9, jitter: 0.8, seed: options.seed };
    let breaking =
        BreakingDesc::once(StrengthDesc::Named(MaterialName::Glass), PatternDesc::Radial(pattern));
    let resolution = Resolution { voxels: Some([400, 300, 2]), sample_spacing: None };
    let pane = BodyDesc {
        position: [0.0, 0.5 * PANE_SIZE[1], 0.0],
        density: GLASS,
        friction: 0.4,
        restitution: 0.2,
        breaking: Some(breaking),
        look: Some(LookDesc::Glass),
        ..BodyDesc::new("pane", ShapeDesc::Box { size: PANE_SIZE, resolution })
    };
    let ball = ShapeDesc::Sphere { radius: RADIUS, resolution: Resolution::default() };
    let ball = BodyDesc {
        position: [0.15, 0.75, 1.0],
        linear_velocity: [0.0, 0.5, -SPEED],
        density: STEEL,
        look: Some(LookDesc::Metal),
        ..BodyDesc::new("ball", ball)
    };
    let mut scene = SceneDesc::new("");
    scene.bodies = vec![BodyDesc::ground(0.0), pane, ball];
    Ok(scene)
}
