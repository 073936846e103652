//! A ball breaks a corner off a wall, and a second one breaks what is left standing [Su09 fig. 7].

use crate::scenes::wall::{GROUND, ball, wall_of};
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
};

/// Figure 7.
pub(crate) const REFRACTURE: Shot = Shot {
    name: "refracture",
    caption: "a ball breaks a wall's corner, a second one breaks a large fragment (figure 7)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: refracture,
};

/// Radius [m] and start of the first ball and the second [m] [Su09 fig. 7]. The second one comes 12
/// frames after the first, while the large fragment that it is meant for is still where it was.
const BALLS: [(f64, [f64; 3]); 2] = [(0.5, [10.0, -1.0, -2.0]), (0.35, [16.0, 0.7, 1.5])];

/// Strength of the wall [N s]: less than a direct hit of a ball, more than a toppling fragment.
const STRENGTH: f64 = 2e4;

fn refracture(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    // Small cells around the blow, large ones away from it.
    let pattern = PatternDesc::Voronoi(Voronoi {
        cells: 60,
        clustering: 5.0,
        seed: options.seed,
        ..Voronoi::default()
    });
    let breaking = BreakingDesc { generations: 2, ..BreakingDesc::once(STRENGTH, pattern) };
    let mut scene = SceneDesc::new("");
    scene.gravity = [0.0, -9.8, 0.0];
    scene.bodies = vec![BodyDesc::ground(GROUND), wall_of(breaking)];
    for (radius, start) in BALLS {
        let shape = ShapeDesc::Sphere { radius, resolution: Resolution::default() };
        scene.bodies.push(BodyDesc { motion: MotionDesc::Kinematic, ..ball(shape, start) });
    }
    Ok(scene)
}
