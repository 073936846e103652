//! Bodies that wait for a frame, or for a blow.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::bodies::BodyId;
use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BondsDesc, BreakingDesc, KeyframeDesc, Method, MotionDesc, PatternDesc, Resolution,
    SceneDesc, ShapeDesc, StartsDesc, StartsWhen, StepReport, World, step,
};
use glam::DVec3;

const STRUCK: Option<StartsDesc> = Some(StartsDesc { frame: None, when: Some(StartsWhen::Struck) });

fn at_frame(frame: u32) -> Option<StartsDesc> {
    Some(StartsDesc { frame: Some(frame), when: None })
}

fn ball(position: [f64; 3], speed: f64) -> BodyDesc {
    let shape = ShapeDesc::Sphere { radius: 0.1, resolution: Resolution::default() };
    let linear_velocity = [speed, 0.0, 0.0];
    BodyDesc { position, linear_velocity, restitution: 1.0, ..BodyDesc::new("ball", shape) }
}

fn block(size: [f64; 3], position: [f64; 3]) -> BodyDesc {
    let shape = ShapeDesc::Box { size, resolution: Resolution::default() };
    BodyDesc { position, restitution: 0.0, ..BodyDesc::new("block", shape) }
}

fn scene(bodies: impl IntoIterator<Item = BodyDesc>) -> SceneDesc {
    SceneDesc { bodies: bodies.into_iter().collect(), ..SceneDesc::new("waiting") }
}

/// Without gravity.
fn floating(bodies: impl IntoIterator<Item = BodyDesc>) -> SceneDesc {
    SceneDesc { gravity: [0.0; 3], ..scene(bodies) }
}

fn build(scene: &SceneDesc) -> World {
    World::build(scene).unwrap()
}

/// A step that gains no energy and loses no momentum.
fn advance(world: &mut World) -> StepReport {
    let report = step(world);
    let scale = report.energy.kinetic + report.energy.potential.abs() + 1.0;
    assert!(report.energy.gain <= 1e-9 * scale, "{} J", report.energy.gain);
    let momentum = report.momentum;
    assert!(momentum.linear_error.max(momentum.angular_error) < 1e-9, "{momentum:?}");
    report
}

fn ids(world: &World) -> Vec<BodyId> {
    world.bodies().ids.clone()
}

fn waiting(world: &World) -> Vec<bool> {
    ids(world).into_iter().map(|id| world.is_waiting(id)).collect()
}

/// It hangs in the air until its frame, and then does what a body of another scene did from frame
/// 0 on, to the bit where it spins and falls.
#[test]
fn a_body_starts_at_its_frame_with_its_velocities() {
    for method in [Method::FrameRate, Method::Paper] {
        let body = BodyDesc {
            angular_velocity: [1.0, 2.0, 3.0],
            linear_velocity: [0.5, 1.0, 0.0],
            ..block([0.1, 0.2, 0.3], [0.0, 5.0, 0.0])
        };
        let waits = BodyDesc { starts: at_frame(7), ..body.clone() };
        let [mut free, mut world] =
            [body, waits].map(|body| build(&SceneDesc { method, ..scene([body]) }));
        let at_start = world.bodies().poses[0];
        let (kinetic, potential) = free.energy();
        for frame in 0..7 {
            let report = advance(&mut world);
            assert_eq!(world.bodies().poses[0], at_start, "frame {frame}");
            assert_eq!((report.waiting, report.mass, report.energy.total), (1, 0.0, 0.0));
            assert_eq!(report.energy.started, 0.0);
        }
        assert_eq!(waiting(&world), [true]);
        let report = advance(&mut world);
        assert!((report.energy.started - kinetic - potential).abs() < 1e-9 * potential);
        assert_eq!((report.waiting, waiting(&world)), (0, vec![false]));
        for _ in 0..10 {
            advance(&mut free);
            assert_eq!(world.bodies().poses, free.bodies().poses);
            assert_eq!(world.bodies().velocities, free.bodies().velocities);
            assert_eq!(advance(&mut world).energy.started, 0.0);
        }
    }
}

