//! Rows of flush tiles: what slides or rolls over many seams moves as on one slab.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use frangible::{BodyDesc, MotionDesc, PartDesc, Resolution, SceneDesc, ShapeDesc, World};
use glam::{DQuat, DVec3};
use proptest::prelude::*;

/// What tiles are made of.
#[derive(Clone, Copy, Debug)]
enum Ground {
    Boxes,
    Hulls,
    ClosedMeshes,
    /// One compound of boxes.
    Compound,
}

/// What crosses them.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Mover {
    Cube,
    Plate,
    Ball,
    Cylinder,
    Capsule,
    /// A cylinder on its end.
    Upright,
}

impl Mover {
    fn rolls(self) -> bool {
        matches!(self, Self::Ball | Self::Cylinder | Self::Capsule)
    }

    /// A body of a size [m], and its height [m].
    fn shape(self, size: f64) -> (ShapeDesc, f64) {
        let (radius, resolution) = (0.5 * size, Resolution::default());
        let shape = match self {
            Self::Cube => cuboid([size; 3]),
            Self::Plate => return (cuboid([2.0 * size, 0.3 * size, size]), 0.3 * size),
            Self::Ball => ShapeDesc::Sphere { radius, resolution },
            Self::Cylinder | Self::Upright => {
                ShapeDesc::Cylinder { radius, height: size, resolution }
            }
            Self::Capsule => ShapeDesc::Capsule { radius, height: size, resolution },
        };
        (shape, size)
    }
}

fn cuboid(size: [f64; 3]) -> ShapeDesc {
    ShapeDesc::Box { size, resolution: Resolution::default() }
}

fn corners([x, y, z]: [f64; 3]) -> Vec<[f64; 3]> {
    let sign = |number: usize, bit: usize| if number >> bit & 1 == 1 { 0.5 } else { -0.5 };
    (0..8).map(|n| [sign(n, 2) * x, sign(n, 1) * y, sign(n, 0) * z]).collect()
}

/// Tiles between neighbouring `seams` [m] along x, with their tops at the height zero, turned about
/// y by `turn` [rad].
fn tiles(ground: Ground, seams: &[f64], [deep, wide]: [f64; 2], turn: f64) -> Vec<BodyDesc> {
    let turn = DQuat::from_rotation_y(turn);
    let body = |shape: ShapeDesc, middle: f64| BodyDesc {
        motion: MotionDesc::Static,
        position: (turn * DVec3::new(middle, -0.5 * deep, 0.0)).to_array(),
        orientation: turn.to_array(),
        restitution: 0.0,
        ..BodyDesc::new("tile", shape)
    };
    let resolution = Resolution::default();
    let stretch = |ends: &[f64]| (0.5 * (ends[0] + ends[1]), [ends[1] - ends[0], deep, wide]);
    if let Ground::Compound = ground {
        let part = |ends: &[f64]| {
            let (middle, size) = stretch(ends);
            PartDesc::Box { size, position: [middle, 0.0, 0.0], orientation: [0.0, 0.0, 0.0, 1.0] }
        };
        let parts = seams.windows(2).map(part).collect();
        return vec![body(ShapeDesc::Compound { parts, resolution }, 0.0)];
    }
    // Corners of each side, around it.
    let sides =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let tile = |ends: &[f64]| {
        let (middle, size) = stretch(ends);
        let shape = match ground {
            Ground::Boxes | Ground::Compound => cuboid(size),
            Ground::Hulls => ShapeDesc::Hull { points: corners(size), resolution },
            Ground::ClosedMeshes => ShapeDesc::Triangles {
                positions: corners(size),
                triangles: sides.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
                thickness: None,
                sides: None,
                resolution,
            },
        };
        body(shape, middle)
    };
    seams.windows(2).map(tile).collect()
}

