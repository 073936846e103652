//! What a body bears follows its thickness where it is struck.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, MaterialName, PartDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    StrengthDesc, World, step,
};

const HALF: f64 = 0.25;

fn block(size: [f64; 3], position: [f64; 3]) -> PartDesc {
    PartDesc::Box { size, position, orientation: [0.0, 0.0, 0.0, 1.0] }
}

/// A cube of walls.
fn hollow(wall: f64) -> ShapeDesc {
    let (all, inner, away) = (2.0 * HALF, 2.0 * (HALF - wall), HALF - 0.5 * wall);
    let mut parts = Vec::new();
    for side in [-away, away] {
        parts.push(block([wall, all, all], [side, 0.0, 0.0]));
        parts.push(block([inner, wall, all], [0.0, side, 0.0]));
        parts.push(block([inner, inner, wall], [0.0, 0.0, side]));
    }
    ShapeDesc::Compound { parts, resolution: Resolution::default() }
}

/// One of its walls, by itself.
fn pane(wall: f64) -> ShapeDesc {
    ShapeDesc::Box { size: [wall, 2.0 * HALF, 2.0 * HALF], resolution: Resolution::default() }
}

/// True if a steel ball breaks a body that it hits along x, off the middle.
fn breaks(
    (shape, wall): (ShapeDesc, f64),
    (material, density): (MaterialName, f64),
    speed: f64,
) -> bool {
    let pattern = PatternDesc::Voronoi(Voronoi { cells: 12, ..Voronoi::default() });
    let front = if matches!(shape, ShapeDesc::Box { .. }) { 0.5 * wall } else { HALF };
    let target = BodyDesc {
        density,
        breaking: Some(BreakingDesc::once(StrengthDesc::Named(material), pattern)),
        ..BodyDesc::new("target", shape)
    };
    let radius = 0.05;
    let ball = BodyDesc {
        position: [front + radius + 0.01 * speed, 0.07, 0.03],
        linear_velocity: [-speed, 0.0, 0.0],
        density: 7800.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius, resolution: Resolution::default() })
    };
    let mut scene = SceneDesc::new("space");
    scene.gravity = [0.0; 3];
    scene.bodies = vec![target, ball];
    let mut world = World::build(&scene).unwrap();
    (0..3).any(|_| !step(&mut world).fractures.is_empty())
}

/// The least speed at which a body breaks, to 5 % [m/s].
fn breaking_speed(shape: &(ShapeDesc, f64), material: (MaterialName, f64)) -> f64 {
    let (mut holds, mut breaking) = (0.01, 2000.0);
    while breaking / holds > 1.05 {
        let speed = f64::sqrt(holds * breaking);
        let bound = if breaks(shape.clone(), material, speed) { &mut breaking } else { &mut holds };
        *bound = speed;
    }
    breaking
}

#[test]
fn a_hollow_cube_breaks_as_a_pane_of_its_wall_does() {
    let mut off = false;
    for (material, walls) in [
        ((MaterialName::Glass, 2500.0), [0.005, 0.02]),
        ((MaterialName::Brick, 1800.0), [0.01, 0.05]),
        ((MaterialName::Concrete, 2400.0), [0.02, 0.05]),
        ((MaterialName::Wood, 600.0), [0.005, 0.03]),
        ((MaterialName::Ice, 917.0), [0.01, 0.04]),
    ] {
        for wall in walls {
            let [of_cube, of_pane] =
                [hollow(wall), pane(wall)].map(|shape| breaking_speed(&(shape, wall), material));
            let ratio = of_cube / of_pane;
            println!(
                "{:?} {wall} m: {of_cube:.2} m/s, a pane {of_pane:.2}: {ratio:.2}",
                material.0
            );
            off |= !(0.5..2.0).contains(&ratio);
        }
    }
    assert!(!off, "a ratio beside 0.5 to 2");
}
