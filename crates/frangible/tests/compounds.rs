//! Bodies of several convex polyhedra, in both methods.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{
    BodyDesc, Energy, Method, PartDesc, Resolution, SceneDesc, ShapeDesc, StepReport, World, step,
};
use frangible_bodies::{Pose, Velocity};
use glam::{DQuat, DVec3};

const METHODS: [Method; 2] = [Method::FrameRate, Method::Paper];

fn part(size: [f64; 3], position: [f64; 3]) -> PartDesc {
    PartDesc::Box { size, position, orientation: [0.0, 0.0, 0.0, 1.0] }
}

/// A cube of edge 1 m.
fn cube() -> ShapeDesc {
    ShapeDesc::Box { size: [1.0; 3], resolution: Resolution::default() }
}

/// The same of eight cubes.
fn cubelets() -> ShapeDesc {
    let side = |bit: i32| 0.5 * f64::from(bit & 1) - 0.25;
    let parts = (0..8).map(|n| part([0.5; 3], [side(n), side(n >> 1), side(n >> 2)])).collect();
    ShapeDesc::Compound { parts, resolution: Resolution::default() }
}

fn scene(method: Method, bodies: impl IntoIterator<Item = BodyDesc>) -> SceneDesc {
    let mut scene = SceneDesc::new("compounds");
    scene.method = method;
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.extend(bodies);
    scene
}

/// Frames of a scene; no frame gains energy, and the books of momentum close.
fn run(scene: &SceneDesc, frames: u32, mut look: impl FnMut(&World, &StepReport)) -> World {
    let mut world = World::build(scene).unwrap();
    for _ in 0..frames {
        let report = step(&mut world);
        let scale = report.energy.total.abs().max(1e3);
        assert!(report.energy.gain <= 1e-9 * scale, "{:?}: {} J", scene.method, report.energy.gain);
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        assert!(report.quarantined.is_empty());
        look(&world, &report);
    }
    world
}

/// Final poses of a scene's bodies.
fn ends(method: Method, bodies: Vec<BodyDesc>, frames: u32) -> (Vec<Pose>, Vec<Velocity>) {
    let world = run(&scene(method, bodies), frames, |_, _| ());
    (world.bodies().poses[1..].to_vec(), world.bodies().velocities[1..].to_vec())
}

/// Eight glued cubes fall, land on a face, slide and stop as one cube does.
#[test]
fn eight_glued_cubes_fall_and_slide_as_one() {
    for method in METHODS {
        let sliding = |shape: ShapeDesc| {
            vec![BodyDesc {
                position: [0.0, 0.8, 0.0],
                linear_velocity: [4.0, 0.0, 1.0],
                friction: 0.4,
                restitution: 0.0,
                ..BodyDesc::new("cube", shape)
            }]
        };
        for frames in [5, 12, 60] {
            let (one, eight) =
                (ends(method, sliding(cube()), frames), ends(method, sliding(cubelets()), frames));
            let apart = (one.0[0].position - eight.0[0].position).length();
            let turned = one.0[0].orientation.angle_between(eight.0[0].orientation);
            assert!(
                apart < 1e-2 && turned < 1e-2,
                "{method:?}, {frames}: {apart} m, {turned} rad apart"
            );
            let faster = (one.1[0].linear - eight.1[0].linear).length();
            assert!(faster < 0.03, "{method:?}, {frames}: {faster} m/s");
        }
    }
}

/// They land on a corner, and come to rest on a face with all their weight on the ground.
#[test]
fn eight_glued_cubes_come_to_rest_on_a_face() {
    for method in METHODS {
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 0.2, 0.7).normalize(), 0.6);
        let body = BodyDesc {
            position: [0.0, 1.5, 0.0],
            orientation: turn.to_array(),
            restitution: 0.2,
            ..BodyDesc::new("cube", cubelets())
        };
        let world = run(&scene(method, [body]), 120, |_, _| ());
        let (pose, velocity) = (world.bodies().poses[1], world.bodies().velocities[1]);
        assert!((pose.position.y - 0.5).abs() < 0.01, "{method:?}: {} m", pose.position.y);
        assert!(velocity.linear.length() < 0.05, "{method:?}: {} m/s", velocity.linear.length());
    }
}

