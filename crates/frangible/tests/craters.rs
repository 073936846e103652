//! Breaks with a reach: craters, and what stays whole around them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::{Bricks, Concrete, Natural, Slices};
use frangible::{
    BodyDesc, BreakingDesc, PartDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, StepReport,
    World, step,
};
use glam::DVec3;

const WALL: [f64; 3] = [3.0, 2.0, 0.4];
const DENSITY: f64 = 1000.0;

fn resolution(voxels: Option<[usize; 3]>) -> Resolution {
    Resolution { voxels, ..Resolution::default() }
}

fn natural() -> PatternDesc {
    PatternDesc::Natural(Natural { cells: 60, ..Natural::default() })
}

/// A box as a mesh: what breaks voxel by voxel.
fn mesh_box([x, y, z]: [f64; 3]) -> ShapeDesc {
    let corner = |at: usize| {
        let side = |axis: usize| if at >> axis & 1 == 1 { 0.5 } else { -0.5 };
        [side(0) * x, side(1) * y, side(2) * z]
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    ShapeDesc::Triangles {
        positions: (0..8).map(corner).collect(),
        triangles,
        thickness: None,
        sides: None,
        resolution: resolution(Some([90, 60, 12])),
    }
}

fn exact_box(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: resolution(None) }
}

/// A wall on the ground.
fn wall(shape: ShapeDesc, pattern: PatternDesc, reach: Option<f64>) -> BodyDesc {
    BodyDesc {
        position: [0.0, 0.5 * WALL[1], 0.0],
        density: DENSITY,
        friction: 0.7,
        restitution: 0.1,
        breaking: Some(BreakingDesc { reach, ..BreakingDesc::once(450.0, pattern) }),
        ..BodyDesc::new("wall", shape)
    }
}

/// A steel ball on its way to the wall's face at a place across.
fn ball(at: [f64; 2]) -> BodyDesc {
    BodyDesc {
        position: [at[0], at[1], 1.0],
        linear_velocity: [0.0, 0.0, -32.0],
        density: 7800.0,
        ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.08, resolution: resolution(None) })
    }
}

fn world_of(bodies: Vec<BodyDesc>) -> World {
    let mut scene = SceneDesc::new("crater");
    scene.frames_per_second = 60.0;
    scene.bodies = vec![BodyDesc::ground(0.0)];
    scene.bodies.extend(bodies);
    World::build(&scene).unwrap()
}

/// The heaviest body of a world, its mass [kg], and where it is [m].
fn heaviest(world: &World) -> (String, f64, DVec3) {
    let bodies = world.bodies();
    let mass = |&i: &usize| if bodies.masses[i].is_finite() { bodies.masses[i] } else { 0.0 };
    let at = (0..bodies.len()).max_by(|a, b| mass(a).total_cmp(&mass(b))).unwrap();
    (world.labels()[at].name.clone(), mass(&at), bodies.poses[at].position)
}

fn run(world: &mut World, frames: usize) -> Vec<StepReport> {
    (0..frames).map(|_| step(world)).collect()
}

/// Five seconds after a ball has struck a wall: the world, and all reports.
fn struck(wall: BodyDesc) -> (World, Vec<StepReport>) {
    let mut world = world_of(vec![wall, ball([0.3, 1.3])]);
    let reports = run(&mut world, 300);
    (world, reports)
}

/// The fractures of all frames are exact, no frame gained energy, and no mass is lost.
fn assert_exact(reports: &[StepReport]) {
    let masses = || reports.iter().map(|report| report.mass);
    let first = masses().next().unwrap();
    for report in reports {
        assert!((report.mass / first - 1.0).abs() < 1e-12);
        assert!(report.energy.gain <= 1e-9, "{}", report.energy.gain);
        for fracture in &report.fractures {
            let off = fracture.imbalance;
            let worst = off.mass.max(off.momentum).max(off.angular_momentum);
            assert!(worst.max(off.kinetic_energy) < 1e-11, "{off:?}");
        }
    }
}

