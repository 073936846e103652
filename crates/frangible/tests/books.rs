//! Every joule is booked: what the stages say they did to the energy is what happened to it.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, Method, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};

/// A ball breaks a slab on a turning plate, over the ground: all causes have something to do.
fn scene(method: Method) -> SceneDesc {
    let sampled = Resolution { voxels: Some([24, 6, 24]), sample_spacing: Some(0.1) };
    let cuboid = |size, resolution| ShapeDesc::Box { size, resolution };
    let pattern = PatternDesc::Voronoi(Voronoi { cells: 12, clustering: 1.0, seed: 3, ..Voronoi::default() });
    let mut scene = SceneDesc::new("books");
    scene.method = method;
    scene.bodies = vec![
        BodyDesc::ground(0.0),
        BodyDesc {
            motion: MotionDesc::Kinematic,
            position: [0.0, 0.5, 0.0],
            linear_velocity: [0.0, 0.2, 0.0],
            angular_velocity: [0.0, 1.5, 0.0],
            ..BodyDesc::new("plate", cuboid([3.0, 0.2, 3.0], Resolution::default()))
        },
        BodyDesc {
            position: [0.0, 0.9, 0.0],
            breaking: Some(BreakingDesc::once(400.0, pattern)),
            ..BodyDesc::new("slab", cuboid([1.2, 0.3, 1.2], sampled))
        },
        BodyDesc {
            position: [0.1, 3.0, 0.2],
            linear_velocity: [0.0, -8.0, 0.0],
            angular_velocity: [4.0, 0.0, 9.0],
            ..BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.25, resolution: Resolution::default() })
        },
    ];
    scene
}

#[test]
fn the_causes_add_up_to_the_change_of_the_energy() {
    for method in [Method::Paper, Method::FrameRate] {
        let mut world = World::build(&scene(method)).unwrap();
        let (kinetic, potential) = world.energy();
        let (mut before, mut scale) = (kinetic + potential, 0.0_f64);
        let mut total = frangible::Causes::default();
        for _ in 0..60 {
            let energy = step(&mut world).energy;
            let causes = energy.causes;
            let sum = causes.work
                + causes.collision
                + causes.contact
                + causes.friction
                + causes.projection
                + causes.fracture
                + causes.balance;
            scale = scale.max(energy.kinetic + energy.potential.abs());
            let error = energy.total - before - sum;
            assert!(error.abs() < 1e-11 * scale, "{method:?}: {error} J are nobody's, {causes:?}");
            before = energy.total;
            total.work += causes.work.abs();
            total.collision += causes.collision.abs();
            total.contact += causes.contact.abs();
            total.friction += causes.friction.abs();
            total.projection += causes.projection.abs();
            total.fracture += causes.fracture.abs();
        }
        assert!(total.fracture < 1e-9 * scale, "{method:?}: breaking conserves, {} J", total.fracture);
        for (name, cause) in [
            ("work", total.work),
            ("collision", total.collision),
            ("contact", total.contact),
            ("friction", total.friction),
            ("projection", total.projection),
        ] {
            assert!(cause > 1e-6 * scale, "{method:?}: {name} is in play");
        }
    }
}
