//! Impacts within a frame, against the same events one after the other.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible::{BodyDesc, MotionDesc, Resolution, SceneDesc, ShapeDesc, World, step};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const SIZE: f64 = 0.2;

fn cube() -> ShapeDesc {
    ShapeDesc::Box { size: [SIZE; 3], resolution: Resolution::default() }
}

fn ball() -> ShapeDesc {
    ShapeDesc::Sphere { radius: 0.5 * SIZE, resolution: Resolution::default() }
}

/// Bodies in a row along x, the first of which comes.
struct Row {
    places: Vec<f64>,
    densities: Vec<f64>,
    speed: f64,
}

impl Row {
    fn random(rng: &mut Pcg64Mcg, counts: &[usize], speeds: &[f64], gaps: &[f64]) -> Self {
        let count = counts[rng.random_range(0..counts.len())];
        let gap = gaps[rng.random_range(0..gaps.len())];
        let mut place = 0.0;
        let places = (0..count).map(|_| {
            place += SIZE + gap * rng.random_range(0.1..1.0);
            place
        });
        let places = places.collect();
        let densities = (0..count).map(|_| 10_f64.powf(rng.random_range(3.0..4.0))).collect();
        Self { places, densities, speed: speeds[rng.random_range(0..speeds.len())] }
    }

    fn velocities(&self) -> Vec<f64> {
        (0..self.places.len()).map(|i| if i == 0 { self.speed } else { 0.0 }).collect()
    }

    /// Their velocities after a time [s], impact by impact.
    fn by_events(&self, time: f64) -> Vec<f64> {
        let (mut x, mut v, mut left) = (self.places.clone(), self.velocities(), time);
        loop {
            let meets = |i: usize| {
                let closing = v[i] - v[i + 1];
                let gap = (x[i + 1] - x[i] - SIZE).max(0.0);
                if closing > 1e-9 { gap / closing } else { f64::INFINITY }
            };
            let next = (0..x.len() - 1).map(|i| (meets(i), i));
            let (time, i) = next.min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
            if time > left {
                return v;
            }
            left -= time;
            x.iter_mut().zip(&v).for_each(|(x, v)| *x += v * time);
            let [m, n] = [self.densities[i], self.densities[i + 1]];
            let impulse = 2.0 * (v[i] - v[i + 1]) / (1.0 / m + 1.0 / n);
            v[i] -= impulse / m;
            v[i + 1] += impulse / n;
        }
    }

    /// The same by frames.
    fn by_frames(&self, shape: &ShapeDesc, frames: u32) -> Vec<f64> {
        let mut scene = SceneDesc::new("row");
        scene.gravity = [0.0; 3];
        let body = |(i, v): (usize, f64)| BodyDesc {
            position: [self.places[i], 0.0, 0.0],
            linear_velocity: [v, 0.0, 0.0],
            density: self.densities[i],
            restitution: 1.0,
            friction: 0.0,
            ..BodyDesc::new("body", shape.clone())
        };
        scene.bodies = self.velocities().into_iter().enumerate().map(body).collect();
        let mut world = World::build(&scene).unwrap();
        for _ in 0..frames {
            step(&mut world);
        }
        world.bodies().velocities.iter().map(|velocity| velocity.linear.x).collect()
    }

    /// Asserts that both agree.
    fn check(&self, shape: &ShapeDesc, frames: u32) {
        let found = self.by_frames(shape, frames);
        let expected = self.by_events(f64::from(frames) / 30.0);
        let error = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(
            error < 1e-3 * self.speed,
            "{} at {} m/s: {found:?}, not {expected:?}",
            self.places.len(),
            self.speed
        );
    }
}

/// At 200 m/s a ball comes 6.7 m far in a frame, past many others of its row, and yet strikes the
/// next one first.
#[test]
fn rows_of_balls_of_any_masses_pass_a_blow_on_in_order() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for _ in 0..30 {
        let row = Row::random(&mut rng, &[3, 5, 10], &[5.0, 30.0, 100.0, 200.0], &[0.3, 1.0]);
        row.check(&ball(), 3);
    }
}

