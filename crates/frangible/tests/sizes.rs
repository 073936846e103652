//! Bodies of 0.1 mm to 1 km fall, stand and rest alike, at 30 frames a second.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World};
use glam::{DQuat, DVec3};

const G: f64 = 9.81;
const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };

/// Sides [m]. In a frame gravity moves by 5.5 mm, 55 of the smallest.
const SIDES: [f64; 6] = [1e-4, 1e-3, 0.05, 1.0, 100.0, 1000.0];

fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: NONE }
}

/// One of each kind, `side` [m] long.
fn shapes(side: f64) -> [ShapeDesc; 6] {
    let radius = 0.5 * side;
    let corners =
        [[1.0, 0.0, 0.0], [-0.6, 0.7, 0.0], [-0.5, -0.7, 0.3], [0.0, 0.1, 0.9], [0.1, 0.0, -0.8]];
    [
        cuboid([side; 3]),
        ShapeDesc::Sphere { radius, resolution: NONE },
        ShapeDesc::Cylinder { radius, height: side, resolution: NONE },
        ShapeDesc::Capsule { radius: 0.5 * radius, height: radius, resolution: NONE },
        ShapeDesc::Cone { radius, height: side, resolution: NONE },
        ShapeDesc::Hull {
            points: corners.map(|corner| corner.map(|x| radius * x)).to_vec(),
            resolution: NONE,
        },
    ]
}

fn after(bodies: Vec<BodyDesc>, seconds: f64, most_substeps: u32) -> World {
    let mut scene = SceneDesc { bodies, ..SceneDesc::new("sizes") };
    scene.solver.most_substeps = most_substeps;
    let mut world = World::build(&scene).unwrap();
    for _ in 0..(30.0 * seconds) as u32 {
        frangible::step(&mut world);
    }
    world
}

/// Deepest overlap [m].
fn deepest(world: &World) -> f64 {
    world.penetrations().into_iter().fold(0.0, f64::max)
}

#[test]
fn bodies_of_any_size_fall_and_rest() {
    for side in SIDES {
        // On the ground, and on a box of up to a million times its size.
        let large = (1e6 * side).min(1e6);
        let floor = BodyDesc {
            motion: MotionDesc::Static,
            position: [0.0, -0.5 * large, 0.0],
            restitution: 1.0,
            ..BodyDesc::new("floor", cuboid([large; 3]))
        };
        for floor in [BodyDesc::ground(0.0), floor] {
            for shape in shapes(side) {
                let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, 3.0).normalize(), 0.44);
                let falls = BodyDesc {
                    position: [0.37 * side, 1.75 * side, 0.0],
                    orientation: turn.to_array(),
                    restitution: 0.3,
                    // What is round stops, too.
                    rolling_friction: 0.05 * side,
                    spinning_friction: 0.05 * side,
                    ..BodyDesc::new("body", shape.clone())
                };
                let time = libm::sqrt(side / G);
                let world = after(vec![floor.clone(), falls], (30.0 * time).max(2.0), 128);
                let (pose, velocity) = (&world.bodies().poses[1], &world.bodies().velocities[1]);
                let what = format!("{shape:?} on {:?}", floor.shape);
                assert!(pose.position.y > 0.05 * side, "{what}: at {} m", pose.position.y);
                assert!(deepest(&world) < 0.02 * side, "{what}: {} m deep", deepest(&world));
                let speed = velocity.linear.length() * time / side;
                assert!(speed < 1e-3, "{what}: {speed} sizes in a time of fall");
            }
        }
    }
}

#[test]
fn stacks_of_ten_cubes_of_any_size_stand() {
    // Of 0.1 mm they need 256 substeps: they yield by 8 % of a side then.
    for (side, most_substeps) in SIDES.into_iter().zip([256, 128, 128, 128, 128, 128]) {
        let cube = |i: u32| BodyDesc {
            position: [0.0, (f64::from(i) + 0.5) * side, 0.0],
            restitution: 0.0,
            ..BodyDesc::new("cube", cuboid([side; 3]))
        };
        let bodies = std::iter::once(BodyDesc::ground(0.0)).chain((0..10).map(cube)).collect();
        let world = after(bodies, (20.0 * libm::sqrt(side / G)).max(3.0), most_substeps);
        let off = world.bodies().poses[10].position - DVec3::new(0.0, 9.5 * side, 0.0);
        assert!(off.length() < 0.1 * side, "cubes of {side} m: the top is {off} m off");
    }
}
