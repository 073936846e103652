//! Processor time to break a convex body exactly: cells, slivers, mass properties, shapes. As in
//! `breaking`, the time is the thread's own, and excludes dropping the pieces.

#![allow(clippy::unwrap_used, reason = "a benchmark that cannot go on stops")]

use cpu_time::ThreadTime;
use frangible_fracture::{Impact, Pattern, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, Shape};
use glam::DVec3;
use std::hint::black_box;

/// Of each measurement.
const RUNS: usize = 301;

/// Median and 95th percentile of `runs` times [us].
fn measure<T>(runs: usize, mut work: impl FnMut() -> T) -> (f64, f64) {
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = ThreadTime::now();
            let made = black_box(work());
            let time = start.elapsed().as_secs_f64() * 1e6;
            drop(made);
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (times[runs / 2], times[runs * 95 / 100])
}

fn voronoi(cells: usize, seed: u64) -> Pattern {
    Pattern::voronoi(&Voronoi { cells, seed, ..Voronoi::default() }).unwrap()
}

/// The first pattern with this number of pieces of the body.
fn pieces_of(shape: &Shape, impact: &Impact, pieces: usize) -> Pattern {
    let settings = ShatterSettings::default();
    let pattern = |seed: u64| voronoi(pieces + 4 * pieces * (seed as usize % 8) / 8, seed);
    (0..)
        .map(pattern)
        .find(|pattern| shatter(shape, pattern, impact, &settings).len() == pieces)
        .unwrap()
}

fn main() {
    println!("name,path,pieces,median_us,p95_us");
    let settings = ShatterSettings::default();
    let bodies = [
        (
            "box 1 x 0.6 x 0.8",
            ClosedForm::Box { half: DVec3::new(0.5, 0.3, 0.4) },
            DVec3::Y * 0.3,
            25,
        ),
        ("ball", ClosedForm::Sphere { radius: 0.5 }, DVec3::Y * 0.5, 25),
        ("cylinder", ClosedForm::Cylinder { radius: 0.3, half_height: 0.5 }, DVec3::X * 0.3, 25),
        ("ball", ClosedForm::Sphere { radius: 0.5 }, DVec3::Y * 0.5, 9),
    ];
    for (name, form, point_body, pieces) in bodies {
        let shape = Shape::breakable(form, 0.05).unwrap();
        let impact = Impact { point_body, normal_body: point_body.normalize() };
        let pattern = pieces_of(&shape, &impact, pieces);
        let (median, p95) =
            measure(RUNS, || shatter(black_box(&shape), &pattern, &impact, &settings));
        println!("{name},exact,{pieces},{median:.1},{p95:.1}");
    }

    // A thousand balls, each struck somewhere else, one after the other.
    let ball = Shape::breakable(ClosedForm::Sphere { radius: 0.5 }, 0.05).unwrap();
    let strike = |number: u32| {
        let angle = 2.399_963 * f64::from(number);
        let y = 1.0 - (f64::from(number) + 0.5) / 500.0;
        let around = (1.0 - y * y).sqrt();
        let normal_body = DVec3::new(around * libm::cos(angle), y, around * libm::sin(angle));
        Impact { point_body: 0.5 * normal_body, normal_body }
    };
    // The first pattern with nine pieces or more on average.
    let of_twenty = |pattern: &Pattern| -> usize {
        (0..1000).step_by(50).map(|n| shatter(&ball, pattern, &strike(n), &settings).len()).sum()
    };
    let pattern =
        (9..).map(|cells| voronoi(cells, 1)).find(|pattern| of_twenty(pattern) >= 180).unwrap();
    let mut count = 0;
    let (median, p95) = measure(21, || {
        let broken: Vec<_> =
            (0..1000).map(|n| shatter(&ball, &pattern, &strike(n), &settings)).collect();
        count = broken.iter().map(Vec::len).sum::<usize>();
        broken
    });
    println!("1000 balls,exact,{count},{median:.1},{p95:.1}");
}