/// A wall stands for 5 s around the crater that a ball has made, in bodies of polyhedra, on grids,
/// of plane and of rough cells, and with the bricks of a pattern; without a reach nothing stands.
#[test]
fn a_wall_stands_around_its_crater() {
    let bricks = || PatternDesc::Bricks(Bricks { columns: 8, courses: 16, ..Bricks::default() });
    let rough = PatternDesc::Concrete(Concrete { cells: 60, ..Concrete::default() });
    for (what, shape, pattern, reach) in [
        ("box", exact_box(WALL), natural(), 0.6),
        ("mesh", mesh_box(WALL), natural(), 0.6),
        ("rough", exact_box(WALL), rough, 0.6),
        ("bricks", exact_box(WALL), bricks(), 0.4),
        ("bricks of a mesh", mesh_box(WALL), bricks(), 0.4),
    ] {
        let (world, reports) = struck(wall(shape, pattern, Some(reach)));
        let fractures: Vec<_> = reports.iter().flat_map(|report| &report.fractures).collect();
        assert_eq!(fractures.len(), 1, "{what}");
        assert!((8..40).contains(&fractures[0].fragments.len()), "{what}");
        assert_exact(&reports);
        let (_, mass, at) = heaviest(&world);
        let whole = DENSITY * WALL.iter().product::<f64>();
        assert!((0.9..0.99).contains(&(mass / whole)), "{what}: {mass} of {whole}");
        assert!((at.y - 0.5 * WALL[1]).abs() < 0.05 && at.z.abs() < 0.1, "{what}: {at}");
    }
    let (world, _) = struck(wall(exact_box(WALL), natural(), None));
    assert!(heaviest(&world).1 < 1000.0);
}

/// A second blow makes a second crater in what the first one left, and equal blows on equal bodies
/// give equal bits.
#[test]
fn what_stands_breaks_again() {
    let run_both = || {
        let late = BodyDesc { position: [-0.8, 1.0, 3.0], ..ball([0.0; 2]) };
        let wall = wall(exact_box(WALL), natural(), Some(0.6));
        let mut world = world_of(vec![wall, ball([0.3, 1.3]), late]);
        let reports = run(&mut world, 20);
        (world, reports)
    };
    let (world, reports) = run_both();
    assert_eq!(reports.iter().map(|report| report.fractures.len()).sum::<usize>(), 2);
    assert_exact(&reports);
    let whole = DENSITY * WALL.iter().product::<f64>();
    assert!((0.9..0.975).contains(&(heaviest(&world).1 / whole)), "{:?}", heaviest(&world));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(3).build().unwrap();
    assert_eq!(world.state_hash(), pool.install(run_both).0.state_hash());
}

/// What a crater parts from the rest is a body of its own: a pillar that is struck in its middle
/// loses that, and is two.
#[test]
fn rests_that_are_not_connected_are_bodies_of_their_own() {
    let pillar = [0.3, 2.0, 0.3];
    let fine = PatternDesc::Natural(Natural { cells: 200, spread: 0.0, ..Natural::default() });
    let angle = ShapeDesc::Compound {
        parts: [[0.0, 0.0], [0.8, 0.85]]
            .map(|[x, y]| PartDesc::Box {
                size: if x == 0.0 { pillar } else { [1.3, 0.3, 0.3] },
                position: [x, y, 0.0],
                orientation: [0.0, 0.0, 0.0, 1.0],
            })
            .to_vec(),
        resolution: resolution(None),
    };
    for (what, shape, at, rests) in [
        ("pillar", exact_box(pillar), 1.0, 2),
        ("pillar's head", exact_box(pillar), 1.85, 1),
        ("mesh", mesh_box(pillar), 1.0, 2),
        ("angle", angle, 1.0, 2),
    ] {
        let wall = BodyDesc { name: what.into(), ..wall(shape, fine.clone(), Some(0.75)) };
        let mut world = world_of(vec![wall, ball([0.0, at])]);
        let reports = run(&mut world, 4);
        assert_exact(&reports);
        let large = world.bodies().masses.iter().filter(|&&mass| (18.0..1e3).contains(&mass));
        assert_eq!(large.count(), rests, "{what}: {:?}", world.bodies().masses);
    }
}

/// What lies beyond a reach is not touched: a blow with a reach larger than the body breaks as one
/// without does, and slices in reach come loose whole.
#[test]
fn the_reach_decides_what_comes_loose() {
    let pieces = |pattern: PatternDesc, reach: Option<f64>| {
        let (_, reports) = struck(wall(exact_box(WALL), pattern, reach));
        reports.iter().find_map(|report| report.fractures.first()).unwrap().fragments.len()
    };
    assert_eq!(pieces(natural(), Some(50.0)), pieces(natural(), None));
    let slices = || PatternDesc::Slices(Slices { cells: 20, ..Slices::default() });
    let [few, many, all] = [Some(0.01), Some(0.5), None].map(|reach| pieces(slices(), reach));
    assert!(few == 3 || few == 2, "{few}");
    assert!(few < many && many < all, "{few} {many} {all}");
}

#[test]
fn a_reach_is_a_length() {
    let mut scene = SceneDesc::new("bad");
    scene.bodies = vec![wall(exact_box(WALL), natural(), Some(-1.0))];
    let sentence = World::build(&scene).unwrap_err().to_string();
    assert!(sentence.contains("breaking.reach: -1.0, must be > 0"), "{sentence}");
}
