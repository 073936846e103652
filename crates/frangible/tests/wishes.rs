//! What an artist sets of a break: where its pattern lies, and where the body is weak.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::{Natural, Slices};
use frangible::{
    AnchorDesc, BodyDesc, BondsDesc, BreakingDesc, Method, PartDesc, PatternDesc, Resolution,
    SceneDesc, ShapeDesc, StrengthPointDesc, World, step,
};
use glam::DVec3;

const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };

/// A slab in space that a ball strikes at a place.
fn scene(breaking: BreakingDesc, at: [f64; 2]) -> SceneDesc {
    let mut scene = SceneDesc::new("space");
    scene.gravity = [0.0; 3];
    let slab = BodyDesc {
        breaking: Some(breaking),
        ..BodyDesc::new("slab", ShapeDesc::Box { size: [2.0, 2.0, 0.2], resolution: NONE })
    };
    let ball = BodyDesc {
        position: [at[0], at[1], 0.5],
        linear_velocity: [0.0, 0.0, -30.0],
        density: 7800.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.1, resolution: NONE })
    };
    scene.bodies = vec![slab, ball];
    scene
}

/// Places of what a slab is in after a few frames, seen from the slab before the blow.
fn pieces(breaking: BreakingDesc, at: [f64; 2]) -> Vec<(DVec3, f64)> {
    let mut world = World::build(&scene(breaking, at)).unwrap();
    let broken = (0..3).any(|_| !step(&mut world).fractures.is_empty());
    let bodies = world.bodies();
    let is_piece = |&i: &usize| world.labels()[i].name != "ball" && broken;
    (0..bodies.len())
        .filter(is_piece)
        .map(|i| (bodies.poses[i].position, bodies.masses[i]))
        .collect()
}

fn natural(clustering: f64) -> PatternDesc {
    PatternDesc::Natural(Natural { cells: 200, clustering, ..Natural::default() })
}

/// Small pieces gather where a clustered pattern has its centre: at the blow, or at a point of the
/// body, wherever the blow is.
#[test]
fn pieces_are_finer_at_the_blow_or_at_a_point() {
    let mean_near = |pieces: &[(DVec3, f64)], at: DVec3| {
        let near: Vec<f64> =
            pieces.iter().filter(|(place, _)| place.distance(at) < 0.5).map(|one| one.1).collect();
        near.iter().sum::<f64>() / near.len().max(1) as f64
    };
    let here = DVec3::new(0.6, 0.5, 0.0);
    let there = -here;
    let once = |clustering: f64| BreakingDesc::once(1.0, natural(clustering));
    let even = pieces(once(0.0), [here.x, here.y]);
    let fine = pieces(once(4.0), [here.x, here.y]);
    assert!(mean_near(&fine, here) < 0.3 * mean_near(&even, here));
    assert!(mean_near(&fine, here) < 0.5 * mean_near(&fine, there));
    let point = Some(there.to_array());
    let away = pieces(BreakingDesc { point, ..once(4.0) }, [here.x, here.y]);
    assert!(mean_near(&away, there) < 0.5 * mean_near(&away, here));
}

/// Slices lie across x; a quarter of a turn about the blow lays them across y.
#[test]
fn a_twist_turns_the_pattern() {
    let spread = |twist: f64| {
        let slices = PatternDesc::Slices(Slices { cells: 9, ..Slices::default() });
        let made = pieces(BreakingDesc { twist, ..BreakingDesc::once(1.0, slices) }, [0.0, 0.0]);
        assert!(made.len() > 3);
        let along = |axis: usize| made.iter().map(|one| one.0[axis].abs()).fold(0.0, f64::max);
        [along(0), along(1)]
    };
    let ([x, y], [turned_x, turned_y]) = (spread(0.0), spread(0.5 * std::f64::consts::PI));
    let (along, across) =
        if x > y { ([x, turned_y], [y, turned_x]) } else { ([y, turned_x], [x, turned_y]) };
    assert!(along.iter().all(|&far| far > 0.4), "{along:?}");
    assert!(across.iter().all(|&far| far < 0.1), "{across:?}");
}

