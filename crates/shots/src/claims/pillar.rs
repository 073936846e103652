//! Spread of the pillar at the frame rate, and at a hundredth of its step [Su09 fig. 1].

use super::energy::run_scene;
use crate::claims::claim::largest;
use crate::claims::claim::{Claim, Finding, Obstacle};
use crate::scenes::pillar::HALF;
use crate::shot::{Shot, ShotOptions};
use frangible::Method;

/// Figure 1.
pub(super) const SPREAD: Claim = Claim {
    name: "pillar-spread",
    says: "after 4 s the pillar lies at 30 steps per second as it does at 3000, averaged over ten of its cuts",
    source: "Su09 fig. 1",
    measure: spread,
};

/// Figure 1, centre.
pub(super) const UNCORRECTED: Claim = Claim {
    name: "pillar-uncorrected",
    says: "at 30 steps per second of the paper's method, without its safeguards and the ledger, the pillar's shards fly",
    source: "Su09 fig. 1",
    measure: uncorrected,
};

/// Distribution of a pillar's pieces after four seconds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spread {
    /// Mean distance of the pieces' centres from the pillar's axis [m].
    pub mean: f64,
    /// 95th percentile of these distances [m].
    pub p95: f64,
    /// Height of the highest centre [m].
    pub highest: f64,
    /// Largest rise of any centre above its start, at any time [m].
    pub rise: f64,
}

/// Seconds.
const TIME: f64 = 4.0;

/// Cuts of the pillar.
const SEEDS: u64 = 10;

/// Runs the pillar of `options` for four seconds.
///
/// # Errors
/// If its scene cannot be built.
pub fn pillar_spread(options: &ShotOptions) -> Result<Spread, Obstacle> {
    let scene = Shot::find("pillar")?.scene(options)?;
    let frames = (TIME * options.frames_per_second).round() as u32;
    let run = run_scene(&scene, frames, |_| {})?;

    // The ground is the first body.
    let centers = run.world.bodies().poses.iter().skip(1).map(|pose| pose.position);
    let mut distances: Vec<f64> =
        centers.clone().map(|center| center.with_y(0.0).length()).collect();
    distances.sort_by(f64::total_cmp);
    let count = distances.len();
    Ok(Spread {
        mean: distances.iter().sum::<f64>() / count as f64,
        p95: distances.get(count * 95 / 100).copied().unwrap_or(f64::NAN),
        highest: largest(centers.map(|center| center.y)),
        rise: run.rise,
    })
}

/// Means over some pillars.
fn mean(spreads: &[Spread]) -> Spread {
    let of =
        |value: fn(&Spread) -> f64| spreads.iter().map(value).sum::<f64>() / spreads.len() as f64;
    Spread {
        mean: of(|s| s.mean),
        p95: of(|s| s.p95),
        highest: of(|s| s.highest),
        rise: of(|s| s.rise),
    }
}

/// The means over all cuts of the pillar.
fn over_seeds(method: Method, frames_per_second: f64) -> Result<Spread, Obstacle> {
    let run = |seed: u64| {
        let options = ShotOptions { seed, method, frames_per_second, ..ShotOptions::default() };
        pillar_spread(&options)
    };
    let spreads: Vec<Spread> = (0..SEEDS).map(run).collect::<Result<_, _>>()?;
    Ok(mean(&spreads))
}

/// The numbers of some runs, without bounds.
fn beside(name: &str, spread: &Spread) -> [Finding; 4] {
    [
        Finding::beside(format!("mean distance, {name}"), "m", spread.mean),
        Finding::beside(format!("95th percentile, {name}"), "m", spread.p95),
        Finding::beside(format!("highest piece, {name}"), "m", spread.highest),
        Finding::beside(format!("rise of a piece, {name}"), "m", spread.rise),
    ]
}

fn spread() -> Result<Vec<Finding>, Obstacle> {
    let frame_rate = over_seeds(Method::FrameRate, 30.0)?;
    let fine = over_seeds(Method::FrameRate, 3000.0)?;
    let mut findings = vec![
        Finding::between(
            "mean distance per that at 3000 steps per second",
            "1",
            frame_rate.mean / fine.mean,
            0.85,
            1.15,
        ),
        Finding::between(
            "95th percentile per that at 3000",
            "1",
            frame_rate.p95 / fine.p95,
            0.85,
            1.15,
        ),
        Finding::between(
            "highest piece less that at 3000, per the pillar's height",
            "1",
            (frame_rate.highest - fine.highest) / (2.0 * HALF.y),
            -0.1,
            0.1,
        ),
        Finding::at_most("rise of a piece", "m", frame_rate.rise, 0.1),
    ];
    findings.extend(beside("30 steps per second", &frame_rate));
    findings.extend(beside("3000 steps per second", &fine));
    Ok(findings)
}

fn uncorrected() -> Result<Vec<Finding>, Obstacle> {
    let uncorrected = over_seeds(Method::PaperUncorrected, 30.0)?;
    let rise = "rise of a piece, mean over the cuts";
    let mut findings = vec![Finding::at_least(rise, "m", uncorrected.rise, 2.0 * HALF.y)];
    findings.extend(beside("uncorrected", &uncorrected));
    Ok(findings)
}
