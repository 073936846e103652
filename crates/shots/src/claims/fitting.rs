//! Close fits: pieces of a slab, a plate before a wall, a nut on its bolt.

use super::scenes::{GRAVITY, run};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::nut::{PITCH, nut};
use crate::scenes::plate::plate;
use crate::shot::{Shot, ShotOptions};
use frangible::World;
use glam::{DQuat, DVec3};
use std::f64::consts::TAU;

/// Pieces.
pub(super) const SLAB: Claim = Claim {
    name: "slab",
    says: "a slab cut into 100 snug pieces lies on the ground for 10 s as if it were whole",
    source: "mechanics",
    measure: slab,
};

/// A hundred metres a second.
pub(super) const PLATE: Claim = Claim {
    name: "plate",
    says: "a wall of 1 cm stops a plate of 1 cm that comes at 100 m/s, however it is turned",
    source: "mechanics",
    measure: plates,
};

/// A thread.
pub(super) const NUT: Claim = Claim {
    name: "nut",
    says: "a nut turns down a smooth bolt as its thread and its inertia say, and stays on a rough one",
    source: "mechanics",
    measure: nuts,
};

fn slab() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for seed in 0..3 {
        let scene = Shot::find("slab")?.scene(&ShotOptions { seed, ..ShotOptions::default() })?;
        let mut world = World::build(&scene)?;
        let start = world.bodies().poses.clone();
        let mut moved = 0.0;
        for _ in 0..300 {
            step(&mut world);
            let ways = world.bodies().poses.iter().zip(&start);
            moved = largest(
                ways.map(|(now, then)| now.position.distance(then.position)).chain([moved]),
            );
        }
        findings.push(Finding::at_most(
            format!("largest drift of a piece of slab {seed}"),
            "m",
            moved,
            1e-3,
        ));
    }
    Ok(findings)
}

fn plates() -> Result<Vec<Finding>, Obstacle> {
    let mut beyond = f64::NEG_INFINITY;
    let turns = [
        DVec3::ZERO,
        DVec3::new(0.0, 0.3, 0.0),
        DVec3::new(0.0, 1.5, 0.2),
        DVec3::new(0.4, 0.1, 0.8),
    ];
    for turn in turns {
        for part in 0..8 {
            let orientation = DQuat::from_scaled_axis(turn);
            let mut world = World::build(&plate(orientation, 0.4 * f64::from(part)))?;
            for _ in 0..15 {
                step(&mut world);
                beyond = largest([beyond, world.bodies().poses[2].position.x]);
            }
        }
    }
    Ok(vec![Finding::at_most(
        "how far the middle of 32 plates gets beyond the wall's middle",
        "m",
        beyond,
        0.0,
    )])
}

/// Duration of the nut's rotation [frames].
const TURNING: u32 = 90;

fn nuts() -> Result<Vec<Finding>, Obstacle> {
    let mut world = World::build(&nut(0.0))?;
    let start = world.bodies().poses[2].position.y;
    let (mut angle, mut off) = (0.0, 0.0);
    for _ in 0..TURNING {
        step(&mut world);
        let bodies = world.bodies();
        let (pose, velocity) = (&bodies.poses[2], &bodies.velocities[2]);
        angle += bodies.inertias[2].angular_velocity(pose.orientation, velocity.angular_momentum).y
            / 30.0;
        off = largest([off, (pose.position.y - start - angle * PITCH / TAU).abs()]);
    }

    // A mass that turns by k per metre of its fall has the inertia of another I k^2.
    let bodies = world.bodies();
    let k = TAU / PITCH;
    let about_axis = {
        let inertia = &bodies.inertias[2];
        let momentum = bodies.poses[2].orientation * DVec3::Y;
        1.0 / inertia.angular_velocity(bodies.poses[2].orientation, momentum).dot(momentum)
    };
    let acceleration = GRAVITY / (1.0 + about_axis * k * k / bodies.masses[2]);
    let time = f64::from(TURNING) / 30.0;
    let expected = -0.5 * acceleration * time * time * k;

    let mut rough = World::build(&nut(0.3))?;
    let start_rough = rough.bodies().poses[2];
    run(&mut rough, TURNING);
    let end_rough = rough.bodies().poses[2];
    let turned = start_rough.orientation.angle_between(end_rough.orientation);
    Ok(vec![
        Finding::between("angle turned in 3 s per the analytic", "1", angle / expected, 0.8, 1.02),
        Finding::at_most("way off the thread", "m", off, 0.01),
        Finding::at_most("angle turned in 3 s with friction 0.3", "rad", turned, 0.01),
        Finding::at_most("sinking then", "m", start_rough.position.y - end_rough.position.y, 0.01),
    ])
}
