//! A break along rough cells fits into a frame [Su09 sec. 4.2].

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use cpu_time::ThreadTime;
use frangible_fracture::{Concrete, Impact, Pattern, ShatterSettings, shatter};
use frangible_geometry::ClosedForm;
use glam::DVec3;

/// Processor time limit of a break, five times the measured time [s].
const MOST_SECONDS: f64 = 0.2;

#[test]
fn a_ball_of_64_voxels_breaks_along_rough_cells_within_a_frame() {
    let radius = 0.3;
    let body = common::sampled_form(ClosedForm::Sphere { radius }, [64; 3]);
    for grain in [0.2, 1.0] {
        let concrete = Concrete { cells: 8, roughness: 0.9, grain, ..Concrete::default() };
        let pattern = Pattern::concrete(&concrete).unwrap();
        pattern.prepare();
        let impact = Impact { point_body: DVec3::Y * -radius, normal_body: DVec3::NEG_Y };
        let seconds = (0..3).map(|_| {
            let start = ThreadTime::now();
            let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());
            assert!(fragments.len() > 2);
            start.elapsed().as_secs_f64()
        });
        let least = seconds.fold(f64::INFINITY, f64::min);
        println!("grain {grain}: {least} s");
        assert!(least < MOST_SECONDS, "grain {grain}: {least} s of processor time");
    }
}
