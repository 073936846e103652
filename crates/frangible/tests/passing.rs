//! Bodies that pass each other do not touch, and flush tiles are one floor.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};

const GRAVITY: f64 = 9.81;

fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: Resolution::default() }
}

fn body(shape: ShapeDesc, position: [f64; 3], friction: f64) -> BodyDesc {
    BodyDesc { position, friction, restitution: 0.0, ..BodyDesc::new("body", shape) }
}

fn block(size: [f64; 3], position: [f64; 3], friction: f64) -> BodyDesc {
    BodyDesc { motion: MotionDesc::Static, ..body(cuboid(size), position, friction) }
}

/// A cube, or a ball as wide.
fn of_size(is_ball: bool, size: f64) -> ShapeDesc {
    if is_ball {
        ShapeDesc::Sphere { radius: 0.5 * size, resolution: Resolution::default() }
    } else {
        cuboid([size; 3])
    }
}

/// A body falls freely between two flush walls of six courses, at any distance from both.
#[test]
fn a_shaft_does_not_touch_what_falls_in_it() {
    for is_ball in [false, true] {
        for frames_per_second in [30.0, 60.0] {
            for room in [0.0002, 0.001, 0.003, 0.0045, 0.005, 0.0055, 0.01] {
                let size = 0.2;
                let mut scene = SceneDesc { frames_per_second, ..SceneDesc::new("shaft") };
                for course in 0..6 {
                    let y = -0.25 * (f64::from(course) + 0.5);
                    for side in [-1.0, 1.0] {
                        let x = side * (0.5 * size + room + 0.1);
                        scene.bodies.push(block([0.2, 0.25, 0.6], [x, y, 0.0], 0.5));
                    }
                }
                scene.bodies.push(body(of_size(is_ball, size), [0.0, 0.3, 0.0], 0.5));
                let mut world = World::build(&scene).unwrap();
                let frames = (0.6 * frames_per_second) as u32;
                for _ in 0..frames {
                    step(&mut world);
                }
                let velocity = world.bodies().velocities[12];
                let expected = -GRAVITY * f64::from(frames) / frames_per_second;
                let error = velocity.linear.distance(glam::DVec3::Y * expected);
                let case = format!("{is_ball} {room} m at {frames_per_second}: {velocity:?}");
                assert!(error < 1e-12 * expected.abs(), "{case}");
                assert!(velocity.angular_momentum.length() < 1e-12, "{case}");
            }
        }
    }
}

/// How far a body slides or rolls over tiles in 1.2 s, and how high it hops [m].
fn crossing(is_ball: bool, size: f64, speed: f64, tile: f64, lower: f64) -> [f64; 2] {
    let mut scene = SceneDesc { frames_per_second: 30.0, ..SceneDesc::new("tiles") };
    let count = (50.0 / tile).ceil();
    for number in 0..count as u32 {
        let x = (f64::from(number) + 0.5) * tile - 4.0;
        let y = if x > 2.0 { -0.5 - lower } else { -0.5 };
        scene.bodies.push(block([tile, 1.0, 8.0], [x, y, 0.0], 0.3));
    }
    let spin = if is_ball { -2.0 * speed / size } else { 0.0 };
    let moving = scene.bodies.len();
    scene.bodies.push(BodyDesc {
        linear_velocity: [speed, 0.0, 0.0],
        angular_velocity: [0.0, 0.0, spin],
        ..body(of_size(is_ball, size), [-0.1, 0.5 * size, 0.0], 0.3)
    });
    let mut world = World::build(&scene).unwrap();
    let mut highest = 0.0_f64;
    for _ in 0..36 {
        step(&mut world);
        highest = highest.max(world.bodies().poses[moving].position.y - 0.5 * size);
    }
    [world.bodies().poses[moving].position.x + 0.1, highest]
}

/// Boxes and balls cross the seams of flush tiles, and of tiles that are a little lower, as they
/// cross one slab: within 1 % of its distance, and without a hop.
#[test]
fn seams_do_not_catch() {
    for (is_ball, sizes) in [(false, [0.1, 0.5, 1.0]), (true, [0.5, 1.0, 2.0])] {
        for size in sizes {
            for speed in [1.0, 3.0, 8.0] {
                let [slab, _] = crossing(is_ball, size, speed, 50.0, 0.0);
                for (tile, lower) in [(2.0, 0.0), (0.7, 0.0), (5.0, 0.001)] {
                    let [way, hop] = crossing(is_ball, size, speed, tile, lower);
                    let case = format!("{is_ball} {size} m at {speed} m/s, tiles of {tile} m");
                    assert!((way - slab).abs() < 0.01 * slab, "{case}: {way} m of {slab}");
                    assert!(hop < 1e-3, "{case}: hops {hop} m");
                }
            }
        }
    }
}

/// A step up is met: a box does not slide through it or over it.
#[test]
fn steps_are_met() {
    let [slab, _] = crossing(false, 0.5, 8.0, 50.0, 0.0);
    let [way, _] = crossing(false, 0.5, 8.0, 2.0, -0.05);
    assert!(way < 0.9 * slab, "{way} m of {slab}");
}
