//! A wall that a ball strikes, at three places with one pattern, and a ball that breaks on it [Su09
//! fig. 4].

use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::fracture::{Natural, Radial};
use frangible::{
    BodyDesc, BreakingDesc, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
};
use glam::DVec3;

/// Struck above the middle, towards one side.
pub(crate) const UPPER: Shot = Shot {
    name: "wall",
    caption: "a ball breaks a wall where it hits it, above the middle (figure 4)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: |options| struck_at([3.0, 0.5, 1.5], options),
};

/// Struck below the middle.
pub(crate) const MIDDLE: Shot = Shot {
    name: "wall-middle",
    caption: "the same wall and pattern, struck near the middle (figure 4)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: |options| struck_at([3.0, -0.5, 0.25], options),
};

/// Struck near a lower corner.
pub(crate) const LOWER: Shot = Shot {
    name: "wall-corner",
    caption: "the same wall and pattern, struck near a lower corner (figure 4)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: |options| struck_at([3.0, -1.0, -2.0], options),
};

/// Broken as stone breaks.
pub(crate) const NATURAL: Shot = Shot {
    name: "wall-natural",
    caption: "the wall breaks as stone does (figure 9)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: |options| {
        // A flat box: the cells are as large across the wall as it is thick.
        let half_extent = DVec3::new(1.0, 1.0, 0.12);
        let pattern = Natural { cells: 110, seed: options.seed, half_extent, ..Natural::default() };
        let pattern = PatternDesc::Natural(pattern);
        Ok(scene(BreakingDesc::once(WEAK, pattern), kinematic_ball([3.0, 0.5, 1.5])))
    },
};

/// The thresholds exchanged.
pub(crate) const BALL: Shot = Shot {
    name: "wall-ball",
    caption: "the wall is the stronger: the ball breaks on it (figure 4)",
    frames: 120,
    takes_mesh: false,
    is_large: false,
    build: ball_breaks,
};

/// Edge lengths of the wall along x, y and z [m]: 0.4 m thick, 4 m high, 6 m wide.
pub(crate) const WALL: [f64; 3] = [0.4, 4.0, 6.0];

/// Voxels along the same axes: cubes of 4 cm [Su09 fig. 4].
const WALL_VOXELS: [usize; 3] = [10, 100, 150];

/// Distance between the wall's surface samples [m], as in the authors' scene (31 x 3 x 21 of them).
const WALL_SAMPLES: f64 = 0.2;

/// The ground [m]; the wall's centre is the origin.
pub(crate) const GROUND: f64 = -2.0;

/// Of the ball [m/s].
pub(crate) const SPEED: f64 = 15.0;

/// Strength of the weaker body [N s]: much less than the impact of either ball.
const WEAK: f64 = 500.0;

/// Strength of the stronger body [N s]: more than the impact of the small ball.
const STRONG: f64 = 1e6;

fn struck_at(center: [f64; 3], options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    Ok(scene(breaking(WEAK, options), kinematic_ball(center)))
}

fn ball_breaks(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let resolution = Resolution { voxels: Some([55; 3]), sample_spacing: Some(0.04) };
    let shape = ShapeDesc::Sphere { radius: 0.25, resolution };
    let ball = BodyDesc { breaking: Some(breaking(WEAK, options)), ..ball(shape, [3.0, 0.5, 1.5]) };
    Ok(scene(breaking(STRONG, options), ball))
}

/// A ball on a prescribed path, as in the paper.
fn kinematic_ball(center: [f64; 3]) -> BodyDesc {
    let shape = ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() };
    BodyDesc { motion: MotionDesc::Kinematic, ..ball(shape, center) }
}

pub(crate) fn ball(shape: ShapeDesc, center: [f64; 3]) -> BodyDesc {
    BodyDesc {
        position: center,
        linear_velocity: [-SPEED, 0.0, 0.0],
        ..BodyDesc::new("ball", shape)
    }
}

pub(crate) fn wall_of(breaking: BreakingDesc) -> BodyDesc {
    let resolution = Resolution { voxels: Some(WALL_VOXELS), sample_spacing: Some(WALL_SAMPLES) };
    let shape = ShapeDesc::Box { size: WALL, resolution };
    BodyDesc { breaking: Some(breaking), ..BodyDesc::new("wall", shape) }
}

fn scene(breaking: BreakingDesc, ball: BodyDesc) -> SceneDesc {
    let mut scene = SceneDesc::new("");
    scene.gravity = [0.0, -9.8, 0.0];
    scene.bodies = vec![BodyDesc::ground(GROUND), wall_of(breaking), ball];
    scene
}

/// One pattern for all of figure 4: the paper's twelve wedges, and rings as they form in a pane.
fn breaking(strength: f64, options: &ShotOptions) -> BreakingDesc {
    let pattern = PatternDesc::Radial(Radial {
        spokes: 12,
        rings: 2,
        seed: options.seed,
        ..Radial::default()
    });
    BreakingDesc::once(strength, pattern)
}
