//! What rests, parts, and is fast.

use crate::scenes::*;
use frangible::{BodyDesc, MotionDesc, ShapeDesc};
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_6;

#[test]
fn round_bodies_roll_stack_and_lie() {
    let mut rows = Vec::new();
    for speed in [1.0, 30.0] {
        let rolls = BodyDesc {
            orientation: lying(),
            linear_velocity: [speed, 0.0, 0.0],
            angular_velocity: [0.0, 0.0, -speed / 0.3],
            ..body(cylinder(0.3, 0.2), [0.0, 0.3, 0.0])
        };
        let world = AT_30.end(vec![BodyDesc::ground(0.0), rolls], 5.0);
        rows.push((
            "synthesis#490",
            format!("speed after 5 s of {speed}"),
            velocity(&world).x / speed,
            about(1.0, 1e-3),
        ));
    }
    let stack = |count: u32| {
        let drum = |i: u32| body(cylinder(0.5, 1.0), [0.0, f64::from(i) + 0.5, 0.0]);
        std::iter::once(BodyDesc::ground(0.0)).chain((0..count).map(drum)).collect()
    };
    let world = AT_30.end(stack(5), 6.0);
    rows.push((
        "godotengine/godot#52542",
        "speed of five drums".into(),
        fastest(&world),
        [0.0, 1e-4],
    ));

    // Millimetres: a cylinder of 7.5 mm stays where it lies.
    for orientation in [DQuat::IDENTITY.to_array(), lying()] {
        let small = BodyDesc { orientation, ..body(cylinder(0.0075, 0.02), [-0.8, 0.1, 0.0]) };
        let floor = fixed(cuboid([2.0, 0.04, 2.0]), [0.0, -0.02, 0.0]);
        let world = Run { rate: 60.0, ..AT_30 }.end(vec![floor, small], 5.0);
        let off = (position(&world) - DVec3::new(-0.8, 0.0, 0.0)).with_y(0.0).length();
        rows.push(("dimforge/rapier.js#215", "drift [m]".into(), off, [0.0, 1e-4]));
        rows.push(("dimforge/rapier.js#215", "overlap [m]".into(), deepest(&world), [0.0, 5e-5]));
    }
    // A toppled cone lies on its side, its apex on the ground.
    let turn = DQuat::from_rotation_z(f64::to_radians(100.0));
    let cone = ShapeDesc::Cone { radius: 0.25, height: 1.0, resolution: NONE };
    let toppled = BodyDesc { orientation: turn.to_array(), ..body(cone, [0.0, 1.0, 0.0]) };
    let world = AT_30.end(vec![BodyDesc::ground(0.0), toppled], 6.0);
    let pose = world.bodies().poses[1];
    let apex = pose.position + pose.orientation * DVec3::new(0.0, 0.75, 0.0);
    rows.push((
        "cx20/webgl-physics-examples#368",
        "height of the apex".into(),
        apex.y,
        about(0.0, 1e-3),
    ));

    // Capsules: one off the middle of its box for five minutes, and a raft of five.
    let lies = BodyDesc { orientation: lying(), ..body(capsule(5.0, 10.0), [1.0, 5.0, 0.0]) };
    let floor = fixed(cuboid([20.0, 2.0, 20.0]), [0.0, -1.0, 0.0]);
    let world = AT_30.end(vec![floor, lies], 300.0);
    let moved = position(&world).distance(DVec3::new(1.0, 5.0, 0.0));
    rows.push(("bulletphysics/bullet3#702", "way in 300 s [m]".into(), moved, [0.0, 1e-3]));
    let upper = 0.1 + 0.2 * libm::sin(2.0 * FRAC_PI_6);
    let raft = [(0.0, 0.1), (0.2, 0.1), (0.4, 0.1), (0.1, upper), (0.3, upper)]
        .map(|(x, y)| BodyDesc { orientation: lying(), ..body(capsule(0.1, 1.0), [x, y, 0.0]) });
    let walls = [-0.2, 0.6].map(|x| fixed(cuboid([0.2, 1.0, 4.0]), [x, 0.5, 0.0]));
    let bodies = [BodyDesc::ground(0.0)].into_iter().chain(walls).chain(raft).collect();
    let world = AT_30.end(bodies, 5.0);
    rows.push((
        "bepu/bepuphysics2#189",
        "speed of parallel capsules".into(),
        fastest(&world),
        [0.0, 1e-4],
    ));
    check(&rows);
}

