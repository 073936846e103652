//! Cubes on cubes: a tower, a pyramid, and a load a thousand times as heavy as its supports.

use crate::shot::Shot;
use frangible::{BodyDesc, LookDesc, Resolution, SceneDesc, ShapeDesc};

/// Fifty cubes.
pub(crate) const TOWER: Shot = Shot {
    name: "tower",
    caption: "a tower of 50 cubes stands",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(tower(50)),
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

/// The heaviest on top.
pub(crate) const LOAD: Shot = Shot {
    name: "load",
    caption: "ten cubes bear an eleventh that is a thousand times as heavy as each of them",
    frames: 150,
    takes_mesh: false,
    is_large: true,
    build: |_| Ok(load(LOAD_RATIO)),
};

/// Of all cubes [m].
const EDGE: f64 = 0.5;

/// In the lowest row of the pyramid.
const BASE: usize = 20;

/// Between the cubes of a row [m].
const GAP: f64 = 0.02;

/// Cubes below the load.
const BEARERS: usize = 10;

/// Mass of the load relative to each support.
pub(crate) const LOAD_RATIO: f64 = 1000.0;

/// Of those that bear the load [kg/m^3]: of softwood; the load is a notion.
const LIGHT: f64 = 500.0;

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

/// A tower of `count` cubes.
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

/// Ten cubes, and one `ratio` times as heavy on top of them.
pub(crate) fn load(ratio: f64) -> SceneDesc {
    let wood =
        |level: usize| BodyDesc { density: LIGHT, look: Some(LookDesc::Wood), ..cube(0.0, level) };
    let load = BodyDesc {
        name: "load".into(),
        density: ratio * LIGHT,
        look: Some(LookDesc::Metal),
        ..cube(0.0, BEARERS)
    };
    on_ground((0..BEARERS).map(wood).chain([load]))
}

/// Half extents of the ground slab [m].
const SLAB: [f64; 3] = [60.0, 0.5, 60.0];
const APART: f64 = 2.6;

/// Of the slab [kg/m^3].
const SLAB_DENSITY: f64 = 100.0;

/// Columns of the field of others, which has as many rows; none stands in the middle.
const FIELD: usize = 21;

/// A tower, or what else stands on the ground, on a slab that can move, and `count` small cubes
/// beside it, which come last.
pub(crate) fn with_company(mut scene: SceneDesc, count: usize) -> SceneDesc {
    for body in &mut scene.bodies[1..] {
        body.position[1] += SLAB[1];
    }
    let box_of = |size: [f64; 3]| ShapeDesc::Box { size, resolution: Resolution::default() };
    scene.bodies.push(BodyDesc {
        position: [0.0, 0.5 * SLAB[1], 0.0],
        density: SLAB_DENSITY,
        ..BodyDesc::new("slab", box_of(SLAB))
    });
    let edge = 0.3;
    let along = |place: usize| APART * (place as f64 - 0.5 * (FIELD as f64 - 1.0));
    let places = (0..FIELD * FIELD).map(|number| (along(number / FIELD), along(number % FIELD)));
    let places = places.filter(|(x, z)| x.abs().max(z.abs()) > 2.5 * APART);
    scene.bodies.extend(places.take(count).map(|(x, z)| BodyDesc {
        position: [x, SLAB[1] + 0.5 * edge, z],
        ..BodyDesc::new("cube", box_of([edge; 3]))
    }));
    scene
}
