//! Bodies that a caller adds to a world and takes out of it.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, SceneDesc, ShapeDesc, World, id_number, step};

fn cube(name: &str, edge: f64, position: [f64; 3]) -> BodyDesc {
    let shape = ShapeDesc::Box { size: [edge; 3], resolution: Default::default() };
    BodyDesc { position, ..BodyDesc::new(name, shape) }
}

fn scene(bodies: Vec<BodyDesc>) -> SceneDesc {
    let mut scene = SceneDesc::new("come and go");
    scene.bodies = vec![BodyDesc::ground(0.0)];
    scene.bodies.extend(bodies);
    scene
}

/// A body that is added before the first frame moves to the bit as one of the scene.
#[test]
fn an_added_body_is_one_of_the_scene() {
    let ball = BodyDesc {
        position: [0.1, 3.0, 0.0],
        linear_velocity: [0.0, -5.0, 1.0],
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.2, resolution: Default::default() })
    };
    let lower = cube("cube", 1.0, [0.0, 0.5, 0.0]);
    let mut whole = World::build(&scene(vec![lower.clone(), ball.clone()])).unwrap();
    let mut grown = World::build(&scene(vec![lower])).unwrap();
    let id = grown.add_body(&ball).unwrap();
    for _ in 0..60 {
        let (expected, report) = (step(&mut whole), step(&mut grown));
        assert_eq!(whole.state_hash(), grown.state_hash());
        assert_eq!(report.energy.total, expected.energy.total);
    }
    assert!(grown.bodies().index_of(id).is_some());
}

/// In the middle of a run neither brings anything into the books of the steps.
#[test]
fn books_stay_balanced_whoever_comes_and_goes() {
    let mut world = World::build(&scene(vec![cube("first", 0.5, [0.0, 0.25, 0.0])])).unwrap();
    let mut ids = vec![world.bodies().ids[1]];
    for frame in 0..120 {
        if frame % 10 == 0 {
            let height = 0.75 + 0.5 * (ids.len() as f64 - 1.0);
            ids.push(world.add_body(&cube("more", 0.5, [0.0, height, 0.0])).unwrap());
        }
        if frame % 25 == 24 {
            world.remove_body(ids.remove(0)).unwrap();
        }
        let report = step(&mut world);
        let scale = 1e3 * report.mass;
        assert!(report.energy.gain < 1e-9 * scale, "frame {frame}: {:?}", report.energy);
        assert!(report.momentum.linear_error < 1e-9, "frame {frame}: {:?}", report.momentum);
        assert_eq!(report.bodies, ids.len() + 1);
    }
}

/// What slept on a body that is gone falls.
#[test]
fn what_slept_on_a_body_that_is_gone_falls() {
    let mut scene =
        scene(vec![cube("lower", 1.0, [0.0, 0.5, 0.0]), cube("upper", 1.0, [0.0, 1.5, 0.0])]);
    scene.sleep = true;
    let mut world = World::build(&scene).unwrap();
    let [_, lower, upper] = world.bodies().ids[..] else { panic!("three bodies") };
    (0..60).for_each(|_| _ = step(&mut world));
    assert!(world.is_asleep(upper));
    world.remove_body(lower).unwrap();
    (0..60).for_each(|_| _ = step(&mut world));
    let height = world.bodies().poses[1].position.y;
    assert!((height - 0.5).abs() < 1e-3, "stands at {height}");
}

#[test]
fn errors_name_the_body_and_the_field() {
    let mut world = World::build(&scene(vec![cube("cube", 1.0, [0.0, 0.5, 0.0])])).unwrap();
    let id = world.bodies().ids[1];
    let bad = BodyDesc { density: -1.0, ..cube("bad", 1.0, [0.0; 3]) };
    let told = world.add_body(&bad).unwrap_err().to_string();
    assert!(told.starts_with("body.density: -1.0, must be between"), "{told}");
    world.remove_body(id).unwrap();
    let told = world.remove_body(id).unwrap_err().to_string();
    assert_eq!(told, format!("body: {}, must be the id of a living body", id_number(id)));
}
