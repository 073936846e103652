//! Bodies that move, collide and rest under the paper's method, against what mechanics says.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{
    BodyDesc, KeyframeDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};
use glam::{DQuat, DVec3};

fn cube(edge: f64) -> ShapeDesc {
    ShapeDesc::Box { size: [edge; 3], resolution: Resolution::default() }
}

fn ball(radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere { radius, resolution: Resolution::default() }
}

fn world(bodies: Vec<BodyDesc>) -> World {
    let mut scene = SceneDesc::new("test");
    scene.bodies = bodies;
    World::build(&scene).unwrap()
}

fn position(world: &World, body: usize) -> DVec3 {
    world.bodies().poses[body].position
}

/// A body thrown up rises and falls on the parabola, and clamping does not hold it: no total energy
/// is clamped in a split state [Su09 sec. 3.1].
#[test]
fn free_flight_is_ballistic_and_keeps_its_energy() {
    let mut brick = BodyDesc::new(
        "brick",
        ShapeDesc::Box { size: [0.3, 0.1, 0.2], resolution: Resolution::default() },
    );
    brick.position = [1.0, 2.0, 3.0];
    brick.linear_velocity = [1.0, 10.0, -0.5];
    brick.angular_velocity = [3.0, 20.0, -7.0];
    let mut world = world(vec![brick]);
    let mut energy = None;
    for _ in 0..60 {
        let report = step(&mut world);
        let first = *energy.get_or_insert(report.energy.total);
        assert!(
            (report.energy.total - first).abs() < 1e-11 * first,
            "{} J",
            report.energy.total - first
        );
        assert!(report.momentum.linear_error < 1e-13 && report.momentum.angular_error < 1e-13);
    }
    let t = 2.0;
    let expected = DVec3::new(1.0 + t, 2.0 + 10.0 * t - 0.5 * 9.81 * t * t, 3.0 - 0.5 * t);
    assert!((position(&world, 0) - expected).length() < 1e-12);
}

/// Two equal balls, head on, without loss: they exchange their velocities.
#[test]
fn an_elastic_collision_exchanges_velocities() {
    let throw = |x: f64, v: f64| BodyDesc {
        position: [x, 0.0, 0.0],
        linear_velocity: [v, 0.0, 0.0],
        restitution: 1.0,
        friction: 0.0,
        ..BodyDesc::new("ball", ball(0.5))
    };
    let mut scene = SceneDesc::new("test");
    scene.gravity = [0.0; 3];
    scene.bodies = vec![throw(-2.0, 3.0), throw(2.0, -1.0)];
    let mut world = World::build(&scene).unwrap();
    for _ in 0..60 {
        let report = step(&mut world);
        assert!(report.energy.gain < 1e-12 * report.energy.total);
        assert!(report.momentum.linear_error < 1e-14);
    }
    // The balls' samples lie some degrees off the line of centres, so a little goes sideways.
    let v = |i: usize| world.bodies().velocities[i].linear;
    assert!((v(0) - DVec3::new(-1.0, 0.0, 0.0)).length() < 0.3, "{}", v(0));
    assert!((v(1) - DVec3::new(3.0, 0.0, 0.0)).length() < 0.3, "{}", v(1));
}

/// A cube let fall comes to rest on the ground, within a millimetre of it.
#[test]
fn a_dropped_cube_comes_to_rest_on_the_ground() {
    let cube = BodyDesc { position: [0.0, 1.5, 0.0], ..BodyDesc::new("cube", cube(1.0)) };
    let mut world = world(vec![BodyDesc::ground(0.0), cube]);
    let mut last = f64::INFINITY;
    for _ in 0..150 {
        last = step(&mut world).energy.kinetic;
    }
    let height = position(&world, 1).y;
    assert!((height - 0.5).abs() < 1e-3, "{height}");
    assert!(last < 1e-3, "{last} J");
}

/// The same world steps to the same bits.
#[test]
fn the_same_scene_gives_the_same_bits() {
    let run = || {
        let mut bodies = vec![BodyDesc::ground(0.0)];
        for i in 0..8 {
            let x = f64::from(i);
            let position = [0.3 * x, 1.0 + 0.7 * x, 0.1 * x];
            bodies.push(BodyDesc {
                position,
                angular_velocity: [x, 1.0, -x],
                ..BodyDesc::new("cube", cube(0.6))
            });
        }
        let mut world = world(bodies);
        (0..90).for_each(|_| {
            step(&mut world);
        });
        world.state_hash()
    };
    assert_eq!(run(), run());
}

/// A kinematic body is where its path says at the end of each frame, also between key frames, and
/// strikes with the velocity of its way.
#[test]
fn kinematic_bodies_follow_their_paths() {
    let key = |frame: f64, x: f64, turn: f64| KeyframeDesc {
        frame,
        position: [x, 0.0, 0.0],
        orientation: DQuat::from_rotation_z(turn).to_array(),
    };
    let block = ShapeDesc::Box { size: [1.0, 2.0, 0.5], resolution: Resolution::default() };
    let hammer = BodyDesc {
        motion: MotionDesc::Kinematic,
        path: vec![key(2.0, 0.0, 0.0), key(6.0, 0.8, 1.0), key(8.5, 0.8, 3.0)],
        ..BodyDesc::new("hammer", block.clone())
    };
    let struck = BodyDesc { position: [1.5, 0.0, 0.0], ..BodyDesc::new("struck", block) };
    let scene = SceneDesc {
        gravity: [0.0; 3],
        bodies: vec![hammer.clone(), struck],
        ..SceneDesc::new("hammer")
    };
    let mut world = World::build(&scene).unwrap();
    let expected = [(0.0, 0.0); 2]
        .into_iter()
        .chain(
            [0.2, 0.4, 0.6, 0.8].into_iter().enumerate().map(|(i, x)| (x, 0.25 * (i + 1) as f64)),
        )
        .chain([(0.8, 1.8), (0.8, 2.6), (0.8, 3.0), (0.8, 3.0)]);
    for (frame, (x, turn)) in expected.enumerate() {
        let report = step(&mut world);
        let pose = &world.bodies().poses[0];
        assert!((pose.position.x - x).abs() < 1e-12, "{frame}: {}", pose.position);
        let off = pose.orientation.angle_between(DQuat::from_rotation_z(turn));
        assert!(off < 1e-7, "{frame}: {off}");
        assert!(report.energy.gain <= 1e-9 * report.energy.causes.work.abs().max(1.0));
    }
    assert!(world.bodies().velocities[1].linear.x > 1.0, "it was struck");

    let wrong = |hammer: BodyDesc| {
        let scene = SceneDesc { bodies: vec![hammer], ..scene.clone() };
        World::build(&scene).unwrap_err().to_string()
    };
    let twice = vec![key(2.0, 0.0, 0.0); 2];
    let sentence = wrong(BodyDesc { path: twice, ..hammer.clone() });
    assert!(sentence.starts_with("bodies[0].path[1].frame: 2, must be after"), "{sentence}");
    let sentence = wrong(BodyDesc { motion: MotionDesc::Dynamic, ..hammer });
    assert!(sentence.starts_with("bodies[0].path: on a body that is not kinematic"), "{sentence}");
}
