//! Static meshes are their triangles: what rests on them, slides over them and rolls down them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, SidesDesc, World, step};
use glam::DVec3;
use std::time::Instant;

const NONE: Resolution = Resolution { voxels: None, sample_spacing: None };

fn fixed(shape: ShapeDesc) -> BodyDesc {
    BodyDesc { motion: MotionDesc::Static, restitution: 0.0, ..BodyDesc::new("mesh", shape) }
}

fn cube(size: f64) -> ShapeDesc {
    ShapeDesc::Box { size: [size; 3], resolution: NONE }
}

fn ball(radius: f64) -> ShapeDesc {
    ShapeDesc::Sphere { radius, resolution: NONE }
}

fn falling(shape: ShapeDesc, position: [f64; 3], linear_velocity: [f64; 3]) -> BodyDesc {
    BodyDesc { position, linear_velocity, restitution: 0.0, ..BodyDesc::new("body", shape) }
}

/// The world after some seconds.
fn run(bodies: Vec<BodyDesc>, frames_per_second: f64, seconds: f64) -> World {
    let scene = SceneDesc { frames_per_second, bodies, ..SceneDesc::new("test") };
    let mut world = World::build(&scene).unwrap();
    for _ in 0..(seconds * frames_per_second) as usize {
        step(&mut world);
    }
    world
}

