//! Bodies of revolution that spin past meshes, roll fast, and fall on thin ground.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World};
use glam::DVec3;
use proptest::prelude::*;

/// A capsule, a cylinder or a cone.
fn round(kind: usize, radius: f64, height: f64) -> ShapeDesc {
    let resolution = Resolution::default();
    match kind {
        0 => ShapeDesc::Capsule { radius, height, resolution },
        1 => ShapeDesc::Cylinder { radius, height, resolution },
        _ => ShapeDesc::Cone { radius, height, resolution },
    }
}

/// A square sheet of two triangles in the plane y = 0, of half a side [m].
fn sheet(half: f64) -> BodyDesc {
    let corner = |x: f64, z: f64| [x * half, 0.0, z * half];
    let shape = ShapeDesc::Triangles {
        positions: vec![corner(-1.0, -1.0), corner(-1.0, 1.0), corner(1.0, -1.0), corner(1.0, 1.0)],
        triangles: vec![[0, 1, 3], [0, 3, 2]],
        thickness: None,
        sides: None,
        resolution: Resolution::default(),
    };
    fixed(shape, 0.0)
}

fn fixed(shape: ShapeDesc, y: f64) -> BodyDesc {
    BodyDesc {
        motion: MotionDesc::Static,
        position: [0.0, y, 0.0],
        friction: 0.6,
        restitution: 0.0,
        ..BodyDesc::new("ground", shape)
    }
}

/// Position and velocity of the second of two bodies after some frames.
fn run(bodies: [BodyDesc; 2], gravity: f64, frames: u32) -> [DVec3; 2] {
    let scene = SceneDesc {
        bodies: bodies.into(),
        gravity: [0.0, -gravity, 0.0],
        ..SceneDesc::new("round bodies")
    };
    let mut world = World::build(&scene).unwrap();
    for _ in 0..frames {
        frangible::step(&mut world);
    }
    let bodies = world.bodies();
    [bodies.poses[1].position, bodies.velocities[1].linear]
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    /// What spins over a mesh, higher than any of its points reach, is not touched.
    #[test]
    fn what_spins_past_a_mesh_is_not_moved(
        kind in 0..3_usize,
        turn in prop::array::uniform4(-1.0..1.0f64),
        spin in prop::array::uniform3(-15.0..15.0f64),
        height in 0.1..1.0f64,
        gap in 2e-3..0.04f64,
        aside in -0.5..0.5f64,
    ) {
        let radius = 0.25;
        let reach = match kind {
            0 => radius + 0.5 * height,
            1 => radius.hypot(0.5 * height),
            _ => radius.hypot(0.25 * height).max(0.75 * height),
        };
        let body = BodyDesc {
            position: [-1.0, reach + gap, aside],
            orientation: turn,
            linear_velocity: [1.0, 0.0, 0.0],
            angular_velocity: spin,
            ..BodyDesc::new("body", round(kind, radius, height))
        };
        let [_, velocity] = run([sheet(0.5), body], 0.0, 60);
        prop_assert!((velocity - DVec3::X).length() < 1e-12, "{velocity}");
    }

    /// Short and slender ones roll on at hundreds of radians per second, and do not hop.
    #[test]
    fn what_rolls_fast_rolls_on(
        kind in 0..2_usize,
        radius in 0.01..0.05f64,
        slender in 0.2..4.0f64,
        spin in 100.0..1500.0f64,
    ) {
        let speed = (spin * radius).min(30.0);
        let half = std::f64::consts::FRAC_1_SQRT_2;
        let body = BodyDesc {
            position: [0.0, radius, 0.0],
            orientation: [half, 0.0, 0.0, half],
            linear_velocity: [speed, 0.0, 0.0],
            angular_velocity: [0.0, 0.0, -speed / radius],
            friction: 0.6,
            restitution: 0.0,
            ..BodyDesc::new("body", round(kind, radius, slender * radius))
        };
        let ground = ShapeDesc::HalfSpace;
        let [position, velocity] = run([fixed(ground, 0.0), body], 9.81, 60);
        prop_assert!((velocity.x / speed - 1.0).abs() < 2e-3, "{velocity} of {speed} m/s");
        prop_assert!((position.y / radius - 1.0).abs() < 1e-2, "{position}");
    }

    /// What falls on a thin plate or a sheet stays on it.
    #[test]
    fn thin_ground_holds(
        kind in 0..3_usize,
        of_triangles in any::<bool>(),
        turn in prop::array::uniform4(-1.0..1.0f64),
        radius in 0.01..0.05f64,
        slender in 0.5..3.0f64,
        speed in 1.0..10.0f64,
    ) {
        let height = slender * radius;
        let body = BodyDesc {
            position: [0.0, 2.0 * radius.max(height), 0.0],
            orientation: turn,
            linear_velocity: [0.0, -speed, 0.0],
            friction: 0.6,
            restitution: 0.0,
            ..BodyDesc::new("body", round(kind, radius, height))
        };
        let plate = ShapeDesc::Box { size: [1.0, 0.01, 1.0], resolution: Resolution::default() };
        let ground = if of_triangles { sheet(0.5) } else { fixed(plate, -0.005) };
        let [position, _] = run([ground, body], 9.81, 40);
        let least = 0.15 * radius.min(height);
        prop_assert!(position.y > least || position.x.abs().max(position.z.abs()) > 0.5, "{position}");
    }
}
