//! How the pillar spreads at the frame rate, and at a hundredth of its step [Su09 fig. 1].

use super::energy::{no_safeguard, run_scene};
use super::{Claim, Finding, Obstacle};
use crate::pillar::HALF;
use crate::{Shot, ShotOptions};
use frangible::Method;

/// Figure 1.
pub(super) const SPREAD: Claim = Claim {
    name: "pillar-spread",
    says: "after 4 s the pillar lies at 30 steps per second as it does at 3000, averaged over ten of its cuts",
    source: "Su09 fig. 1",
    measure: spread,
};

/// How the pieces of a pillar lie after four seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean distance of the pieces' centres from the pillar's axis [m].
    pub mean: f64,
    /// What 95 % of these distances are below [m].
    pub p95: f64,
    /// Height of the highest centre [m].
    pub highest: f64,
    /// How far any centre rose above where it was at first, at any time [m].
    pub rise: f64,
}

/// Seconds.
const TIME: f64 = 4.0;

/// Cuts of the pillar.
const SEEDS: u64 = 10;

/// Runs the pillar of `options` for four seconds, with or without ledger, clamp and energy fix.
///
/// # Errors
/// If its scene cannot be built.
pub fn pillar_spread(options: &ShotOptions, safeguards: bool) -> Result<Spread, Obstacle> {
    let scene = Shot::find("pillar")?.scene(options)?;
    let frames = (TIME * options.frames_per_second).round() as u32;
    let run =
        if safeguards { run_scene(&scene, frames, |_| {}) } else { run_scene(&scene, frames, no_safeguard) }?;

    // The ground is the first body.
    let centers = run.world.bodies().poses.iter().skip(1).map(|pose| pose.position);
    let mut distances: Vec<f64> = centers.clone().map(|center| center.with_y(0.0).length()).collect();
    distances.sort_by(f64::total_cmp);
    let count = distances.len();
    Ok(Spread {
        mean: distances.iter().sum::<f64>() / count as f64,
        p95: distances.get(count * 95 / 100).copied().unwrap_or(f64::NAN),
        highest: super::largest(centers.map(|center| center.y)),
        rise: run.rise,
    })
}

/// Means over some pillars.
fn mean(spreads: &[Spread]) -> Spread {
    let of = |value: fn(&Spread) -> f64| spreads.iter().map(value).sum::<f64>() / spreads.len() as f64;
    Spread { mean: of(|s| s.mean), p95: of(|s| s.p95), highest: of(|s| s.highest), rise: of(|s| s.rise) }
}

/// The means over the rows of `data/pillar.csv` that begin so: method, rate and safeguards. The program
/// `examples/pillar_spread.rs` wrote it: the runs take an hour.
fn recorded(beginning: &str) -> Spread {
    let rows = include_str!("../../data/pillar.csv").lines().filter_map(|row| row.strip_prefix(beginning));
    let spreads: Vec<Spread> = rows
        .filter_map(|row| {
            let values: Vec<f64> = row.split(',').filter_map(|value| value.parse().ok()).collect();
            let &[_, mean, p95, highest, rise] = values.as_slice() else { return None };
            Some(Spread { mean, p95, highest, rise })
        })
        .collect();
    mean(&spreads)
}

fn spread() -> Result<Vec<Finding>, Obstacle> {
    let run = |seed: u64| {
        pillar_spread(&ShotOptions { seed, method: Method::FrameRate, ..ShotOptions::default() }, true)
    };
    let spreads: Vec<Spread> = (0..SEEDS).map(run).collect::<Result<_, _>>()?;
    let (frame_rate, fine) = (mean(&spreads), recorded("frame-rate,3000,on,"));
    let mut findings = vec![
        Finding::between(
            "mean distance per that at 3000 steps per second",
            "1",
            frame_rate.mean / fine.mean,
            0.85,
            1.15,
        ),
        Finding::between("95th percentile per that at 3000", "1", frame_rate.p95 / fine.p95, 0.85, 1.15),
        Finding::between(
            "highest piece less that at 3000, per the pillar's height",
            "1",
            (frame_rate.highest - fine.highest) / (2.0 * HALF.y),
            -0.1,
            0.1,
        ),
        Finding::at_most("rise of a piece", "m", frame_rate.rise, 0.1),
    ];
    let others = [
        ("frame-rate method at 30", frame_rate),
        ("frame-rate method at 3000, recorded", fine),
        ("paper's method at 30, recorded", recorded("paper,30,on,")),
        ("paper's method at 30 without ledger, clamp and energy fix, recorded", recorded("paper,30,off,")),
    ];
    for (name, spread) in others {
        findings.push(Finding::beside(format!("mean distance, {name}"), "m", spread.mean));
        findings.push(Finding::beside(format!("95th percentile, {name}"), "m", spread.p95));
        findings.push(Finding::beside(format!("highest piece, {name}"), "m", spread.highest));
        findings.push(Finding::beside(format!("rise of a piece, {name}"), "m", spread.rise));
    }
    Ok(findings)
}
