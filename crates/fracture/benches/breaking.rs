//! Processor time of one break on one core: `cargo bench -p frangible-fracture --bench breaking`.
//! Prints the rows of `bench/results/breaking.csv`. Fragments are whole bodies, with samples and
//! mass properties; their surfaces for drawing are not made. The thread's own time is measured, so
//! that programs which run beside count only by what they take of the caches and of a shared core.

#![allow(clippy::expect_used, reason = "a benchmark with wrong parameters ends")]

#[path = "../tests/common/mod.rs"]
mod common;

use cpu_time::ThreadTime;
use frangible_fracture::{Impact, Pattern, Radial, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, Shape};
use glam::DVec3;
use std::hint::black_box;

const PASSES: usize = 201;

/// A body, its impact point, and its pattern.
struct Case {
    name: &'static str,
    path: &'static str,
    body: Shape,
    impact: Impact,
    pattern: Pattern,
}

/// The bodies of [Su09 fig. 4, 5] on the paper's grids.
fn cases() -> Vec<Case> {
    let radial = || Pattern::radial(&Radial::default());
    let voronoi = |half_extent| Pattern::voronoi(&Voronoi { half_extent, ..Voronoi::default() });
    let wall_struck = Impact { point_body: DVec3::new(0.71, 0.2, 0.43), normal_body: DVec3::Y };
    let ball_normal = DVec3::new(0.3, 0.9, -0.2).normalize();
    let ball_struck = Impact { point_body: 0.5 * ball_normal, normal_body: ball_normal };
    let ball = || common::sampled_form(ClosedForm::Sphere { radius: 0.5 }, [55; 3]);
    let grid = |name, body, impact, pattern: Result<Pattern, _>| {
        let pattern = pattern.expect("the parameters are in range");
        Case { name, path: "grid", body, impact, pattern }
    };
    vec![
        grid("wall 150x10x100 radial 12", common::wall(), wall_struck, radial()),
        grid(
            "wall 150x10x100 voronoi 25",
            common::wall(),
            wall_struck,
            voronoi(DVec3::new(1.5, 1.0, 0.1)),
        ),
        grid("ball 55^3 radial 12", ball(), ball_struck, radial()),
        grid("ball 55^3 voronoi 25", ball(), ball_struck, voronoi(DVec3::ONE)),
    ]
}

/// Number of pieces and processor time of each pass [us], sorted.
fn measure(case: &Case) -> (usize, Vec<f64>) {
    let settings = ShatterSettings::default();
    let mut pieces = 0;
    let mut times: Vec<f64> = (0..PASSES)
        .map(|_| {
            let start = ThreadTime::now();
            let fragments =
                black_box(shatter(black_box(&case.body), &case.pattern, &case.impact, &settings));
            let time = start.elapsed().as_secs_f64() * 1e6;
            pieces = fragments.len();
            time
        })
        .collect();
    times.sort_by(f64::total_cmp);
    (pieces, times)
}

fn main() {
    println!("name,path,pieces,median_us,p95_us");
    for case in cases() {
        let (pieces, times) = measure(&case);
        let [median, p95] = [0.5, 0.95].map(|part| times[(part * (PASSES - 1) as f64) as usize]);
        println!("{},{},{pieces},{median:.0},{p95:.0}", case.name, case.path);
    }
}
