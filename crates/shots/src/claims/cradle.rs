//! Momentum transfer through rows of balls.

use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::cradle::{RADIUS, ROW, SPEED, cradle, row};
use frangible::{SceneDesc, World};

/// As many leave as came.
pub(super) const CRADLE: Claim = Claim {
    name: "cradle",
    says: "of five balls that touch as many leave as strike them, and the others rest, as in Newton's cradle",
    source: "[SKV12]",
    measure: measured,
};

/// Long ones.
pub(super) const ROWS: Claim = Claim {
    name: "rows",
    says: "in rows of 10 to 500 elastic balls, touching or apart, the last one takes the whole energy of the first",
    source: "[SKV12]",
    measure: rows,
};

/// Until the balls have struck and parted [frames].
const FRAMES: u32 = 30;

/// Tolerance of speeds, relative to the striker's.
const FEW_PER_CENT: f64 = 0.04;

/// Speed of each ball relative to the strikers', in row order; and changes of momentum and energy.
struct Struck {
    speeds: Vec<f64>,
    momentum: f64,
    energy: f64,
}

fn struck(scene: &SceneDesc) -> Result<Struck, Obstacle> {
    let mut world = World::build(scene)?;
    let momentum = |world: &World| -> f64 {
        let bodies = world.bodies();
        let of = |i: usize| bodies.masses[i] * bodies.velocities[i].linear.x;
        (0..bodies.len()).filter(|&i| bodies.masses[i].is_finite()).map(of).sum()
    };
    let energy = |world: &World| world.energy().0 + world.energy().1;
    let before = (momentum(&world), energy(&world), world.energy().0);
    for _ in 0..FRAMES {
        step(&mut world);
    }
    let bodies = world.bodies();
    let balls = (0..bodies.len()).filter(|&i| bodies.masses[i].is_finite());
    Ok(Struck {
        speeds: balls.map(|i| bodies.velocities[i].linear.x / SPEED).collect(),
        momentum: momentum(&world) / before.0 - 1.0,
        energy: (energy(&world) - before.1) / before.2,
    })
}

/// Without ground and gravity.
fn freed(mut scene: SceneDesc) -> SceneDesc {
    scene.bodies.remove(0);
    SceneDesc { gravity: [0.0; 3], ..scene }
}

fn measured() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (place, is_free) in [("on smooth ground", false), ("in free space", true)] {
        let scene = |strikers: usize, restitution: f64| {
            let scene = cradle(strikers, restitution);
            if is_free { freed(scene) } else { scene }
        };
        let mut books = Vec::new();
        for strikers in 1..=3 {
            let struck = struck(&scene(strikers, 1.0))?;
            let (rest, leave) = struck.speeds.split_at(ROW);
            let slowest = leave.iter().copied().fold(f64::INFINITY, f64::min);
            let fastest = largest(rest.iter().map(|speed| speed.abs()));
            let of = format!("of those that {strikers} set in motion, {place}");
            findings.push(Finding::at_least(
                format!("slowest {of}"),
                "1",
                slowest,
                1.0 - FEW_PER_CENT,
            ));
            findings.push(Finding::at_most(
                format!("fastest of the others, struck by {strikers}, {place}"),
                "1",
                fastest,
                FEW_PER_CENT,
            ));
            books.push(struck);
        }

        // Each of five impacts leaves (1 + e) / 2 of the speed to the next ball.
        let losing = struck(&scene(1, 0.9))?;
        let last = losing.speeds.last().map_or(0.0, |speed| speed / libm::pow(0.95, ROW as f64));
        let quantity = format!("speed of the last with restitution 0.9 per the analytic, {place}");
        findings.push(Finding::between(
            quantity,
            "1",
            last,
            1.0 - FEW_PER_CENT,
            1.0 + FEW_PER_CENT,
        ));
        books.push(losing);

        // From light to heavy and back.
        let mut mixed = scene(1, 1.0);
        for (body, factor) in mixed.bodies.iter_mut().rev().zip([1.0, 8.0, 1.0, 0.2, 3.0, 1.0]) {
            body.density *= factor;
        }
        let mixed = struck(&mixed)?;
        let approach = largest(mixed.speeds.windows(2).map(|pair| pair[0] - pair[1]));
        let quantity =
            format!("largest speed at which balls of other masses still approach, {place}");
        findings.push(Finding::at_most(quantity, "1", approach, FEW_PER_CENT));
        books.push(mixed);

        let change = largest(books.iter().map(|struck| struck.momentum.abs()));
        findings.push(Finding::at_most(
            format!("largest change of the momentum, {place}"),
            "1",
            change,
            1e-9,
        ));
        let gain = largest(books.iter().map(|struck| struck.energy));
        findings.push(Finding::at_most(
            format!("largest gain of energy, {place}"),
            "1",
            gain,
            1e-9,
        ));
    }
    Ok(findings)
}

/// Numbers of balls, gap between balls [m], and striker speeds [m/s].
const ROWS_OF: [(&[usize], f64, &[f64]); 3] = [
    (&[10, 34, 100, 500], 0.0, &[1.0, 10.0, 60.0, 100.0, 300.0]),
    (&[10, 50], 1e-3, &[1.0, 10.0, 100.0]),
    (&[10, 20], 1.0, &[10.0, 100.0]),
];

/// Maximum gain or loss of a row, relative to its input.
const ROUNDING: f64 = 1e-5;

fn rows() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (counts, gap, speeds) in ROWS_OF {
        for &speed in speeds {
            let (mut lost, mut gained, mut slowest) = (0.0_f64, 0.0_f64, f64::INFINITY);
            for &count in counts {
                let mut world = World::build(&row(count, gap, speed))?;
                let came = world.energy().0;
                // All gaps, of which each has closed when its ball has come that far.
                let seconds = (gap * count as f64 + 2.0 * RADIUS) / speed;
                for _ in 0..(seconds * 30.0).ceil() as u32 + 3 {
                    step(&mut world);
                    let kept = world.energy().0 / came;
                    (lost, gained) = (lost.max(1.0 - kept), gained.max(kept - 1.0));
                }
                slowest = slowest.min(world.bodies().velocities[count - 1].linear.x / speed);
            }
            let of = format!("balls {gap} m apart at {speed} m/s");
            findings.extend([
                Finding::at_most(format!("energy lost, {of}"), "1", lost, ROUNDING),
                Finding::at_most(format!("energy gained, {of}"), "1", gained, ROUNDING),
                Finding::at_least(
                    format!("speed of the last per that of the first, {of}"),
                    "1",
                    slowest,
                    1.0 - ROUNDING,
                ),
            ]);
        }
    }
    Ok(findings)
}
