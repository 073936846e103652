//! Nothing makes energy: random scenes, and what happens without the safeguards.

use super::scenes::{METHODS, ball, cuboid};
use super::{Claim, Finding, Obstacle};
use frangible::dynamics::{Rotation, StepSettings};
use frangible::{BodyDesc, BuildError, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Two hundred scenes.
pub(super) const RANDOM_SCENES: Claim = Claim {
    name: "random-scenes",
    says: "no frame of 200 random scenes gains energy",
    source: "docs/adr/009",
    measure: random_scenes,
};

/// Negative controls.
pub(super) const SAFEGUARDS: Claim = Claim {
    name: "safeguards",
    says: "without the ledger, the clamp or the energy fix the same scenes gain energy",
    source: "Su09 sec. 2, 3",
    measure: safeguards,
};

/// The largest gain of a frame, in units of the energy in play: round-off.
pub(super) const MOST_GAIN: f64 = 1e-9;

/// Of each random scene: two seconds.
const FRAMES: u32 = 60;

/// Largest gain of any frame, of any of several runs, relative to the energy in play.
struct Gain {
    largest: f64,
    momentum_error: f64,
    quarantined: usize,
}

/// Runs a scene for `frames` with the settings changed. The energy in play is the largest kinetic energy and the range of the
/// potential energy.
fn gain_of(scene: &SceneDesc, frames: u32, change: impl Fn(&mut StepSettings)) -> Result<Gain, BuildError> {
    let mut world = World::build(scene)?;
    change(world.settings_mut());
    let (kinetic, potential) = world.energy();
    let (mut largest, mut low, mut high) = (kinetic, potential, potential);
    let mut gain = Gain { largest: f64::NEG_INFINITY, momentum_error: 0.0, quarantined: 0 };
    for _ in 0..frames {
        let report = step(&mut world);
        largest = largest.max(report.energy.kinetic);
        low = low.min(report.energy.potential);
        high = high.max(report.energy.potential);
        gain.largest = gain.largest.max(report.energy.gain);
        let error = report.momentum.linear_error.max(report.momentum.angular_error);
        gain.momentum_error = gain.momentum_error.max(error);
        gain.quarantined += report.quarantined.len();
    }
    gain.largest /= largest + high - low;
    Ok(gain)
}

fn random_scenes() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    for (method, name) in METHODS {
        let (mut largest, mut momentum, mut quarantined) = (f64::NEG_INFINITY, 0.0_f64, 0);
        for seed in 0..200 {
            let gain = gain_of(&random_scene(seed, method), FRAMES, |_| {})?;
            largest = largest.max(gain.largest);
            momentum = momentum.max(gain.momentum_error);
            quarantined += gain.quarantined;
        }
        findings.push(Finding::at_most(format!("largest gain of a frame, {name}"), "1", largest, MOST_GAIN));
        findings.push(Finding::at_most(format!("largest change of momentum, {name}"), "1", momentum, 1e-9));
        findings.push(Finding::at_most(format!("bodies taken out, {name}"), "1", quarantined as f64, 0.0));
    }
    Ok(findings)
}

fn safeguards() -> Result<Vec<Finding>, Obstacle> {
    let worst = |change: fn(&mut StepSettings)| -> Result<f64, BuildError> {
        (0..6).try_fold(f64::NEG_INFINITY, |worst, seed| {
            Ok(gain_of(&random_scene(seed, Method::Paper), FRAMES, change)?.largest.max(worst))
        })
    };
    let no_ledger = worst(|settings| settings.ledger = false)?;
    let no_clamp = worst(|settings| (settings.ledger, settings.impulse_clamp) = (false, false))?;
    let no_fix = worst(|settings| {
        settings.ledger = false;
        settings.rotation = Rotation::SecondOrder { energy_fix: false };
    })?;
    Ok(vec![
        Finding::between("largest gain without the ledger", "1", no_ledger, 1e-6, 5e-3),
        Finding::at_least("largest gain without ledger and clamp", "1", no_clamp, 5.0 * no_ledger),
        Finding::at_least("largest gain without ledger and energy fix", "1", no_fix, 10.0 * no_ledger),
    ])
}

/// Bodies of all proportions thrown at each other, at the ground and at a moving kinematic one.
fn random_scene(seed: u64, method: Method) -> SceneDesc {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut scene = SceneDesc { method, ..SceneDesc::new("random") };
    scene.bodies.push(BodyDesc { friction: 1.5, ..BodyDesc::ground(0.0) });
    scene.bodies.push(BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, 0.3, 0.0],
        linear_velocity: [between(-1.0, 1.0), between(0.0, 1.0), between(-1.0, 1.0)],
        angular_velocity: [between(-0.3, 0.3), between(-2.0, 2.0), between(-0.3, 0.3)],
        friction: 1.5,
        restitution: 1.0,
        ..BodyDesc::new("plate", cuboid([4.0, 0.2, 4.0]))
    });
    for number in 0..10 {
        // From cubes to shards of 100:1, and balls.
        let thin = libm::pow(10.0, between(-2.0, 0.0));
        let length = between(0.3, 1.0);
        let shape = if number % 4 == 3 {
            ball(0.3 * length)
        } else {
            let size = [length, length * thin, length * between(thin, 1.0)];
            let resolution = Resolution { voxels: None, sample_spacing: Some(0.15 * length) };
            ShapeDesc::Box { size, resolution }
        };
        scene.bodies.push(BodyDesc {
            position: [between(-1.0, 1.0), 1.0 + 0.6 * f64::from(number), between(-1.0, 1.0)],
            orientation: [between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0), 0.3],
            linear_velocity: [between(-3.0, 3.0), between(-6.0, 3.0), between(-3.0, 3.0)],
            angular_velocity: [between(-30.0, 30.0), between(-30.0, 30.0), between(-30.0, 30.0)],
            density: libm::pow(10.0, between(2.0, 4.5)),
            friction: between(0.0, 1.5),
            restitution: between(0.0, 1.0),
            ..BodyDesc::new("body", shape)
        });
    }
    scene
}
