//! Bodies that a caller pushes, holds, cuts and breaks between frames.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BodyId, BondsDesc, BreakingDesc, MaterialName, PatternDesc, Resolution, SceneDesc,
    ShapeDesc, StartsDesc, StrengthDesc, World, id_number, step,
};
use glam::DVec3;

fn cuboid(size: [f64; 3]) -> BodyDesc {
    let shape = ShapeDesc::Box { size, resolution: Resolution::default() };
    BodyDesc { density: 1000.0, ..BodyDesc::new("block", shape) }
}

fn voronoi() -> PatternDesc {
    PatternDesc::Voronoi(Voronoi { cells: 20, ..Voronoi::default() })
}

fn breakable(body: BodyDesc) -> BodyDesc {
    let strength = StrengthDesc::Named(MaterialName::Concrete);
    BodyDesc { breaking: Some(BreakingDesc::once(strength, voronoi())), ..body }
}

fn glued(body: BodyDesc) -> BodyDesc {
    let bonds = BondsDesc {
        pattern: Some(voronoi()),
        point: None,
        normal: [0.0, 1.0, 0.0],
        tensile_strength: 1e9,
        shear_strength: 1e9,
        anchors: Vec::new(),
        strength_points: Vec::new(),
        strength_triangles: Vec::new(),
    };
    BodyDesc { bonds: Some(bonds), ..body }
}

/// One body, without gravity.
fn in_space(body: BodyDesc) -> (World, BodyId) {
    let mut scene = SceneDesc::new("space");
    scene.gravity = [0.0; 3];
    scene.bodies = vec![body];
    let world = World::build(&scene).unwrap();
    let id = world.bodies().ids[0];
    (world, id)
}

fn on_the_ground(body: BodyDesc) -> (World, BodyId) {
    let mut scene = SceneDesc::new("ground");
    scene.sleep = true;
    scene.bodies = vec![BodyDesc::ground(0.0), body];
    let world = World::build(&scene).unwrap();
    let id = world.bodies().ids[1];
    (world, id)
}

/// Momentum, and angular momentum about the origin.
fn momenta(world: &World) -> (DVec3, DVec3) {
    let bodies = world.bodies();
    (0..bodies.len()).fold((DVec3::ZERO, DVec3::ZERO), |(linear, angular), i| {
        let momentum = bodies.masses[i] * bodies.velocities[i].linear;
        let orbital = bodies.poses[i].position.cross(momentum);
        (linear + momentum, angular + orbital + bodies.velocities[i].angular_momentum)
    })
}

fn place(world: &World, id: BodyId, point_body: DVec3) -> DVec3 {
    let dense = world.bodies().index_of(id).unwrap();
    world.bodies().poses[dense].world_from_body().point(point_body)
}

#[test]
fn an_impulse_does_the_work_that_the_formula_says() {
    // 1000 x 1 x 2 x 3 kg; moments m (b^2 + c^2) / 12.
    let (mut world, id) = in_space(cuboid([1.0, 2.0, 3.0]));
    let (mass, about_z) = (6000.0, 6000.0 * 5.0 / 12.0);
    let work = world.apply_impulse(id, DVec3::new(0.0, 900.0, 0.0), DVec3::X).unwrap();
    let expected = 900.0 * 900.0 / (2.0 * mass) + 900.0 * 900.0 / (2.0 * about_z);
    assert!((work - expected).abs() < 1e-12 * expected, "{work} for {expected}");
    assert_eq!(world.bodies().velocities[0].linear, DVec3::new(0.0, 0.15, 0.0));
    assert_eq!(world.bodies().velocities[0].angular_momentum, DVec3::new(0.0, 0.0, 900.0));

    let report = step(&mut world);
    assert!((report.energy.work - work).abs() < 1e-12 * work);
    assert!((report.energy.causes.work - work).abs() < 1e-12 * work);
    assert!((report.energy.kinetic - work).abs() < 1e-12 * work);
    assert!(report.energy.gain.abs() < 1e-12 * work, "{:?}", report.energy);
    assert!(report.momentum.linear_error < 1e-14);
    assert_eq!(step(&mut world).energy.work, 0.0);
}