/// Compounds stand on compounds as cubes on cubes do: seams that do not meet carry, and nobody
/// drifts.
#[test]
fn stacks_of_glued_cubes_stand() {
    for method in METHODS {
        let stack = |shapes: [ShapeDesc; 4]| {
            let body = |(n, shape): (usize, ShapeDesc)| BodyDesc {
                position: [0.07 * (n % 2) as f64, 0.5 + n as f64, -0.05 * (n % 3) as f64],
                restitution: 0.0,
                ..BodyDesc::new("cube", shape)
            };
            shapes.into_iter().enumerate().map(body).collect::<Vec<_>>()
        };
        let bodies = stack([cubelets(), cubelets(), cube(), cubelets()]);
        let starts: Vec<DVec3> =
            bodies.iter().map(|body| DVec3::from_array(body.position)).collect();
        let (poses, _) = ends(method, bodies, 120);
        let (of_one, _) = ends(method, stack([cube(), cube(), cube(), cube()]), 120);
        for ((pose, start), one) in poses.iter().zip(&starts).zip(&of_one) {
            let (moved, as_one) =
                ((pose.position - start).length(), (one.position - start).length());
            assert!(moved < as_one + 2e-3, "{method:?}: {moved} m, one cube {as_one} m");
        }
    }
}

/// A ball rolls over seams as over one floor, and a box slides over them; a table stands on its
/// legs over a ball that it does not touch.
#[test]
fn seams_are_smooth_and_hollows_are_empty() {
    let tiles = (0..8).map(|n| part([1.0, 0.5, 2.0], [f64::from(n), -0.25, 0.0])).collect();
    let floor = BodyDesc {
        motion: frangible::MotionDesc::Static,
        position: [0.0, 1.0, 0.0],
        ..BodyDesc::new(
            "floor",
            ShapeDesc::Compound { parts: tiles, resolution: Resolution::default() },
        )
    };
    let moving = |name: &str, shape: ShapeDesc, z: f64| BodyDesc {
        position: [0.0, 1.2, z],
        linear_velocity: [3.0, 0.0, 0.0],
        restitution: 0.0,
        friction: 0.0,
        ..BodyDesc::new(name, shape)
    };
    let ball = ShapeDesc::Sphere { radius: 0.2, resolution: Resolution::default() };
    let brick = ShapeDesc::Box { size: [0.4; 3], resolution: Resolution::default() };
    let bodies = [floor, moving("ball", ball.clone(), -0.5), moving("brick", brick, 0.5)];
    let world = run(&scene(Method::FrameRate, bodies), 60, |world, _| {
        for pose in &world.bodies().poses[2..] {
            assert!((pose.position.y - 1.2).abs() < 2e-3, "{}", pose.position);
        }
    });
    for (pose, velocity) in world.bodies().poses[2..].iter().zip(&world.bodies().velocities[2..]) {
        assert!((pose.position.x - 6.0).abs() < 0.02, "{}", pose.position);
        assert!(
            (velocity.linear - DVec3::new(3.0, 0.0, 0.0)).length() < 0.02,
            "{}",
            velocity.linear
        );
    }

    let leg = |x: f64, z: f64| part([0.1, 0.9, 0.1], [x, 0.45, z]);
    let top = part([1.2, 0.1, 1.2], [0.0, 0.95, 0.0]);
    let parts = vec![top, leg(0.5, 0.5), leg(-0.5, 0.5), leg(0.5, -0.5), leg(-0.5, -0.5)];
    for method in METHODS {
        let shape = ShapeDesc::Compound { parts: parts.clone(), resolution: Resolution::default() };
        let under = BodyDesc { position: [0.0, 0.2, 0.0], ..BodyDesc::new("ball", ball.clone()) };
        let world = run(&scene(method, [BodyDesc::new("table", shape), under]), 60, |_, _| ());
        let [table, ball] = [world.bodies().poses[1], world.bodies().poses[2]];
        assert!(table.orientation.angle_between(DQuat::IDENTITY) < 1e-2);
        let origin =
            table.world_from_body().point(world.bodies().shapes[1].body_from_grid.translation);
        assert!(origin.length() < 5e-3, "{method:?}: {origin}");
        // In the paper's method a ball stands on its samples, and rolls from one to the next.
        assert!((ball.position.y - 0.2).abs() < 5e-3, "{method:?}: {}", ball.position);
    }
}

