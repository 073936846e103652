//! Every generator, over the range of its parameters.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{
    Bricks, Concrete, Natural, Pattern, PatternError, Radial, Slices, Splinters, Voronoi,
};
use glam::DVec3;
use proptest::prelude::*;
use rand::RngExt;

fn half_extent() -> impl Strategy<Value = DVec3> {
    (0.1..1.0f64, 0.1..1.0f64, 0.1..1.0f64).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

/// A pattern that is shown by its parameters.
struct Made {
    pattern: Pattern,
    parameters: String,
}

impl std::fmt::Debug for Made {
    fn fmt(&self, to: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        to.write_str(&self.parameters)
    }
}

fn made<T: std::fmt::Debug>(of: &T, make: fn(&T) -> Result<Pattern, PatternError>) -> Made {
    Made { pattern: make(of).unwrap(), parameters: format!("{of:?}") }
}

/// Planar patterns of all kinds.
fn planar() -> impl Strategy<Value = Made> {
    let radial = (3..30usize, 0..6usize, 0.0..=1.0, any::<u64>()).prop_map(
        |(spokes, rings, jitter, seed)| {
            made(&Radial { spokes, rings, jitter, seed }, Pattern::radial)
        },
    );
    let voronoi = (1..60usize, 0.0..10.0, half_extent(), half_extent(), any::<u64>()).prop_map(
        |(cells, clustering, grading, half_extent, seed)| {
            let grading = 10.0 * (grading - 0.5);
            made(&Voronoi { cells, clustering, grading, seed, half_extent }, Pattern::voronoi)
        },
    );
    let natural = (1..80usize, 0.0..=1.0, half_extent(), any::<u64>()).prop_map(
        |(cells, spread, half_extent, seed)| {
            made(
                &Natural { cells, spread, seed, half_extent, ..Natural::default() },
                Pattern::natural,
            )
        },
    );
    let slices = (1..30usize, half_extent(), 0.0..=1.0, half_extent(), any::<u64>()).prop_map(
        |(cells, axis, jitter, half_extent, seed)| {
            made(&Slices { cells, axis: axis - 0.3, jitter, seed, half_extent }, Pattern::slices)
        },
    );
    let bricks = (1..8usize, 1..12usize, 0.0..=0.5, 0.0..=1.0, half_extent(), any::<u64>())
        .prop_map(|(columns, courses, mortar, jitter, half_extent, seed)| {
            made(&Bricks { columns, courses, mortar, jitter, seed, half_extent }, Pattern::bricks)
        });
    let splinters =
        (1..20usize, 1..4usize, 0..3usize, 0.0..20.0, 0.0..=1.0, half_extent(), any::<u64>())
            .prop_map(|(fibres, pieces, grain, sharpness, spread, half_extent, seed)| {
                let shape =
                    Splinters { fibres, pieces, grain, sharpness, spread, seed, half_extent };
                made(&shape, Pattern::splinters)
            });
    prop_oneof![radial, voronoi, natural, slices, bricks, splinters]
}

/// A point anywhere in the box.
fn point_in(pattern: &Pattern, random: &mut impl RngExt) -> DVec3 {
    pattern.half_extent
        * (2.0 * DVec3::new(random.random(), random.random(), random.random()) - 1.0)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(150))]

    /// Volumes add up, exactly one cell holds each point, and each cell is closed and as large as
    /// its planes say.
    #[test]
    fn planar_patterns_tile_their_box(made in planar(), seed in any::<u64>()) {
        let pattern = made.pattern;
        prop_assert!(pattern.tiling_defect() < 1e-9, "{}", pattern.tiling_defect());
        let mut random = common::random(seed);
        for _ in 0..50 {
            let point = point_in(&pattern, &mut random);
            let inside = (0..pattern.len()).filter(|&cell| pattern.distance(cell, point) < -1e-9).count();
            let near = (0..pattern.len()).filter(|&cell| pattern.distance(cell, point) <= 1e-9).count();
            prop_assert!(inside <= 1 && near >= 1, "{inside} cells hold {point}, {near} nearly");
        }
        let scale = 8.0 * pattern.half_extent.element_product();
        for (cell, region) in pattern.planar().unwrap().iter().enumerate() {
            let mesh = pattern.region_mesh(cell, f64::INFINITY);
            prop_assert!(mesh.is_watertight() && !mesh.triangles.is_empty());
            let difference = mesh.mass_properties().volume - pattern.region_volume(region);
            prop_assert!(difference.abs() < 1e-9 * scale, "{difference}");
        }
        for shape in pattern.cell_shapes() {
            // Euler's formula for the polyhedra whose corners are not all of three edges: V - E + F
            // = 2 and 2 E >= 3 V.
            prop_assert!(shape.faces >= 4 && shape.corners <= 2 * shape.faces - 4);
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]

    /// Rough cells have the sign that tells where a point is, distances that no way outruns, closed
    /// surfaces that are where the distance vanishes, and volumes that add up to the box's.
    #[test]
    fn concrete_tiles_its_box(
        cells in 2..12usize, roughness in 0.05..=1.0, grain in 0.5..2.0, half_extent in half_extent(),
        seed in any::<u64>(),
    ) {
        let half_extent = half_extent + 0.3;
        let concrete = Concrete { cells, roughness, grain, clustering: 0.0, seed, half_extent };
        let pattern = Pattern::concrete(&concrete).unwrap();
        prop_assert!(pattern.planar().is_none());
        let mut random = common::random(seed);
        for _ in 0..100 {
            let (a, b) = (point_in(&pattern, &mut random), point_in(&pattern, &mut random));
            let b = a + (b - a) * libm::pow(10.0, -3.0 * random.random::<f64>());
            let holder = pattern.region_at(a).unwrap();
            for cell in 0..cells {
                let (at_a, at_b) = (pattern.distance(cell, a), pattern.distance(cell, b));
                prop_assert!((at_a - at_b).abs() <= a.distance(b) * (1.0 + 1e-12));
                prop_assert_eq!(at_a < 0.0, cell == holder);
            }
        }
        let mut volume = 0.0;
        for cell in 0..cells {
            let mesh = pattern.region_mesh(cell, f64::INFINITY);
            prop_assert!(mesh.is_watertight());
            volume += mesh.mass_properties().volume;
            // Distances know the noise by its samples.
            for point in common::inside_of_box(&pattern, &mesh) {
                prop_assert!(pattern.distance(cell, point).abs() < 1e-2 * half_extent.max_element());
            }
        }
        let whole = 8.0 * half_extent.element_product();
        prop_assert!((volume / whole - 1.0).abs() < 1e-9, "{volume} {whole}");
    }
}

