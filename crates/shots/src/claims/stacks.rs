//! Stacks on the ground, straight and shifted.

use super::scenes::{METHODS, cube, run, world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, Method, Resolution, ShapeDesc};

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

/// Prisms and cylinders.
pub(super) const ROUND: Claim = Claim {
    name: "round-stacks",
    says: "stacks of four to eight prisms and cylinders come to rest within 8 s",
    source: "mechanics",
    measure: rests,
};

/// Maximum drift of ten cubes in 20 s [m].
const MOST_DRIFT: f64 = 0.02;

/// Maximum drift of shifted stacks, whose edges settle on edges [m].
const MOST_ZIGZAG_DRIFT: f64 = 0.03;

/// Largest drift of ten cubes in 20 s, each `shift` [m] off the middle to alternating sides.
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

/// Radii and heights of cylinders [m].
const CYLINDERS: [[f64; 2]; 4] = [[0.5, 1.0], [0.5, 0.5], [0.5, 0.2], [0.25, 1.0]];

/// Sides of prisms 1 m wide and high.
const SIDES: [u32; 3] = [6, 8, 32];

/// Numbers of stories.
const STORIES: [u32; 3] = [4, 6, 8];

/// The fastest body of a stack at rest [m/s].
const REST: f64 = 1e-3;

/// The largest speed of any body from 8 to 10 s [m/s].
fn last_speed(shape: &ShapeDesc, height: f64, stories: u32) -> Result<f64, Obstacle> {
    let body = |story: u32| BodyDesc {
        position: [0.0, (f64::from(story) + 0.5) * height, 0.0],
        ..BodyDesc::new("body", shape.clone())
    };
    let bodies = std::iter::once(BodyDesc::ground(0.0)).chain((0..stories).map(body)).collect();
    let mut world = world(Method::FrameRate, bodies)?;
    run(&mut world, 240);
    let mut speed = 0.0;
    for _ in 0..60 {
        step(&mut world);
        let speeds = world.bodies().velocities.iter().map(|velocity| velocity.linear.length());
        speed = largest(speeds.chain([speed]));
    }
    Ok(speed)
}

fn prism(sides: u32) -> ShapeDesc {
    let corner = |number: u32| {
        let turned = f64::from(number / 2) * std::f64::consts::TAU / f64::from(sides);
        let (sine, cosine) = libm::sincos(turned);
        [0.5 * cosine, if number.is_multiple_of(2) { 0.5 } else { -0.5 }, 0.5 * sine]
    };
    let points = (0..2 * sides).map(corner).collect();
    ShapeDesc::Hull { points, resolution: Resolution::default() }
}

fn rests() -> Result<Vec<Finding>, Obstacle> {
    let prisms = SIDES.map(|sides| (format!("prisms of {sides} sides"), prism(sides), 1.0));
    let cylinders = CYLINDERS.map(|[radius, height]| {
        let name = format!("cylinders of radius {radius} m and height {height} m");
        let resolution = Resolution::default();
        (name, ShapeDesc::Cylinder { radius, height, resolution }, height)
    });
    let mut findings = Vec::new();
    for (name, shape, height) in prisms.into_iter().chain(cylinders) {
        for stories in STORIES {
            let speed = last_speed(&shape, height, stories)?;
            let quantity = format!("largest speed from 8 to 10 s of {stories} {name}");
            findings.push(Finding::at_most(quantity, "m/s", speed, REST));
        }
    }
    Ok(findings)
}
