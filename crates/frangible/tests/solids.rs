//! Meshes that break into pieces of their own surface.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::f64::consts::TAU;

type Mesh = (Vec<[f64; 3]>, Vec<[u32; 3]>);

/// A ring around the y axis.
fn torus(around: u32, across: u32) -> Mesh {
    let place = |i: u32, j: u32| {
        let (turn, twist) = (f64::from(i) / f64::from(around), f64::from(j) / f64::from(across));
        let spoke = DQuat::from_rotation_y(TAU * turn);
        let radius = 0.5 + 0.2 * (TAU * twist).cos();
        (spoke * DVec3::new(radius, 0.2 * (TAU * twist).sin(), 0.0)).to_array()
    };
    let vertex = |i: u32, j: u32| (i % around) * across + j % across;
    let positions = (0..around).flat_map(|i| (0..across).map(move |j| place(i, j))).collect();
    let cells = (0..around).flat_map(|i| (0..across).map(move |j| (i, j)));
    let triangles = cells.flat_map(|(i, j)| {
        let [a, b, c, d] = [vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)];
        [[a, b, c], [a, c, d]]
    });
    (positions, triangles.collect())
}

/// A box with a corner here and there.
fn block(low: [f64; 3], high: [f64; 3]) -> Mesh {
    let corner = |n: usize| std::array::from_fn(|axis| [low, high][n >> axis & 1][axis]);
    let sides: [[u32; 4]; 6] =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ((0..8).map(corner).collect(), triangles)
}

fn together(meshes: &[Mesh]) -> Mesh {
    let mut all: Mesh = (Vec::new(), Vec::new());
    for (positions, triangles) in meshes {
        let first = all.0.len() as u32;
        all.0.extend(positions);
        all.1.extend(triangles.iter().map(|corners| corners.map(|at| at + first)));
    }
    all
}

/// Breaks a mesh into pieces in its place, without gravity.
fn broken((positions, triangles): Mesh, pieces: usize) -> (World, f64) {
    let shape = ShapeDesc::Triangles {
        positions,
        triangles,
        thickness: None,
        sides: None,
        resolution: Resolution::default(),
    };
    let pattern = PatternDesc::Voronoi(Voronoi::default());
    let breaking = BreakingDesc { pieces: Some(pieces), ..BreakingDesc::once(1e6, pattern) };
    let mut scene = SceneDesc::new("solid");
    scene.gravity = [0.0; 3];
    scene.bodies = vec![BodyDesc {
        density: 1000.0,
        breaking: Some(breaking),
        ..BodyDesc::new("body", shape)
    }];
    let mut world = World::build(&scene).unwrap();
    let mass = world.bodies().masses[0];
    let id = world.bodies().ids[0];
    let restored = World::restore(&world.snapshot().unwrap()).unwrap();
    assert_eq!(restored.state_hash(), world.state_hash());
    world.burst(id, DVec3::new(0.3, 0.2, 0.1), 0.0).unwrap();
    (world, mass)
}

/// Masses add up, surfaces are closed and wind around the mass that the body has, and no hull
/// overlaps another one.
fn check(world: &World, mass: f64) {
    let masses = &world.bodies().masses;
    let sum: f64 = masses.iter().sum();
    assert!((sum / mass - 1.0).abs() < 1e-9, "{}", sum / mass - 1.0);
    for (&id, &own) in world.bodies().ids.iter().zip(masses) {
        let surface = world.surface(id).unwrap();
        assert!(surface.mesh.is_watertight());
        assert_eq!(surface.mesh.parts(), 1);
        let inside = 1000.0 * surface.mesh.mass_properties().volume;
        assert!((inside - own).abs() < 1e-9 * mass, "{inside} {own}");
        assert!(surface.interior.contains(&true));
    }
    let deepest = world.penetrations().into_iter().fold(0.0, f64::max);
    assert!(deepest < 1e-7, "{deepest}");
}

