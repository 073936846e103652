//! Bodies that break again and again: no piece is so small that its numbers go bad, nothing is
//! lost, and reports are whole.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::fracture::{Bricks, Natural, Radial, Slices, Splinters, Voronoi};
use frangible::{
    BodyDesc, BreakingDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A body that falls on the ground and breaks up to three times in a row.
fn scene(
    shape: ShapeDesc,
    pattern: PatternDesc,
    (height, frames_per_second): (f64, f64),
) -> SceneDesc {
    let mut scene = SceneDesc::new("slivers");
    scene.frames_per_second = frames_per_second;
    let breaking = BreakingDesc { generations: 3, ..BreakingDesc::once(0.037, pattern) };
    let position = [0.0, height, 0.0];
    let body = BodyDesc {
        position,
        friction: 0.2,
        breaking: Some(breaking),
        ..BodyDesc::new("body", shape)
    };
    scene.bodies = vec![BodyDesc::ground(0.0), body];
    scene
}

/// Steps a scene and returns how often something broke.
fn run(scene: &SceneDesc, frames: u32, what: &str) -> usize {
    let mut world = World::build(scene).unwrap();
    let mass = world.bodies().masses[1];
    let mut breaks = 0;
    for frame in 0..frames {
        let report = step(&mut world);
        let what = format!("{what}, frame {frame}");
        assert!(report.quarantined.is_empty(), "{what}: {:?}", report.quarantined);
        assert!(
            !serde_json::to_string(&report).unwrap().contains("null"),
            "{what}: a number is missing"
        );
        assert!((report.mass / mass - 1.0).abs() < 1e-9, "{what}: {} of {mass} kg", report.mass);
        for fracture in &report.fractures {
            let imbalance = &fracture.imbalance;
            let worst = [
                imbalance.mass,
                imbalance.momentum,
                imbalance.angular_momentum,
                imbalance.kinetic_energy,
            ];
            assert!(worst.into_iter().all(|part| part < 1e-9), "{what}: {imbalance:?}");
            breaks += 1;
        }
        for (&piece, inertia) in world.bodies().masses.iter().zip(&world.bodies().inertias).skip(1)
        {
            assert!(piece > 1e-9 * mass, "{what}: {piece} of {mass} kg");
            assert!(inertia.inverse_moments.max_element() < 1e30, "{what}");
        }
    }
    breaks
}

/// A cylinder that breaks along spokes, three times in a row: each break along them used to leave
/// slivers of 1e-13 of their parent.
#[test]
fn spokes_of_spokes_leave_no_slivers() {
    let mut breaks = 0;
    for seed in 0..12 {
        let pattern = PatternDesc::Radial(Radial { seed, spokes: 6, rings: 1, jitter: 0.48 });
        let shape =
            ShapeDesc::Cylinder { radius: 0.17, height: 0.41, resolution: Resolution::default() };
        breaks += run(&scene(shape, pattern, (6.7, 15.0)), 24, &format!("seed {seed}"));
    }
    assert!(breaks > 60, "{breaks}");
}

/// Shapes and patterns by chance.
#[test]
fn random_worlds_keep_all_of_their_mass() {
    let mut random = Pcg64Mcg::seed_from_u64(22);
    let mut breaks = 0;
    for world in 0..40 {
        let size = libm::exp2(random.random_range(-5.0..1.0));
        let mut edge = || size * random.random_range(0.05..1.0);
        let resolution = Resolution::default();
        let shape = match world % 4 {
            0 => ShapeDesc::Box { size: [edge(), edge(), edge()], resolution },
            1 => ShapeDesc::Sphere { radius: edge(), resolution },
            2 => ShapeDesc::Cylinder { radius: edge(), height: edge(), resolution },
            _ => ShapeDesc::Hull {
                points: (0..8).map(|_| [edge(), edge(), edge()]).collect(),
                resolution,
            },
        };
        let (seed, cells) = (random.random(), random.random_range(2..20));
        let pattern = match world / 4 % 6 {
            0 => PatternDesc::Radial(Radial {
                seed,
                spokes: cells.max(3),
                rings: cells % 3,
                jitter: 0.9,
            }),
            1 => {
                PatternDesc::Voronoi(Voronoi { seed, cells, clustering: 2.0, ..Voronoi::default() })
            }
            2 => PatternDesc::Natural(Natural { seed, cells, ..Natural::default() }),
            3 => PatternDesc::Slices(Slices { seed, cells, jitter: 1.0, ..Slices::default() }),
            4 => {
                PatternDesc::Bricks(Bricks { seed, mortar: 0.3, jitter: 1.0, ..Bricks::default() })
            }
            _ => PatternDesc::Splinters(Splinters { seed, fibres: cells, ..Splinters::default() }),
        };
        let height = 2.0 * size + random.random_range(0.5..5.0);
        let rate = random.random_range(15.0..60.0);
        let frames = (1.2 * (height / 5.0_f64).sqrt() * rate) as u32 + 8;
        breaks += run(&scene(shape, pattern, (height, rate)), frames, &format!("world {world}"));
    }
    assert!(breaks > 100, "{breaks}");
}
