//! Rows of flush tiles, and walls of flush bricks: what slides or rolls over many seams moves as on
//! one slab, and what flies at a wall leaves it as a single one.

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

/// Boxes from their lowest to their highest corners [m], turned about the origin.
fn blocks(ground: Ground, blocks: &[[DVec3; 2]], turn: DQuat) -> Vec<BodyDesc> {
    let body = |shape: ShapeDesc, middle: DVec3| BodyDesc {
        motion: MotionDesc::Static,
        position: (turn * middle).to_array(),
        orientation: turn.to_array(),
        restitution: 0.0,
        ..BodyDesc::new("block", shape)
    };
    let resolution = Resolution::default();
    let place = |&[low, high]: &[DVec3; 2]| (0.5 * (low + high), (high - low).to_array());
    if let Ground::Compound = ground {
        let part = |block: &[DVec3; 2]| {
            let (middle, size) = place(block);
            PartDesc::Box { size, position: middle.to_array(), orientation: [0.0, 0.0, 0.0, 1.0] }
        };
        let parts = blocks.iter().map(part).collect();
        return vec![body(ShapeDesc::Compound { parts, resolution }, DVec3::ZERO)];
    }
    // Corners of each side, around it.
    let sides =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let block = |block: &[DVec3; 2]| {
        let (middle, size) = place(block);
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
    blocks.iter().map(block).collect()
}

/// Boxes side by side along x, from one of `seams` [m] to the next, between two corners' other
/// coordinates [m].
fn row(seams: &[f64], low: [f64; 2], high: [f64; 2]) -> Vec<[DVec3; 2]> {
    let block =
        |ends: &[f64]| [DVec3::new(ends[0], low[0], low[1]), DVec3::new(ends[1], high[0], high[1])];
    seams.windows(2).map(block).collect()
}

/// Positions [m] and the last velocity [m/s] of a body on some ground.
fn cross(
    ground: Vec<BodyDesc>,
    (body, friction): (&BodyDesc, f64),
    gravity: f64,
    (rate, frames): (f64, u32),
) -> (Vec<DVec3>, DVec3) {
    let mut bodies: Vec<BodyDesc> = ground;
    bodies.push(body.clone());
    bodies.iter_mut().for_each(|body| body.friction = friction);
    let scene = SceneDesc {
        bodies,
        frames_per_second: rate,
        gravity: [0.0, -gravity, 0.0],
        ..SceneDesc::new("row")
    };
    let mut world = World::build(&scene).unwrap();
    let last = world.bodies().len() - 1;
    let step = |_| {
        frangible::step(&mut world);
        world.bodies().poses[last].position
    };
    let way = (0..frames).map(step).collect();
    (way, world.bodies().velocities[last].linear)
}

/// [m/s^2]
const GRAVITY: f64 = 9.81;

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
        let (deep, wide) = ((0.3 * size).max(0.02), 20.0 * size + 2.0 * way);
        let ends = [start - length - 4.0 * size, start + way + length + 9.0 * size];
        let inner = (0..=seams).map(|number| f64::from(number) * tile);
        let all: Vec<f64> = [ends[0]].into_iter().chain(inner).chain([ends[1]]).collect();

        let friction = if mover.rolls() { 0.5 } else { 0.0 };
        let on = |seams: &[f64]| {
            let tiles = row(seams, [-deep, -0.5 * wide], [0.0, 0.5 * wide]);
            let tiles = blocks(ground, &tiles, DQuat::from_rotation_y(turn));
            cross(tiles, (&body, friction), GRAVITY, (rate, frames))
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

    /// A wall of bricks beside tiles, below a row of beams or not, as separate bodies or as one:
    /// what slides along all of them, pushed into the wall or not, moves as along three slabs.
    #[test]
    fn walls_on_tiles_are_slabs(
        ground in prop::sample::select(vec![
            Ground::Boxes, Ground::Hulls, Ground::ClosedMeshes, Ground::Compound, Ground::Compound,
        ]),
        mover in prop::sample::select(vec![Mover::Cube, Mover::Plate, Mover::Ball]),
        log_size in -1.3..0.0f64,
        log_speed in 0.0..1.2f64,
        rate in prop::sample::select(vec![24.0, 30.0, 60.0]),
        tile in 0.4..3.0f64,
        push in prop::sample::select(vec![0.0, 0.1, 0.5]),
        [off, off_above] in [0.0..1.0f64, 0.0..1.0f64],
        foot in prop::sample::select(vec![-1.0, 0.0]),
        room in prop_oneof![Just(None), Just(Some(0.0)), Just(Some(0.05))],
        // Tiles end at the wall, or run on below it.
        under in prop_oneof![Just(0.0), 0.2..0.8f64],
    ) {
        let (size, speed) = (10f64.powf(log_size), 10f64.powf(log_speed));
        let tile = tile * size;
        let count = (((speed + 4.0 * size) / tile) as u32 + 2).min(60);
        let length = f64::from(count) * tile;
        let frames = ((length / speed * 0.7).min(1.0) * rate) as u32;
        prop_assume!(frames > 0);
        let (shape, height) = mover.shape(size);
        let half_width = 0.5 * size;
        let body = BodyDesc {
            position: [0.0, 0.5 * height, 2.0 * size - half_width],
            linear_velocity: [speed, 0.0, push * speed],
            restitution: 0.0,
            ..BodyDesc::new("mover", shape)
        };
        let wall = 2.0 * size;
        let foot = if under > 0.0 { 0.0 } else { foot * size };
        let rows = |of_row: &dyn Fn(f64) -> Vec<f64>| {
            let mut all = row(&of_row(0.0), [-size, -size], [0.0, wall + under * size]);
            all.extend(row(&of_row(off), [foot, wall], [2.0 * size, wall + size]));
            if let Some(room) = room {
                let low = height * (1.0 + room);
                all.extend(row(&of_row(off_above), [low, -size], [low + size, wall]));
            }
            all
        };
        let first = -2.0 * size - tile;
        let seams = |off: f64| (0..count + 3).map(|n| first + (f64::from(n) - off) * tile).collect();
        let many = rows(&seams);
        let single = rows(&|_| vec![first - tile, first + length + 3.0 * tile]);
        let along = |ground: Ground, all: &[[DVec3; 2]]| {
            cross(blocks(ground, all, DQuat::IDENTITY), (&body, 0.0), GRAVITY, (rate, frames))
        };
        let [(bricks, _), (slabs, _)] = [along(ground, &many), along(Ground::Boxes, &single)];
        let way = slabs[slabs.len() - 1].x;
        for (at, wanted) in bricks.iter().zip(&slabs) {
            let off = *at - *wanted;
            prop_assert!(off.x.abs() <= 0.01 * way.max(size), "{off} of {way} m off");
            prop_assert!(off.y.abs() <= 0.1 * size, "{off} off, of {size} m");
        }
    }

    /// Without friction a wall of bricks changes no velocity along it, whatever flies at it.
    #[test]
    fn walls_of_bricks_are_flat(
        ground in prop::sample::select(vec![
            Ground::Boxes, Ground::Hulls, Ground::ClosedMeshes, Ground::Compound,
        ]),
        mover in prop::sample::select(vec![
            Mover::Cube, Mover::Plate, Mover::Ball, Mover::Cylinder, Mover::Capsule,
        ]),
        log_size in -1.3..0.3f64,
        log_speed in -0.5..1.7f64,
        rate in prop::sample::select(vec![24.0, 30.0, 60.0, 120.0]),
        [brick, deep] in [0.3..3.0f64, 0.3..2.0f64],
        is_bond: bool,
        slant in 0.0..1.3f64,
        heading in 0.0..std::f64::consts::TAU,
        [turn, pose, spin] in prop::array::uniform3(prop::array::uniform3(-1.0..1.0f64)),
    ) {
        let (size, speed) = (10f64.powf(log_size), 10f64.powf(log_speed));
        let (brick, deep) = (brick * size, deep * size);
        let turn = DQuat::from_scaled_axis(3.0 * DVec3::from(turn));
        let mut bricks = Vec::new();
        let seams = |shift: f64| (0..10).map(move |n| (f64::from(n) - 4.5 + shift) * brick);
        for course in 0..9 {
            let (low, shift) = (f64::from(course) - 4.5, if is_bond { course % 2 } else { 0 });
            let seams: Vec<f64> = seams(0.5 * f64::from(shift)).collect();
            bricks.extend(row(&seams, [low * brick, -deep], [(low + 1.0) * brick, 0.0]));
        }
        let way = DVec3::new(
            slant.sin() * heading.cos(), slant.sin() * heading.sin(), -slant.cos(),
        );
        let start = -1.5 * size / slant.cos().max(0.05) * way;
        let body = BodyDesc {
            position: (turn * start).to_array(),
            orientation: DQuat::from_scaled_axis(3.0 * DVec3::from(pose)).to_array(),
            linear_velocity: (turn * (speed * way)).to_array(),
            angular_velocity: (0.3 * speed / size * DVec3::from(spin)).to_array(),
            restitution: 0.5,
            ..BodyDesc::new("mover", mover.shape(size).0)
        };
        let frames = ((3.0 * size / speed * rate) as u32).clamp(4, 60);
        let wall = blocks(ground, &bricks, turn);
        let (path, velocity) = cross(wall, (&body, 0.0), 0.0, (rate, frames));
        // Over the wall's borders there is no wall.
        let most = 3.5 * brick - 1.5 * size;
        let is_inside = |at: &DVec3| (turn.inverse() * *at).truncate().abs().max_element() < most;
        prop_assume!(path.iter().all(is_inside));
        let off = (turn.inverse() * velocity - speed * way).truncate();
        prop_assert!(off.length() <= 0.01 * speed, "{off} of {speed} m/s");
    }
}