/// Before its frame it is a wall to a ball, which comes back as fast, and does not break.
#[test]
fn what_waits_for_its_frame_bears_every_blow() {
    let pattern = PatternDesc::Voronoi(Voronoi::default());
    let target = BodyDesc {
        starts: at_frame(60),
        restitution: 1.0,
        breaking: Some(BreakingDesc::once(1.0, pattern)),
        ..block([0.4; 3], [1.0, 0.0, 0.0])
    };
    let mut world = build(&floating([ball([0.0; 3], 5.0), target]));
    for _ in 0..20 {
        assert!(advance(&mut world).fractures.is_empty());
    }
    let bodies = world.bodies();
    assert!((bodies.velocities[0].linear.x + 5.0).abs() < 1e-6, "{:?}", bodies.velocities[0]);
    assert_eq!(bodies.poses[1].position, DVec3::X);
}

/// Balls of equal mass exchange their velocities: a waiting one leaves with all of it, in the frame
/// of the blow, as one that is free from the start does.
#[test]
fn a_blow_does_to_what_waits_what_it_does_to_a_free_body() {
    for speed in [0.021, 0.31, 5.1, 80.0] {
        let row = |starts| {
            let target = BodyDesc { starts, ..ball([0.3, 0.0, 0.0], 0.0) };
            build(&floating([ball([0.0; 3], speed), target]))
        };
        let (mut free, mut world) = (row(None), row(STRUCK));
        let mut moved = None;
        for frame in 0..400 {
            let was_waiting = waiting(&world)[1];
            advance(&mut free);
            advance(&mut world);
            assert_eq!(world.bodies().poses, free.bodies().poses, "{speed} m/s, frame {frame}");
            assert_eq!(world.bodies().velocities, free.bodies().velocities);
            let moves = world.bodies().velocities[1].linear.x > 0.0;
            assert!(was_waiting || moved.is_some() == moves, "{speed} m/s, frame {frame}");
            moved = moved.or(moves.then_some(frame));
        }
        // 0.1 m of way, in frames of 1/30 s.
        let arrives = (0.1 / speed * 30.0) as usize;
        assert_eq!(moved, (arrives < 400).then_some(arrives), "{speed} m/s");
        let leaves = world.bodies().velocities[1].linear.x;
        assert!(moved.is_none() || (leaves / speed - 1.0).abs() < 1e-5, "{leaves} of {speed}");
    }
}

/// In a row with gaps the last ball leaves in the frame of the blow, if the way is short enough:
/// momentum passes through balls that waited when the frame began.
#[test]
fn a_blow_passes_on_through_others_within_the_frame() {
    // One free ball among those that wait.
    for free in [None, Some(2)] {
        let waiting = |number: usize| BodyDesc {
            starts: if free == Some(number) { None } else { STRUCK },
            ..ball([0.21 * number as f64, 0.0, 0.0], 0.0)
        };
        let mut world =
            build(&floating([ball([0.0; 3], 20.0)].into_iter().chain((1..6).map(waiting))));
        advance(&mut world);
        let speeds: Vec<f64> =
            world.bodies().velocities.iter().map(|velocity| velocity.linear.x).collect();
        assert!(speeds[..5].iter().all(|speed| speed.abs() < 1e-3), "{free:?}: {speeds:?}");
        assert!((speeds[5] - 20.0).abs() < 1e-3, "{free:?}: {speeds:?}");
    }
}

