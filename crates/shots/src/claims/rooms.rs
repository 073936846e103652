//! Fast bodies in closed rooms.

use super::scenes::{ball, cube, cuboid};
use super::watch::step;
use crate::claims::claim::{Claim, Finding, Obstacle, largest};
use crate::random::Random;
use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World};
use glam::DVec3;

/// At 10 to 200 m/s.
pub(super) const ROOMS: Claim = Claim {
    name: "rooms",
    says: "of twelve bodies that fly about in a closed room with restitution 1 none leaves it",
    source: "mechanics",
    measure: measured,
};

/// Half of the room's width, and how thick its walls are [m].
const ROOM: [f64; 2] = [1.0, 0.5];

/// Of a body [m].
const SIZE: f64 = 0.2;

/// Bodies at most a row, of rows at most a layer, and how far they are apart [m].
const PLACES: ([usize; 2], f64) = ([3, 3], 0.5);

/// In a room.
const BODIES: usize = 12;

/// At first [m/s].
const SPEEDS: [f64; 4] = [10.0, 20.0, 50.0, 200.0];

/// Rooms of each kind and speed.
const SEEDS: u64 = 4;

/// [frames]
const FRAMES: u32 = 30;

fn shapes() -> [(&'static str, ShapeDesc); 5] {
    let resolution = Resolution::default();
    let half = 0.5 * SIZE;
    let tip = |number: usize| {
        let mut point = [0.0; 3];
        point[number / 2] = if number.is_multiple_of(2) { half } else { -half };
        point
    };
    let hull = ShapeDesc::Hull { points: (0..6).map(tip).collect(), resolution };
    [
        ("balls", ball(half)),
        ("cubes", cube(SIZE)),
        ("slabs", cuboid([SIZE, 0.2 * SIZE, half])),
        ("hulls", hull),
        ("cylinders", ShapeDesc::Cylinder { radius: 0.5 * half, height: SIZE, resolution }),
    ]
}

fn room(shape: &ShapeDesc, speed: f64, seed: u64) -> SceneDesc {
    let [half, thick] = ROOM;
    let mut bodies: Vec<BodyDesc> = (0..6)
        .map(|side| {
            let axis = side / 2;
            let mut size = [2.0 * (half + thick); 3];
            size[axis] = thick;
            let mut position = [0.0; 3];
            position[axis] = (half + 0.5 * thick) * if side % 2 == 0 { 1.0 } else { -1.0 };
            BodyDesc {
                motion: MotionDesc::Static,
                position,
                restitution: 1.0,
                ..BodyDesc::new("wall", cuboid(size))
            }
        })
        .collect();
    let mut random = Random::new(seed);
    let ([row, layer], apart) = PLACES;
    bodies.extend((0..BODIES).map(|number| {
        BodyDesc {
            position: [number % row, number / row % layer, number / (row * layer)]
                .map(|place| (place as f64 - 1.0) * apart),
            linear_velocity: (speed * random.direction()).to_array(),
            angular_velocity: (10.0 * random.direction()).to_array(),
            restitution: 1.0,
            ..BodyDesc::new("body", shape.clone())
        }
    }));
    SceneDesc { bodies, ..SceneDesc::new("claim") }
}

/// Number of bodies outside or removed at the end, and the largest momentum error.
fn run(scene: &SceneDesc) -> Result<[f64; 2], Obstacle> {
    let mut world = World::build(scene)?;
    let mut error = 0.0;
    for _ in 0..FRAMES {
        let momentum = step(&mut world).momentum;
        error = largest([error, momentum.linear_error, momentum.angular_error]);
    }
    let (bodies, [half, _]) = (world.bodies(), ROOM);
    let stays = |i: &usize| {
        let place = bodies.poses[*i].position;
        bodies.masses[*i].is_finite()
            && place.cmple(DVec3::splat(half)).all()
            && place.cmpge(DVec3::splat(-half)).all()
    };
    let inside = (0..bodies.len()).filter(stays).count();
    Ok([(BODIES - inside) as f64, error])
}

fn measured() -> Result<Vec<Finding>, Obstacle> {
    let mut findings = Vec::new();
    let mut error = 0.0;
    for speed in SPEEDS {
        for (name, shape) in shapes() {
            let mut outside = 0.0;
            for seed in 0..SEEDS {
                let [out, changed] = run(&room(&shape, speed, seed))?;
                outside += out;
                error = largest([error, changed]);
            }
            let share = outside / (SEEDS as f64 * BODIES as f64);
            let quantity = format!("share of {name} at {speed} m/s that leave");
            findings.push(Finding::at_most(quantity, "1", share, 0.0));
        }
    }
    findings.push(Finding::at_most("change of momentum", "1", error, 1e-9));
    Ok(findings)
}
