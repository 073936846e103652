//! Stacks on the ground, straight and shifted.

use super::scenes::{METHODS, cube, run, world};
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, Method};

/// Straight.
pub(super) const STACK: Claim = Claim {
    name: "stack",
    says: "a stack of ten cubes stands for 20 s at 30 frames per second",
    source: "Su09 fig. 2",
    measure: || {
        METHODS.map(|(method, name)| drift(method, name, 0.0, MOST_DRIFT)).into_iter().collect()
    },
};

/// Each cube's support lies on edges that cross edges.
pub(super) const ZIGZAG: Claim = Claim {
    name: "zigzag-stack",
    says: "ten cubes shifted by a quarter of their width to alternating sides, in both directions, stand for 20 s",
    source: "mechanics",
    measure: || {
        METHODS
            .map(|(method, name)| drift(method, name, 0.125, MOST_ZIGZAG_DRIFT))
            .into_iter()
            .collect()
    },
};

/// What ten cubes may drift in 20 s [m].
const MOST_DRIFT: f64 = 0.02;

/// What counts as standing for those that are shifted, whose edges settle on edges [m].
const MOST_ZIGZAG_DRIFT: f64 = 0.03;

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
    let moved = world
        .bodies()
        .poses
        .iter()
        .zip(&start)
        .map(|(now, then)| now.position.distance(then.position));
    Ok(Finding::at_most(format!("largest drift, {name}"), "m", largest(moved), most))
}