/// A closed box of twelve triangles, from -half to half.
fn box_of_triangles(half: [f64; 3], faces_outward: bool) -> ShapeDesc {
    let corner = |n: usize| {
        [0, 1, 2].map(|axis| if n >> (2 - axis) & 1 == 1 { half[axis] } else { -half[axis] })
    };
    let mut triangles = vec![
        [0, 1, 3],
        [0, 3, 2],
        [4, 6, 7],
        [4, 7, 5],
        [0, 4, 5],
        [0, 5, 1],
        [2, 3, 7],
        [2, 7, 6],
        [0, 2, 6],
        [0, 6, 4],
        [1, 5, 7],
        [1, 7, 3],
    ];
    if !faces_outward {
        triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    ShapeDesc::Triangles {
        positions: (0..8).map(corner).collect(),
        triangles,
        thickness: None,
        sides: Some(SidesDesc::One),
        resolution: NONE,
    }
}

fn field(rows: usize, columns: usize, spacing: f64, height: impl Fn(f64, f64) -> f64) -> ShapeDesc {
    let middle = |count: usize| 0.5 * (count - 1) as f64;
    let row = |k: usize| {
        let z = (k as f64 - middle(rows)) * spacing;
        (0..columns).map(|i| height((i as f64 - middle(columns)) * spacing, z)).collect()
    };
    ShapeDesc::Heightfield {
        heights: (0..rows).map(row).collect(),
        spacing: [spacing; 2],
        sides: Some(SidesDesc::Two),
    }
}

/// Small bodies come to rest on thin plates and on a single sheet, at any rate (field test F6).
#[test]
fn thin_meshes_hold_small_bodies() {
    for mesh in [box_of_triangles([0.1, 0.0015, 0.1], true), field(2, 2, 0.2, |_, _| 0.0015)] {
        for body in [cube(0.02), ball(0.01)] {
            for (rate, height) in [(30.0, 1.0), (30.0, 3.0), (60.0, 1.0), (240.0, 3.0)] {
                let at = [0.003, height + 0.01, 0.001];
                let bodies = vec![fixed(mesh.clone()), falling(body.clone(), at, [0.0; 3])];
                let world = run(bodies, rate, 1.5);
                let y = world.bodies().poses[1].position.y;
                assert!((y - 0.0115).abs() < 2e-4, "{rate} {height}: {y}");
            }
        }
    }
}

/// Cylinders and capsules roll over a floor of triangles as over one slab.
#[test]
fn round_bodies_roll_over_triangles() {
    for (radius, speed) in [(0.01, 1.0), (0.1, 1.0), (0.1, 30.0), (1.0, 5.0)] {
        for shape in [
            ShapeDesc::Cylinder { radius, height: 2.0 * radius, resolution: NONE },
            ShapeDesc::Capsule { radius, height: 2.0 * radius, resolution: NONE },
        ] {
            let floor = field(9, 401, 0.2, |_, _| 0.0);
            let lying = BodyDesc {
                orientation: [0.5_f64.sqrt(), 0.0, 0.0, 0.5_f64.sqrt()],
                angular_velocity: [0.0, 0.0, -speed / radius],
                ..falling(shape.clone(), [-35.0, radius, 0.013], [speed, 0.0, 0.0])
            };
            let scene = SceneDesc { bodies: vec![fixed(floor), lying], ..SceneDesc::new("test") };
            let mut world = World::build(&scene).unwrap();
            for _ in 0..60 {
                step(&mut world);
                let off = world.bodies().poses[1].position.y - radius;
                assert!(off.abs() < 2e-4, "{shape:?} {speed} m/s: {off} m");
            }
            let way = world.bodies().poses[1].position.x + 35.0;
            assert!((way - 2.0 * speed).abs() < 2e-3 * speed, "{shape:?} {speed} m/s: {way} m");
        }
    }
}

/// A floor of fine triangles is as smooth as one of two.
#[test]
fn fine_floors_are_smooth() {
    for body in [cube(0.5), ball(0.25)] {
        for speed in [1.0, 5.0, 30.0] {
            let way = |columns: usize, spacing: f64| {
                let floor = field(41.min(columns), columns, spacing, |_, _| 0.0);
                let at = [-15.0, 0.25, 0.013];
                let bodies = vec![fixed(floor), falling(body.clone(), at, [speed, 0.0, 0.0])];
                let scene = SceneDesc { bodies, ..SceneDesc::new("test") };
                let mut world = World::build(&scene).unwrap();
                let mut highest = 0.0_f64;
                for _ in 0..30 {
                    step(&mut world);
                    highest = highest.max(world.bodies().poses[1].position.y - 0.25);
                }
                (world.bodies().poses[1].position.x + 15.0, highest)
            };
            let (coarse, fine) = (way(2, 40.0), way(801, 0.05));
            assert!((fine.0 / coarse.0 - 1.0).abs() < 1e-3, "{speed}: {fine:?} {coarse:?}");
            assert!(fine.1 < 1e-5, "{speed}: hops {}", fine.1);
        }
    }
}

/// A ramp, a ridge and steps down are passed at the same speed whatever the rate.
#[test]
fn ridges_and_steps_are_the_same_at_any_rate() {
    let step = |x: f64, _: f64| if x < 1e-4 { 0.0 } else { -0.02 };
    let ridge = |x: f64, _: f64| (0.03 - 0.1 * (x - 1.0).abs()).max(0.0);
    let ends = |height: &dyn Fn(f64, f64) -> f64, rate: f64| {
        let floor = field(81, 601, 0.025, height);
        let body = falling(cube(0.5), [-0.6, 0.25, 0.013], [5.0, 0.0, 0.0]);
        let world = run(vec![fixed(floor), body], rate, 1.0);
        world.bodies().poses[1].position.x
    };
    for height in [&step as &dyn Fn(f64, f64) -> f64, &ridge] {
        let (coarse, fine) = (ends(height, 30.0), ends(height, 240.0));
        assert!((coarse - fine).abs() < 0.05, "{coarse} {fine}");
    }
}

/// A room that faces inward keeps what flies about in it.
#[test]
fn rooms_keep_what_is_inside() {
    let room = BodyDesc { restitution: 0.8, ..fixed(box_of_triangles([1.0; 3], false)) };
    let mut bodies = vec![room];
    for n in 0..12 {
        let at = |k: usize| 0.4 * ((n >> k & 1) as f64 - 0.5) + 0.1 * (n / 8) as f64;
        let speed = |k: usize| 15.0 * libm::sin((3 * n + k) as f64);
        let shape = if n % 2 == 0 { cube(0.1) } else { ball(0.05) };
        let velocity = [speed(0), speed(1), speed(2)];
        let body = falling(shape, [at(0), at(1), at(2)], velocity);
        bodies.push(BodyDesc { restitution: 0.8, ..body });
    }
    let world = run(bodies, 30.0, 4.0);
    for pose in &world.bodies().poses[1..] {
        assert!(pose.position.abs().max_element() < 1.0, "{}", pose.position);
    }
}

/// A half-pipe along a helix: a ball rolls down it as it does in fine steps.
#[test]
fn a_marble_run_is_the_same_at_any_rate() {
    let (radius, pipe, pitch, turns, segments) = (1.5, 0.12, 0.6, 1.5, 12_u32);
    let rows = 156_u32;
    let mut positions = Vec::new();
    let mut triangles = Vec::new();
    let center = |angle: f64| {
        let down = -pitch * angle / std::f64::consts::TAU;
        DVec3::new(radius * libm::cos(angle), down, radius * libm::sin(angle))
    };
    for row in 0..=rows {
        let angle = std::f64::consts::TAU * turns * f64::from(row) / f64::from(rows);
        let outward = DVec3::new(libm::cos(angle), 0.0, libm::sin(angle));
        for segment in 0..=segments {
            let around = std::f64::consts::PI * f64::from(segment) / f64::from(segments);
            let off = -libm::cos(around) * outward - libm::sin(around) * DVec3::Y;
            positions.push((center(angle) + pipe * off).to_array());
        }
    }
    for row in 0..rows {
        for segment in 0..segments {
            let a = row * (segments + 1) + segment;
            let (b, c, d) = (a + 1, a + segments + 1, a + segments + 2);
            triangles.extend([[a, b, d], [a, d, c]]);
        }
    }
    let run_shape = ShapeDesc::Triangles {
        positions,
        triangles,
        thickness: None,
        sides: None,
        resolution: NONE,
    };
    let angle_at = |rate: f64| {
        let start = center(0.2) + DVec3::new(0.0, -0.12 + 0.052, 0.0);
        let marble = falling(ball(0.05), start.to_array(), [0.0; 3]);
        let bodies = vec![BodyDesc { friction: 1.0, ..fixed(run_shape.clone()) }, marble];
        let at = run(bodies, rate, 4.0).bodies().poses[1].position;
        assert!((at.length_squared() - at.y * at.y).sqrt() < radius + pipe);
        libm::atan2(at.z, at.x)
    };
    let (coarse, fine) = (angle_at(30.0), angle_at(480.0));
    assert!((coarse - fine).abs() < 0.05, "{coarse} {fine}");
}

/// On a field of 100,000 triangles a step costs about as much as on one of two.
#[test]
fn large_meshes_cost_as_much_as_small_ones() {
    let time = |cells: usize, spacing: f64| {
        let floor = field(cells + 1, cells + 1, spacing, |_, _| 0.0);
        let size = ShapeDesc::Box { size: [4.0, 1.2, 2.0], resolution: NONE };
        let bodies = vec![fixed(floor), falling(size, [-10.0, 0.6, 0.01], [10.0, 0.0, 0.0])];
        let scene = SceneDesc { bodies, ..SceneDesc::new("test") };
        let mut world = World::build(&scene).unwrap();
        let mut times: Vec<f64> = (0..100)
            .map(|_| {
                let begin = Instant::now();
                step(&mut world);
                begin.elapsed().as_secs_f64()
            })
            .collect();
        times.sort_by(f64::total_cmp);
        times[20]
    };
    let (small, large) = (time(1, 120.0), time(224, 0.5));
    assert!(large < 5.0 * small, "{large} s, {small} s with two triangles");
}

/// What only static triangles can be is refused elsewhere, by field, value and rule.
#[test]
fn other_bodies_have_no_sides() {
    let sentence = |body: BodyDesc| {
        let scene = SceneDesc { bodies: vec![body], ..SceneDesc::new("test") };
        World::build(&scene).unwrap_err().to_string()
    };
    let mesh = box_of_triangles([0.5; 3], true);
    let text = sentence(BodyDesc::new("m", mesh));
    assert!(text.starts_with("bodies[0].shape.sides: one, must be left out, but"), "{text}");
    let heights =
        |heights: Vec<Vec<f64>>| ShapeDesc::Heightfield { heights, spacing: [1.0; 2], sides: None };
    let text = sentence(BodyDesc::new("h", heights(vec![vec![0.0; 2]; 2])));
    assert!(text.starts_with("bodies[0].shape.kind: heightfield, must be"), "{text}");
    let text = sentence(fixed(heights(vec![vec![0.0; 2], vec![0.0; 3]])));
    let rule = "bodies[0].shape.heights[1]: 3 heights, must be as many as the first row, 2";
    assert!(text.starts_with(rule), "{text}");
    let text = sentence(fixed(heights(vec![vec![0.0; 2]])));
    assert!(text.starts_with("bodies[0].shape.heights: 1 rows, the first of 2, must"), "{text}");
    let text = sentence(fixed(heights(vec![vec![0.0, f64::NAN], vec![0.0; 2]])));
    assert!(text.starts_with("bodies[0].shape.heights[0]: NaN, must be between"), "{text}");
}

/// A prism over a polygon in x and y, counter-clockwise, which fans of triangles fill: the longest
/// side of its box is `size`.
fn prism(polygon: &[[f64; 2]], depth: f64, fans: &[&[u32]], size: f64) -> ShapeDesc {
    let count = polygon.len() as u32;
    let scale = size / 0.8;
    let at = |z: f64| move |&[x, y]: &[f64; 2]| [x, y, z].map(|along| scale * along);
    let positions = polygon.iter().map(at(0.0)).chain(polygon.iter().map(at(depth))).collect();
    let mut triangles = Vec::new();
    for fan in fans {
        for pair in fan[1..].windows(2) {
            triangles.push([fan[0], pair[1], pair[0]]);
            triangles.push([fan[0], pair[0], pair[1]].map(|n| n + count));
        }
    }
    for n in 0..count {
        let next = (n + 1) % count;
        triangles.extend([[n, next, next + count], [n, next + count, n + count]]);
    }
    ShapeDesc::Triangles { positions, triangles, thickness: None, sides: None, resolution: NONE }
}

/// Sampled bodies on narrow feet stand. Samples that were rounded off at the feet's edges, and
/// points that were chosen for their distance although they hung above others, let an H rock ever
/// more, and an L of 5 cm fall.
#[test]
fn sampled_letters_stand_on_their_feet() {
    let h = [
        [0.0, 0.0],
        [0.15, 0.0],
        [0.15, 0.325],
        [0.45, 0.325],
        [0.45, 0.0],
        [0.6, 0.0],
        [0.6, 0.8],
        [0.45, 0.8],
        [0.45, 0.475],
        [0.15, 0.475],
        [0.15, 0.8],
        [0.0, 0.8],
    ];
    let l = [[0.0, 0.0], [0.6, 0.0], [0.6, 0.15], [0.15, 0.15], [0.15, 0.8], [0.0, 0.8]];
    let of_h: &[&[u32]] = &[&[0, 1, 2, 9, 10, 11], &[2, 3, 8, 9], &[5, 6, 7, 8, 3, 4]];
    let of_l: &[&[u32]] = &[&[0, 1, 2, 3], &[0, 3, 4, 5]];
    let sizes_and_rates = [(0.05, 24.0), (0.05, 60.0), (0.2, 24.0), (0.8, 24.0), (0.8, 30.0)];
    for (what, polygon, fans) in [("H", &h[..], of_h), ("L", &l[..], of_l)] {
        for (size, rate) in sizes_and_rates {
            for turn in [0.0, 0.2] {
                let letter = BodyDesc {
                    orientation: [0.0, libm::sin(turn), 0.0, libm::cos(turn)],
                    density: 2000.0,
                    friction: 0.6,
                    restitution: 0.1,
                    ..BodyDesc::new(what, prism(polygon, 0.2, fans, size))
                };
                let bodies = vec![BodyDesc::ground(0.0), letter];
                let scene =
                    SceneDesc { frames_per_second: rate, bodies, ..SceneDesc::new("letters") };
                let mut world = World::build(&scene).unwrap();
                let start = world.bodies().poses[1];
                for _ in 0..(3.0 * rate) as usize {
                    let report = step(&mut world);
                    assert_eq!(report.energy.causes.projection, 0.0, "{what} {size} {rate}");
                }
                let now = world.bodies().poses[1];
                let tilt = 2.0 * now.orientation.dot(start.orientation).abs().min(1.0).acos();
                let moved = now.position.distance(start.position) / size;
                assert!(tilt < 5e-3 && moved < 5e-3, "{what} {size} m {rate} Hz: {tilt}, {moved}");
            }
        }
    }
}
