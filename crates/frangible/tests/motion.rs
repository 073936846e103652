//! Bodies that move, collide and rest under the paper's method, against what mechanics says.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use glam::DVec3;

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

/// A body thrown up rises and falls on the parabola, and clamping does not hold it: no total energy is clamped in a
/// split state [Su09 sec. 3.1].
#[test]
fn free_flight_is_ballistic_and_keeps_its_energy() {
    let mut brick =
        BodyDesc::new("brick", ShapeDesc::Box { size: [0.3, 0.1, 0.2], resolution: Resolution::default() });
    brick.position = [1.0, 2.0, 3.0];
    brick.linear_velocity = [1.0, 10.0, -0.5];
    brick.angular_velocity = [3.0, 20.0, -7.0];
    let mut world = world(vec![brick]);
    let mut energy = None;
    for _ in 0..60 {
        let report = step(&mut world);
        let first = *energy.get_or_insert(report.energy.total);
        assert!((report.energy.total - first).abs() < 1e-11 * first, "{} J", report.energy.total - first);
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

/// A swarm in free space: linear and angular momentum stay to rounding, whatever collides, and energy is not made.
#[test]
fn a_free_swarm_keeps_its_momentum() {
    let mut scene = SceneDesc::new("swarm");
    scene.gravity = [0.0; 3];
    for i in 0..27 {
        let [x, y, z] = [i % 3, i / 3 % 3, i / 9].map(|n| f64::from(n) - 1.0);
        scene.bodies.push(BodyDesc {
            position: [2.0 * x, 2.0 * y, 2.0 * z],
            linear_velocity: [-4.0 * x + y, -4.0 * y + z, -4.0 * z + x],
            angular_velocity: [z, 5.0 * x, -3.0 * y],
            ..BodyDesc::new(
                "brick",
                ShapeDesc::Box { size: [0.6, 0.9, 1.2], resolution: Resolution::default() },
            )
        });
    }
    let mut world = World::build(&scene).unwrap();
    let mut impulses = 0;
    for _ in 0..90 {
        let report = step(&mut world);
        impulses += report.impulses.applied;
        assert!(report.momentum.linear_error < 1e-12, "{}", report.momentum.linear_error);
        assert!(report.momentum.angular_error < 1e-12, "{}", report.momentum.angular_error);
    }
    assert!(impulses > 100, "the bricks do meet");
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

/// Ten cubes stay where they were put.
#[test]
fn a_stack_stands() {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for level in 0..10 {
        let position = [0.0, 0.5 + f64::from(level), 0.0];
        bodies.push(BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) });
    }
    let mut world = world(bodies);
    for _ in 0..120 {
        step(&mut world);
    }
    for level in 0..10 {
        let at = position(&world, level + 1);
        let put = DVec3::new(0.0, 0.5 + level as f64, 0.0);
        assert!((at - put).length() < 0.05, "level {level} at {at}");
    }
}

/// Where a cube that is pushed down a slope comes to rest after 5 s [m], and how far it creeps in the 10 s after.
fn slide(slope: f64, friction: f64, speed: f64) -> (f64, f64) {
    let tilt = glam::DQuat::from_rotation_z(-slope);
    let down = tilt * DVec3::X;
    let ground = BodyDesc { orientation: tilt.to_array(), friction, ..BodyDesc::ground(0.0) };
    let start = tilt * DVec3::new(0.0, 0.1, 0.0);
    let cube = BodyDesc {
        position: start.to_array(),
        orientation: tilt.to_array(),
        linear_velocity: (speed * down).to_array(),
        friction,
        restitution: 0.0,
        ..BodyDesc::new("cube", cube(0.2))
    };
    let mut world = world(vec![ground, cube]);
    let mut run = |frames: u32| {
        (0..frames).for_each(|_| drop(step(&mut world)));
        position(&world, 1)
    };
    let rest = run(150);
    ((rest - start).dot(down), (run(300) - rest).length())
}

/// A cube on a slope slides down against mu cos - sin, and stops where its kinetic energy is used up [Su09 fig. 3]; there it
/// stays.
#[test]
fn a_sliding_cube_stops_where_coulomb_says() {
    for (degrees, friction, speed) in
        [(5_f64, 0.2, 1.0), (10.0, 0.2, 1.0), (10.0, 0.3, 2.0), (20.0, 0.5, 2.0), (30.0, 0.7, 3.0)]
    {
        let slope = degrees.to_radians();
        let brake = 9.81 * (friction * slope.cos() - slope.sin());
        let expected = 0.5 * speed * speed / brake;
        let (slid, crept) = slide(slope, friction, speed);
        assert!(
            (slid - expected).abs() < 0.01 * expected,
            "{degrees} degrees: {slid} m, expected {expected} m"
        );
        assert!(crept < 1e-4, "{degrees} degrees: crept {crept} m");
    }
}

/// A lift carries a cube: the clamp does not hold the cube down, and the work is booked [Su09 sec. 3.2].
#[test]
fn a_lift_lifts_and_its_work_is_booked() {
    let lift = BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, -0.1, 0.0],
        linear_velocity: [0.0, 1.0, 0.0],
        ..BodyDesc::new("lift", ShapeDesc::Box { size: [3.0, 0.2, 3.0], resolution: Resolution::default() })
    };
    let cube = BodyDesc { position: [0.0, 0.5, 0.0], restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) };
    let mut world = world(vec![lift, cube]);
    let mut work = 0.0;
    let (mut first, mut last) = (None, 0.0);
    for _ in 0..60 {
        let report = step(&mut world);
        work += report.energy.work;
        first.get_or_insert(report.energy.total - report.energy.work);
        last = report.energy.total;
    }
    let height = position(&world, 1).y - position(&world, 0).y - 0.1;
    assert!((height - 0.5).abs() < 0.01, "{height} m above the lift");
    let raised = last - first.unwrap();
    assert!((work - raised).abs() < 0.03 * work, "work {work} J, energy {raised} J");
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
