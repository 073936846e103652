//! Scenes of convex polyhedra, in both methods.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, Method, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    World, step,
};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// The hull of some points in a box of these edge lengths [m], its middle at the origin.
fn rock(size: DVec3, count: usize, random: &mut Pcg64Mcg) -> ShapeDesc {
    let coordinate = |edge: f64, random: &mut Pcg64Mcg| edge * (random.random::<f64>() - 0.5);
    let points = (0..count).map(|_| size.to_array().map(|edge| coordinate(edge, random))).collect();
    ShapeDesc::Hull { points, resolution: Resolution::default() }
}

fn falling_rocks(method: Method, count: usize) -> SceneDesc {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut scene = SceneDesc::new("rocks");
    scene.method = method;
    scene.bodies.push(BodyDesc::ground(0.0));
    for n in 0..count {
        let shape = rock(DVec3::new(0.8, 0.6, 0.5), 12, &mut random);
        let [x, y, z] = [n % 2, n / 4, n / 2 % 2].map(|at| at as f64);
        let position = [0.5 * x + 0.1 * y, 0.6 + 0.9 * y, 0.5 * z - 0.05 * y];
        scene.bodies.push(BodyDesc { position, restitution: 0.2, ..BodyDesc::new("rock", shape) });
    }
    scene
}

/// Rocks fall into a heap: nothing sinks in, nothing gains energy, and in the end all lie still.
#[test]
fn rocks_fall_into_a_heap() {
    for (method, most_depth) in [(Method::Paper, 0.05), (Method::FrameRate, 0.02)] {
        let mut world = World::build(&falling_rocks(method, 8)).unwrap();
        let (kinetic, potential) = world.energy();
        let scale = kinetic + potential;
        for frame in 0..150 {
            let report = step(&mut world);
            assert!(report.energy.gain <= 1e-9 * scale, "{method:?}: {} J", report.energy.gain);
            assert!(report.quarantined.is_empty());
            if frame > 60 {
                let depth = deepest_below_ground(&world);
                assert!(depth < most_depth, "{method:?}, frame {frame}: {depth} m in the ground");
            }
        }
        let fastest =
            world.bodies().velocities.iter().map(|v| v.linear.length()).fold(0.0, f64::max);
        assert!(fastest < 0.1, "{method:?}: {fastest} m/s");
    }
}

/// A cube that is struck by a ball at 60 m/s is not pressed into the thin plate before it,
/// whichever pair acts first: not even by a ball of twice its weight, which has to give up its
/// motion in many small parts.
#[test]
fn what_is_struck_is_not_pressed_through_a_thin_plate() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for case in 0..80 {
        let density = if case % 2 == 0 { 1000.0 } else { 10_000.0 };
        let cube = ShapeDesc::Box { size: [0.1; 3], resolution: Resolution::default() };
        let plate = ShapeDesc::Box { size: [0.01, 1.0, 1.0], resolution: Resolution::default() };
        let ball = ShapeDesc::Sphere { radius: 0.05, resolution: Resolution::default() };
        // Half of them are near, and not pressed in at all; the others have to get there first.
        let (gap, most) = if case % 4 < 2 {
            (1e-3 + 3e-3 * random.random::<f64>(), 5e-4)
        } else {
            (0.03 * random.random::<f64>(), 5e-3)
        };
        // It strikes in the first two substeps, before the cube has begun to fall.
        let way = 0.1 + 2.0 * 60.0 / 240.0 * random.random::<f64>();
        let plate = BodyDesc {
            motion: MotionDesc::Static,
            position: [0.055 + gap, 0.0, 0.0],
            ..BodyDesc::new("plate", plate)
        };
        let striker = BodyDesc {
            position: [-way, 0.0, 0.0],
            linear_velocity: [60.0, 0.0, 0.0],
            density,
            ..BodyDesc::new("ball", ball)
        };
        let struck = BodyDesc::new("cube", cube);
        let mut scene = SceneDesc::new("struck");
        scene.bodies = if random.random() {
            vec![plate, struck, striker]
        } else {
            vec![striker, struck, plate]
        };
        let mut world = World::build(&scene).unwrap();
        for _ in 0..6 {
            step(&mut world);
            let depth = world.bodies().poses[1].position.x - gap;
            assert!(
                depth < most,
                "{density} kg/m^3 from {way} m off press the cube {depth} m into a plate {gap} m off"
            );
        }
    }
}