#[test]
fn what_rests_stays_and_what_leans_falls() {
    let mut rows = Vec::new();
    // Stacks at a hundredfold mass ratio, from 1 m; and under tenfold and hundredfold gravity.
    let cube = |side: f64, y: f64, density: f64| BodyDesc {
        density,
        ..body(cuboid([side; 3]), [0.0, y, 0.0])
    };
    let world =
        AT_30.end(vec![BodyDesc::ground(0.0), cube(1.0, 0.5, 10.0), cube(1.0, 2.5, 1000.0)], 6.0);
    rows.push(("jrouwe/JoltPhysics#1390", "overlap [m]".into(), deepest(&world), [0.0, 2e-3]));
    rows.push((
        "jrouwe/JoltPhysics#1390",
        "height of the heavy one".into(),
        position(&world).y,
        about(1.5, 3e-3),
    ));
    for times in [10.0, 100.0] {
        let strong = Run { rate: 60.0, gravity: [0.0, -times * G, 0.0], ..AT_30 };
        let floor = fixed(cuboid([4.0, 0.1, 4.0]), [0.0, -0.05, 0.0]);
        let stack = (0..5).map(|i| cube(0.1, 0.05 + 0.1 * f64::from(i), 1000.0));
        let world = strong.end([floor].into_iter().chain(stack).collect(), 3.0);
        rows.push((
            "godot-jolt/godot-jolt#796",
            format!("sinks at {times} g [m]"),
            0.45 - position(&world).y,
            [0.0, 2e-3],
        ));
    }
    // Face to face at every shift and turn, no contact is lost.
    let mut lowest = f64::INFINITY;
    for (dx, yaw) in [(0.0, 0.0), (0.25, 90.0), (0.45, 45.0), (0.499999, 0.0), (-0.45, 30.0)] {
        let orientation = DQuat::from_rotation_y(f64::to_radians(yaw)).to_array();
        let upper = BodyDesc { orientation, ..cube(1.0, 1.5, 1000.0) };
        let upper = BodyDesc { position: [0.9 * dx, 1.5, 0.0], ..upper };
        let world = AT_30.end(vec![BodyDesc::ground(0.0), cube(1.0, 0.5, 1000.0), upper], 2.0);
        lowest = lowest.min(position(&world).y);
    }
    rows.push((
        "google-deepmind/mujoco_warp#1526",
        "lowest of the upper boxes".into(),
        lowest,
        about(1.5, 1e-3),
    ));

    // A box on its edge, half a degree off, tips over.
    let turn = DQuat::from_rotation_z(-f64::to_radians(71.7995722113328));
    let corners =
        [-1.0, 1.0].map(|x| [-1.0, 1.0].map(|y| (turn * DVec3::new(0.047 * x, 0.015 * y, 0.0)).y));
    let lowest = corners.as_flattened().iter().copied().fold(0.0, f64::min);
    let edge = BodyDesc {
        orientation: turn.to_array(),
        friction: 1.0,
        ..body(cuboid([0.094, 0.03, 0.135]), [0.0, -lowest, 0.0])
    };
    let world = Run { rate: 60.0, ..AT_30 }.end(vec![BodyDesc::ground(0.0), edge], 3.0);
    rows.push((
        "dimforge/rapier#934",
        "height of the box on its face".into(),
        position(&world).y,
        about(0.015, 1e-4),
    ));
    check(&rows);
}

#[test]
fn what_overlaps_parts() {
    let mut rows = Vec::new();
    for method in BOTH {
        let depth = 1.5;
        let free = Run { method, gravity: [0.0; 3], ..AT_30 };
        let world = free
            .end(vec![body(ball(1.0), [0.0; 3]), body(ball(1.0), [2.0 - depth, 0.0, 0.0])], 10.0);
        let apart = position(&world).distance(world.bodies().poses[0].position);
        rows.push((
            "pmndrs/cannon-es#165",
            format!("distance, {method:?}"),
            apart,
            about(2.0, 1e-4),
        ));
        rows.push((
            "pmndrs/cannon-es#165",
            format!("speed, {method:?}"),
            fastest(&world),
            [0.0, 1e-4],
        ));
    }
    // Triangles of 84 m, and a box 5 cm in them.
    let wide = BodyDesc {
        shape: match sheet(84.0, 1).shape {
            ShapeDesc::Triangles { positions, triangles, .. } => ShapeDesc::Triangles {
                positions,
                triangles,
                thickness: None,
                sides: Some(frangible::SidesDesc::One),
                resolution: NONE,
            },
            other => other,
        },
        ..sheet(84.0, 1)
    };
    let sunk = body(cuboid([0.5, 0.3, 0.4]), [13.0, 0.1, 7.0]);
    let world = AT_30.end(vec![wide, sunk], 4.0);
    rows.push((
        "jrouwe/JoltPhysics#2065",
        "height of the box".into(),
        position(&world).y,
        about(0.15, 5e-4),
    ));
    check(&rows);
}

