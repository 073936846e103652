//! A cube slides down slopes and stops by friction [Su09 fig. 3].

use super::scenes::{GRAVITY, METHODS, cube, position, run, world};
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use frangible::{BodyDesc, BuildError, Method};
use glam::{DQuat, DVec3};

/// Figure 3, on five slopes.
pub(super) const INCLINE: Claim = Claim {
    name: "incline",
    says: "a cube on a slope stops where its kinetic energy is used up by friction, and creeps no further in 10 s",
    source: "Su09 fig. 3",
    measure: incline,
};

/// Slope [degrees], friction, and speed at first [m/s].
const SLIDES: [(f64, f64, f64); 5] =
    [(5.0, 0.2, 1.0), (10.0, 0.2, 1.0), (10.0, 0.3, 2.0), (20.0, 0.5, 2.0), (30.0, 0.7, 3.0)];

/// Edge of the cube [m].
const EDGE: f64 = 0.2;

fn incline() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let mut most_crept: f64 = 0.0;
        for (degrees, friction, speed) in SLIDES {
            let slope = degrees.to_radians();
            let brake = GRAVITY * (friction * libm::cos(slope) - libm::sin(slope));
            let expected = 0.5 * speed * speed / brake;
            let (slid, crept) = slide(method, slope, friction, speed)?;
            let quantity = format!(
                "slide on {degrees} degrees with friction {friction} per the analytic, {name}"
            );
            findings.push(Finding::between(quantity, "1", slid / expected, 0.99, 1.01));
            most_crept = largest([most_crept, crept]);
        }
        findings.push(Finding::at_most(
            format!("largest creep in 10 s, {name}"),
            "m",
            most_crept,
            1e-4,
        ));
    }
    Ok(findings)
}

/// Sliding distance of a cube in 5 s, and its creep in the next 10 s [m].
fn slide(method: Method, slope: f64, friction: f64, speed: f64) -> Result<(f64, f64), BuildError> {
    let tilt = DQuat::from_rotation_z(-slope);
    let down = tilt * DVec3::X;
    let start = tilt * DVec3::new(0.0, 0.5 * EDGE, 0.0);
    let orientation = tilt.to_array();
    let mut world = world(
        method,
        vec![
            BodyDesc { orientation, friction, ..BodyDesc::ground(0.0) },
            BodyDesc {
                position: start.to_array(),
                orientation,
                linear_velocity: (speed * down).to_array(),
                friction,
                restitution: 0.0,
                ..BodyDesc::new("cube", cube(EDGE))
            },
        ],
    )?;
    run(&mut world, 150);
    let rest = position(&world, 1);
    run(&mut world, 300);
    Ok(((rest - start).dot(down), position(&world, 1).distance(rest)))
}