/// Concrete's faces are what sets it apart: they leave the planes behind them by some hundredths of
/// a cell.
#[test]
fn concrete_is_rough() {
    let concrete = Concrete { cells: 8, ..Concrete::default() };
    let rough = Pattern::concrete(&concrete).unwrap();
    let plane = Pattern::concrete(&Concrete { roughness: 0.0, ..concrete }).unwrap();
    assert!(plane.planar().is_some());
    let off = |cell: usize| {
        let points = common::inside_of_box(&rough, &rough.region_mesh(cell, 1.0));
        points.iter().map(|&point| plane.distance(cell, point).abs()).fold(0.0, f64::max)
    };
    let largest = (0..8).map(off).fold(0.0, f64::max);
    assert!((0.02..0.3).contains(&largest), "{largest}");
}

/// Mean number of faces and corners of all cells, and of those that touch no wall.
fn means(patterns: &[Pattern]) -> [(f64, f64); 2] {
    let shapes: Vec<_> = patterns.iter().flat_map(Pattern::cell_shapes).collect();
    [false, true].map(|only_inner| {
        let chosen = shapes.iter().filter(|shape| shape.inner || !only_inner);
        let count = chosen.clone().count() as f64;
        let faces: usize = chosen.clone().map(|shape| shape.faces).sum();
        let corners: usize = chosen.map(|shape| shape.corners).sum();
        (faces as f64 / count, corners as f64 / count)
    })
}

/// Natural fragments are cuboids in the mean [DJKT20]; Voronoi cells, a negative control, have
/// 15.54 faces far from walls.
#[test]
fn natural_cells_have_six_faces_and_eight_corners_in_the_mean() {
    for cells in [25, 100, 500] {
        let patterns: Vec<Pattern> = (0..3000 / cells as u64)
            .map(|seed| Pattern::natural(&Natural { cells, seed, ..Natural::default() }).unwrap())
            .collect();
        for (faces, corners) in means(&patterns) {
            if cells > 25 {
                assert!((faces / 6.0 - 1.0).abs() < 0.1, "{cells}: {faces} faces");
                assert!((corners / 8.0 - 1.0).abs() < 0.1, "{cells}: {corners} corners");
            }
        }
        let (faces, corners) = means(&patterns)[0];
        assert!((faces / 6.0 - 1.0).abs() < 0.1, "{cells}: {faces} faces");
        assert!((corners / 8.0 - 1.0).abs() < 0.1, "{cells}: {corners} corners");
    }
    let voronoi = Pattern::voronoi(&Voronoi { cells: 2000, ..Voronoi::default() }).unwrap();
    let (faces, corners) = means(&[voronoi])[1];
    assert!((14.7..15.8).contains(&faces), "{faces}");
    assert!((25.4..27.6).contains(&corners), "{corners}");
}