/// Without gravity and apart, bodies that wait and bodies that rest are the same: of random boxes
/// and balls that a ball flies into the same ones move, in the same frames and the same way, up to
/// the points that contacts keep from frame to frame, and the number of substeps.
#[test]
fn random_bodies_move_as_if_they_had_been_free() {
    let mut state = 7_u64;
    let mut random = || {
        state =
            state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as f64 / f64::from(1_u32 << 31)
    };
    let (mut started, mut in_vain) = (0, 0);
    for number in 0..60 {
        let speed = [3.0, 6.0, 40.0][number % 3];
        let mut bodies = vec![ball([-1.0, 0.05, 0.02], speed)];
        for cell in 0..8 {
            let place = [cell & 1, cell >> 1 & 1, cell >> 2]
                .map(|side| 0.3 * f64::from(side) - 0.15 + 0.06 * random());
            let shape = if random() < 0.5 {
                ball([0.0; 3], 0.0).shape
            } else {
                block([0.14, 0.2, 0.1], place).shape
            };
            bodies.push(BodyDesc {
                position: place,
                orientation: [random(), random(), random(), 1.0],
                density: 500.0 + 4000.0 * random(),
                restitution: random(),
                ..BodyDesc::new("body", shape)
            });
        }
        // Those that start in each other are no bodies at rest.
        let free = floating(bodies);
        if !build(&free).penetrations().is_empty() {
            continue;
        }
        let mut waits = free.clone();
        waits.bodies.iter_mut().skip(1).for_each(|body| body.starts = STRUCK);
        let (mut free, mut world) = (build(&free), build(&waits));
        for frame in 0..7 {
            step(&mut free);
            advance(&mut world);
            let (bodies, others, wait) = (world.bodies(), free.bodies(), waiting(&world));
            for i in 0..bodies.len() {
                let apart = bodies.poses[i].position.distance(others.poses[i].position);
                let moves = others.velocities[i].linear.length();
                let near = if speed < 10.0 { 0.02 } else { f64::INFINITY };
                assert!(apart < near, "{apart} m in scene {number}, frame {frame}, body {i}");
                assert!(
                    !wait[i] || moves < 1e-3 || speed > 10.0 && frame > 0,
                    "{moves} m/s in scene {number}, body {i}"
                );
            }
        }
        let moves = |i: &usize| free.bodies().velocities[*i].linear != DVec3::ZERO;
        let has_started = |i: &usize| !waiting(&world)[*i];
        started += (1..9).filter(has_started).count();
        in_vain += (1..9).filter(|i| has_started(i) && !moves(i)).count();
    }
    assert!((40..250).contains(&started), "{started}");
    assert!(in_vain == 0, "{in_vain} of {started}");
}

/// It breaks in the frame in which it is struck, like a body that is free; the pieces fly.
#[test]
fn what_waits_breaks_in_the_frame_of_the_blow() {
    let wall = |starts| {
        let pattern = PatternDesc::Voronoi(Voronoi::default());
        let wall = BodyDesc {
            starts,
            breaking: Some(BreakingDesc::once(10.0, pattern)),
            ..block([0.2, 1.0, 1.0], [1.0, 0.0, 0.0])
        };
        build(&floating([ball([0.0; 3], 30.0), wall]))
    };
    let (mut free, mut world) = (wall(None), wall(STRUCK));
    let mut broken = 0;
    for frame in 0..20 {
        let (of_free, report) = (advance(&mut free), advance(&mut world));
        assert_eq!(report.fractures.len(), of_free.fractures.len(), "frame {frame}");
        broken += report.fractures.len();
        if let [fracture] = &report.fractures[..] {
            assert!(fracture.fragments.len() > 5);
            assert!(fracture.imbalance.momentum < 1e-12);
        }
        assert_eq!(world.bodies().poses, free.bodies().poses, "frame {frame}");
    }
    assert_eq!((broken, waiting(&world).contains(&true)), (1, false));
}

/// Neither what rests on it, nor what leans on it, nor what rolls over it or is put down on it
/// starts a waiting body; a drop of a centimetre does.
#[test]
fn rest_is_no_blow_and_a_drop_is() {
    let table = || BodyDesc { starts: STRUCK, ..block([2.0, 0.2, 2.0], [0.0, 1.0, 0.0]) };
    let on_it = |height: f64| block([0.2; 3], [0.5, 1.2 + height, 0.0]);
    let stack = (0..5).map(|level| block([0.2; 3], [-0.5, 1.2 + 0.2 * f64::from(level), 0.0]));
    let rolls = BodyDesc { restitution: 0.0, ..ball([0.0, 1.2, 0.5], 1.0) };
    let bodies = [table(), on_it(0.0), rolls].into_iter().chain(stack);
    let mut world = build(&scene(bodies));
    for frame in 0..30 {
        advance(&mut world);
        assert!(waiting(&world)[0], "frame {frame}");
    }
    for (height, waits) in [(1e-4, true), (0.01, false)] {
        let mut world = build(&scene([table(), on_it(height)]));
        (0..10).for_each(|_| drop(advance(&mut world)));
        assert_eq!(waiting(&world)[0], waits, "from {height} m");
    }
}

