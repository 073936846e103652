//! A precut slab: pieces fit without gaps, and stay.

use crate::random::Random;
use crate::scenes::pillar::cut_up;
use crate::shot::{Shot, ShotError, ShotOptions};
use frangible::geometry::Hull;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};
use glam::DVec3;

/// On the ground.
pub(crate) const SLAB: Shot = Shot {
    name: "slab",
    caption: "a slab that is cut into 100 pieces lies on the ground as if it were whole",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: slab,
};

/// Of the slab [m].
const HALF: DVec3 = DVec3::new(2.0, 0.1, 2.0);

/// Number of pieces.
const PIECES: usize = 100;

/// Remaining upward component of a cut's normal: cracks are slightly tilted.
const UPRIGHT: f64 = 0.3;

fn slab(options: &ShotOptions) -> Result<SceneDesc, ShotError> {
    let mut pieces = vec![Hull::cuboid(HALF)];
    let mut random = Random::new(options.seed);
    cut_up(&mut pieces, PIECES, &mut random, |direction| direction * DVec3::new(1.0, UPRIGHT, 1.0));
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(pieces.iter().map(|piece| {
        let points = piece.vertices().iter().map(DVec3::to_array).collect();
        BodyDesc {
            position: [0.0, HALF.y, 0.0],
            look: Some(LookDesc::Concrete),
            ..BodyDesc::new("piece", ShapeDesc::Hull { points, resolution: Resolution::default() })
        }
    }));
    Ok(scene)
}
