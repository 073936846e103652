//! Breaks the paper's wall with both kinds of pattern and says how long it takes.

#[path = "../tests/common/mod.rs"]
mod common;

use frangible_fracture::{Impact, Pattern, Radial, ShatterSettings, Voronoi, shatter};
use glam::DVec3;
use std::time::Instant;

fn main() {
    let wall = common::wall();
    let radial = |rings| Pattern::radial(&Radial { rings, ..Radial::default() });
    let voronoi = |cells| {
        Pattern::voronoi(&Voronoi { cells, half_extent: DVec3::new(3.0, 2.0, 0.5), ..Voronoi::default() })
    };
    let impact = Impact { point_body: DVec3::new(0.5, 0.2, -0.3), normal_body: DVec3::Y };
    let named = [
        ("12 wedges", radial(0)),
        ("12 wedges, 2 rings", radial(2)),
        ("25 cells", voronoi(25)),
        ("40 cells", voronoi(40)),
    ];
    for (name, pattern) in named {
        let Ok(pattern) = pattern else { continue };
        let settings = ShatterSettings::default();
        let mut least = f64::INFINITY;
        let mut fragments = Vec::new();
        for _ in 0..20 {
            let start = Instant::now();
            fragments = shatter(&wall, &pattern, &impact, &settings);
            least = least.min(start.elapsed().as_secs_f64());
        }
        let samples: usize = fragments.iter().map(|fragment| fragment.shape.samples.len()).sum();
        println!(
            "{name}: {} pieces with {samples} samples from {} in {:.2} ms",
            fragments.len(),
            wall.samples.len(),
            1e3 * least
        );
    }
}
