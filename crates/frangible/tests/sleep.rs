//! Sleeping, if enabled in the scene, and waking.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{
    BodyDesc, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc, StepReport, World, step,
};
use frangible_bodies::BodyId;
use glam::DVec3;

fn cube(position: [f64; 3]) -> BodyDesc {
    let shape = ShapeDesc::Box { size: [1.0; 3], resolution: Resolution::default() };
    BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", shape) }
}

/// A scene whose bodies may sleep.
fn scene(bodies: impl IntoIterator<Item = BodyDesc>) -> SceneDesc {
    SceneDesc { sleep: true, bodies: bodies.into_iter().collect(), ..SceneDesc::new("sleep") }
}

/// Steps for some frames, of which none gains energy or loses momentum; the last one's report.
fn run(world: &mut World, frames: u32) -> StepReport {
    let (kinetic, potential) = world.energy();
    let scale = kinetic + potential.abs() + 1.0;
    let mut last = None;
    for _ in 0..frames {
        let report = step(world);
        assert!(report.energy.gain <= 1e-9 * scale, "{} J", report.energy.gain);
        let momentum = report.momentum;
        assert!(momentum.linear_error.max(momentum.angular_error) < 1e-9, "{momentum:?}");
        last = Some(report);
    }
    last.unwrap()
}

fn asleep(world: &World) -> Vec<bool> {
    world.bodies().ids.iter().map(|&id| world.is_asleep(id)).collect()
}

/// A stack, and a cube beside it, sleep until a ball falls onto the stack: all of the stack wakes,
/// and the cube does not. Sleeping bodies keep their pose to the bit.
#[test]
fn what_stands_still_sleeps_until_it_is_touched() {
    const STACK: usize = 5;
    let stack = (0..STACK).map(|level| cube([0.0, 0.5 + level as f64, 0.0]));
    let ball = ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() };
    // It falls for 3.9 s.
    let position = [0.2, 80.0, 0.0];
    // A point of contact stops no spin about the vertical by itself.
    let (rolling_friction, spinning_friction) = (0.05, 0.05);
    let ball =
        BodyDesc { position, rolling_friction, spinning_friction, ..BodyDesc::new("ball", ball) };
    let bodies =
        [BodyDesc::ground(0.0)].into_iter().chain(stack).chain([cube([5.0, 0.5, 0.0]), ball]);
    let scene = scene(bodies);
    let mut world = World::build(&scene).unwrap();
    let report = run(&mut world, 60);
    assert_eq!(report.asleep, STACK + 1, "{:?}", asleep(&world));
    assert!(
        !asleep(&world)[0] && !asleep(&world)[STACK + 2],
        "the ground needs no sleep, and the ball falls"
    );
    let then = world.bodies().clone();
    run(&mut world, 50);
    let now = world.bodies();
    assert_eq!(now.poses[..=STACK + 1], then.poses[..=STACK + 1]);
    assert!(now.velocities[1..=STACK + 1].iter().all(|velocity| velocity.linear == DVec3::ZERO));

    // Awake once it is touched, and asleep again in the end.
    let report = run(&mut world, 12);
    assert_eq!(report.asleep, 1, "{:?}", asleep(&world));
    assert!(asleep(&world)[STACK + 1]);
    assert!(world.bodies().poses[STACK].position.distance(then.poses[STACK].position) > 0.01);
    let report = run(&mut world, 600);
    assert_eq!(report.asleep, world.bodies().len() - 1, "{:?}", asleep(&world));

    // Sleep is off by default.
    let mut world = World::build(&SceneDesc { sleep: false, ..scene }).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 0);
}

/// Bodies on a platform sleep, and move along once it begins to move.
#[test]
fn a_platform_that_moves_wakes_what_stands_on_it() {
    let platform = ShapeDesc::Box { size: [4.0, 0.5, 4.0], resolution: Resolution::default() };
    let platform =
        BodyDesc { motion: MotionDesc::Kinematic, ..BodyDesc::new("platform", platform) };
    let mut world = World::build(&scene([platform, cube([0.0, 0.75, 0.0])])).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 1);
    let id = world.bodies().ids[0];
    world.set_velocity(id, DVec3::new(0.0, -0.5, 0.0), DVec3::ZERO).unwrap();
    assert_eq!(run(&mut world, 30).asleep, 0);
    let left = world.bodies().poses[1].position.y - world.bodies().poses[0].position.y;
    assert!((left - 0.75).abs() < 0.01, "{left} m");
    world.set_velocity(id, DVec3::ZERO, DVec3::ZERO).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 1);
}

