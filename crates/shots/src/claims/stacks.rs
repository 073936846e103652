//! Stacks: on the ground, shifted, and in an elevator.

use super::scenes::{METHODS, cube, cuboid, energy, position, run, world};
use super::{Claim, Finding, Obstacle};
use frangible::{BodyDesc, BuildError, Method, MotionDesc, World, step};

/// Straight.
pub(super) const STACK: Claim = Claim {
    name: "stack",
    says: "a stack of ten cubes stands for 20 s at 30 frames per second",
    source: "Su09 fig. 2",
    measure: || METHODS.map(|(method, name)| drift(method, name, 0.0, MOST_DRIFT)).into_iter().collect(),
};

/// Each cube's support lies on edges that cross edges.
pub(super) const ZIGZAG: Claim = Claim {
    name: "zigzag-stack",
    says: "ten cubes shifted by a quarter of their width to alternating sides, in both directions, stand for 20 s",
    source: "mechanics",
    measure: || {
        METHODS.map(|(method, name)| drift(method, name, 0.125, MOST_ZIGZAG_DRIFT)).into_iter().collect()
    },
};

/// Up.
pub(super) const ELEVATOR: Claim = Claim {
    name: "elevator",
    says: "an elevator at 2 m/s carries a stack of five cubes, and its work is the energy that they gain",
    source: "Su09 sec. 3.2",
    measure: elevator,
};

/// What ten cubes may drift in 20 s [m].
const MOST_DRIFT: f64 = 0.02;

/// What counts as standing for those that are shifted [m]: a twentieth of their width.
const MOST_ZIGZAG_DRIFT: f64 = 0.05;

/// What a cube may sink into what it stands on [m].
const MOST_SINKING: f64 = 1e-3;

/// How far any of ten cubes gets in 20 s, each `shift` [m] off the middle to alternating sides.
fn drift(method: Method, name: &str, shift: f64, most: f64) -> Result<Finding, Obstacle> {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for level in 0..10 {
        let aside = if level % 2 == 0 { shift } else { -shift };
        let position = [aside, 0.5 + f64::from(level), aside];
        bodies.push(BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) });
    }
    let mut world = world(method, bodies)?;
    let start = world.bodies().poses.clone();
    run(&mut world, 600);
    let moved =
        world.bodies().poses.iter().zip(&start).map(|(now, then)| now.position.distance(then.position));
    let largest = moved.fold(0.0, f64::max);
    Ok(Finding::at_most(format!("largest drift, {name}"), "m", largest, most))
}

/// Five cubes on a plate that rises.
fn in_elevator(method: Method) -> Result<World, BuildError> {
    let mut bodies = vec![BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, -0.1, 0.0],
        linear_velocity: [0.0, 2.0, 0.0],
        ..BodyDesc::new("elevator", cuboid([3.0, 0.2, 3.0]))
    }];
    for level in 0..5 {
        let position = [0.0, 0.5 + f64::from(level), 0.0];
        bodies.push(BodyDesc { position, restitution: 0.0, ..BodyDesc::new("cube", cube(1.0)) });
    }
    world(method, bodies)
}

/// How deep any cube is in what it stands on [m].
fn sinking(world: &World) -> f64 {
    let height = |i: usize| position(world, i).y;
    let gap = |level: usize| height(level) - height(level - 1) - if level == 1 { 0.6 } else { 1.0 };
    (1..6).map(|level| -gap(level)).fold(f64::NEG_INFINITY, f64::max)
}

fn elevator() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let mut world = in_elevator(method)?;
        run(&mut world, 30);
        let start = energy(&world);
        let (mut work, mut sunk) = (0.0, f64::NEG_INFINITY);
        for _ in 0..90 {
            work += step(&mut world).energy.work;
            sunk = sinking(&world).max(sunk);
        }
        let raised = energy(&world) - start;
        findings.push(Finding::at_most(format!("sinking on the way up, {name}"), "m", sunk, MOST_SINKING));
        findings.push(Finding::between(
            format!("energy gained per work, {name}"),
            "1",
            raised / work,
            0.99,
            1.01,
        ));
    }
    Ok(findings)
}