#[test]
fn a_push_wakes_what_sleeps() {
    let (mut world, id) = on_the_ground(BodyDesc { position: [0.0, 0.5, 0.0], ..cuboid([1.0; 3]) });
    (0..60).for_each(|_| _ = step(&mut world));
    assert!(world.is_asleep(id));
    world.apply_impulse(id, DVec3::Y * 5000.0, place(&world, id, DVec3::ZERO)).unwrap();
    step(&mut world);
    assert!(place(&world, id, DVec3::ZERO).y > 0.6);
}

/// While the hand is too weak to follow, its force is the bound: F t / m.
#[test]
fn a_weak_hand_accelerates_by_its_force() {
    let (mut world, id) = in_space(cuboid([1.0; 3]));
    world.hold(id, DVec3::ZERO, DVec3::X * 1e3, 2000.0).unwrap();
    let mut work = 0.0;
    for _ in 0..30 {
        let report = step(&mut world);
        work += report.energy.work;
        assert!(report.energy.gain.abs() < 1e-9);
    }
    let speed = 2000.0 * 30.0 * world.dt() / 1000.0;
    let velocity = world.bodies().velocities[0].linear;
    assert!((velocity - speed * DVec3::X).length() < 1e-12, "{velocity}");
    assert!((work - 500.0 * speed * speed).abs() < 1e-9 * work);
    assert!(world.let_go(id) && !world.let_go(id));
    assert_eq!(step(&mut world).energy.work, 0.0);
}

/// A strong hand lifts a body to where it points, and holds it there; one that is weaker than its
/// weight leaves it on the ground.
#[test]
fn a_hand_lifts_what_it_is_strong_enough_for() {
    let weight = 1000.0 * 9.81;
    // The force of a frame acts at its start: what it cannot lift hops by millimetres.
    for (force, expected, tolerance) in [(5.0 * weight, 2.0, 2e-3), (0.9 * weight, 0.5, 1e-2)] {
        let (mut world, id) =
            on_the_ground(BodyDesc { position: [0.0, 0.5, 0.0], ..cuboid([1.0; 3]) });
        world.hold(id, DVec3::ZERO, DVec3::new(0.0, 2.0, 0.0), force).unwrap();
        let before = {
            let (kinetic, potential) = world.energy();
            kinetic + potential
        };
        let (mut work, mut last) = (0.0, 0.0);
        for _ in 0..60 {
            let report = step(&mut world);
            work += report.energy.work;
            last = report.energy.total;
            assert!(report.energy.gain < 1e-6, "{:?}", report.energy);
        }
        let height = place(&world, id, DVec3::ZERO).y;
        assert!((height - expected).abs() < tolerance, "{force} N: {height} m");
        if expected > 1.0 {
            // It fell nowhere: all work is in its height.
            assert!((work - (last - before)).abs() < 1e-6 * work, "{work} J");
        }
    }
}

/// Held by an edge it swings below the hand, and never with more energy than it was given.
#[test]
fn a_body_held_by_an_edge_hangs() {
    let mut scene = SceneDesc::new("hang");
    scene.bodies = vec![BodyDesc { position: [0.0, 5.0, 0.0], ..cuboid([1.0, 0.2, 0.2]) }];
    let mut world = World::build(&scene).unwrap();
    let id = world.bodies().ids[0];
    let edge = DVec3::new(0.5, 0.1, 0.1);
    world.hold(id, edge, place(&world, id, edge), 1e4).unwrap();
    let (mut most, mut away) = (f64::NEG_INFINITY, 0.0f64);
    let first = world.energy().1;
    for _ in 0..900 {
        most = most.max(step(&mut world).energy.total);
        away = away.max(place(&world, id, edge).distance(DVec3::new(0.5, 5.1, 0.1)));
    }
    let fall = 40.0 * 9.81;
    assert!(most - first < 0.02 * fall, "{} J came out of the hand", most - first);
    assert!(away < 0.1, "the hand slipped by {away} m");
    let center = place(&world, id, DVec3::ZERO);
    assert!(center.y < 5.0, "hangs at {center}");
}