#[test]
fn nothing_passes_and_free_spin_stays() {
    let mut rows = Vec::new();
    for shape in [ball(0.1), cuboid([0.2; 3])] {
        let of = |x: f64, speed: f64| BodyDesc {
            restitution: 1.0,
            linear_velocity: [speed, 0.0, 0.0],
            ..body(shape.clone(), [x, 0.0, 0.0])
        };
        let run = Run { gravity: [0.0; 3], ..AT_30 };
        let world = run.end(vec![of(-50.3, 1000.0), of(50.3, -1000.0)], 0.2);
        let speed = velocity(&world).x;
        rows.push(("dimforge/rapier#984", "speed back".into(), speed, about(1000.0, 1e-6)));
    }
    // Small prisms at 20 m/s, on a floor that none leaves, and long ones on hills.
    let turned = |i: u32| {
        let axis = DVec3::new(1.0, f64::from(i), 2.0).normalize();
        DQuat::from_axis_angle(axis, f64::from(37 * i)).to_array()
    };
    let prism = |i: u32| BodyDesc {
        orientation: turned(i),
        linear_velocity: [0.0, -20.0, 0.0],
        ..body(cuboid([0.04, 0.02, 0.1]), [0.2 * f64::from(i) - 1.0, 1.0, 0.0])
    };
    let floor = BodyDesc {
        motion: MotionDesc::Dynamic,
        ..fixed(cuboid([20.0, 0.05, 20.0]), [0.0, 0.025, 0.0])
    };
    let bodies = [BodyDesc::ground(0.0), floor].into_iter().chain((0..10).map(prism)).collect();
    let world = Run { rate: 120.0, ..AT_30 }.end(bodies, 1.0);
    let lowest = world.bodies().poses[2..].iter().map(|pose| pose.position.y).fold(9.0, f64::min);
    rows.push(("Facepunch/sbox-issues#4468", "lowest centre [m]".into(), lowest, [0.0599, 9.0]));

    let hill = |i: u32, k: u32| 0.6 * libm::sin(0.7 * f64::from(i)) * libm::cos(0.5 * f64::from(k));
    let heights = (0..25).map(|k| (0..25).map(|i| hill(i, k)).collect()).collect();
    let field = fixed(ShapeDesc::Heightfield { heights, spacing: [1.0; 2], sides: None }, [0.0; 3]);
    let plank = |i: u32| BodyDesc {
        orientation: turned(i),
        ..body(
            cuboid([0.2, 0.2, [0.2, 1.0, 2.0, 4.0, 6.0][i as usize % 5]]),
            [f64::from(i % 4) * 3.0 - 5.0, 3.0 + 0.5 * f64::from(i), f64::from(i % 3) * 3.0 - 3.0],
        )
    };
    let world = AT_30.end([field].into_iter().chain((0..10).map(plank)).collect(), 6.0);
    rows.push((
        "bulletphysics/bullet3#1022",
        "deepest overlap [m]".into(),
        deepest(&world),
        [0.0, 2e-3],
    ));
    let lowest = world.bodies().poses[1..].iter().map(|pose| pose.position.y).fold(9.0, f64::min);
    rows.push(("bulletphysics/bullet3#1022", "lowest centre [m]".into(), lowest, [-0.6, 9.0]));

    // Moments of 1.7231e-4, 6.58e-6 and 1.7243e-4 kg m^2, far from a stable axis.
    let spins = BodyDesc {
        density: 0.12 / (0.01830300521772313 * 0.13003076559030174 * 0.017972200755611453),
        angular_velocity: [100.0, 1000.0, -30.0],
        ..body(cuboid([0.01830300521772313, 0.13003076559030174, 0.017972200755611453]), [0.0; 3])
    };
    let run = Run { gravity: [0.0; 3], ..AT_30 };
    let mut kinetic = [f64::INFINITY, 0.0_f64];
    run.watch(vec![spins], 20.0, |world| {
        let (pose, velocity) = (&world.bodies().poses[0], &world.bodies().velocities[0]);
        let energy = 0.5 * velocity.angular_momentum.dot(world.bodies().spin(0, pose, velocity));
        kinetic = [kinetic[0].min(energy), kinetic[1].max(energy)];
    });
    rows.push((
        "google-deepmind/mujoco#3553",
        "spread of the energy".into(),
        kinetic[1] / kinetic[0] - 1.0,
        [0.0, 1e-9],
    ));
    check(&rows);
}