/// Touching balls of one mass: the last one flies off, all others stand.
#[test]
fn touching_rows_of_any_length_and_speed_are_exact() {
    for count in [2, 10, 20, 60, 200] {
        for speed in [1.0, 60.0, 100.0, 200.0] {
            let places = (0..count).map(|i| SIZE * f64::from(i)).collect();
            let row = Row { places, densities: vec![1000.0; count as usize], speed };
            let found = row.by_frames(&ball(), 2);
            let (last, others) = found.split_last().unwrap();
            let fastest = others.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            assert!((last / speed - 1.0).abs() < 1e-5, "{count} at {speed} m/s: {last} m/s");
            assert!(fastest < 1e-5 * speed, "{count} at {speed} m/s: {fastest} m/s");
        }
    }
}

/// Faces that meet flat bounce without turning, and cubes that come back within the frame are met
/// with all corners.
#[test]
fn rows_of_cubes_pass_a_blow_on_in_order() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    for _ in 0..30 {
        Row::random(&mut rng, &[2, 3], &[5.0, 30.0, 100.0], &[0.3]).check(&cube(), 2);
    }
}

/// A body that comes fast meets another one at its surface: it bounces from there, or rests there.
#[test]
fn fast_bodies_meet_others_at_their_surfaces() {
    for shape in [cube(), ball()] {
        for (speed, restitution) in [(3.0, 0.0), (10.0, 0.0), (30.0, 0.0), (10.0, 1.0), (30.0, 1.0)]
        {
            let mut scene = SceneDesc::new("drop");
            scene.gravity = [0.0; 3];
            let slab = ShapeDesc::Box { size: [9.0, 1.0, 9.0], resolution: Resolution::default() };
            let height = 0.05;
            scene.bodies = vec![
                BodyDesc {
                    position: [0.0, -0.5, 0.0],
                    motion: MotionDesc::Static,
                    restitution,
                    ..BodyDesc::new("slab", slab)
                },
                BodyDesc {
                    position: [0.0, 0.5 * SIZE + height, 0.0],
                    linear_velocity: [0.0, -speed, 0.0],
                    restitution,
                    ..BodyDesc::new("body", shape.clone())
                },
            ];
            let mut world = World::build(&scene).unwrap();
            step(&mut world);
            let above = world.bodies().poses[1].position.y - 0.5 * SIZE;
            let expected = restitution * (speed / 30.0 - height);
            let error = (above - expected).abs();
            assert!(error < 2e-3, "{shape:?} at {speed} m/s: {above} m, not {expected} m");
        }
    }
}

/// The lowest centre of a body that falls onto the ground within some frames [m].
fn lowest(body: BodyDesc, frames: u32) -> f64 {
    let mut scene = SceneDesc::new("fall");
    scene.bodies = vec![BodyDesc::ground(0.0), body];
    let mut world = World::build(&scene).unwrap();
    let heights = (0..frames).map(|_| {
        step(&mut world);
        world.bodies().poses[1].position.y
    });
    heights.fold(f64::INFINITY, f64::min)
}

/// A body that turns once or more within a frame meets the ground with corners that nobody saw
/// coming; its core stays above.
#[test]
fn what_spins_fast_stays_above_the_ground() {
    for spin in [20.0, 100.0, 400.0] {
        for speed in [5.0, 20.0, 60.0] {
            for phase in 0..6 {
                let body = BodyDesc {
                    position: [0.0, 0.3 + 0.2 * f64::from(phase), 0.0],
                    linear_velocity: [1.0, -speed, 0.5],
                    angular_velocity: [spin, -0.3 * spin, 0.6 * spin],
                    restitution: 0.3,
                    ..BodyDesc::new("cube", cube())
                };
                let lowest = lowest(body, 30);
                assert!(lowest > 0.4 * SIZE, "{spin} rad/s, {speed} m/s: {lowest} m");
            }
        }
    }
}

/// The samples of a disc that is thinner than any length of its contacts find the ground.
#[test]
fn thin_discs_do_not_fall_through_the_ground() {
    for height in [3e-4, 3e-3] {
        let disc = ShapeDesc::Cylinder { radius: 0.12, height, resolution: Resolution::default() };
        let body = BodyDesc {
            position: [0.0, 0.3, 0.0],
            orientation: [0.2, 0.0, 0.1, 0.97],
            angular_velocity: [3.0, 0.5, -1.0],
            ..BodyDesc::new("disc", disc)
        };
        let lowest = lowest(body, 90);
        assert!(lowest > -1e-3, "{height} m thick: {lowest} m");
    }
}