/// Setting a velocity wakes a body, even a slow velocity.
#[test]
fn what_gets_a_velocity_wakes() {
    let bodies = [BodyDesc { friction: 0.0, ..BodyDesc::ground(0.0) }, cube([0.0, 0.5, 0.0])];
    let mut world = World::build(&scene(bodies)).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 1);
    let id: BodyId = world.bodies().ids[1];
    world.set_velocity(id, 0.004 * DVec3::X, DVec3::ZERO).unwrap();
    assert_eq!(run(&mut world, 10).asleep, 0);
    let way = world.bodies().poses[1].position.x;
    assert!((way - 0.004 / 3.0).abs() < 1e-4, "{way} m");

    // Momentum lost on falling asleep is booked.
    let mass = world.bodies().masses[1];
    let mut lost = 0.0;
    for _ in 0..20 {
        let causes = run(&mut world, 1).energy.causes;
        assert!(causes.flight.abs() < 1e-9, "{causes:?}");
        lost += causes.contact + causes.projection + causes.friction;
    }
    assert!(world.is_asleep(id) && world.bodies().velocities[1].linear == DVec3::ZERO);
    assert!((lost + 0.5 * mass * 0.004 * 0.004).abs() < 1e-2 * mass * 0.004 * 0.004, "{lost} J");
}

/// Slow bodies on a tilting platform are not at rest: sleep follows half a second after the
/// platform stops.
#[test]
fn what_stood_on_a_tilting_platform_does_not_sleep_at_once() {
    let platform = ShapeDesc::Box { size: [4.0, 0.5, 4.0], resolution: Resolution::default() };
    let platform =
        BodyDesc { motion: MotionDesc::Kinematic, ..BodyDesc::new("platform", platform) };
    let mut world = World::build(&scene([platform, cube([0.0, 0.75, 0.0])])).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 1);
    let id = world.bodies().ids[0];
    world.set_velocity(id, DVec3::ZERO, 0.001 * DVec3::Z).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 0);
    world.set_velocity(id, DVec3::ZERO, DVec3::ZERO).unwrap();
    assert_eq!(run(&mut world, 12).asleep, 0);
    assert_eq!(run(&mut world, 12).asleep, 1);
}

/// A body gliding past a wall without gravity, within the speculative margin, is not stopped by it.
#[test]
fn what_glides_past_a_wall_does_not_sleep() {
    let wall = ShapeDesc::Box { size: [9.0, 1.0, 9.0], resolution: Resolution::default() };
    let wall = BodyDesc { motion: MotionDesc::Static, ..BodyDesc::new("wall", wall) };
    let glides = BodyDesc { linear_velocity: [0.004, 0.0, 0.0], ..cube([0.0, 1.0003, 0.0]) };
    let mut world =
        World::build(&SceneDesc { gravity: [0.0; 3], ..scene([wall, glides]) }).unwrap();
    assert_eq!(run(&mut world, 60).asleep, 0);
    assert!((world.bodies().poses[1].position.x - 0.008).abs() < 1e-6);
}

/// The paper's method has no sleep, and says so.
#[test]
fn the_papers_method_refuses_to_sleep() {
    let scene = SceneDesc { method: Method::Paper, ..scene([cube([0.0; 3])]) };
    let error = World::build(&scene).err().unwrap().to_string();
    assert!(error.contains("sleep") && error.contains("paper"), "{error}");
}

/// Bodies without a fixed support never sleep: two cubes drifting side by side without gravity.
#[test]
fn what_floats_does_not_sleep() {
    let mut bodies = [cube([0.0, 0.0, 0.0]), cube([0.0, 1.0, 0.0])];
    bodies.iter_mut().for_each(|body| body.linear_velocity = [0.002, 0.0, 0.0]);
    let mut world = World::build(&SceneDesc { gravity: [0.0; 3], ..scene(bodies) }).unwrap();
    assert_eq!(run(&mut world, 90).asleep, 0);
    let way = world.bodies().poses[0].position.x;
    assert!((way - 0.006).abs() < 1e-6, "{way} m");
}