/// A card that lies with one edge on a thin plate, its other edge some millimetres or centimetres
/// above it, is struck there: that edge, too far up to touch within the frame by itself, stops at
/// the plate.
#[test]
fn a_card_that_is_struck_at_its_edge_is_stopped() {
    const CARD: [f64; 3] = [0.4, 0.01, 0.3];
    let cuboid = |size: [f64; 3]| ShapeDesc::Box { size, resolution: Resolution::default() };
    for speed in [2.0, 8.0, 12.0, 20.0] {
        for lift in (2..14).map(|lift| 2e-3 * f64::from(lift)) {
            let turn = DQuat::from_rotation_z((lift / CARD[0]).asin());
            let mut scene = SceneDesc::new("card");
            scene.bodies.push(BodyDesc {
                motion: MotionDesc::Static,
                position: [0.0, -0.5 * CARD[1], 0.0],
                ..BodyDesc::new("plate", cuboid([1.0, CARD[1], 1.0]))
            });
            let card = 0.5 * (CARD[1] + lift);
            scene.bodies.push(BodyDesc {
                position: [0.0, card, 0.0],
                orientation: turn.to_array(),
                density: 800.0,
                ..BodyDesc::new("card", cuboid(CARD))
            });
            scene.bodies.push(BodyDesc {
                position: [0.17, 0.07 + lift, 0.0],
                linear_velocity: [0.0, -speed, 0.0],
                density: 3000.0,
                ..BodyDesc::new(
                    "ball",
                    ShapeDesc::Sphere { radius: 0.05, resolution: Resolution::default() },
                )
            });
            let mut world = World::build(&scene).unwrap();
            for _ in 0..5 {
                step(&mut world);
                let pose = &world.bodies().poses[1];
                let lowest =
                    |x: f64| (pose.position + pose.orientation * DVec3::new(x, 0.0, 0.0)).y;
                let lowest = lowest(0.5 * CARD[0]).min(lowest(-0.5 * CARD[0]));
                assert!(
                    lowest > 0.5 * CARD[1] - 2e-3,
                    "struck at {speed} m/s {lift} m above the plate its edge gets to {lowest} m"
                );
            }
        }
    }
}

/// Depth of the lowest vertex of all bodies below the ground [m].
fn deepest_below_ground(world: &World) -> f64 {
    let bodies = world.bodies();
    let mut depth = 0.0_f64;
    for (shape, pose) in bodies.shapes.iter().zip(&bodies.poses) {
        for &vertex in shape.hull.iter().flat_map(|hull| hull.vertices()) {
            depth = depth.max(-pose.world_from_body().point(vertex).y);
        }
    }
    depth
}

/// Cubes as polyhedra (four points per face) or on grids (eight): a stack of them stands, upright
/// and with alternating shifts.
#[test]
fn stacks_stand_whatever_their_cubes_are_made_of() {
    for voxels in [None, Some([16; 3])] {
        for shift in [0.0, 0.125] {
            let mut scene = SceneDesc::new("stack");
            scene.method = Method::FrameRate;
            scene.bodies.push(BodyDesc::ground(0.0));
            for level in 0..8 {
                let aside = if level % 2 == 0 { shift } else { -shift };
                let resolution = Resolution { voxels, sample_spacing: Some(0.125) };
                let shape = ShapeDesc::Box { size: [1.0; 3], resolution };
                let position = [aside, 0.5 + f64::from(level), aside];
                scene.bodies.push(BodyDesc {
                    position,
                    restitution: 0.0,
                    ..BodyDesc::new("cube", shape)
                });
            }
            let mut world = World::build(&scene).unwrap();
            let start = world.bodies().poses.clone();
            (0..600).for_each(|_| drop(step(&mut world)));
            let moved = world
                .bodies()
                .poses
                .iter()
                .zip(&start)
                .map(|(a, b)| a.position.distance(b.position));
            let drift = moved.fold(0.0, f64::max);
            // Of sampled cubes, round-off decides the way: moved by 1e-14 m at the start, the stack
            // drifts 0.7 to 5 cm.
            let limit = if voxels.is_some() { 0.08 } else { 0.03 };
            assert!(drift < limit, "{voxels:?}, {shift} m aside: {drift} m");
        }
    }
}

