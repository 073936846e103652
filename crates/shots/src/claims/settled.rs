//! Where nothing is wrong, the safeguards have nothing to do.

use super::rolling::{RADIUS, ball_on_ground};
use super::scenes::{METHODS, cube, cuboid, run, world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle};
use crate::shot::{Shot, ShotOptions};
use frangible::{BodyDesc, Method, World};
use glam::DVec3;

/// A heap at rest.
pub(super) const SETTLED_PILE: Claim = Claim {
    name: "settled-pile",
    says: "in a settled pile fewer than 1 % of the islands have to be balanced",
    source: "docs/adr/009",
    measure: settled_pile,
};

/// Motions without friction's work.
pub(super) const LOSSLESS: Claim = Claim {
    name: "lossless",
    says: "free flight, rolling and spinning lose nothing, and are never balanced",
    source: "mechanics",
    measure: lossless,
};

fn settled_pile() -> Result<Vec<Finding>, Obstacle> {
    let mut bodies = vec![BodyDesc::ground(0.0)];
    for i in 0..30 {
        let [x, y, z] = [i % 3, i / 9, i / 3 % 3].map(f64::from);
        let position = [0.8 * x + 0.1 * y, 0.6 + 1.2 * y, 0.8 * z - 0.1 * y];
        bodies.push(BodyDesc {
            position,
            angular_velocity: [x, y, z],
            ..BodyDesc::new("cube", cube(0.6))
        });
    }
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let share = share_balanced(&mut world(method, bodies.clone())?);
        findings.push(Finding::at_most(
            format!("share of islands balanced, {name}"),
            "1",
            share,
            0.01,
        ));
    }
    let share =
        share_balanced(&mut World::build(&Shot::find("pillar")?.scene(&ShotOptions::default())?)?);
    let quantity = "share of islands balanced in the rubble of the pillar, frame-rate method";
    findings.push(Finding::at_most(quantity, "1", share, 0.01));
    Ok(findings)
}

/// Of all islands in 5 s, after 10 s in which the bodies come to rest.
fn share_balanced(world: &mut World) -> f64 {
    run(world, 300);
    let (mut islands, mut balanced) = (0, 0);
    for _ in 0..150 {
        let balance = step(world).balance;
        islands += balance.islands;
        balanced += balance.scaled + balance.paid;
    }
    balanced as f64 / islands as f64
}

/// Motion that is rounded to single precision in each frame may lose so much of its energy [1]: one
/// unit of the last place in each of 300 frames is 1.8e-5.
const ROUNDED: f64 = 4e-5;

fn lossless() -> Result<Vec<Finding>, Obstacle> {
    let brick = BodyDesc {
        linear_velocity: [1.0, 10.0, -0.5],
        angular_velocity: [3.0, 20.0, -7.0],
        ..BodyDesc::new("brick", cuboid([0.3, 0.1, 0.2]))
    };
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let most = |bound: f64| if method == Method::FrameRate { bound } else { f64::INFINITY };
        let cases = [
            ("flying brick", world(method, vec![brick.clone()])?, 1e-11),
            (
                "rolling ball",
                ball_on_ground(method, 2.0 * DVec3::X, -2.0 / RADIUS * DVec3::Z)?,
                most(ROUNDED),
            ),
            (
                "ball spinning on the spot",
                ball_on_ground(method, DVec3::ZERO, 20.0 * DVec3::Y)?,
                most(1e-6),
            ),
        ];
        for (motion, mut world, most) in cases {
            let (kinetic, potential) = world.energy();
            let mut removed = 0.0;
            for _ in 0..300 {
                removed += step(&mut world).balance.removed;
            }
            // Resting bodies sink slightly: the weight's energy is not kinetic.
            let (kinetic_now, potential_now) = world.energy();
            let flies = world.bodies().len() == 1;
            let fallen = if flies { potential - potential_now } else { 0.0 };
            let change = (kinetic_now - fallen) / kinetic - 1.0;
            let quantity = format!("energy of motion lost in 10 s, {motion}, {name}");
            findings.push(Finding::at_most(quantity, "1", change.abs(), most));
            let quantity = format!("energy that had to be balanced, {motion}, {name}");
            findings.push(Finding::at_most(quantity, "1", removed / kinetic, 1e-9));
        }
    }
    Ok(findings)
}