/// A body that starts deep where two parts of a compound join, each part's shortest way out leading
/// into the other one, is out within a second, and slowly.
#[test]
fn what_lies_deep_in_a_joint_comes_out() {
    let parts = vec![part([1.0, 0.3, 0.5], [0.0; 3]), part([0.4, 0.8, 0.5], [0.3, 0.55, 0.0])];
    let joint = ShapeDesc::Compound { parts, resolution: Resolution::default() };
    let resolution = Resolution::default();
    let small = [
        ShapeDesc::Box { size: [0.1; 3], resolution },
        ShapeDesc::Sphere { radius: 0.06, resolution },
        ShapeDesc::Cone { radius: 0.06, height: 0.1, resolution },
        ShapeDesc::Cylinder { radius: 0.05, height: 0.1, resolution },
        ShapeDesc::Compound {
            parts: vec![part([0.1, 0.05, 0.1], [0.0; 3]), part([0.05, 0.1, 0.1], [0.0; 3])],
            resolution: Resolution::default(),
        },
    ];
    for motion in [frangible::MotionDesc::Static, frangible::MotionDesc::Dynamic] {
        for (shape, up) in small.iter().flat_map(|shape| [(shape, -0.02), (shape, 0.02)]) {
            let of_joint = BodyDesc { motion, ..BodyDesc::new("joint", joint.clone()) };
            let of_small = BodyDesc {
                position: [0.28, 0.155 + up, 0.16],
                orientation: [0.05, 0.09, 0.14, 0.98],
                ..BodyDesc::new("small", shape.clone())
            };
            let mut scene = SceneDesc::new("joint");
            scene.gravity = [0.0; 3];
            scene.bodies = vec![of_joint, of_small];
            let world = run(&scene, 30, |world, _| {
                let speed = world.bodies().velocities[1].linear.length();
                assert!(speed < 1.0, "{shape:?}: {speed} m/s");
            });
            let overlap = world.penetrations().into_iter().fold(0.0, f64::max);
            assert!(overlap < 5e-4, "{motion:?} {shape:?}: {overlap} m");
        }
    }
}

/// A cone that lies in the corner of a bin, deep in the floor and in a wall.
#[test]
fn what_lies_deep_in_a_corner_comes_out() {
    let wall = |x: f64| part([0.1, 3.0, 1.2], [x, 1.5, 0.0]);
    let parts = vec![part([1.2, 0.1, 1.2], [0.0, -0.05, 0.0]), wall(0.55), wall(-0.55)];
    let bin = BodyDesc {
        motion: frangible::MotionDesc::Static,
        ..BodyDesc::new("bin", ShapeDesc::Compound { parts, resolution: Resolution::default() })
    };
    let cone = ShapeDesc::Cone { radius: 0.072, height: 0.113, resolution: Resolution::default() };
    let cone = BodyDesc {
        position: [-0.480, 0.027, -0.199],
        orientation: [-0.0405, 0.4064, -0.1104, -0.9061],
        restitution: 0.0,
        ..BodyDesc::new("cone", cone)
    };
    let mut scene = SceneDesc::new("corner");
    scene.bodies = vec![bin, cone];
    let world = run(&scene, 60, |_, _| ());
    let overlap = world.penetrations().into_iter().fold(0.0, f64::max);
    assert!(overlap < 5e-4, "{overlap} m");
    assert!(world.bodies().velocities[1].linear.length() < 0.3);
}

