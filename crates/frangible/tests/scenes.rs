//! What is wrong with a scene is said in one sentence; what cannot be broken does not swallow its collision.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::{
    BodyDesc, BreakingDesc, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc, World, step,
};

fn ball() -> BodyDesc {
    BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() })
}

fn voronoi(cells: usize) -> BreakingDesc {
    let pattern = PatternDesc::Voronoi { cells, clustering: 0.0, seed: 1 };
    BreakingDesc { strength: 10.0, pattern, generations: 1 }
}

fn sentence(body: BodyDesc) -> String {
    let mut scene = SceneDesc::new("test");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.push(body);
    World::build(&scene).expect_err("the scene is wrong").to_string()
}

#[test]
fn a_wrong_field_is_named_with_its_value_and_its_rule() {
    let cases = [
        (
            BodyDesc { density: -1.0, ..ball() },
            "bodies[1].density: -1.0, must be > 0 and at most 1e12 kg/m^3",
        ),
        (BodyDesc { friction: f64::NAN, ..ball() }, "bodies[1].friction: NaN, must be >= 0"),
        (BodyDesc { restitution: 1.5, ..ball() }, "bodies[1].restitution: 1.5, must be between 0 and 1"),
        (
            BodyDesc { angular_velocity: [0.0, 1e200, 0.0], ..ball() },
            "bodies[1].angular_velocity: [0.0, 1e200, 0.0], must be three numbers from -1e9 to 1e9 rad/s",
        ),
        (
            BodyDesc { orientation: [0.0; 4], ..ball() },
            "bodies[1].orientation: [0.0, 0.0, 0.0, 0.0], must be a quaternion x, y, z, w other than zero",
        ),
        (
            BodyDesc { motion: MotionDesc::Kinematic, breaking: Some(voronoi(10)), ..ball() },
            "bodies[1].breaking: on a body that is not dynamic, must be left out, or the body dynamic",
        ),
        (
            BodyDesc { breaking: Some(voronoi(1_000_000)), ..ball() },
            "bodies[1].breaking.pattern.cells: 1000000, must be between 1 and 2000",
        ),
        (
            BodyDesc {
                shape: ShapeDesc::Sphere { radius: 1e-200, resolution: Resolution::default() },
                ..ball()
            },
            "bodies[1].shape.radius: 1e-200, must be between 1e-6 and 1e6 m",
        ),
        (
            BodyDesc { shape: ShapeDesc::HalfSpace, ..ball() },
            "bodies[1].motion: Dynamic, must be static for a half-space, which has no mass",
        ),
    ];
    for (body, expected) in cases {
        assert_eq!(sentence(body), expected);
    }
}

#[test]
fn a_grid_that_misses_the_shape_is_refused() {
    let resolution = Resolution { voxels: Some([64, 2, 64]), sample_spacing: None };
    let sheet = BodyDesc::new("sheet", ShapeDesc::Box { size: [1.0, 0.001, 1.0], resolution });
    let text = sentence(sheet);
    assert!(text.starts_with("bodies[1].shape.resolution.voxels: "), "{text}");

    let resolution = Resolution { voxels: Some([100_000; 3]), sample_spacing: None };
    let text = sentence(BodyDesc::new("huge", ShapeDesc::Sphere { radius: 1.0, resolution }));
    assert!(text.contains("to fit in memory"), "{text}");
}

/// A pattern of one cell cannot split the ball: it bounces as if it were unbreakable.
#[test]
fn a_body_that_cannot_be_split_still_bounces() {
    let rebound = |breaking: Option<BreakingDesc>| {
        let mut scene = SceneDesc::new("bounce");
        scene.bodies.push(BodyDesc::ground(0.0));
        let resolution = Resolution { voxels: Some([24; 3]), sample_spacing: Some(0.1) };
        let shape = ShapeDesc::Sphere { radius: 0.5, resolution };
        let position = [0.0, 2.0, 0.0];
        scene.bodies.push(BodyDesc { position, breaking, restitution: 1.0, ..BodyDesc::new("ball", shape) });
        let mut world = World::build(&scene).unwrap();
        (0..30)
            .map(|_| {
                step(&mut world);
                world.bodies().velocities[1].linear.y
            })
            .fold(f64::NEG_INFINITY, f64::max)
    };
    let unbreakable = rebound(None);
    assert!(unbreakable > 4.0);
    assert!((rebound(Some(voronoi(1))) - unbreakable).abs() < 0.1 * unbreakable);
}
