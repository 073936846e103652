//! Overlapping bodies separate.

use super::scenes::{ball, cube, cuboid};
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};

/// In the ground, in a static box, and in one of its own kind.
pub(super) const INSIDE: Claim = Claim {
    name: "starts-inside",
    says: "what starts in a static body or in one of its own kind is out of it within 2 s, and leaves it slowly",
    source: "docs/adr/022",
    measure: measured,
};

/// Of all bodies [m].
const SIZE: f64 = 0.5;

/// Initial depths [m].
const DEPTHS: [f64; 3] = [0.01, 0.05, 0.2];

/// Time limit of separation [frames].
const FRAMES: u32 = 60;

/// Maximum remaining overlap [m].
const MOST_LEFT: f64 = 1e-3;

/// Maximum speed after separation in free space [m/s].
const MOST_SPEED: f64 = 0.1;

fn shapes() -> [(&'static str, ShapeDesc); 4] {
    let resolution = Resolution::default();
    let half = 0.5 * SIZE;
    // A hexagonal prism.
    let corner = |number: i32| {
        let (sine, cosine) = libm::sincos(f64::from(number / 2) * std::f64::consts::FRAC_PI_3);
        [half * cosine, if number % 2 == 0 { half } else { -half }, half * sine]
    };
    let points = (0..12).map(corner).collect();
    [
        ("a cube", cube(SIZE)),
        ("a ball", ball(half)),
        ("a prism", ShapeDesc::Hull { points, resolution }),
        ("a cylinder", ShapeDesc::Cylinder { radius: half, height: SIZE, resolution }),
    ]
}

/// The last overlap [m] and the last speed of any body [m/s]. Little energy is in play but for what
/// closing the overlap spends, so that frames are not watched here.
fn last(scene: &SceneDesc) -> Result<[f64; 2], Obstacle> {
    let mut world = World::build(scene)?;
    let is_free = scene.gravity == [0.0; 3];
    for _ in 0..FRAMES {
        if is_free {
            frangible::step(&mut world)
        } else {
            step(&mut world)
        };
    }
    let speeds = world.bodies().velocities.iter().map(|velocity| velocity.linear.length());
    Ok([largest(world.penetrations().into_iter().chain([0.0])), largest(speeds)])
}

fn measured() -> Result<Vec<Finding>, Obstacle> {
    let block = BodyDesc {
        motion: MotionDesc::Static,
        position: [0.0, -1.0, 0.0],
        ..BodyDesc::new("block", cuboid([4.0, 2.0, 4.0]))
    };
    let mut findings = Vec::new();
    for (name, shape) in shapes() {
        let at = |height: f64| BodyDesc {
            position: [0.0, height, 0.0],
            restitution: 0.0,
            ..BodyDesc::new("body", shape.clone())
        };
        for (place, outside) in [("the ground", BodyDesc::ground(0.0)), ("a block", block.clone())]
        {
            let mut left = 0.0;
            for depth in DEPTHS {
                let bodies = vec![outside.clone(), at(0.5 * SIZE - depth)];
                left = largest([left, last(&SceneDesc { bodies, ..SceneDesc::new("claim") })?[0]]);
            }
            let quantity = format!("last overlap of {name} that starts in {place}");
            findings.push(Finding::at_most(quantity, "m", left, MOST_LEFT));
        }
        let (mut left, mut speed) = (0.0, 0.0);
        for depth in DEPTHS {
            let bodies = vec![at(0.0), at(SIZE - depth)];
            let scene = SceneDesc { bodies, gravity: [0.0; 3], ..SceneDesc::new("claim") };
            let [overlap, leaves] = last(&scene)?;
            (left, speed) = (largest([left, overlap]), largest([speed, leaves]));
        }
        let of = format!("{name} that starts in another in free space");
        findings.push(Finding::at_most(format!("last overlap of {of}"), "m", left, MOST_LEFT));
        findings.push(Finding::at_most(format!("last speed of {of}"), "m/s", speed, MOST_SPEED));
    }
    Ok(findings)
}
