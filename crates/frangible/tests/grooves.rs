//! A ball in a groove has two contact points: it stays in the middle, and rolls as it would in exact
//! time.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{BodyDesc, MotionDesc, PartDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use std::f64::consts::{FRAC_1_SQRT_2, FRAC_PI_8};

const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };

/// Of the sides [m].
const LENGTH: f64 = 60.0;
const WIDTH: f64 = 1.0;
const THICKNESS: f64 = 0.2;

/// The two sides of a groove along x, at 45 degrees each; they meet in the x axis.
fn sides() -> [([f64; 3], [f64; 4]); 2] {
    [1.0, -1.0].map(|side| {
        // A box turned by 45 degrees about x, its upper face's edge on the axis.
        let (along, down) = (0.5 * WIDTH * FRAC_1_SQRT_2, 0.5 * THICKNESS * FRAC_1_SQRT_2);
        let position = [0.0, along - down, side * (along + down)];
        (position, [-side * FRAC_PI_8.sin(), 0.0, 0.0, FRAC_PI_8.cos()])
    })
}

fn still(shape: ShapeDesc) -> BodyDesc {
    BodyDesc { motion: MotionDesc::Static, restitution: 0.0, ..BodyDesc::new("groove", shape) }
}

/// Two boxes, a compound of both, two triangles for each side, and many.
fn grooves() -> Vec<(&'static str, Vec<BodyDesc>)> {
    let size = [LENGTH, THICKNESS, WIDTH];
    let boxes = sides().map(|(position, orientation)| BodyDesc {
        position,
        orientation,
        ..still(ShapeDesc::Box { size, resolution: NONE })
    });
    let parts =
        sides().map(|(position, orientation)| PartDesc::Box { size, position, orientation });
    let mesh = |cells: usize| {
        let across = WIDTH * FRAC_1_SQRT_2;
        let row = |k: usize| {
            let x = LENGTH * (k as f64 / cells as f64 - 0.5);
            [[x, across, -across], [x, 0.0, 0.0], [x, across, across]]
        };
        let pair = |k: usize| {
            let at = |row: usize, column: usize| (3 * (k + row) + column) as u32;
            [0, 1].map(|c| {
                [[at(0, c), at(0, c + 1), at(1, c)], [at(0, c + 1), at(1, c + 1), at(1, c)]]
            })
        };
        still(ShapeDesc::Triangles {
            positions: (0..=cells).flat_map(row).collect(),
            triangles: (0..cells).flat_map(pair).flatten().collect(),
            thickness: None,
            sides: None,
            resolution: NONE,
        })
    };
    vec![
        ("boxes", boxes.to_vec()),
        ("compound", vec![still(ShapeDesc::Compound { parts: parts.to_vec(), resolution: NONE })]),
        ("two triangles", vec![mesh(1)]),
        ("fine triangles", vec![mesh(300)]),
    ]
}

#[test]
fn a_ball_rolls_in_a_groove() {
    for (name, groove) in grooves() {
        for radius in [0.01, 0.1] {
            for (slope, speed) in [(0.0_f64, 0.0), (0.0, 3.0), (0.2, 0.0)] {
                // Where it touches the ball is this far from the axis that it rolls about.
                let lever = radius * FRAC_1_SQRT_2;
                let shape = ShapeDesc::Sphere { radius, resolution: NONE };
                let ball = BodyDesc {
                    position: [-20.0, radius / FRAC_1_SQRT_2, 0.0],
                    linear_velocity: [speed, 0.0, 0.0],
                    angular_velocity: [0.0, 0.0, -speed / lever],
                    restitution: 0.0,
                    ..BodyDesc::new("ball", shape)
                };
                let scene = SceneDesc {
                    bodies: groove.iter().cloned().chain([ball]).collect(),
                    gravity: [9.81 * slope.sin(), -9.81 * slope.cos(), 0.0],
                    ..SceneDesc::new("test")
                };
                let mut world = World::build(&scene).unwrap();
                let (mut aside, seconds) = (0.0_f64, 2.0);
                for _ in 0..(seconds * scene.frames_per_second) as usize {
                    step(&mut world);
                    aside = aside.max(world.bodies().poses.last().unwrap().position.z.abs());
                }
                // 2/5 m r^2 turns with the way over the lever.
                let pull = 9.81 * slope.sin() / (1.0 + 0.4 * (radius / lever).powi(2));
                let expected = speed * seconds + 0.5 * pull * seconds * seconds;
                let way = world.bodies().poses.last().unwrap().position.x + 20.0;
                let case = format!("{name}, {radius} m, {slope}, {speed} m/s: {way} {expected}");
                assert!((way - expected).abs() <= 2e-3 * expected + 1e-9, "{case}");
                assert!(aside <= 1e-3 * radius, "{case}: {aside} m aside");
            }
        }
    }
}
