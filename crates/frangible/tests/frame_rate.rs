//! The frame-rate method against what mechanics says: one detection a frame, and contact that is right.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use glam::{DQuat, DVec3};

fn cube(edge: f64) -> ShapeDesc {
    ShapeDesc::Box { size: [edge; 3], resolution: Resolution::default() }
}

fn world(bodies: Vec<BodyDesc>) -> World {
    let mut scene = SceneDesc::new("test");
    scene.method = Method::FrameRate;
    scene.bodies = bodies;
    World::build(&scene).unwrap()
}

fn run(world: &mut World, frames: u32) {
    (0..frames).for_each(|_| drop(step(world)));
}

/// Ten cubes, each shifted by `shift` to alternating sides in both directions: how far any of them gets in 20 s [m].
fn drift_of_stack(shift: f64) -> f64 {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for level in 0..10 {
        let aside = if level % 2 == 0 { shift } else { -shift };
        let position = [aside, 0.5 + f64::from(level), aside];
        bodies.push(BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) });
    }
    let mut world = world(bodies);
    let start = world.bodies().poses.clone();
    run(&mut world, 600);
    let moved =
        world.bodies().poses.iter().zip(&start).map(|(now, then)| (now.position - then.position).length());
    moved.fold(0.0, f64::max)
}

#[test]
fn a_stack_of_ten_stands_for_twenty_seconds() {
    let drift = drift_of_stack(0.0);
    assert!(drift < 0.02, "{drift} m");
}

/// Each cube shifted by an eighth of its width to either side of the middle: its support lies on edges that cross edges.
#[test]
fn a_zigzag_stack_stands() {
    let drift = drift_of_stack(0.125);
    assert!(drift < 0.03, "{drift} m");
}

/// Heights above rest of the first bounces of a ball that falls from 2 m [m].
fn bounces(restitution: f64, count: usize) -> Vec<f64> {
    let shape = ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() };
    let ball = BodyDesc { position: [0.0, 2.5, 0.0], restitution, ..BodyDesc::new("ball", shape) };
    let mut world = world(vec![BodyDesc::ground(0.0), ball]);
    let (mut heights, mut last, mut rises) = (Vec::new(), 2.0, false);
    while heights.len() < count {
        step(&mut world);
        // The energy tells the height between the frames.
        let speed = world.bodies().velocities[1].linear.y;
        let height = world.bodies().poses[1].position.y - 0.5;
        if rises && height < last {
            heights.push(height + speed * speed / (2.0 * 9.81));
        }
        rises = height > last;
        last = height;
    }
    heights
}

#[test]
fn bounces_return_to_their_height() {
    for (number, height) in bounces(1.0, 20).into_iter().enumerate() {
        assert!(height > 0.999 * 2.0 && height <= 2.0 + 1e-9, "bounce {number}: {height} m");
    }
    let mut before = 2.0;
    for height in bounces(0.5, 3) {
        assert!((height / before - 0.25).abs() < 0.02, "{height} m after {before} m");
        before = height;
    }
}

#[test]
fn a_sliding_cube_stops_where_coulomb_says_and_stays() {
    for (degrees, friction, speed) in
        [(5_f64, 0.2, 1.0), (10.0, 0.2, 1.0), (10.0, 0.3, 2.0), (20.0, 0.5, 2.0), (30.0, 0.7, 3.0)]
    {
        let tilt = DQuat::from_rotation_z(-degrees.to_radians());
        let down = tilt * DVec3::X;
        let start = tilt * DVec3::new(0.0, 0.1, 0.0);
        let mut world = world(vec![
            BodyDesc { orientation: tilt.to_array(), friction, ..BodyDesc::ground(0.0) },
            BodyDesc {
                position: start.to_array(),
                orientation: tilt.to_array(),
                linear_velocity: (speed * down).to_array(),
                friction,
                restitution: 0.0,
                ..BodyDesc::new("cube", cube(0.2))
            },
        ]);
        run(&mut world, 150);
        let rest = world.bodies().poses[1].position;
        run(&mut world, 300);
        let crept = (world.bodies().poses[1].position - rest).length();
        let slope = degrees.to_radians();
        let expected = 0.5 * speed * speed / (9.81 * (friction * slope.cos() - slope.sin()));
        let slid = (rest - start).dot(down);
        assert!(
            (slid - expected).abs() < 0.01 * expected,
            "{degrees} degrees: {slid} m, expected {expected} m"
        );
        assert!(crept < 1e-4, "{degrees} degrees: crept {crept} m");
    }
}

