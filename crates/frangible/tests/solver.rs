//! Solver settings of a scene.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::bodies::StepSettings;
use frangible::{
    BodyDesc, Method, Quality, Resolution, SceneDesc, ShapeDesc, SolverDesc, World, step,
};

/// A cube on the ground.
fn resting(solver: SolverDesc) -> SceneDesc {
    let shape = ShapeDesc::Box { size: [1.0; 3], resolution: Resolution::default() };
    let cube = BodyDesc { position: [0.0, 0.5, 0.0], ..BodyDesc::new("cube", shape) };
    let bodies = vec![BodyDesc::ground(0.0), cube];
    SceneDesc { solver, bodies, ..SceneDesc::new("resting") }
}

/// Sinking depth [m].
fn sinks(solver: SolverDesc) -> f64 {
    let mut world = World::build(&resting(solver)).unwrap();
    for _ in 0..60 {
        step(&mut world);
    }
    0.5 - world.bodies().poses[1].position.y
}

/// Each quality yields about a quarter of the one before, where nothing asks for more substeps.
#[test]
fn quality_is_stiffness() {
    let depths = [Quality::Draft, Quality::Game, Quality::Default, Quality::Film]
        .map(|quality| sinks(SolverDesc { quality, ..SolverDesc::default() }));
    assert!(depths[0] < 2e-3 && depths[3] > 0.0, "{depths:?}");
    assert!(depths.is_sorted_by(|a, b| *b < 0.5 * a), "{depths:?}");
}

/// An island with fewer substeps than needed is reported.
#[test]
fn what_is_short_of_substeps_is_reported() {
    let short = |most_substeps: u32| {
        let mut scene = resting(SolverDesc { most_substeps, ..SolverDesc::default() });
        let load = BodyDesc { position: [0.0, 1.5, 0.0], density: 1e5, ..scene.bodies[1].clone() };
        scene.bodies.push(load);
        step(&mut World::build(&scene).unwrap()).short_of_substeps
    };
    assert_eq!([short(8), short(128)], [1, 0]);
}

/// No settings can be set with which a frame would not end.
#[test]
fn settings_that_hang_are_refused() {
    let mut world = World::build(&resting(SolverDesc::default())).unwrap();
    let known = *world.settings();
    for settings in [
        StepSettings { substeps: 0, ..known },
        StepSettings { substeps: 12, ..known },
        StepSettings { most_substeps: 4, ..known },
        StepSettings { substeps: 1 << 31, most_substeps: 1 << 31, ..known },
        StepSettings { breaking_passes: u32::MAX, ..known },
        StepSettings { recovery_speed: f64::NAN, ..known },
        StepSettings { bank_cap: f64::INFINITY, ..known },
    ] {
        let error = world.set_settings(settings).unwrap_err().to_string();
        assert!(error.starts_with("settings: "), "{error}");
        assert_eq!(*world.settings(), known);
    }
    world.set_settings(StepSettings { substeps: 4, ..known }).unwrap();
    step(&mut world);
}

#[test]
fn what_cannot_be_is_refused() {
    let refusal = |scene: SceneDesc| World::build(&scene).unwrap_err().to_string();
    let solver = SolverDesc { most_substeps: 100, ..SolverDesc::default() };
    assert!(
        refusal(resting(solver)).contains("solver.most_substeps"),
        "{}",
        refusal(resting(solver))
    );
    let solver = SolverDesc { quality: Quality::Film, most_substeps: 8, ..SolverDesc::default() };
    assert!(refusal(resting(solver)).contains("from 16"), "{}", refusal(resting(solver)));
    let solver = SolverDesc { recovery_speed: 0.0, ..SolverDesc::default() };
    assert!(refusal(resting(solver)).contains("solver.recovery_speed"));
    let solver = SolverDesc { quality: Quality::Film, ..SolverDesc::default() };
    let scene = SceneDesc { method: Method::Paper, ..resting(solver) };
    assert!(refusal(scene).starts_with("solver"));
}