/// Random numbers in -1..1, from a linear congruential generator.
fn draw(state: &mut u64) -> f64 {
    *state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    (*state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
}

/// Pairs of compounds that start at rest, deep in each other, without gravity: what jams leaves the
/// overlap without energy, too.
#[test]
fn overlaps_give_no_energy() {
    let angle = vec![
        part([0.757, 0.0757, 0.0757], [0.0; 3]),
        part([0.0757, 0.0757, 0.757], [0.378, 0.0, 0.378]),
    ];
    let leg = |x: f64| part([0.157, 0.551, 0.315], [x, 0.354, 0.0]);
    let fork = vec![part([0.787, 0.157, 0.315], [0.0; 3]), leg(-0.315), leg(0.315)];
    let shape = |parts: &Vec<PartDesc>| ShapeDesc::Compound {
        parts: parts.clone(),
        resolution: Resolution::default(),
    };
    // Two legs of one jam in the other.
    let jam = ([-0.155, -0.190, -0.022], [1.316, 0.218, -0.764, -1.340]);
    let mut state = 7;
    let drawn = (0..60).map(|_| {
        let at = [0.0; 3].map(|_| 0.3 * draw(&mut state));
        (at, [0.0; 4].map(|_| draw(&mut state)))
    });
    let poses: Vec<_> = std::iter::once(jam).chain(drawn).collect();
    let (mut overlaps, mut stay) = (0, 0);
    for (position, orientation) in poses {
        let restitution = 0.0;
        let first = BodyDesc {
            position,
            orientation,
            restitution,
            ..BodyDesc::new("angle", shape(&angle))
        };
        let second = BodyDesc { restitution, ..BodyDesc::new("fork", shape(&fork)) };
        let mut scene = SceneDesc::new("overlaps");
        (scene.gravity, scene.frames_per_second) = ([0.0; 3], 24.0);
        scene.bodies = vec![first, second];
        let deepest = |world: &World| world.penetrations().into_iter().fold(0.0, f64::max);
        let is_deep = deepest(&World::build(&scene).unwrap()) > 0.01;
        let world = run(&scene, 24, |_, report| {
            let Energy { kinetic, .. } = report.energy;
            assert!(kinetic < 1e-9, "{position:?} {orientation:?}: {kinetic} J");
        });
        overlaps += u32::from(is_deep);
        stay += u32::from(deepest(&world) > 0.01);
    }
    assert!(overlaps > 30 && stay <= 3, "{stay} of {overlaps} overlaps stay");
}

/// Tables on tables come to rest: their feet bear on the same corners in every frame.
#[test]
fn stacks_of_tables_rest() {
    let table = |s: f64| {
        let leg =
            |x: f64, z: f64| part([0.1 * s, 0.8 * s, 0.1 * s], [0.45 * x * s, 0.0, 0.45 * z * s]);
        let top = part([s, 0.1 * s, s], [0.0, 0.45 * s, 0.0]);
        let parts = vec![top, leg(1.0, 1.0), leg(1.0, -1.0), leg(-1.0, 1.0), leg(-1.0, -1.0)];
        ShapeDesc::Compound { parts, resolution: Resolution::default() }
    };
    for (s, count) in [(0.05, 4), (0.2, 3), (0.8, 6)] {
        let body = |n: usize| BodyDesc {
            position: [0.0, (0.4 + 0.9 * n as f64) * s, 0.0],
            restitution: 0.0,
            ..BodyDesc::new("table", table(s))
        };
        let bodies: Vec<BodyDesc> = (0..count).map(body).collect();
        let world = run(&scene(Method::FrameRate, bodies), 240, |_, _| ());
        for velocity in &world.bodies().velocities {
            let speed = velocity.linear.length();
            assert!(speed < 1e-3, "{count} of {s} m: {speed} m/s");
        }
    }
}
