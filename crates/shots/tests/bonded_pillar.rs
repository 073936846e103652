//! A pillar of glued pieces stands, until a ball strikes it.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::geometry::Shape;
use frangible::{BodyDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use frangible_shots::{Shot, ShotOptions};
use glam::DVec3;

fn scene() -> SceneDesc {
    Shot::find("bonded-pillar").unwrap().scene(&ShotOptions::default()).unwrap()
}

/// The pillar alone, its bonds this many times as strong.
fn alone(strength: f64) -> SceneDesc {
    let mut scene = scene();
    scene.bodies.truncate(2);
    let bonds = scene.bodies[1].bonds.as_mut().unwrap();
    bonds.tensile_strength *= strength;
    bonds.shear_strength *= strength;
    scene
}

/// Bodies of the pillar, by dense index.
fn pieces(world: &World) -> impl Iterator<Item = usize> + '_ {
    (0..world.bodies().len()).filter(|&i| world.labels()[i].name.starts_with("pillar"))
}

/// The highest point of the bounds of what was the pillar [m].
fn height(world: &World) -> f64 {
    let top = |i: usize| {
        let (shape, pose): (&Shape, _) = (&world.bodies().shapes[i], &world.bodies().poses[i]);
        let hulls = shape.hull.iter().map(|hull| &**hull);
        let parts =
            shape.compound.iter().flat_map(|compound| compound.parts()).map(|part| &part.hull);
        let corners = hulls.chain(parts).flat_map(|hull| hull.vertices());
        corners.map(|&corner| pose.world_from_body().point(corner).y).fold(0.0, f64::max)
    };
    pieces(world).map(top).fold(0.0, f64::max)
}

/// For ten seconds nothing breaks, and it moves by less than a millimetre.
#[test]
fn it_stands_alone_for_ten_seconds() {
    let mut world = World::build(&alone(1.0)).unwrap();
    let glued = world.labels()[1].bonds.as_ref().unwrap().glued();
    assert!(glued.pieces().len() > 50, "{} pieces", glued.pieces().len());
    let bonds = glued.bonds().len();
    let volume: f64 = glued.pieces().iter().map(|piece| piece.volume).sum();
    assert!((volume - 6.0).abs() < 1e-9, "{volume} m^3");
    let start = world.bodies().poses[1];
    for _ in 0..300 {
        let report = step(&mut world);
        assert!(report.fractures.is_empty() && report.energy.gain <= 1e-9 * report.energy.total);
        let pose = world.bodies().poses[1];
        assert!((pose.position - start.position).length() < 1e-3);
        assert!((pose.orientation - start.orientation).length() < 1e-4);
    }
    assert_eq!(world.labels()[1].bonds.as_ref().unwrap().glued().bonds().len(), bonds);
}

/// The ball breaks it: momentum and energy pass through the break, no mass is lost, and it comes
/// down.
#[test]
fn it_falls_when_the_ball_strikes_it() {
    let mut world = World::build(&scene()).unwrap();
    let mut fractures = Vec::new();
    let mut mass = None;
    for _ in 0..150 {
        let report = step(&mut world);
        let scale = report.energy.total.abs() + report.energy.kinetic;
        assert!(report.energy.gain <= 1e-9 * scale, "{} J", report.energy.gain);
        assert!(report.momentum.linear_error < 1e-9 && report.momentum.angular_error < 1e-9);
        assert!((report.mass / *mass.get_or_insert(report.mass) - 1.0).abs() < 1e-10);
        fractures.extend(report.fractures);
    }
    assert!(!fractures.is_empty());
    for fracture in &fractures {
        let off = fracture.imbalance;
        let worst = off.mass.max(off.momentum).max(off.angular_momentum).max(off.kinetic_energy);
        assert!(worst < 1e-10, "{off:?}");
        assert!(fracture.borne <= fracture.impulse);
    }
    let (count, height) = (pieces(&world).count(), height(&world));
    assert!(count > 20 && height < 4.0, "{count} bodies, {height} m high");
}

/// With bonds of a ten-thousandth of the strength it gives way under its own weight.
#[test]
fn weak_bonds_do_not_carry_its_weight() {
    let mut world = World::build(&alone(1e-4)).unwrap();
    let mut broke = 0;
    for _ in 0..60 {
        broke += step(&mut world).fractures.len();
    }
    assert!(broke > 0 && pieces(&world).count() > 20, "{} bodies", pieces(&world).count());
}

/// The same pieces without bonds come apart when the ball only rolls against them; with bonds they
/// do not.
#[test]
fn without_bonds_it_spreads() {
    let world = World::build(&alone(1.0)).unwrap();
    let hulls = world.labels()[1].bonds.as_ref().unwrap().glued().hulls().to_vec();
    let nudge = BodyDesc {
        position: [-0.85, 5.0, 0.0],
        linear_velocity: [1.5, 0.0, 0.0],
        density: 1500.0,
        ..BodyDesc::new(
            "nudge",
            ShapeDesc::Sphere { radius: 0.3, resolution: Resolution::default() },
        )
    };
    let mut bonded = alone(1.0);
    bonded.bodies.push(nudge.clone());
    let mut loose = alone(1.0);
    loose.bodies.truncate(1);
    for hull in hulls {
        let points = hull.vertices().iter().map(DVec3::to_array).collect();
        let shape = ShapeDesc::Hull { points, resolution: Resolution::default() };
        loose.bodies.push(BodyDesc {
            position: [0.0, 3.0, 0.0],
            restitution: 0.1,
            ..BodyDesc::new("pillar", shape)
        });
    }
    loose.bodies.push(nudge);
    let heights = [bonded, loose].map(|scene| {
        let mut world = World::build(&scene).unwrap();
        (0..120).for_each(|_| drop(step(&mut world)));
        height(&world)
    });
    assert!((heights[0] - 6.0).abs() < 0.01 && heights[1] < 5.0, "{heights:?}");
}