/// The same blow breaks a body where it is weak, and not where it is strong; what it bears there is
/// what it is said to.
#[test]
fn strength_is_that_of_the_place() {
    let at = |x: f64, factor: f64| StrengthPointDesc { point: [x, 0.0, 0.1], factor };
    let breaking = || BreakingDesc {
        strength_points: vec![at(-0.8, 0.1), at(0.8, 10.0)],
        ..BreakingDesc::once(200.0, natural(0.0))
    };
    assert!(pieces(breaking(), [0.8, 0.0]).is_empty());
    assert!(pieces(breaking(), [-0.8, 0.0]).len() > 10);
    let mut world = World::build(&scene(breaking(), [-0.8, 0.0])).unwrap();
    let fracture = (0..3).find_map(|_| step(&mut world).fractures.first().cloned()).unwrap();
    // The ball touches within rounding of the point.
    assert!((fracture.borne - 20.0).abs() < 0.5, "{}", fracture.borne);

    // Fragments have the strengths of their places.
    let twice = BreakingDesc { generations: 2, ..breaking() };
    let mut world = World::build(&scene(twice, [-0.8, 0.0])).unwrap();
    (0..3).for_each(|_| drop(step(&mut world)));
    assert!(world.labels().iter().any(|label| {
        label.breaking.as_ref().is_some_and(|breaking| breaking.strength_points.is_some())
    }));
}

/// A glued row of cubes that hangs from its top breaks where it is weak, not where it bears most.
#[test]
fn bonds_break_where_they_are_weak() {
    let part = |n: usize| PartDesc::Box {
        size: [0.2; 3],
        position: [0.0, 0.2 * n as f64, 0.0],
        orientation: [0.0, 0.0, 0.0, 1.0],
    };
    let lowest_that_hangs = |strength_points: Vec<StrengthPointDesc>| {
        let mut scene = SceneDesc::new("row");
        let shape = ShapeDesc::Compound { parts: (0..10).map(part).collect(), resolution: NONE };
        let bonds = BondsDesc {
            pattern: None,
            point: None,
            normal: [0.0, 1.0, 0.0],
            // The upper end bears 18 kPa.
            tensile_strength: 25e3,
            shear_strength: 25e3,
            anchors: vec![AnchorDesc { low: [-0.1, 1.7, -0.1], high: [0.1, 1.9, 0.1] }],
            strength_points,
            strength_triangles: Vec::new(),
        };
        let row = BodyDesc { bonds: Some(bonds), density: 1000.0, ..BodyDesc::new("row", shape) };
        scene.bodies = vec![row];
        let mut world = World::build(&scene).unwrap();
        (0..3).for_each(|_| drop(step(&mut world)));
        let bodies = world.bodies();
        let anchored = (0..bodies.len()).find(|&i| bodies.inertias[i].is_infinite()).unwrap();
        bodies.poses[anchored].position.y + bodies.shapes[anchored].bounds.0.min_element()
    };
    let at = |y: f64, factor: f64| StrengthPointDesc { point: [0.0, y, 0.0], factor };
    assert!(lowest_that_hangs(Vec::new()) < 0.0);
    // Weak between the fourth cube and the fifth.
    let weak = lowest_that_hangs(vec![at(0.5, 1.0), at(0.7, 0.2), at(0.9, 1.0)]);
    assert!((weak - 0.7).abs() < 1e-6, "{weak}");
}

#[test]
fn sentences() {
    let sentence = |breaking: BreakingDesc, method: Method| {
        let scene = SceneDesc { method, ..scene(breaking, [0.0; 2]) };
        World::build(&scene).unwrap_err().to_string()
    };
    let points = vec![StrengthPointDesc { point: [0.0; 3], factor: -1.0 }];
    let weak = BreakingDesc { strength_points: points, ..BreakingDesc::once(1.0, natural(0.0)) };
    let said = sentence(weak.clone(), Method::FrameRate);
    assert!(said.contains("strength_points[0].factor: -1.0, must be "), "{said}");
    let points = vec![StrengthPointDesc { point: [0.0; 3], factor: 1.0 }];
    let said = sentence(BreakingDesc { strength_points: points, ..weak }, Method::Paper);
    assert!(said.contains("must be left out, with the paper's method"), "{said}");
    let said = sentence(BreakingDesc::once(1.0, natural(31.0)), Method::FrameRate);
    assert!(said.contains("pattern.clustering: 31, must be from 0 to 30"), "{said}");
}
