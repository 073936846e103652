//! Pieces of a body at rest are born at rest, for any shape and any cut.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::{Concrete, Natural, Radial, Slices, Voronoi};
use frangible::{
    BodyDesc, BreakingDesc, PartDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};
use glam::DVec3;

/// A piece that is faster pops [m/s].
const POPS: f64 = 1e-3;

/// A body at rest without strength, and a projectile of half a microgram's millionth.
fn struck(shape: ShapeDesc, pattern: PatternDesc, from: DVec3) -> World {
    let feather = ShapeDesc::Sphere { radius: 0.005, resolution: Resolution::default() };
    let mut scene = SceneDesc::new("birth");
    scene.gravity = [0.0; 3];
    scene.bodies.push(BodyDesc {
        breaking: Some(BreakingDesc::once(1e-15, pattern)),
        ..BodyDesc::new("body", shape)
    });
    scene.bodies.push(BodyDesc {
        position: (3.0 * from).to_array(),
        linear_velocity: (-10.0 * from).to_array(),
        density: 1e-6,
        restitution: 0.0,
        ..BodyDesc::new("feather", feather)
    });
    World::build(&scene).unwrap()
}

/// Breaks one body; how many pieces there are, and how fast any of them moves in the second after,
/// by its velocity or from frame to frame [m/s].
fn births(mut world: World) -> (usize, f64) {
    let (mut pieces, mut fastest): (usize, f64) = (0, 0.0);
    let mut left = 60;
    while left > 0 {
        left -= 1;
        let before: Vec<_> =
            world.bodies().ids.iter().copied().zip(world.bodies().poses.clone()).collect();
        let report = step(&mut world);
        assert!(report.quarantined.is_empty());
        if let Some(fracture) = report.fractures.first() {
            (pieces, left) = (fracture.fragments.len(), 30);
        }
        let bodies = world.bodies();
        let is_feather = |i: usize| world.labels()[i].name == "feather";
        for i in (0..bodies.len()).filter(|&i| !is_feather(i)) {
            fastest = fastest.max(bodies.velocities[i].linear.length());
        }
        for (id, pose) in before {
            if let Some(i) = bodies.index_of(id).filter(|&i| !is_feather(i)) {
                fastest =
                    fastest.max(bodies.poses[i].position.distance(pose.position) / world.dt());
            }
        }
    }
    (pieces, fastest)
}

fn points(seed: u64) -> Vec<[f64; 3]> {
    let number = |at: u64| {
        let mixed = (seed * 977 + at).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        (mixed >> 40) as f64 / (1_u64 << 24) as f64 - 0.5
    };
    (0..16).map(|point| [0, 1, 2].map(|axis| number(3 * point + axis))).collect()
}

fn pattern(kind: u64, seed: u64) -> PatternDesc {
    match kind % 4 {
        0 => PatternDesc::Voronoi(Voronoi { cells: 30, seed, ..Voronoi::default() }),
        1 => PatternDesc::Radial(Radial { seed, ..Radial::default() }),
        2 => PatternDesc::Natural(Natural { seed, ..Natural::default() }),
        _ => PatternDesc::Slices(Slices { seed, ..Slices::default() }),
    }
}

fn part(size: [f64; 3], position: [f64; 3]) -> PartDesc {
    PartDesc::Box { size, position, orientation: [0.0, 0.0, 0.0, 1.0] }
}

/// Breaks bodies and asserts that none of their pieces pops.
fn lie_still(
    breaks: impl IntoIterator<Item = (String, ShapeDesc, PatternDesc, DVec3)>,
    least: usize,
) {
    let mut count = 0;
    let mut popped = Vec::new();
    for (name, shape, pattern, from) in breaks {
        let (pieces, fastest) = births(struck(shape, pattern, from.normalize()));
        count += usize::from(pieces > 1);
        if fastest > POPS {
            popped.push(format!("{name}: {fastest} m/s"));
        }
    }
    assert!(popped.is_empty(), "{popped:#?}");
    assert!(count >= least, "{count} bodies broke");
}

fn from(seed: u64) -> DVec3 {
    DVec3::from_array(points(seed + 500)[0])
}

#[test]
fn pieces_of_polyhedra_lie_still() {
    let whole = Resolution::default();
    let breaks = (0..160).map(|seed| {
        let shape = match seed % 4 {
            0 => ShapeDesc::Hull { points: points(seed), resolution: whole },
            1 => ShapeDesc::Box { size: [1.0, 0.2, 0.6], resolution: whole },
            2 => ShapeDesc::Sphere { radius: 0.5, resolution: whole },
            _ => ShapeDesc::Cylinder { radius: 0.3, height: 1.0, resolution: whole },
        };
        (format!("polyhedron {seed}"), shape, pattern(seed / 4, seed), from(seed))
    });
    lie_still(breaks, 150);
}

#[test]
fn pieces_of_level_sets_lie_still() {
    let sampled = Resolution { voxels: Some([24; 3]), sample_spacing: None };
    let breaks = (0..60).map(|seed| {
        // An L, a cross and a table; a rough pattern is for grids alone.
        let parts = match seed % 3 {
            0 => vec![part([1.0, 0.3, 0.3], [0.0; 3]), part([0.3, 0.7, 0.3], [-0.35, 0.5, 0.0])],
            1 => vec![part([1.0, 0.2, 0.2], [0.0; 3]), part([0.2, 1.0, 0.2], [0.0; 3])],
            _ => vec![part([1.0, 0.2, 1.0], [0.0; 3]), part([0.3, 0.6, 0.3], [0.0, -0.4, 0.0])],
        };
        let rough = PatternDesc::Concrete(Concrete { seed, ..Concrete::default() });
        let pattern = if seed % 5 == 4 { rough } else { pattern(seed / 3, seed) };
        (
            format!("level set {seed}"),
            ShapeDesc::Compound { parts, resolution: sampled },
            pattern,
            from(seed),
        )
    });
    lie_still(breaks, 55);
}

/// Overlapping bodies do separate with speed.
#[test]
fn boxes_that_overlap_pop() {
    let shape = ShapeDesc::Box { size: [1.0; 3], resolution: Resolution::default() };
    let mut scene = SceneDesc::new("overlap");
    scene.gravity = [0.0; 3];
    scene.bodies.extend(
        [0.0, 0.99]
            .map(|x| BodyDesc { position: [x, 0.0, 0.0], ..BodyDesc::new("box", shape.clone()) }),
    );
    let (pieces, fastest) = births(World::build(&scene).unwrap());
    assert!(pieces == 0 && fastest > POPS, "{fastest} m/s");
}