/// A wall of waiting bricks stands in the air. One that is hit starts the wall, but not a brick
/// that stands apart, nor one that waits for a frame.
#[test]
fn those_that_touch_start_together() {
    let bricks = (0..12).map(|number| {
        let (column, course) = (number % 3, number / 3);
        let place = [0.0, 0.05 + 0.1 * f64::from(course), 0.2 * f64::from(column)];
        BodyDesc { starts: STRUCK, ..block([0.1, 0.1, 0.2], place) }
    });
    let apart = BodyDesc { starts: STRUCK, ..block([0.1, 0.1, 0.2], [0.0, 0.05, 0.63]) };
    let later = BodyDesc { starts: at_frame(90), ..block([0.1, 0.1, 0.2], [0.0, 0.45, 0.0]) };
    let bodies = [BodyDesc::ground(0.0), ball([-0.4, 0.15, 0.0], 3.0), apart, later];
    let mut world = build(&scene(bodies.into_iter().chain(bricks)));
    let all = world.bodies().len() - 2;
    let mut frame = 0;
    while advance(&mut world).waiting == all {
        frame += 1;
        assert!(frame < 10);
    }
    assert_eq!(frame, 2);
    let wait = waiting(&world);
    assert_eq!(wait.iter().filter(|&&waits| waits).count(), 2, "{wait:?}");
    assert!(wait[2] && wait[3]);
}

/// A hammer on a path hits however slowly it comes, and is not slowed.
#[test]
fn a_driven_body_hits() {
    for speed in [0.01, 4.0] {
        let key = |frame: f64, x: f64| KeyframeDesc {
            frame,
            position: [x, 0.0, 0.0],
            orientation: [0.0, 0.0, 0.0, 1.0],
        };
        let hammer = BodyDesc {
            motion: MotionDesc::Kinematic,
            path: vec![key(0.0, 0.0), key(300.0, 10.0 * speed)],
            ..block([0.2; 3], [0.0; 3])
        };
        // Its face is one frame and a half away.
        let x = 0.2 + 1.5 * speed / 30.0;
        let target = BodyDesc { starts: STRUCK, ..block([0.2; 3], [x, 0.0, 0.0]) };
        let mut world = build(&floating([hammer, target]));
        advance(&mut world);
        assert!(waiting(&world)[1], "{speed} m/s");
        advance(&mut world);
        assert!(!waiting(&world)[1], "{speed} m/s");
        (0..10).for_each(|_| drop(advance(&mut world)));
        let target = &world.bodies().velocities[1];
        assert!(target.linear.x >= speed - 1e-4, "{speed} m/s: {target:?}");
    }
}

/// A glued body holds, whatever its weight, until its blow, and then loses bonds.
#[test]
fn glue_holds_until_the_blow() {
    let bonds = BondsDesc {
        pattern: Some(PatternDesc::Voronoi(Voronoi::default())),
        point: None,
        normal: [0.0, 1.0, 0.0],
        tensile_strength: 1e4,
        shear_strength: 1e4,
        anchors: Vec::new(),
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    };
    let glued =
        BodyDesc { starts: STRUCK, bonds: Some(bonds), ..block([0.2, 1.0, 1.0], [1.0, 2.0, 0.0]) };
    let striker = ball([-1.0, 2.2, 0.0], 20.0);
    let mut world = build(&scene([BodyDesc::ground(0.0), glued, striker]));
    let hits = (0..10).find(|_| advance(&mut world).waiting == 0);
    assert_eq!(hits, Some(2));
    (0..10).for_each(|_| drop(advance(&mut world)));
    assert!(world.bodies().len() > 5, "{}", world.bodies().len());
}

