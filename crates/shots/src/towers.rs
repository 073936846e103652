//! Cubes on cubes: a tower and a pyramid.

use crate::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Ten cubes.
pub(crate) const TOWER: Shot = Shot {
    name: "tower",
    caption: "a tower of ten cubes stands",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(tower(10)),
};

/// Rows of cubes, each one shorter than the one below.
pub(crate) const PYRAMID: Shot = Shot {
    name: "pyramid",
    caption: "a pyramid of 210 cubes stands, 20 in its lowest row",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(pyramid()),
};

/// Of all cubes [m].
const EDGE: f64 = 0.5;

/// In the lowest row of the pyramid.
const BASE: usize = 20;

/// Between the cubes of a row [m].
const GAP: f64 = 0.02;

fn cube(x: f64, level: usize) -> BodyDesc {
    let shape = ShapeDesc::Box { size: [EDGE; 3], resolution: Resolution::default() };
    BodyDesc {
        position: [x, (level as f64 + 0.5) * EDGE, 0.0],
        look: Some(LookDesc::Stone),
        ..BodyDesc::new("cube", shape)
    }
}

fn on_ground(bodies: impl IntoIterator<Item = BodyDesc>) -> SceneDesc {
    let mut scene = SceneDesc::new("");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(bodies);
    scene
}

/// Some cubes, one on the other.
pub(crate) fn tower(count: usize) -> SceneDesc {
    on_ground((0..count).map(|level| cube(0.0, level)))
}

pub(crate) fn pyramid() -> SceneDesc {
    let row = |level: usize| {
        let count = BASE - level;
        let along = move |place: usize| (place as f64 - 0.5 * (count as f64 - 1.0)) * (EDGE + GAP);
        (0..count).map(move |place| cube(along(place), level))
    };
    on_ground((0..BASE).flat_map(row))
}