/// Sixty towers of thirty cubes share a budget of passes that is large enough: with a quarter of it
/// they lean by 0.3 m after 4 s, and fall after 10.
#[test]
fn many_towers_stand() {
    const HIGH: u32 = 30;
    let mut scene = SceneDesc::new("towers");
    scene.bodies.push(BodyDesc::ground(0.0));
    let cube = ShapeDesc::Box { size: [1.0; 3], resolution: Resolution::default() };
    for tower in 0..60 {
        for level in 0..HIGH {
            let position =
                [3.0 * f64::from(tower % 10), 0.5 + f64::from(level), 3.0 * f64::from(tower / 10)];
            scene.bodies.push(BodyDesc { position, ..BodyDesc::new("cube", cube.clone()) });
        }
    }
    let mut world = World::build(&scene).unwrap();
    let start = world.bodies().poses.clone();
    (0..120).for_each(|_| drop(step(&mut world)));
    let moved =
        world.bodies().poses.iter().zip(&start).map(|(a, b)| a.position.distance(b.position));
    let drift = moved.fold(0.0, f64::max);
    assert!(drift < 0.05, "{drift} m");
}

/// Rocks with many corners, each by itself, come to rest on the ground: on four of their corners
/// some would rock for ever, over those that are left out.
#[test]
fn rocks_come_to_rest() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    let mut scene = SceneDesc::new("rocks");
    scene.method = Method::FrameRate;
    scene.bodies.push(BodyDesc::ground(0.0));
    for n in 0..100_u32 {
        let shape = rock(DVec3::new(0.4, 0.2, 0.3), 40, &mut random);
        let position = [f64::from(n % 10), 0.12, f64::from(n / 10)];
        scene.bodies.push(BodyDesc { position, restitution: 0.2, ..BodyDesc::new("rock", shape) });
    }
    let mut world = World::build(&scene).unwrap();
    (0..150).for_each(|_| drop(step(&mut world)));
    let moves =
        world.bodies().velocities.iter().filter(|velocity| velocity.linear.length() > 0.01).count();
    let depth = deepest_below_ground(&world);
    assert!(moves == 0 && depth < 2e-3, "{moves} of 100 move, {depth} m in the ground");
}

/// A body is where its points are, wherever its centre of mass and its principal axes lie.
#[test]
fn a_hull_stands_where_its_points_are() {
    let points =
        vec![[1.0, 2.0, 3.0], [2.0, 2.0, 3.0], [1.0, 3.0, 3.0], [1.0, 2.0, 4.0], [1.2, 2.2, 3.2]];
    let mut scene = SceneDesc::new("tetrahedron");
    let shape = ShapeDesc::Hull { points: points.clone(), resolution: Resolution::default() };
    let position = [10.0, 0.0, -5.0];
    scene.bodies.push(BodyDesc { position, ..BodyDesc::new("tetrahedron", shape) });
    let text = serde_json::to_string(&scene).unwrap();
    assert_eq!(serde_json::from_str::<SceneDesc>(&text).unwrap(), scene);

    let world = World::build(&scene).unwrap();
    let (shape, pose) = (&world.bodies().shapes[0], &world.bodies().poses[0]);
    assert!((shape.volume - 1.0 / 6.0).abs() < 1e-15);
    assert!((pose.position - DVec3::new(11.25, 2.25, -1.75)).length() < 1e-14);
    for point in &points[..4] {
        let expected = DVec3::from_array(*point) + DVec3::from_array(position);
        let hull = shape.hull.as_ref().unwrap();
        let nearest =
            hull.vertices().iter().map(|&v| pose.world_from_body().point(v).distance(expected));
        assert!(nearest.fold(f64::INFINITY, f64::min) < 1e-14);
    }
}