#[test]
fn a_cut_keeps_mass_and_motion() {
    let moving = BodyDesc {
        position: [1.0, 2.0, 3.0],
        linear_velocity: [1.0, -2.0, 3.0],
        angular_velocity: [0.5, 2.0, -1.0],
        ..cuboid([1.0, 2.0, 3.0])
    };
    let voxels = BodyDesc {
        shape: ShapeDesc::Box {
            size: [1.0, 2.0, 3.0],
            resolution: Resolution { voxels: Some([10, 20, 30]), ..Resolution::default() },
        },
        ..moving.clone()
    };
    for (body, tolerance) in [(moving.clone(), 1e-12), (breakable(moving), 1e-12), (voxels, 1e-6)] {
        let (mut world, id) = in_space(body);
        let (before, energy) = (momenta(&world), world.energy().0);
        let whole = world.bodies().masses[0];
        // A quarter of its height is above.
        let pieces = world.cut(id, DVec3::new(9.0, 2.5, 0.0), DVec3::Y * 7.0).unwrap();
        assert_eq!(pieces.len(), 2);
        let masses = &world.bodies().masses;
        let mut shares = [masses[0] / whole, masses[1] / whole];
        shares.sort_by(f64::total_cmp);
        assert!((shares[0] + shares[1] - 1.0).abs() < tolerance);
        assert!((shares[0] - 0.25).abs() < tolerance.max(1e-5), "{shares:?}");
        let after = momenta(&world);
        assert!((after.0 - before.0).length() < tolerance * before.0.length());
        assert!((after.1 - before.1).length() < tolerance.max(1e-9) * before.1.length());
        assert!((world.energy().0 - energy).abs() < tolerance * energy);
        let report = step(&mut world);
        assert_eq!(report.fractures.len(), 1);
        let told = &report.fractures[0];
        assert_eq!((told.body, told.striker), (id_number(id), id_number(id)));
        let ids: Vec<u64> = pieces.iter().map(|&piece| id_number(piece)).collect();
        assert_eq!(told.fragments, ids);
        assert!(report.energy.gain.abs() < 1e-9 * energy);
        assert!(step(&mut world).fractures.is_empty());
    }
}

#[test]
fn a_plane_beside_a_body_cuts_nothing() {
    let (mut world, id) = in_space(breakable(cuboid([1.0; 3])));
    let hash = world.state_hash();
    assert!(world.cut(id, DVec3::Y * 0.6, DVec3::Y).unwrap().is_empty());
    assert_eq!(world.state_hash(), hash);
    assert!(step(&mut world).fractures.is_empty());
}

/// Halves of halves: the pieces of a cut body break as it would have.
#[test]
fn pieces_of_a_cut_break_by_the_pattern() {
    let (mut world, id) = in_space(breakable(cuboid([1.0; 3])));
    let halves = world.cut(id, DVec3::ZERO, DVec3::X).unwrap();
    let quarters = world.cut(halves[0], DVec3::ZERO, DVec3::Y).unwrap();
    let pieces = world.burst(quarters[1], place(&world, quarters[1], DVec3::ZERO), 0.0).unwrap();
    assert!(pieces.len() > 5, "{} pieces", pieces.len());
    // Once was all that it could break.
    let told = world.burst(pieces[0], DVec3::ZERO, 0.0).unwrap_err().to_string();
    let rule = "must be breakable: raise `generations` of its `breaking`, or cut it";
    assert_eq!(told, format!("body: a piece that breaks no further, {rule}"));
    assert_eq!(step(&mut world).fractures.len(), 3);
}

/// Pieces fly apart from the centre, and neither momentum changes.
#[test]
fn a_burst_keeps_momenta_and_books_its_work() {
    let moving = BodyDesc {
        linear_velocity: [1.0, -2.0, 3.0],
        angular_velocity: [0.0, 2.0, 0.0],
        ..cuboid([1.0, 2.0, 3.0])
    };
    for body in [breakable(moving.clone()), glued(moving)] {
        let (mut world, id) = in_space(body);
        let (before, energy) = (momenta(&world), world.energy().0);
        let pieces = world.burst(id, DVec3::new(0.0, 0.0, 1.5), 5.0).unwrap();
        assert!(pieces.len() > 3, "{} pieces", pieces.len());
        let after = momenta(&world);
        assert!((after.0 - before.0).length() < 1e-9 * before.0.length());
        assert!((after.1 - before.1).length() < 1e-9 * before.1.length());
        let given = world.energy().0 - energy;
        assert!(given > 0.0);
        let report = step(&mut world);
        assert!((report.energy.work - given).abs() < 1e-9 * given, "{:?}", report.energy);
        assert!(report.energy.gain < 1e-6 * given, "{:?}", report.energy);
    }
}

