//! Every joule is booked: the stages' accounts match the real energy changes.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, Method, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    World, step,
};
use std::cell::Cell;

/// A ball breaks a slab on a turning plate, over the ground: all causes have something to do.
fn scene(method: Method) -> SceneDesc {
    let sampled = Resolution { voxels: Some([24, 6, 24]), sample_spacing: Some(0.1) };
    let cuboid = |size, resolution| ShapeDesc::Box { size, resolution };
    let pattern =
        PatternDesc::Voronoi(Voronoi { cells: 12, clustering: 1.0, seed: 3, ..Voronoi::default() });
    let mut scene = SceneDesc::new("books");
    scene.method = method;
    scene.bodies = vec![
        BodyDesc::ground(0.0),
        BodyDesc {
            motion: MotionDesc::Kinematic,
            position: [0.0, 0.5, 0.0],
            linear_velocity: [0.0, 0.2, 0.0],
            angular_velocity: [0.0, 1.5, 0.0],
            ..BodyDesc::new("plate", cuboid([3.0, 0.2, 3.0], Resolution::default()))
        },
        BodyDesc {
            position: [0.0, 0.9, 0.0],
            breaking: Some(BreakingDesc::once(400.0, pattern)),
            ..BodyDesc::new("slab", cuboid([1.2, 0.3, 1.2], sampled))
        },
        BodyDesc {
            position: [0.1, 3.0, 0.2],
            linear_velocity: [0.0, -8.0, 0.0],
            angular_velocity: [4.0, 0.0, 9.0],
            ..BodyDesc::new(
                "ball",
                ShapeDesc::Sphere { radius: 0.25, resolution: Resolution::default() },
            )
        },
    ];
    scene
}

#[test]
fn the_causes_add_up_to_the_change_of_the_energy() {
    for method in [Method::Paper, Method::FrameRate] {
        let mut world = World::build(&scene(method)).unwrap();
        let (kinetic, potential) = world.energy();
        let (mut before, mut scale) = (kinetic + potential, 0.0_f64);
        let mut total = frangible::Causes::default();
        for _ in 0..60 {
            let energy = step(&mut world).energy;
            let causes = energy.causes;
            let sum = causes.work
                + causes.collision
                + causes.contact
                + causes.friction
                + causes.projection
                + causes.fracture
                + causes.balance;
            scale = scale.max(energy.kinetic + energy.potential.abs());
            let error = energy.total - before - sum;
            assert!(error.abs() < 1e-11 * scale, "{method:?}: {error} J are nobody's, {causes:?}");
            before = energy.total;
            total.work += causes.work.abs();
            total.collision += causes.collision.abs();
            total.contact += causes.contact.abs();
            total.friction += causes.friction.abs();
            total.projection += causes.projection.abs();
            total.fracture += causes.fracture.abs();
        }
        assert!(
            total.fracture < 1e-9 * scale,
            "{method:?}: breaking conserves, {} J",
            total.fracture
        );
        for (name, cause) in [
            ("work", total.work),
            ("collision", total.collision),
            ("contact", total.contact),
            ("friction", total.friction),
            ("projection", total.projection),
        ] {
            // Closing the overlaps of the frame-rate method leaves nothing behind here.
            let is_in_play = name != "projection" || method == Method::Paper;
            assert_eq!(cause > 1e-6 * scale, is_in_play, "{method:?}: {name}, {cause} J");
        }
    }
}

/// A sled slides on ice under a load twenty times its mass: all that carries the load passes
/// through it, in every substep, and slows nothing down.
#[test]
fn what_a_sled_carries_does_not_brake_it() {
    let slide = |name: &str, size: [f64; 3], y: f64, density: f64, friction: f64| BodyDesc {
        position: [0.0, y, 0.0],
        linear_velocity: [5.0, 0.0, 0.0],
        density,
        friction,
        ..BodyDesc::new(name, ShapeDesc::Box { size, resolution: Resolution::default() })
    };
    let mut scene = SceneDesc::new("sled");
    scene.bodies = vec![
        BodyDesc { friction: 0.0, ..BodyDesc::ground(0.0) },
        slide("sled", [1.0, 0.1, 0.6], 0.05, 150.0, 0.8),
        slide("load", [0.8, 0.5, 0.5], 0.35, 900.0, 0.8),
    ];
    let mut world = World::build(&scene).unwrap();
    for _ in 0..90 {
        step(&mut world);
    }
    for body in [1, 2] {
        let speed = world.bodies().velocities[body].linear.x;
        assert!((speed - 5.0).abs() < 1e-6, "{speed} m/s");
    }
}

/// The engine has no clock: where there is none, as on WebAssembly, a step must not ask for one.
#[test]
fn stages_take_the_time_of_the_callers_clock() {
    let mut scene = SceneDesc::new("empty");
    scene.bodies.push(BodyDesc::ground(0.0));
    let mut world = World::build(&scene).unwrap();
    assert!(step(&mut world).stages.iter().all(|&(_, milliseconds)| milliseconds == 0.0));

    // Each look at this clock takes a second.
    thread_local!(static LOOKS: Cell<f64> = const { Cell::new(0.0) });
    world.set_clock(|| LOOKS.replace(LOOKS.get() + 1.0));
    let stages = step(&mut world).stages;
    assert!(stages.len() > 5 && stages.iter().all(|&(_, milliseconds)| milliseconds >= 1e3));
}

/// A heavy ball inside a breakable one, far from the origin, in the paper's method: what is left of
/// the energy after position correction pays for none of it. Before, the pieces kept the angular
/// momentum of the corrected positions at shorter displacements, and gained 0.04 J a frame.
#[test]
fn shortened_displacements_keep_the_moment_of_gravity() {
    let scene = r#"{"frames_per_second": 60.0, "method": "paper", "bodies": [
        {"shape": {"kind": "sphere", "radius": 0.6954, "resolution": {"voxels": [16, 16, 16]}},
         "position": [28.73, 14.7494, -18.8811], "orientation": [0.4488, -0.8673, 0.1717, 0.1302],
         "density": 2382.6, "angular_velocity": [-0.0876, 0.0894, -0.0805], "friction": 0.16,
         "restitution": 1.0, "breaking": {"strength": 0.445, "generations": 2, "smallest": 0.6954,
             "pattern": {"kind": "concrete", "seed": 158747021274, "cells": 3, "roughness": 0.559,
                         "grain": 0.60818}}},
        {"shape": {"kind": "sphere", "radius": 0.2382}, "position": [28.1301, 14.4811, -19.4697],
         "density": 13007.0, "friction": 2.0, "restitution": 0.0}]}"#;
    let mut world = World::build(&SceneDesc::from_json(scene).unwrap()).unwrap();
    for frame in 0..9 {
        let report = step(&mut world);
        assert!(report.energy.gain <= 1e-8, "frame {frame}: {} J", report.energy.gain);
        let momentum = report.momentum;
        assert!(momentum.angular_error <= 1e-13, "frame {frame}: {}", momentum.angular_error);
    }
    assert!(world.bodies().len() > 2, "it breaks");
}
