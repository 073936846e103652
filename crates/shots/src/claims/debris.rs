//! Heavy bodies fall on light bodies.

use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::debris::{Debris, Piece};
use frangible::World;

/// At all ratios and speeds.
pub(super) const DEBRIS: Claim = Claim {
    name: "debris",
    says: "what a slab of 3 to 1000 times their mass presses down at 0.3 to 10 m/s does not stay in the ground or in the slab",
    source: "mechanics",
    measure: measured,
};

/// Shapes, sizes [m], and counts.
const PIECES: [(Piece, f64, usize); 7] = [
    (Piece::Cube, 0.2, 1),
    (Piece::Cube, 0.1, 1),
    (Piece::Ball, 0.2, 1),
    (Piece::Cube, 0.2, 4),
    (Piece::Cube, 0.1, 4),
    (Piece::Ball, 0.2, 4),
    (Piece::Hull, 0.2, 4),
];

/// Mass of the slab in units of all pieces', and the largest overlap that it may make, in units of
/// a piece's size.
const RATIOS: [(&str, &[f64], f64); 2] = [
    ("3 to 100", &[3.0, 10.0, 30.0, 100.0], 0.2),
    ("300 and 1000", &[300.0, 1000.0], f64::INFINITY),
];

/// Of the slab [m/s].
const SPEEDS: [f64; 4] = [0.3, 1.0, 3.0, 10.0];

/// Settling time [frames].
const FRAMES: u32 = 90;

/// Maximum remaining overlap [m].
const MOST_LEFT: f64 = 1e-3;

/// The largest and the last overlap [m].
fn overlaps(debris: Debris) -> Result<[f64; 2], Obstacle> {
    let mut world = World::build(&debris.scene())?;
    let (mut most, mut last) = (0.0, 0.0);
    for _ in 0..FRAMES {
        step(&mut world);
        last = largest(world.penetrations().into_iter().chain([0.0]));
        most = largest([most, last]);
    }
    Ok([most, last])
}

fn measured() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (piece, size, count) in PIECES {
        for (name, ratios, most_pressed) in RATIOS {
            let (mut pressed, mut left) = (0.0, 0.0);
            for (&ratio, speed) in ratios.iter().flat_map(|ratio| SPEEDS.map(|v| (ratio, v))) {
                let [most, last] = overlaps(Debris { piece, size, count, ratio, speed })?;
                (pressed, left) = (largest([pressed, most / size]), largest([left, last]));
            }
            let of = format!("{count} of {piece:?}, {size} m, ratio {name}").to_lowercase();
            findings.push(Finding::at_most(
                format!("largest overlap per size, {of}"),
                "1",
                pressed,
                most_pressed,
            ));
            findings.push(Finding::at_most(format!("last overlap, {of}"), "m", left, MOST_LEFT));
        }
    }
    Ok(findings)
}