#[test]
fn a_glued_body_comes_apart_along_a_plane() {
    let (mut world, id) = in_space(glued(cuboid([1.0, 2.0, 1.0])));
    let before = world.bodies().masses[0];
    let parts = world.cut(id, DVec3::ZERO, DVec3::Y).unwrap();
    assert!(parts.len() >= 2, "{} parts", parts.len());
    let sum: f64 = world.bodies().masses.iter().sum();
    assert!((sum - before).abs() < 1e-9 * before);
}

/// Not before it starts: its pieces would not have its velocity.
#[test]
fn what_waits_is_not_parted() {
    for body in [breakable(cuboid([1.0; 3])), glued(cuboid([1.0; 3]))] {
        let starts = Some(StartsDesc { frame: Some(2), when: None });
        let (mut world, id) = in_space(BodyDesc { starts, ..body });
        let told = world.cut(id, DVec3::ZERO, DVec3::Y).unwrap_err().to_string();
        assert_eq!(told, "body: waiting, must be started before");
        assert!(world.burst(id, DVec3::ZERO, 1.0).is_err());
        step(&mut world);
        step(&mut world);
        step(&mut world);
        assert!(world.cut(id, DVec3::ZERO, DVec3::Y).unwrap().len() > 1);
    }
}

/// What the next report is to tell, and what is held, are part of a snapshot.
#[test]
fn snapshots_hold_what_hands_did() {
    let (mut world, id) =
        on_the_ground(breakable(BodyDesc { position: [0.0, 1.0, 0.0], ..cuboid([1.0; 3]) }));
    world.hold(id, DVec3::ZERO, DVec3::Y, 1.0).unwrap();
    let halves = world.cut(id, DVec3::Y, DVec3::new(1.0, 2.0, 0.0)).unwrap();
    assert!(!world.let_go(id), "what was cut slips out of the hand");
    world.hold(halves[0], DVec3::ZERO, DVec3::new(0.5, 2.0, 0.0), 1e5).unwrap();
    world.apply_impulse(halves[1], DVec3::Z * 500.0, DVec3::Y).unwrap();
    let mut other = World::restore(&world.snapshot().unwrap()).unwrap();
    for frame in 0..40 {
        let (expected, report) = (step(&mut world), step(&mut other));
        assert_eq!(world.state_hash(), other.state_hash(), "frame {frame}");
        assert_eq!(report.energy, expected.energy);
        assert_eq!(report.fractures, expected.fractures);
        assert!(report.energy.gain < 1e-6, "{:?}", report.energy);
    }
}

#[test]
fn errors_name_the_field_and_the_rule() {
    let (mut world, ground) = on_the_ground(cuboid([1.0; 3]));
    let block = ground;
    let ground = world.bodies().ids[0];
    let told = |result: Result<(), frangible::BuildError>| result.unwrap_err().to_string();
    let push = world.apply_impulse(ground, DVec3::X, DVec3::ZERO).map(|_| ());
    assert_eq!(told(push), "body: static, must be dynamic");
    let fast = world.apply_impulse(block, DVec3::X * 1e11, DVec3::ZERO).map(|_| ());
    assert!(told(fast).starts_with("impulse: [100000000000.0, 0.0, 0.0], must be one that leaves"));
    let nowhere = world.hold(block, DVec3::ZERO, DVec3::NAN, 1.0);
    assert!(told(nowhere).starts_with("target: [NaN, NaN, NaN], must be three numbers"));
    assert!(told(world.hold(block, DVec3::ZERO, DVec3::ZERO, 0.0)).starts_with("force: 0.0"));
    let flat = world.cut(block, DVec3::ZERO, DVec3::ZERO).map(|_| ());
    assert_eq!(told(flat), "normal: [0.0, 0.0, 0.0], must be longer than 0");
    let whole = world.burst(block, DVec3::ZERO, 0.0).map(|_| ());
    assert_eq!(told(whole), "body: unbreakable, must be breakable");
    let shape = ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() };
    let ball = world.add_body(&BodyDesc::new("ball", shape)).unwrap();
    let round = world.cut(ball, DVec3::ZERO, DVec3::X).map(|_| ());
    assert!(told(round).starts_with("body: round and unbreakable, must be a polyhedron"));
}
