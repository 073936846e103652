//! A ball falls and bounces.

use super::scenes::{GRAVITY, METHODS, ball, world};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle};
use frangible::{BodyDesc, BuildError, Method};

/// With restitution 1 and with a half.
pub(super) const BOUNCES: Claim = Claim {
    name: "bounces",
    says: "a ball returns to the restitution squared of its height",
    source: "mechanics",
    measure: bounces,
};

/// From which the ball falls [m].
const HEIGHT: f64 = 2.0;

/// Of the ball [m].
const RADIUS: f64 = 0.5;

/// A bounce that has not come by then does not [frames].
const MOST_FRAMES: u32 = 1000;

fn bounces() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let elastic = heights(method, 1.0, 20)?;
        let returned = elastic.last().map_or(0.0, |height| height / HEIGHT);
        let highest = elastic.iter().fold(0.0_f64, |most, &height| most.max(height)) / HEIGHT;
        let losing = heights(method, 0.5, 3)?;
        let ratios = std::iter::once(&HEIGHT)
            .chain(&losing)
            .zip(&losing)
            .map(|(before, after)| after / before);
        let worst = ratios.fold(0.25_f64, |worst, ratio| {
            if (ratio - 0.25).abs() > (worst - 0.25).abs() { ratio } else { worst }
        });
        let quantities = [
            (
                format!("height after 20 bounces with restitution 1, {name}"),
                returned,
                0.999,
                1.0 + 1e-9,
            ),
            (format!("highest of them, {name}"), highest, 0.999, 1.0 + 1e-9),
            (
                format!("height after one bounce with restitution 0.5, worst of 3, {name}"),
                worst,
                0.23,
                0.27,
            ),
        ];
        for (number, (quantity, measured, low, high)) in quantities.into_iter().enumerate() {
            // The paper's method bounces before the touch, up to a frame's way above the ground.
            let is_promised = method == Method::FrameRate || number < 2;
            findings.push(if is_promised {
                Finding::between(quantity, "1", measured, low, high)
            } else {
                Finding::beside(quantity, "1", measured)
            });
        }
    }
    Ok(findings)
}

/// Heights above rest of the first bounces [m]; 0 for missing bounces.
fn heights(method: Method, restitution: f64, count: usize) -> Result<Vec<f64>, BuildError> {
    let position = [0.0, HEIGHT + RADIUS, 0.0];
    let ball = BodyDesc { position, restitution, ..BodyDesc::new("ball", ball(RADIUS)) };
    let mut world = world(method, vec![BodyDesc::ground(0.0), ball])?;
    let (mut heights, mut last, mut rises) = (Vec::new(), HEIGHT, false);
    for _ in 0..MOST_FRAMES {
        step(&mut world);
        // The energy tells the height between the frames.
        let speed = world.bodies().velocities[1].linear.y;
        let height = world.bodies().poses[1].position.y - RADIUS;
        if rises && height < last {
            heights.push(height + speed * speed / (2.0 * GRAVITY));
        }
        if heights.len() == count {
            break;
        }
        rises = height > last;
        last = height;
    }
    heights.resize(count, 0.0);
    Ok(heights)
}
