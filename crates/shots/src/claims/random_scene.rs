//! Bodies of all proportions thrown at each other.

use super::scenes::{ball, cuboid};
use crate::random::Random;
use frangible::{BodyDesc, Method, MotionDesc, Resolution, SceneDesc, ShapeDesc};

/// Number of thrown bodies.
const BODIES: u32 = 12;

/// Concave outlines as cells of a 3 x 3 square, row by row: an L, a U, a T, a plus, and a ring.
const OUTLINES: [[u8; 9]; 5] = [
    [1, 0, 0, 1, 0, 0, 1, 1, 1],
    [1, 0, 1, 1, 0, 1, 1, 1, 1],
    [1, 1, 1, 0, 1, 0, 0, 1, 0],
    [0, 1, 0, 1, 1, 1, 0, 1, 0],
    [1, 1, 1, 1, 0, 1, 1, 1, 1],
];

/// A heap that falls on the ground, on a spinning plate that rises, and on a spinning bar that
/// comes from the side: cubes to shards of 100:1, balls, cylinders, and concave bodies; masses
/// 1:1000, friction to 1.5, restitution to 1, spins to 50 rad/s.
pub(super) fn random_scene(seed: u64, method: Method) -> SceneDesc {
    let mut random = Random::new(seed);
    let mut scene = SceneDesc { method, ..SceneDesc::new("random") };
    scene.bodies.push(BodyDesc { friction: 1.5, ..BodyDesc::ground(0.0) });
    let moving = |shape: ShapeDesc| BodyDesc {
        motion: MotionDesc::Kinematic,
        friction: 1.5,
        restitution: 1.0,
        ..BodyDesc::new("moving", shape)
    };
    scene.bodies.push(BodyDesc {
        position: [0.0, 0.3, 0.0],
        linear_velocity: [
            random.between(-1.0, 1.0),
            random.between(0.0, 1.0),
            random.between(-1.0, 1.0),
        ],
        angular_velocity: [
            random.between(-0.3, 0.3),
            random.between(-2.0, 2.0),
            random.between(-0.3, 0.3),
        ],
        ..moving(cuboid([4.0, 0.2, 4.0]))
    });
    scene.bodies.push(BodyDesc {
        position: [-4.0, 1.5, 0.0],
        linear_velocity: [random.between(2.0, 6.0), 0.0, 0.0],
        angular_velocity: (random.between(0.0, 15.0) * random.direction()).to_array(),
        ..moving(cuboid([0.3, 0.3, 2.0]))
    });
    for number in 0..BODIES {
        let (shape, volume) = random_shape(number, &mut random);
        scene.bodies.push(BodyDesc {
            position: [
                random.between(-1.0, 1.0),
                1.0 + 0.6 * f64::from(number),
                random.between(-1.0, 1.0),
            ],
            orientation: random.orientation().to_array(),
            linear_velocity: [
                random.between(-3.0, 3.0),
                random.between(-6.0, 3.0),
                random.between(-3.0, 3.0),
            ],
            angular_velocity: (random.between(0.0, 50.0) * random.direction()).to_array(),
            density: power_of_ten(random.between(0.0, 3.0)) / volume,
            friction: random.between(0.0, 1.5),
            restitution: random.between(0.0, 1.0),
            ..BodyDesc::new("body", shape)
        });
    }
    scene
}