/// A breaking body is sampled on a grid, and its pieces add up to it.
#[test]
fn a_hull_breaks() {
    for method in [Method::Paper, Method::FrameRate] {
        let mut random = Pcg64Mcg::seed_from_u64(3);
        let mut scene = SceneDesc::new("break");
        scene.method = method;
        scene.bodies.push(BodyDesc::ground(0.0));
        let ShapeDesc::Hull { points, .. } = rock(DVec3::ONE, 20, &mut random) else {
            unreachable!()
        };
        let resolution = Resolution { voxels: Some([24; 3]), sample_spacing: None };
        let pattern = PatternDesc::Voronoi(Voronoi { cells: 60, seed: 1, ..Voronoi::default() });
        let breaking = BreakingDesc::once(100.0, pattern);
        scene.bodies.push(BodyDesc {
            position: [0.0, 2.0, 0.0],
            breaking: Some(breaking),
            ..BodyDesc::new("rock", ShapeDesc::Hull { points, resolution })
        });
        let mut world = World::build(&scene).unwrap();
        let mass = world.bodies().masses[1];
        let mut fractures = 0;
        for _ in 0..30 {
            fractures += step(&mut world).fractures.len();
        }
        let pieces: f64 = world.bodies().masses[1..].iter().sum();
        assert_eq!(fractures, 1, "{method:?}");
        assert!(world.bodies().len() > 5, "{method:?}: {} bodies", world.bodies().len());
        assert!((pieces / mass - 1.0).abs() < 1e-12, "{method:?}: {pieces} of {mass} kg");
    }
}

/// A row of separated bodies, the first under impact: each hits the next, without penetration.
/// Ballistic paths alone do not predict these contacts.
#[test]
fn what_is_struck_strikes_on_in_the_same_frame() {
    const SIZE: f64 = 0.2;
    let ball = ShapeDesc::Sphere { radius: 0.5 * SIZE, resolution: Resolution::default() };
    let cube = ShapeDesc::Box { size: [SIZE; 3], resolution: Resolution::default() };
    for (shape, on_ground) in [(&ball, false), (&cube, false), (&cube, true)] {
        for (gap, speed) in [(0.001, 5.0), (0.02, 2.0), (0.02, 50.0), (0.05, 5.0), (0.05, 15.0)] {
            let mut scene = SceneDesc::new("row");
            // On the ground the whole row slides.
            let along = if on_ground { 1.0 } else { 0.0 };
            if on_ground {
                scene.bodies.push(BodyDesc::ground(0.0));
            } else {
                scene.gravity = [0.0; 3];
            }
            for number in 0..5 {
                let x =
                    if number == 0 { -SIZE - 0.05 } else { f64::from(number - 1) * (SIZE + gap) };
                scene.bodies.push(BodyDesc {
                    position: [x, 0.5 * SIZE, 0.0],
                    linear_velocity: [along + if number == 0 { speed } else { 0.0 }, 0.0, 0.0],
                    restitution: 0.5,
                    ..BodyDesc::new("body", shape.clone())
                });
            }
            let mut world = World::build(&scene).unwrap();
            let mut moved = false;
            for _ in 0..20 {
                step(&mut world);
                let all: Vec<f64> =
                    world.bodies().poses.iter().map(|pose| pose.position.x).collect();
                let row = &all[all.len() - 5..];
                moved |= row[4] > 3.0 * (SIZE + gap) + 1e-3;
                let overlap = world.penetrations().into_iter().fold(0.0, f64::max);
                assert!(
                    overlap < 2e-3 && (on_ground || row.is_sorted()),
                    "{shape:?} {gap} m apart at {speed} m/s: {overlap} m into each other"
                );
            }
            assert!(moved, "{shape:?} {gap} m apart at {speed} m/s: the last one stays");
        }
    }
}