/// What sleeps on a body wakes when that starts.
#[test]
fn what_sleeps_on_it_wakes_when_it_starts() {
    let table = BodyDesc { starts: at_frame(90), ..block([2.0, 0.2, 2.0], [0.0, 1.0, 0.0]) };
    let top = block([0.2; 3], [0.0, 1.2, 0.0]);
    let mut world = build(&SceneDesc { sleep: true, ..scene([table, top]) });
    (0..90).for_each(|_| drop(advance(&mut world)));
    assert!(world.is_asleep(ids(&world)[1]));
    (0..10).for_each(|_| drop(advance(&mut world)));
    assert!(!world.is_asleep(ids(&world)[1]));
    assert!(world.bodies().velocities[1].linear.y < -2.0);
}

/// By hand, with the velocity that was described.
#[test]
fn a_caller_may_start_it() {
    let mut world = build(&floating([BodyDesc { starts: at_frame(99), ..ball([0.0; 3], 2.0) }]));
    let id = ids(&world)[0];
    let refused = world.set_velocity(id, DVec3::X, DVec3::ZERO).unwrap_err();
    assert_eq!(refused.to_string(), "body: waiting, must be started before");
    advance(&mut world);
    assert!(world.start(id) && !world.start(id));
    step(&mut world);
    assert!((world.bodies().poses[0].position.x - 2.0 / 30.0).abs() < 1e-12);
}

/// What cannot wait is refused in a sentence.
#[test]
fn what_cannot_wait_is_refused() {
    let refused = |body: BodyDesc, method: Method| {
        World::build(&SceneDesc { method, ..scene([body]) }).unwrap_err().to_string()
    };
    let body = || ball([0.0; 3], 0.0);
    let both = Some(StartsDesc { when: Some(StartsWhen::Struck), ..at_frame(3).unwrap() });
    let neither = Some(StartsDesc::default());
    let cases = [
        (BodyDesc { starts: both, ..body() }, "starts: with both 'frame' and 'when', must be"),
        (BodyDesc { starts: neither, ..body() }, "starts: with neither 'frame' nor 'when', must"),
        (
            BodyDesc { starts: STRUCK, ..ball([0.0; 3], 1.0) },
            "starts.when: struck, must be left out on a body with an initial velocity",
        ),
        (
            BodyDesc { starts: at_frame(1), motion: MotionDesc::Kinematic, ..body() },
            "starts: on a kinematic body, must be left out: before its first key a path stands",
        ),
        (
            BodyDesc { starts: STRUCK, motion: MotionDesc::Static, ..body() },
            "starts: on a static body, must be left out, or the body dynamic",
        ),
    ];
    for (body, sentence) in cases {
        let said = refused(body, Method::FrameRate);
        assert!(said.contains(sentence), "{said}");
    }
    let said = refused(BodyDesc { starts: STRUCK, ..body() }, Method::Paper);
    assert!(
        said.contains("starts.when: struck, must be a frame, with the paper's method"),
        "{said}"
    );
}

/// Of a wall that waits and is hit, on one thread and on four.
#[test]
fn threads_change_no_bit() {
    let bricks = (0..300).map(|number| {
        let (column, course) = (number % 20, number / 20);
        let shift = 0.1 * f64::from(course % 2);
        let place = [0.0, 0.05 + 0.1 * f64::from(course), 0.201 * f64::from(column) + shift];
        BodyDesc { starts: STRUCK, ..block([0.1, 0.1, 0.2], place) }
    });
    let bodies = [BodyDesc::ground(0.0), ball([-0.5, 0.8, 2.0], 20.0)];
    let scene = scene(bodies.into_iter().chain(bricks));
    let hash = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let mut world = build(&scene);
            (0..6).for_each(|_| drop(step(&mut world)));
            assert!(!waiting(&world).contains(&true));
            world.state_hash()
        })
    };
    assert_eq!(hash(1), hash(4));
}