/// A lift at 2 m/s carries a stack without any cube sinking a millimetre into what it stands on, and its work is booked.
#[test]
fn a_lift_carries_a_stack() {
    let plate = ShapeDesc::Box { size: [3.0, 0.2, 3.0], resolution: Resolution::default() };
    let mut bodies = vec![BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, -0.1, 0.0],
        linear_velocity: [0.0, 2.0, 0.0],
        ..BodyDesc::new("lift", plate)
    }];
    for level in 0..5 {
        let position = [0.0, 0.5 + f64::from(level), 0.0];
        bodies.push(BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) });
    }
    let mut world = world(bodies);
    run(&mut world, 30);
    let (start, mut work) = (world.energy(), 0.0);
    for _ in 0..90 {
        work += step(&mut world).energy.work;
        let height = |i: usize| world.bodies().poses[i].position.y;
        for level in 1..6 {
            let below = if level == 1 { 0.6 } else { 1.0 };
            let gap = height(level) - height(level - 1) - below;
            assert!(gap > -1e-3, "level {level} sank {} m", -gap);
        }
    }
    let end = world.energy();
    let raised = end.0 + end.1 - start.0 - start.1;
    assert!((work - raised).abs() < 0.01 * work, "work {work} J, energy {raised} J");
}

/// Whatever 200 bodies do to each other in free space, both momenta stay.
#[test]
fn a_free_swarm_keeps_its_momentum() {
    let mut scene = SceneDesc::new("swarm");
    scene.method = Method::FrameRate;
    scene.gravity = [0.0; 3];
    for i in 0..200 {
        let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|n| f64::from(n) - 2.5);
        scene.bodies.push(BodyDesc {
            position: [1.6 * x, 1.6 * y, 1.6 * z],
            linear_velocity: [-2.0 * x + y, -2.0 * y + z, -2.0 * z + x],
            angular_velocity: [z, 5.0 * x, -3.0 * y],
            ..BodyDesc::new(
                "brick",
                ShapeDesc::Box { size: [0.6, 0.9, 1.2], resolution: Resolution::default() },
            )
        });
    }
    let mut world = World::build(&scene).unwrap();
    let mut impulses = 0;
    for _ in 0..300 {
        let report = step(&mut world);
        impulses += report.impulses.applied;
        assert!(report.momentum.linear_error < 1e-10 && report.momentum.angular_error < 1e-10);
    }
    assert!(impulses > 10_000, "{impulses} impulses: the bricks do meet");
}

/// In a settled pile hardly any island has to be balanced.
#[test]
fn balance_is_invisible_in_a_settled_pile() {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for i in 0..30 {
        let [x, y, z] = [i % 3, i / 9, i / 3 % 3].map(f64::from);
        let position = [0.8 * x + 0.1 * y, 0.6 + 1.2 * y, 0.8 * z - 0.1 * y];
        bodies.push(BodyDesc { position, angular_velocity: [x, y, z], ..BodyDesc::new("cube", cube(0.6)) });
    }
    let mut world = world(bodies);
    run(&mut world, 300);
    let (mut islands, mut scaled) = (0, 0);
    for _ in 0..150 {
        let balance = step(&mut world).balance;
        islands += balance.islands;
        scaled += balance.scaled;
    }
    assert!(scaled * 100 <= islands, "{scaled} of {islands}");
}