/// Positions [m] and the last velocity [m/s] of a body on some ground.
fn cross(
    ground: Vec<BodyDesc>,
    (body, friction): (&BodyDesc, f64),
    rate: f64,
    frames: u32,
) -> (Vec<DVec3>, DVec3) {
    let mut bodies: Vec<BodyDesc> = ground;
    bodies.push(body.clone());
    bodies.iter_mut().for_each(|body| body.friction = friction);
    let scene = SceneDesc { bodies, frames_per_second: rate, ..SceneDesc::new("row") };
    let mut world = World::build(&scene).unwrap();
    let last = world.bodies().len() - 1;
    let step = |_| {
        frangible::step(&mut world);
        world.bodies().poses[last].position
    };
    let way = (0..frames).map(step).collect();
    (way, world.bodies().velocities[last].linear)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(128))]

    /// Tiles of a third to four times the body's size, at any angle to the way, at any speed and
    /// rate.
    #[test]
    fn rows_of_tiles_are_one_slab(
        ground in prop::sample::select(vec![
            Ground::Boxes, Ground::Hulls, Ground::ClosedMeshes, Ground::Compound,
        ]),
        mover in prop::sample::select(vec![
            Mover::Cube, Mover::Plate, Mover::Ball, Mover::Cylinder, Mover::Capsule, Mover::Upright,
        ]),
        log_size in -1.7..0.3f64,
        log_speed in 0.0..1.477f64,
        rate in prop::sample::select(vec![10.0, 24.0, 30.0, 60.0, 120.0, 240.0]),
        log_tile in -0.5..0.6f64,
        seams in 2..12_u32,
        phase in 0.0..1.0f64,
        turn in prop_oneof![Just(0.0), -0.6..0.6f64],
        yaw in prop_oneof![Just(0.0), -0.8..0.8f64],
    ) {
        let size = 10f64.powf(log_size);
        // Faster spins wobble.
        let most = if mover.rolls() { 150.0 * size } else { f64::INFINITY };
        let speed = 10f64.powf(log_speed).min(most);
        let tile = 10f64.powf(log_tile) * size;
        let start = -2.0 * size - phase * speed / rate;
        let length = f64::from(seams) * tile;
        let frames = (((length + 4.0 * size) / speed * rate) as u32).clamp(3, 120);
        let way = speed * f64::from(frames) / rate;

        let (shape, height) = mover.shape(size);
        let across = DQuat::from_rotation_x(0.5 * std::f64::consts::PI);
        let spin = if mover.rolls() { -2.0 * speed / size } else { 0.0 };
        let orientation = match mover {
            Mover::Cylinder | Mover::Capsule => across,
            _ => DQuat::from_rotation_y(yaw),
        };
        let body = BodyDesc {
            position: [start, 0.5 * height, 0.0],
            orientation: orientation.to_array(),
            linear_velocity: [speed, 0.0, 0.0],
            angular_velocity: [0.0, 0.0, spin],
            restitution: 0.0,
            ..BodyDesc::new("mover", shape)
        };
        let section = [(0.3 * size).max(0.02), 20.0 * size + 2.0 * way];
        let ends = [start - length - 4.0 * size, start + way + length + 9.0 * size];
        let inner = (0..=seams).map(|number| f64::from(number) * tile);
        let all: Vec<f64> = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();

        let friction = if mover.rolls() { 0.5 } else { 0.0 };
        let on = |seams: &[f64]| {
            cross(tiles(ground, seams, section, turn), (&body, friction), rate, frames)
        };
        let [(row, velocity), (slab, wanted)] = [on(&all), on(&ends)];
        let off = row[row.len() - 1] - slab[slab.len() - 1];
        prop_assert!(off.x.abs() <= 0.01 * way, "{off} of {way} m off");
        let off = velocity - wanted;
        prop_assert!(off.x.abs() <= 0.02 * speed, "{off} of {speed} m/s off");
        // What rolls is steered by seams that it crosses at an angle.
        prop_assert!(off.z.abs() <= 0.1 * speed, "{off} of {speed} m/s off");
        let top = |way: &[DVec3]| way.iter().map(|at| at.y).fold(f64::NEG_INFINITY, f64::max);
        let hop = top(&row) - top(&slab);
        prop_assert!(hop < 1e-3, "hops {hop} m");
    }
}
