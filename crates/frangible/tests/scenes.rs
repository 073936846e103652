//! Scene errors are reported in one sentence; unbreakable bodies still collide.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::fracture::Voronoi;
use frangible::{
    BodyDesc, BreakingDesc, BuildError, MotionDesc, PatternDesc, Resolution, SceneDesc, ShapeDesc,
    World, id_from_number, step,
};
use glam::{DQuat, DVec3};

fn ball() -> BodyDesc {
    BodyDesc::new("ball", ShapeDesc::Sphere { radius: 0.5, resolution: Resolution::default() })
}

fn hull(points: Vec<[f64; 3]>) -> BodyDesc {
    BodyDesc::new("hull", ShapeDesc::Hull { points, resolution: Resolution::default() })
}

fn voronoi(cells: usize) -> BreakingDesc {
    let pattern =
        PatternDesc::Voronoi(Voronoi { cells, clustering: 0.0, seed: 1, ..Voronoi::default() });
    BreakingDesc::once(10.0, pattern)
}

fn sentence(body: BodyDesc) -> String {
    let mut scene = SceneDesc::new("test");
    scene.bodies.push(BodyDesc::ground(0.0));
    scene.bodies.push(BodyDesc { name: String::new(), ..body });
    World::build(&scene).expect_err("the scene is wrong").to_string()
}

#[test]
fn a_wrong_field_is_named_with_its_value_and_its_rule() {
    let cases = [
        (
            BodyDesc { density: -1.0, ..ball() },
            "bodies[1].density: -1.0, must be between 1e-6 and 1e9 kg/m^3",
        ),
        (BodyDesc { friction: f64::NAN, ..ball() }, "bodies[1].friction: NaN, must be >= 0"),
        (
            BodyDesc { restitution: 1.5, ..ball() },
            "bodies[1].restitution: 1.5, must be between 0 and 1",
        ),
        (
            BodyDesc { angular_velocity: [0.0, 1e200, 0.0], ..ball() },
            "bodies[1].angular_velocity: [0.0, 1e200, 0.0], must be three numbers from -1e4 to 1e4 rad/s",
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
            "bodies[1].breaking.pattern.cells: 1000000, must be from 1 to 10000",
        ),
        (
            BodyDesc {
                shape: ShapeDesc::Sphere { radius: 1e-200, resolution: Resolution::default() },
                ..ball()
            },
            "bodies[1].shape.radius: 1e-200, must be between 1e-6 and 1e6 m",
        ),
        (
            hull(vec![[0.0; 3]; 3]),
            "bodies[1].shape.points: 3 points, must be at least 4 points that span a volume",
        ),
        (
            hull(vec![
                [0.0, 0.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 1.0, 0.0],
                [1.0, 1.0, 0.0],
                [2.0, 1.0, 0.0],
            ]),
            "bodies[1].shape.points: 5 points, must be points that do not all lie on a plane",
        ),
        (
            hull(vec![[0.0; 3], [0.0, 0.0, f64::INFINITY], [1.0; 3], [2.0; 3]]),
            "bodies[1].shape.points[1]: [0.0, 0.0, inf], must be three numbers from -1e9 to 1e9 m",
        ),
        (
            BodyDesc { shape: ShapeDesc::HalfSpace, ..ball() },
            "bodies[1].motion: dynamic, must be static for a half-space, which has no mass",
        ),
    ];
    for (body, expected) in cases {
        assert_eq!(sentence(body), expected);
    }
}

/// A mesh needs no file: an L of three cubes.
#[test]
fn triangles_are_a_body() {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let positions: Vec<[f64; 3]> =
        [0.0, 1.0].into_iter().flat_map(|z| outline.map(|[x, y]| [x, y, z])).collect();
    let side = |i: u32| [[i, (i + 1) % 6, (i + 1) % 6 + 6], [i, (i + 1) % 6 + 6, i + 6]];
    let ends = [[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]];
    let mut triangles: Vec<[u32; 3]> = (0..6).flat_map(side).collect();
    triangles.extend(ends.map(|[a, b, c]| [a, c, b]));
    triangles.extend(ends.map(|corners| corners.map(|corner| corner + 6)));
    let shape = |triangles: &[[u32; 3]]| ShapeDesc::Triangles {
        positions: positions.clone(),
        triangles: triangles.to_vec(),
        thickness: None,
        sides: None,
        resolution: Resolution { voxels: Some([24; 3]), sample_spacing: None },
    };

    let mut scene = SceneDesc::new("test");
    scene.bodies.push(BodyDesc { density: 1000.0, ..BodyDesc::new("L", shape(&triangles)) });
    let world = World::build(&scene).unwrap();
    assert!((world.bodies().masses[0] - 3000.0).abs() < 30.0);
    assert!(
        (world.bodies().poses[0].position - DVec3::new(5.0 / 6.0, 5.0 / 6.0, 0.5)).length() < 0.01
    );

    assert_eq!(
        sentence(BodyDesc::new("L", shape(&[[0, 1, 12]]))),
        "bodies[1].shape: triangle 0 refers to vertex 12, must be 0 to 11"
    );
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

/// A body follows its given velocity; bodies without one report a reason.
#[test]
fn a_body_moves_as_it_is_told() {
    let mut scene = SceneDesc::new("test");
    scene.gravity = [0.0; 3];
    let at = |x: f64, motion: MotionDesc| BodyDesc { position: [x, 0.0, 0.0], motion, ..ball() };
    let motions = [MotionDesc::Dynamic, MotionDesc::Kinematic, MotionDesc::Static];
    scene.bodies =
        [0.0, 3.0, 6.0].into_iter().zip(motions).map(|(x, motion)| at(x, motion)).collect();
    let mut world = World::build(&scene).unwrap();
    let [ball, lift, rock] = [0, 1, 2].map(|i| world.bodies().ids[i]);
    for id in [ball, lift] {
        world.set_velocity(id, DVec3::Y, 2.0 * DVec3::Z).unwrap();
    }
    (0..30).for_each(|_| drop(step(&mut world)));
    let expected = DQuat::from_rotation_z(2.0);
    for pose in &world.bodies().poses[..2] {
        assert!(
            (pose.position.y - 1.0).abs() < 1e-12
                && pose.orientation.dot(expected).abs() > 1.0 - 1e-12
        );
    }

    let sentence = |result: Result<(), BuildError>| result.unwrap_err().to_string();
    assert_eq!(
        sentence(world.set_velocity(rock, DVec3::Y, DVec3::ZERO)),
        "body: static, must be dynamic or kinematic"
    );
    assert_eq!(
        sentence(world.set_velocity(id_from_number(7), DVec3::Y, DVec3::ZERO)),
        "body: 7, must be the id of a living body"
    );
    assert_eq!(
        sentence(world.set_velocity(ball, DVec3::Y, DVec3::splat(f64::NAN))),
        "angular: [NaN, NaN, NaN], must be three numbers from -1e4 to 1e4 rad/s"
    );
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
        scene.bodies.push(BodyDesc {
            position,
            breaking,
            restitution: 1.0,
            ..BodyDesc::new("ball", shape)
        });
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
