//! What stands by its shape and by friction, and falls without.

use super::{Claim, Finding, Obstacle, largest};
use crate::arch::{FRICTION as STONE, arch};
use crate::towers::{pyramid, tower};
use frangible::{SceneDesc, World, step};
use glam::DVec3;

/// Up.
pub(super) const TOWERS: Claim = Claim {
    name: "towers",
    says: "a tower of ten cubes and a pyramid of 210 stand for 20 s at 30 frames per second",
    source: "mechanics",
    measure: towers,
};

/// Of stones.
pub(super) const ARCH: Claim = Claim {
    name: "arch",
    says: "an arch of 15 loose stones stands for 20 s, and falls if they are smooth",
    source: "[Hey66]",
    measure: || of_friction("arch", arch, STONE, 0.1),
};

/// How far anything that stands may get in 20 s [m].
const MOST_DRIFT: f64 = 0.02;

/// How long [frames].
const FRAMES: u32 = 600;

/// The largest way of any body [m], and the largest sinking of any [m].
fn drift(scene: &SceneDesc) -> Result<[f64; 2], Obstacle> {
    let mut world = World::build(scene)?;
    let start = world.bodies().poses.clone();
    for _ in 0..FRAMES {
        step(&mut world);
    }
    let moves = || -> Vec<DVec3> {
        world.bodies().poses.iter().zip(&start).map(|(now, then)| now.position - then.position).collect()
    };
    Ok([largest(moves().iter().map(|by| by.length())), largest(moves().iter().map(|by| -by.y))])
}

fn stands(name: &str, scene: &SceneDesc) -> Result<[Finding; 2], Obstacle> {
    let [moved, sunk] = drift(scene)?;
    Ok([
        Finding::at_most(format!("largest drift of {name}"), "m", moved, MOST_DRIFT),
        Finding::beside(format!("of this, downward, of {name}"), "m", sunk),
    ])
}

fn towers() -> Result<Vec<Finding>, Obstacle> {
    Ok([stands("a tower of ten", &tower(10))?, stands("a pyramid", &pyramid())?].concat())
}

fn of_friction(
    name: &str,
    build: fn(f64) -> SceneDesc,
    rough: f64,
    smooth: f64,
) -> Result<Vec<Finding>, Obstacle> {
    let mut findings = stands(name, &build(rough))?.to_vec();
    let [moved, _] = drift(&build(smooth))?;
    let quantity = format!("the same with friction {smooth} instead of {rough}");
    findings.push(Finding::at_least(quantity, "m", moved, 10.0 * MOST_DRIFT));
    Ok(findings)
}
