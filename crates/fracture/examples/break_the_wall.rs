//! Breaks the paper's wall with both kinds of pattern and says how long it takes.

use frangible_fracture::{Impact, Pattern, Radial, ShatterSettings, Voronoi, shatter};
use frangible_geometry::{ClosedForm, GridSolid, Shape};
use glam::DVec3;
use std::time::Instant;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    // 6 x 0.4 x 4 m on 150 x 10 x 100 voxels of 4 cm.
    let form = ClosedForm::Box { half: DVec3::new(3.0, 0.2, 2.0) };
    let samples = Shape::closed_form(form, 0.08).samples().to_vec();
    let wall =
        Shape::from_grid_solid(GridSolid::from_closed_form(form, [150, 10, 100], 2)?, samples)?;

    let radial = |rings| Pattern::radial(&Radial { rings, ..Radial::default() });
    let half_extent = DVec3::new(3.0, 2.0, 0.5);
    let voronoi = |cells| Pattern::voronoi(&Voronoi { cells, half_extent, ..Voronoi::default() });
    let patterns = [
        ("12 wedges", radial(0)?),
        ("12 wedges, 2 rings", radial(2)?),
        ("25 cells", voronoi(25)?),
        ("40 cells", voronoi(40)?),
    ];
    let impact = Impact { point_body: DVec3::new(0.5, 0.2, -0.3), normal_body: DVec3::Y };
    for (name, pattern) in patterns {
        // Minimum of many runs: other load on the machine only adds time.
        let mut least = f64::INFINITY;
        let mut fragments = Vec::new();
        for _ in 0..50 {
            let start = Instant::now();
            fragments = shatter(&wall, &pattern, &impact, &ShatterSettings::default());
            least = least.min(start.elapsed().as_secs_f64());
        }
        let samples: usize = fragments.iter().map(|fragment| fragment.shape.samples().len()).sum();
        println!(
            "{name}: {} pieces, {} samples become {samples}, {:.2} ms",
            fragments.len(),
            wall.samples().len(),
            1e3 * least
        );
    }
    Ok(())
}