/// A shape and its volume [m^3].
fn random_shape(number: u32, random: &mut Random) -> (ShapeDesc, f64) {
    let length = random.between(0.3, 1.0);
    let sampled = Resolution { voxels: None, sample_spacing: Some(0.15 * length) };
    match number % 7 {
        6 => hull(length, random),
        0 => (ball(0.3 * length), 4.0 / 3.0 * std::f64::consts::PI * libm::pow(0.3 * length, 3.0)),
        1 => {
            let (radius, height) = (length * random.between(0.05, 0.5), length);
            let volume = std::f64::consts::PI * radius * radius * height;
            (ShapeDesc::Cylinder { radius, height, resolution: sampled }, volume)
        }
        2 | 3 => {
            let outline = OUTLINES[random.index(OUTLINES.len())];
            let (cell, depth) = (length / 3.0, length * random.between(0.1, 1.0));
            let cells = f64::from(outline.iter().sum::<u8>());
            (prism(&outline, cell, depth), cells * cell * cell * depth)
        }
        _ => {
            // From cubes to shards.
            let thin = power_of_ten(random.between(-2.0, 0.0));
            let size = [length, length * thin, length * random.between(thin, 1.0)];
            (ShapeDesc::Box { size, resolution: sampled }, size.iter().product())
        }
    }
}

/// A tetrahedron with its corners about a box of a length [m], thin or not, and its volume [m^3].
fn hull(length: f64, random: &mut Random) -> (ShapeDesc, f64) {
    let thin = power_of_ten(random.between(-2.0, 0.0));
    let mut corner = |x: f64, y: f64, z: f64| {
        let shift = random.direction() * 0.2;
        glam::DVec3::new(
            length * (x + shift.x),
            length * thin * (y + shift.y),
            length * (z + shift.z),
        )
    };
    let corners = [
        corner(0.0, 0.0, 0.0),
        corner(1.0, 0.0, 0.0),
        corner(0.0, 1.0, 0.0),
        corner(0.0, 0.0, 1.0),
    ];
    let [a, b, c] = [1, 2, 3].map(|i: usize| corners[i] - corners[0]);
    let resolution = Resolution { voxels: None, sample_spacing: Some(0.15 * length) };
    let points = corners.map(|corner| corner.to_array()).to_vec();
    (ShapeDesc::Hull { points, resolution }, a.cross(b).dot(c).abs() / 6.0)
}

/// An outline of cells of a width [m] as a body of a depth [m]. The walls between two cells of it
/// are left out.
fn prism(outline: &[u8; 9], cell: f64, depth: f64) -> ShapeDesc {
    let filled = |x: i32, y: i32| {
        (0..3).contains(&x) && (0..3).contains(&y) && outline[(3 * y + x) as usize] == 1
    };
    let vertex = |x: i32, y: i32, z: i32| (x + 4 * y + 16 * z) as u32;
    let mut triangles = Vec::new();
    let mut face = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
    for (x, y) in (0..3).flat_map(|y| (0..3).map(move |x| (x, y))).filter(|&(x, y)| filled(x, y)) {
        let corner = |dx: i32, dy: i32, z: i32| vertex(x + dx, y + dy, z);
        face([corner(0, 0, 1), corner(1, 0, 1), corner(1, 1, 1), corner(0, 1, 1)]);
        face([corner(0, 0, 0), corner(0, 1, 0), corner(1, 1, 0), corner(1, 0, 0)]);
        let sides = [
            ((0, -1), [(0, 0), (1, 0)]),
            ((1, 0), [(1, 0), (1, 1)]),
            ((0, 1), [(1, 1), (0, 1)]),
            ((-1, 0), [(0, 1), (0, 0)]),
        ];
        for ((dx, dy), [a, b]) in sides {
            if !filled(x + dx, y + dy) {
                face([
                    corner(a.0, a.1, 0),
                    corner(b.0, b.1, 0),
                    corner(b.0, b.1, 1),
                    corner(a.0, a.1, 1),
                ]);
            }
        }
    }
    let position = |index: i32| {
        let [x, y, z] = [index % 4, index / 4 % 4, index / 16].map(f64::from);
        [(x - 1.5) * cell, (y - 1.5) * cell, (z - 0.5) * depth]
    };
    let resolution = Resolution { voxels: Some([15, 15, 5]), sample_spacing: Some(0.4 * cell) };
    ShapeDesc::Triangles {
        positions: (0..32).map(position).collect(),
        triangles,
        thickness: None,
        sides: None,
        resolution,
    }
}

fn power_of_ten(exponent: f64) -> f64 {
    libm::pow(10.0, exponent)
}
