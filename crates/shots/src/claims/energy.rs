//! Nothing makes energy: random scenes, all shots, and what happens without the safeguards.

use super::random_scene::random_scene;
use super::scenes::METHODS;
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::scenes::SHOTS;
use crate::shot::{Shot, ShotOptions};
use frangible::bodies::{Rotation, StepSettings};
use frangible::{BuildError, Method, SceneDesc, World};

/// Two hundred scenes; the paper's method, which takes ten times as long, runs a quarter of them.
pub(super) const RANDOM_SCENES: Claim = Claim {
    name: "random-scenes",
    says: "no frame of 200 random scenes gains energy: convex and concave bodies, shards of 100:1, masses 1:1000, spins to 50 rad/s",
    source: "docs/adr/009",
    measure: random_scenes,
};

/// Every scene that needs no file; the paper's method runs two seconds of each.
pub(super) const ALL_SHOTS: Claim = Claim {
    name: "all-shots",
    says: "no frame of any shot gains energy, but for the largest, which have tests of their own",
    source: "Su09 sec. 3",
    measure: all_shots,
};

/// Negative controls.
pub(super) const SAFEGUARDS: Claim = Claim {
    name: "safeguards",
    says: "without the ledger, the clamp or the energy fix random scenes gain energy, and the pillar's shards fly",
    source: "Su09 sec. 2, 3, fig. 1",
    measure: safeguards,
};

/// The largest gain of a frame, in units of the energy in play: round-off.
const MOST_GAIN: f64 = 1e-9;

/// Result of a run.
pub(super) struct Run {
    /// The largest gain of a frame, in units of the energy in play: the largest kinetic energy and
    /// the range of the potential energy.
    pub(super) gain: f64,
    /// The largest part of a frame's change of energy that no cause explains, in the same units.
    pub(super) unexplained: f64,
    /// The largest relative change of linear or angular momentum.
    pub(super) momentum_error: f64,
    /// Number of quarantined bodies.
    pub(super) quarantined: usize,
    /// Largest rise of any body's centre above its start [m].
    pub(super) rise: f64,
    /// At the end.
    pub(super) world: World,
}

/// Runs a scene for `frames` with the settings changed.
pub(super) fn run_scene(
    scene: &SceneDesc,
    frames: u32,
    change: impl Fn(&mut StepSettings),
) -> Result<Run, BuildError> {
    let mut world = World::build(scene)?;
    let mut settings = *world.settings();
    change(&mut settings);
    world.set_settings(settings)?;
    let start: Vec<_> =
        world.bodies().ids.iter().copied().zip(world.bodies().poses.clone()).collect();
    let (kinetic, potential) = world.energy();
    let (mut kinetics, mut low, mut high) = (kinetic, potential, potential);
    let (mut gain, mut unexplained, mut momentum_error) = (f64::NEG_INFINITY, 0.0, 0.0);
    let (mut quarantined, mut rise) = (0, 0.0);
    for _ in 0..frames {
        let report = step(&mut world);
        kinetics = largest([kinetics, report.energy.kinetic]);
        low = -largest([-low, -report.energy.potential]);
        high = largest([high, report.energy.potential]);
        gain = largest([gain, report.energy.gain]);
        unexplained = largest([unexplained, report.energy.causes.flight.abs()]);
        momentum_error =
            largest([momentum_error, report.momentum.linear_error, report.momentum.angular_error]);
        quarantined += report.quarantined.len();
        let risen = start.iter().filter_map(|(id, pose)| {
            Some(world.bodies().poses[world.bodies().index_of(*id)?].position.y - pose.position.y)
        });
        rise = largest(risen.chain([rise]));
    }
    let scale = kinetics + high - low;
    Ok(Run {
        gain: gain / scale,
        unexplained: unexplained / scale,
        momentum_error,
        quarantined,
        rise,
        world,
    })
}

