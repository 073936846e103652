//! Time of the broad and the narrow phase on one core: `cargo bench -p frangible-collision --bench
//! contact`. Prints medians over passes, as CSV. Rocks of 20 points lie in three layers, as dense
//! as a pile.

#[path = "../../bodies/tests/common/mod.rs"]
mod common;

use common::Random;
use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pose, StepSettings, SurfaceProperties, Velocity, predict,
};
use frangible_collision::{ContactCache, ImpulseCache, find_swept_pairs};
use frangible_geometry::{Hull, Shape};
use glam::DVec3;
use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

const DT: f64 = 1.0 / 30.0;

/// Spacing of neighbours relative to the rocks' diameter: a few touch, most are apart.
const SPACING: f64 = 0.95;

/// A rock of about 0.3 m.
fn rock(random: &mut Random) -> Option<Arc<Shape>> {
    let points: Vec<DVec3> = (0..20).map(|_| 0.15 * random.direction()).collect();
    Some(Arc::new(Shape::convex(Hull::of_points(&points).ok()?, 0.1).ok()?))
}

/// `count` rocks in three layers, moving by a few centimetres per frame.
fn pile(count: usize, random: &mut Random) -> Bodies {
    let rocks: Vec<Arc<Shape>> = (0..200).filter_map(|_| rock(random)).collect();
    let across = (count as f64 / 3.0).sqrt().ceil() as usize;
    let mut bodies = Bodies::default();
    for i in 0..count {
        let cell = DVec3::new(
            (i % across) as f64,
            (i / across % across) as f64,
            (i / across / across) as f64,
        );
        let shape = rocks[i % rocks.len()].clone();
        let pose = Pose {
            position: 0.3 * SPACING * (cell + 0.1 * random.vector()),
            orientation: random.orientation(),
        };
        let angular = 0.1 * random.vector();
        let velocity =
            Velocity::spinning(0.2 * random.vector(), angular, pose.orientation, &shape, 1000.0);
        let surface = SurfaceProperties::new(0.0, 0.5);
        bodies.spawn(NewBody {
            shape,
            density: 1000.0,
            motion: Motion::Dynamic,
            pose,
            velocity,
            surface,
        });
    }
    bodies
}

/// Median time of a task [ms], and its last result.
fn median<T>(passes: usize, mut task: impl FnMut() -> T) -> (f64, T) {
    let mut times = Vec::new();
    let mut last = task();
    for _ in 0..passes {
        let start = Instant::now();
        last = black_box(task());
        times.push(1e3 * start.elapsed().as_secs_f64());
    }
    times.sort_by(f64::total_cmp);
    (times[times.len() / 2], last)
}

fn main() {
    let frame = Frame { dt: DT, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
    let (mut random, warm) = (Random::new(1), ImpulseCache::default());
    println!("bodies,pairs,find_pairs_ms,manifolds,find_manifolds_ms,ns_per_pair");
    for (count, passes) in [(1000, 101), (9000, 21), (100_000, 5)] {
        let bodies = pile(count, &mut random);
        let ends = predict(&bodies, &frame);
        let (find_pairs, pairs) =
            median(passes, || find_swept_pairs(&bodies, &ends, frame.speculative_margin(), &frame));
        let (find, manifolds) = median(passes, || {
            ContactCache::default().find_manifolds(&bodies, &pairs, &warm, &frame).iter().count()
        });
        let each = 1e6 * find / pairs.len() as f64;
        println!("{count},{},{find_pairs:.2},{manifolds},{find:.2},{each:.0}", pairs.len());
    }
}
