//! An arch of stones that nothing but friction and their shape holds.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Half a ring.
pub(crate) const ARCH: Shot = Shot {
    name: "arch",
    caption: "an arch of 15 loose stones stands",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(arch(FRICTION)),
};

/// In the arch.
const STONES: usize = 15;

/// Of the arch, inside and outside [m]. A half ring thinner than 0.11 of its mean radius falls
/// whatever its friction [Hey66].
const RADII: [f64; 2] = [2.0, 2.6];

/// Half of its depth [m].
const HALF_DEPTH: f64 = 0.4;

/// Coulomb's coefficient of rough stone.
pub(crate) const FRICTION: f64 = 0.7;

/// Stones of some friction, on ground with the same.
pub(crate) fn arch(friction: f64) -> SceneDesc {
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc { friction, ..BodyDesc::ground(0.0) });
    let rib = |number: usize| {
        let angle = std::f64::consts::PI * number as f64 / STONES as f64;
        let (sin, cos) = (libm::sin(angle), libm::cos(angle));
        RADII.map(|radius| [radius * cos, radius * sin.max(0.0)])
    };
    for number in 0..STONES {
        let corners = [rib(number), rib(number + 1)].concat();
        let deep = |z: f64| corners.iter().map(move |&[x, y]| [x, y, z]);
        let points = deep(-HALF_DEPTH).chain(deep(HALF_DEPTH)).collect();
        scene.bodies.push(BodyDesc {
            friction,
            look: Some(LookDesc::Stone),
            ..BodyDesc::new("stone", ShapeDesc::Hull { points, resolution: Resolution::default() })
        });
    }
    scene
}
