//! Nothing makes energy: random scenes, and what happens without the safeguards.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::dynamics::Rotation;
use frangible::{BodyDesc, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// Bodies of all proportions thrown at each other, at the ground and at a moving kinematic one.
fn random_scene(seed: u64, method: Method) -> SceneDesc {
    let mut random = Pcg64Mcg::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| low + (high - low) * random.random::<f64>();
    let mut scene = SceneDesc::new("random");
    scene.method = method;
    scene.bodies.push(BodyDesc { friction: 1.5, ..BodyDesc::ground(0.0) });
    let plate = ShapeDesc::Box { size: [4.0, 0.2, 4.0], resolution: Resolution::default() };
    scene.bodies.push(BodyDesc {
        motion: MotionDesc::Kinematic,
        position: [0.0, 0.3, 0.0],
        linear_velocity: [between(-1.0, 1.0), between(0.0, 1.0), between(-1.0, 1.0)],
        angular_velocity: [between(-0.3, 0.3), between(-2.0, 2.0), between(-0.3, 0.3)],
        friction: 1.5,
        restitution: 1.0,
        ..BodyDesc::new("plate", plate)
    });
    for number in 0..10 {
        // From cubes to shards of 100:1, and balls.
        let thin = 10_f64.powf(between(-2.0, 0.0));
        let length = between(0.3, 1.0);
        let shape = if number % 4 == 3 {
            ShapeDesc::Sphere { radius: 0.3 * length, resolution: Resolution::default() }
        } else {
            let size = [length, length * thin, length * between(thin, 1.0)];
            ShapeDesc::Box {
                size,
                resolution: Resolution { voxels: None, sample_spacing: Some(0.15 * length) },
            }
        };
        scene.bodies.push(BodyDesc {
            position: [between(-1.0, 1.0), 1.0 + 0.6 * f64::from(number), between(-1.0, 1.0)],
            orientation: [between(-1.0, 1.0), between(-1.0, 1.0), between(-1.0, 1.0), 0.3],
            linear_velocity: [between(-3.0, 3.0), between(-6.0, 3.0), between(-3.0, 3.0)],
            angular_velocity: [between(-30.0, 30.0), between(-30.0, 30.0), between(-30.0, 30.0)],
            density: 10_f64.powf(between(2.0, 4.5)),
            friction: between(0.0, 1.5),
            restitution: between(0.0, 1.0),
            ..BodyDesc::new("body", shape)
        });
    }
    scene
}

/// Largest gain of any frame, relative to the energy in play, and the share of islands that had to be scaled.
fn worst_gain(
    scene: &SceneDesc,
    frames: u32,
    change: impl Fn(&mut frangible::dynamics::StepSettings),
) -> f64 {
    let mut world = World::build(scene).unwrap();
    change(world.settings_mut());
    let (kinetic, potential) = world.energy();
    let (mut largest, mut low, mut high, mut gain) = (kinetic, potential, potential, f64::NEG_INFINITY);
    for _ in 0..frames {
        let report = step(&mut world);
        assert!(report.quarantined.is_empty());
        largest = largest.max(report.energy.kinetic);
        low = low.min(report.energy.potential);
        high = high.max(report.energy.potential);
        gain = gain.max(report.energy.gain);
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
    }
    gain / (largest + high - low)
}

#[test]
fn no_frame_of_any_random_scene_gains_energy() {
    for method in [Method::Paper, Method::FrameRate] {
        for seed in 0..200 {
            let gain = worst_gain(&random_scene(seed, method), 60, |_| {});
            assert!(gain < 1e-9, "{method:?}, seed {seed}: {gain}");
        }
    }
}

/// Each safeguard off makes energy in these scenes: so they have something to do.
#[test]
fn without_the_safeguards_energy_is_made() {
    let worst = |change: fn(&mut frangible::dynamics::StepSettings)| {
        (0..6)
            .map(|seed| worst_gain(&random_scene(seed, Method::Paper), 60, change))
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let no_ledger = worst(|settings| settings.ledger = false);
    let no_clamp = worst(|settings| (settings.ledger, settings.impulse_clamp) = (false, false));
    let no_fix = worst(|settings| {
        settings.ledger = false;
        settings.rotation = Rotation::SecondOrder { energy_fix: false };
    });
    assert!(no_ledger > 1e-6 && no_ledger < 5e-3, "without the ledger: {no_ledger}");
    assert!(no_clamp > 5.0 * no_ledger, "without the clamp: {no_clamp}, with it {no_ledger}");
    assert!(no_fix > 10.0 * no_ledger, "without the energy fix: {no_fix}, with it {no_ledger}");
}