/// A wall of 6 x 4 bricks: every other course has a half brick at both ends, and each brick has a
/// joint beside it and above.
#[test]
fn bricks_lie_in_running_bond() {
    let half_extent = DVec3::ONE;
    let bricks = Bricks {
        columns: 6,
        courses: 4,
        mortar: 0.16,
        jitter: 0.0,
        half_extent,
        ..Bricks::default()
    };
    let pattern = Pattern::bricks(&bricks).unwrap();
    let volumes: Vec<f64> = pattern.cell_shapes().iter().map(|shape| shape.volume).collect();
    // Bricks of 1/3 x 1/2 with joints of 0.08: 6 bricks and 5 joints, or 5 bricks, 2 halves and 6
    // joints beside them.
    let count = |length: f64, height: f64| {
        volumes.iter().filter(|&&volume| (volume - 2.0 * length * height).abs() < 1e-9).count()
    };
    let (length, half) = (1.0 / 3.0, 1.0 / 6.0);
    assert_eq!(count(length - 0.08, 0.42), 2 * 5 + 2 * 5);
    assert_eq!(count(length, 0.42), 2, "the last brick of an even course has no joint beside it");
    assert_eq!(count(half - 0.08, 0.42), 2, "the first half bricks");
    assert_eq!(count(half, 0.42), 2, "the last half bricks");
    assert_eq!(count(0.08, 0.42), 2 * 5 + 2 * 6, "joints beside");
    assert_eq!(count(length, 0.08) + count(half, 0.08), 2 * 6 + 2 * 7, "joints above");
    let plain = Pattern::bricks(&Bricks { mortar: 0.0, ..bricks }).unwrap();
    assert_eq!(plain.len(), 2 * 6 + 2 * 7);
}

/// Splinters are several times longer along the grain than across, and pointed.
#[test]
fn splinters_are_long_and_pointed() {
    for grain in 0..3 {
        let mut half_extent = DVec3::splat(0.25);
        half_extent[grain] = 1.0;
        let pattern =
            Pattern::splinters(&Splinters { grain, half_extent, ..Splinters::default() }).unwrap();
        assert_eq!(pattern.len(), 48);
        let mut ratios: Vec<f64> = (0..pattern.len())
            .map(|cell| {
                let (low, high) = pattern.region_mesh(cell, f64::INFINITY).bounds();
                let extent = high - low;
                extent[grain] / extent[(grain + 1) % 3].max(extent[(grain + 2) % 3])
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        assert!(ratios[24] > 4.0, "{}", ratios[24]);
    }
}

/// Grading makes the cells of one end smaller: e^4 times as dense at the upper end as at the lower.
#[test]
fn graded_cells_crowd_at_one_end() {
    let grading = DVec3::new(2.0, 0.0, 0.0);
    let pattern =
        Pattern::voronoi(&Voronoi { cells: 2000, grading, ..Voronoi::default() }).unwrap();
    let center = |cell| pattern.region_mesh(cell, f64::INFINITY).mass_properties().center;
    let centers: Vec<DVec3> = (0..pattern.len()).map(center).collect();
    let share = |low: f64, high: f64| {
        centers.iter().filter(|c| (low..high).contains(&c.x)).count() as f64 / centers.len() as f64
    };
    // The integral of 2 exp(2 x) / (e^2 - e^-2) from 0 to 1.
    let expected = (2f64.exp() - 1.0) / (2f64.exp() - (-2f64).exp());
    assert!((share(0.0, 1.0) - expected).abs() < 0.03, "{} {expected}", share(0.0, 1.0));
    assert!((centers.iter().filter(|c| c.y > 0.0).count() as f64 / 2000.0 - 0.5).abs() < 0.05);
}

#[test]
fn the_seed_decides_and_nothing_else() {
    let natural = |seed| Pattern::natural(&Natural { seed, ..Natural::default() }).unwrap();
    let concrete = |seed| Pattern::concrete(&Concrete { seed, ..Concrete::default() }).unwrap();
    let splinters = |seed| Pattern::splinters(&Splinters { seed, ..Splinters::default() }).unwrap();
    let bricks = |seed| Pattern::bricks(&Bricks { seed, ..Bricks::default() }).unwrap();
    let slices = |seed| Pattern::slices(&Slices { seed, ..Slices::default() }).unwrap();
    let makers: [&dyn Fn(u64) -> Pattern; 5] = [&natural, &concrete, &splinters, &bricks, &slices];
    for make in makers {
        assert_eq!(make(7), make(7));
        assert_ne!(make(7), make(8));
    }
}

#[test]
fn parameters_out_of_range_are_named() {
    let named = |made: Result<Pattern, PatternError>| made.unwrap_err().to_string();
    let natural = Natural { spread: 1.5, ..Natural::default() };
    assert_eq!(named(Pattern::natural(&natural)), "spread: 1.5, must be from 0 to 1");
    let slices = Slices { axis: DVec3::ZERO, ..Slices::default() };
    assert_eq!(
        named(Pattern::slices(&slices)),
        "axis: 0, must be three finite numbers that are not all 0"
    );
    let bricks = Bricks { mortar: f64::NAN, ..Bricks::default() };
    assert_eq!(named(Pattern::bricks(&bricks)), "mortar: NaN, must be from 0 to 0.5");
    let splinters = Splinters { grain: 3, ..Splinters::default() };
    assert_eq!(named(Pattern::splinters(&splinters)), "grain: 3, must be 0, 1 or 2");
    let concrete = Concrete { grain: 0.0, ..Concrete::default() };
    assert_eq!(named(Pattern::concrete(&concrete)), "grain: 0, must be from 0.05 to 2");
    let voronoi = Voronoi { cells: 0, ..Voronoi::default() };
    assert_eq!(named(Pattern::voronoi(&voronoi)), "cells: 0, must be from 1 to 10000");
}
