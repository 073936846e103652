//! Bodies that collide in free space.

use super::scenes::{METHODS, cuboid, free_world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::BodyDesc;

/// Two hundred of them.
pub(super) const SWARM: Claim = Claim {
    name: "swarm",
    says: "whatever 200 bodies do to each other in free space for 10 s, both momenta stay",
    source: "docs/adr/006",
    measure: swarm,
};

/// Impulses from which on the swarm counts as colliding.
const COLLISIONS: f64 = 1_000.0;

fn swarm() -> Result<Vec<Finding>, Obstacle> {
    let brick = |i: i32| {
        let [x, y, z] = [i % 6, i / 6 % 6, i / 36].map(|n| f64::from(n) - 2.5);
        BodyDesc {
            position: [1.6 * x, 1.6 * y, 1.6 * z],
            linear_velocity: [-2.0 * x + y, -2.0 * y + z, -2.0 * z + x],
            angular_velocity: [z, 5.0 * x, -3.0 * y],
            ..BodyDesc::new("brick", cuboid([0.6, 0.9, 1.2]))
        }
    };
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let mut world = free_world(method, (0..200).map(brick).collect())?;
        let (mut impulses, mut linear, mut angular) = (0, 0.0_f64, 0.0_f64);
        for _ in 0..300 {
            let report = step(&mut world);
            impulses += report.impulses.applied;
            linear = largest([linear, report.momentum.linear_error]);
            angular = largest([angular, report.momentum.angular_error]);
        }
        findings.push(Finding::at_most(
            format!("change of linear momentum, {name}"),
            "1",
            linear,
            1e-10,
        ));
        findings.push(Finding::at_most(
            format!("change of angular momentum, {name}"),
            "1",
            angular,
            1e-10,
        ));
        findings.push(Finding::at_least(
            format!("impulses, {name}"),
            "1",
            impulses as f64,
            COLLISIONS,
        ));
    }
    Ok(findings)
}