/// The findings of several runs.
fn of_runs(runs: &[Run], name: &str) -> [Finding; 4] {
    let quarantined = runs.iter().map(|run| run.quarantined as f64).sum();
    let of = |quantity: &str| format!("{quantity}, {name}");
    let worst = |value: fn(&Run) -> f64| largest(runs.iter().map(value));
    let unexplained = of("largest change of the energy in a frame that has no cause");
    [
        Finding::at_most(of("largest gain of a frame"), "1", worst(|run| run.gain), MOST_GAIN),
        Finding::at_most(unexplained, "1", worst(|run| run.unexplained), MOST_GAIN),
        Finding::at_most(of("change of momentum"), "1", worst(|run| run.momentum_error), 1e-9),
        Finding::at_most(of("bodies taken out"), "1", quarantined, 0.0),
    ]
}

fn random_scenes() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for ((method, name), count) in METHODS.into_iter().zip([200, 50]) {
        let run = |seed: u64| run_scene(&random_scene(seed, method), 60, |_| {});
        let runs: Vec<Run> = (0..count).map(run).collect::<Result<_, _>>()?;
        findings.extend(of_runs(&runs, name));
    }
    Ok(findings)
}

fn all_shots() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for ((method, name), most_frames) in METHODS.into_iter().zip([u32::MAX, 60]) {
        let mut runs = Vec::new();
        for shot in SHOTS.iter().filter(|shot| !shot.takes_mesh && !shot.is_large) {
            let scene = shot.scene(&ShotOptions { method, ..ShotOptions::default() })?;
            let run = run_scene(&scene, shot.frames.min(most_frames), |_| {})?;
            findings.push(Finding::at_most(
                format!("largest gain of a frame of {}, {name}", shot.name),
                "1",
                run.gain,
                MOST_GAIN,
            ));
            runs.push(run);
        }
        findings.extend(of_runs(&runs, name).into_iter().skip(1));
    }
    Ok(findings)
}

/// Pillars that break without safeguards.
const UNSAFE_PILLARS: u64 = 4;

fn no_ledger(settings: &mut StepSettings) {
    settings.ledger = false;
}

fn no_clamp(settings: &mut StepSettings) {
    settings.ledger = false;
    settings.impulse_clamp = false;
}

fn no_energy_fix(settings: &mut StepSettings) {
    settings.ledger = false;
    settings.rotation = Rotation::SecondOrder { energy_fix: false };
}

fn safeguards() -> Result<Vec<Finding>, Obstacle> {
    let gain = |change: fn(&mut StepSettings)| -> Result<f64, BuildError> {
        let run = |seed: u64| run_scene(&random_scene(seed, Method::Paper), 60, change);
        let runs: Vec<Run> = (0..6).map(run).collect::<Result<_, _>>()?;
        Ok(largest(runs.iter().map(|run| run.gain)))
    };
    // The ledger would catch what the others let through.
    let (ledger, clamp, fix) = (gain(no_ledger)?, gain(no_clamp)?, gain(no_energy_fix)?);
    let mut findings = vec![
        Finding::at_least(
            "largest gain without the ledger, paper's method",
            "1",
            ledger,
            1e3 * MOST_GAIN,
        ),
        Finding::at_least("the same without ledger and clamp", "1", clamp, 5.0 * ledger),
        Finding::at_least("the same without ledger and energy fix", "1", fix, 10.0 * ledger),
    ];

    // Figure 1.
    let pillar = |method: Method, seed: u64| {
        Shot::find("pillar")?.scene(&ShotOptions { method, seed, ..ShotOptions::default() })
    };
    for (method, name) in METHODS {
        let run = run_scene(&pillar(method, 0)?, 60, |_| {})?;
        findings.push(Finding::at_most(
            format!("rise of a shard of the pillar, {name}"),
            "m",
            run.rise,
            0.1,
        ));
    }
    // Not every pillar has a shard that is thin enough.
    let runs: Vec<Run> = (0..UNSAFE_PILLARS)
        .map(|seed| Ok(run_scene(&pillar(Method::PaperUncorrected, seed)?, 60, |_| {})?))
        .collect::<Result<_, Obstacle>>()?;
    let quantity = "rise of a shard of some pillars without any of them, paper's method";
    findings.push(Finding::at_least(quantity, "m", largest(runs.iter().map(|run| run.rise)), 1.0));
    let gain = largest(runs.iter().map(|run| run.gain));
    findings.push(Finding::at_least("largest gain of a frame then", "1", gain, 1e3 * MOST_GAIN));
    Ok(findings)
}
