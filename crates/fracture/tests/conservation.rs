//! Conservation through a break: every voxel's material, mass, momentum, angular momentum and
//! kinetic energy.

mod common;

use common::{assert_voxels_shared_out, defect, solid};
use frangible_fracture::{Fragment, ShatterSettings, align_pattern, shatter};
use frangible_geometry::{Grid, LevelSet, Shape};
use rand_pcg::Pcg64Mcg;

fn assert_conserves(parent: &Shape, fragments: &[Fragment], random: &mut Pcg64Mcg, what: &str) {
    assert!(!fragments.is_empty(), "{what}");
    assert_voxels_shared_out(parent, fragments);
    let defect = defect(parent, fragments, random);
    assert!(defect < 1e-10, "{what}: {defect}");
}

#[test]
fn breaks_keep_everything() {
    let mut random = common::random(11);
    let mut breaks = 0;
    for seed in 0..6 {
        for (name, body) in common::bodies() {
            for pattern in common::patterns(seed) {
                let impact = common::random_impact(&body, &mut random);
                let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());
                assert!(fragments.len() > 1, "{name} did not break");
                assert_conserves(&body, &fragments, &mut random, name);
                breaks += 1;
            }
        }
    }
    assert_eq!(breaks, 120);
}

/// Fragments are ordinary bodies: they break again, without loss of material.
#[test]
fn fragments_break_again() {
    let mut random = common::random(12);
    for (name, body) in common::bodies() {
        let [_, ringed, _, clustered] = common::patterns(2).try_into().unwrap();
        let impact = common::random_impact(&body, &mut random);
        let mut generation = shatter(&body, &clustered, &impact, &ShatterSettings::default());
        for _ in 0..2 {
            generation.sort_by(|a, b| b.shape.volume.total_cmp(&a.shape.volume));
            let parent = generation.swap_remove(0).shape;
            let impact = common::random_impact(&parent, &mut random);
            generation = shatter(&parent, &ringed, &impact, &ShatterSettings::default());
            assert!(generation.len() > 1, "{name} did not break again");
            assert_conserves(&parent, &generation, &mut random, name);
        }
    }
}

/// Without merging, every crumb down to a single voxel is a fragment, and still nothing is lost.
#[test]
fn crumbs_keep_everything_too() {
    let mut random = common::random(13);
    let settings = ShatterSettings { smallest_fragment_voxels: 0.0, ..ShatterSettings::default() };
    let mut crumbs = 0;
    for (name, body) in common::bodies() {
        for pattern in common::patterns(9) {
            let impact = common::random_impact(&body, &mut random);
            let fragments = shatter(&body, &pattern, &impact, &settings);
            assert_conserves(&body, &fragments, &mut random, name);
            let voxel = solid(&body).grid().voxel_volume();
            crumbs +=
                fragments.iter().filter(|fragment| fragment.shape.volume < 27.0 * voxel).count();
        }
    }
    assert!(crumbs > 20, "the test is about crumbs: {crumbs}");
}

/// The authors' way to the same fragments: each region is a level set on a grid of its own,
/// interpolated at the parent's nodes, and a node with `phi <= 0` counts as one full voxel. Along
/// the edges of the regions voxels drop out, so that mass is not kept.
#[test]
fn interpolated_regions_lose_mass() {
    let body = common::bodies().swap_remove(1).1;
    let mut random = common::random(14);
    let impact = common::random_impact(&body, &mut random);
    let pattern = common::patterns(4).swap_remove(2);
    let fragments = shatter(&body, &pattern, &impact, &ShatterSettings::default());
    assert_conserves(&body, &fragments, &mut random, "box");

    let parent = solid(&body).level_set();
    let grid = parent.grid();
    let (low, high) = grid.bounds();
    let coarse = Grid::around_box(low, high, [20, 5, 16], 2);
    let inside = |level_set: &LevelSet| {
        (0..grid.len())
            .filter(|&node| {
                let [i, j, k] = grid.coordinates(node);
                parent.phi()[node].max(level_set.value(grid.node(i, j, k))) <= 0.0
            })
            .count()
    };
    let regions = align_pattern(&pattern, &impact, &body);
    let counted: usize = regions
        .iter()
        .map(|region| inside(&LevelSet::sample(coarse, |point| region.distance(point))))
        .sum();
    let whole = parent.phi().iter().filter(|&&phi| phi <= 0.0).count();
    let defect = 1.0 - counted as f64 / whole as f64;
    assert!(defect > 1e-3, "{defect}");
}