#[test]
fn a_ring_breaks_into_pieces_of_its_surface() {
    for pieces in [10, 40, 150] {
        let (world, mass) = broken(torus(48, 24), pieces);
        let count = world.bodies().len();
        assert!(count.abs_diff(pieces) as f64 <= 0.1 * pieces as f64, "{count} of {pieces}");
        check(&world, mass);
    }
}

/// Two bars that cross are one solid: what they have in common counts once.
#[test]
fn solids_that_cross_are_one() {
    let bars =
        [block([-1.0, -0.1, -0.2], [1.0, 0.1, 0.2]), block([-0.2, -0.15, -1.0], [0.2, 0.15, 1.0])];
    let (world, mass) = broken(together(&bars), 30);
    let both = 1000.0 * (2.0 * 0.2 * 0.4 + 0.4 * 0.3 * 2.0 - 0.4 * 0.2 * 0.4);
    assert!((mass / both - 1.0).abs() < 1e-12, "{mass} {both}");
    check(&world, mass);
}

/// A shell has its cavity, and pieces of both its walls.
#[test]
fn a_cavity_stays_hollow() {
    let mut inner = block([-0.4; 3], [0.4; 3]);
    inner.1.iter_mut().for_each(|corners| corners.swap(1, 2));
    let (world, mass) = broken(together(&[block([-0.5; 3], [0.5; 3]), inner]), 40);
    assert!((mass / 488.0 - 1.0).abs() < 1e-12, "{mass}");
    check(&world, mass);
}

/// Pieces fly on and break again; nothing is lost, and nothing gains energy.
#[test]
fn pieces_break_again() {
    let (positions, triangles) = torus(32, 16);
    let shape = ShapeDesc::Triangles {
        positions,
        triangles,
        thickness: None,
        sides: None,
        resolution: Resolution::default(),
    };
    let pattern = PatternDesc::Voronoi(Voronoi { cells: 8, ..Voronoi::default() });
    let breaking = BreakingDesc { generations: 3, ..BreakingDesc::once(2.0, pattern) };
    let mut scene = SceneDesc::new("again");
    let body = BodyDesc { position: [0.0, 3.0, 0.0], ..BodyDesc::new("body", shape) };
    scene.bodies = vec![BodyDesc::ground(0.0), BodyDesc { breaking: Some(breaking), ..body }];
    let mut world = World::build(&scene).unwrap();
    let mass = world.bodies().masses[1];
    let mut generations = 0;
    for _ in 0..60 {
        let report = step(&mut world);
        for fracture in &report.fractures {
            assert!(fracture.imbalance.mass < 1e-9 && fracture.imbalance.momentum < 1e-9);
            generations += 1;
        }
        let sum: f64 = world.bodies().masses[1..].iter().sum();
        assert!((sum / mass - 1.0).abs() < 1e-9);
    }
    assert!(generations > 3, "{generations}");
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Boxes side by side, in one another, crossing and touching: the pieces fill their union.
    #[test]
    fn blocks_of_any_kind_break(
        corners in prop::collection::vec(
            (prop::array::uniform3(-3..3i32), prop::array::uniform3(1..4i32)), 1..5),
        pieces in 2..40_usize,
    ) {
        let of_corner = |(low, size): &([i32; 3], [i32; 3])| {
            let low = low.map(|place| 0.25 * f64::from(place));
            let high = std::array::from_fn(|axis| low[axis] + 0.25 * f64::from(size[axis]));
            block(low, high)
        };
        let blocks: Vec<Mesh> = corners.iter().map(of_corner).collect();
        let (world, mass) = broken(together(&blocks), pieces);
        let sum: f64 = world.bodies().masses.iter().sum();
        prop_assert!((sum / mass - 1.0).abs() < 1e-9, "{}", sum / mass - 1.0);
        for &id in &world.bodies().ids {
            let surface = world.surface(id).unwrap();
            prop_assert!(surface.mesh.is_watertight());
        }
        // Blocks that touch have faces in the planes of others.
        let deepest = world.penetrations().into_iter().fold(0.0, f64::max);
        prop_assert!(deepest < 1e-7, "{}", deepest);
    }
}
