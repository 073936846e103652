//! Patterns tile their box, and everything beyond it too.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{Cells, Pattern, PatternError, Radial, Region, Voronoi};
use glam::DVec3;
use rand::RngExt;

/// Patterns over the range of all parameters.
fn many_patterns() -> Vec<Pattern> {
    let mut patterns = Vec::new();
    for seed in 0..10 {
        for (spokes, rings, jitter) in
            [(3, 0, 1.0), (3, 4, 1.0), (12, 0, 0.5), (9, 5, 0.8), (40, 8, 1.0)]
        {
            patterns.push(Pattern::radial(&Radial { spokes, rings, jitter, seed }).unwrap());
        }
        for (cells, clustering) in [(1, 0.0), (2, 0.0), (25, 0.0), (25, 4.0), (60, 1.0), (30, 30.0)]
        {
            let half_extent = DVec3::new(1.0, 0.3, 2.0);
            patterns.push(
                Pattern::voronoi(&Voronoi {
                    cells,
                    clustering,
                    seed,
                    half_extent,
                    ..Voronoi::default()
                })
                .unwrap(),
            );
        }
    }
    patterns
}

#[test]
fn regions_tile_the_box() {
    let mut random = common::random(5);
    for pattern in many_patterns() {
        assert!(pattern.tiling_defect() < 1e-9, "{}", pattern.tiling_defect());
        for _ in 0..200 {
            let point = pattern.half_extent
                * (2.0 * DVec3::new(random.random(), random.random(), random.random()) - 1.0);
            let distances: Vec<f64> =
                pattern.planar().unwrap().iter().map(|region| region.distance(point)).collect();
            let inside = distances.iter().filter(|&&distance| distance < -1e-9).count();
            let near = distances.iter().filter(|&&distance| distance <= 1e-9).count();
            assert!(inside <= 1, "regions overlap at {point}");
            assert!(near >= 1, "no region holds {point}");
            if inside == 1 {
                let holder = distances.iter().position(|&distance| distance < -1e-9);
                assert_eq!(pattern.region_at(point), holder);
            }
        }
    }
}

/// A pattern with a lost or a repeated region is detected.
#[test]
fn the_tiling_check_sees_gaps_and_overlaps() {
    let whole = Pattern::voronoi(&Voronoi::default()).unwrap();
    let mut regions = whole.planar().unwrap().to_vec();
    let overlap = [&regions[..], &regions[..1]].concat();
    regions.pop();
    let gap = Pattern { cells: Cells::Planar(regions), ..whole };
    assert!(gap.tiling_defect() > 1e-3);
    let overlap = Pattern { cells: Cells::Planar(overlap), ..gap };
    assert!(overlap.tiling_defect() > 1e-3);
}

#[test]
fn faces_lie_on_their_region() {
    for pattern in many_patterns() {
        for region in pattern.planar().unwrap() {
            for cut in &region.cuts {
                assert!(cut.face.len() >= 3);
                assert!((cut.half_space.normal.length() - 1.0).abs() < 1e-12);
                let turn = (cut.face[1] - cut.face[0]).cross(cut.face[2] - cut.face[1]);
                assert!(turn.dot(cut.half_space.normal) > -1e-12);
                for &corner in &cut.face {
                    assert!(region.distance(corner).abs() < 1e-9);
                    assert!((corner.abs() - pattern.half_extent).max_element() < 1e-9);
                }
            }
        }
    }
}

/// The paper's pattern: wedges around the line through the centre along the collision normal.
#[test]
fn spokes_meet_on_the_normal() {
    let pattern = Pattern::radial(&Radial { spokes: 12, rings: 0, jitter: 1.0, seed: 3 }).unwrap();
    assert_eq!(pattern.len(), 12);
    for region in pattern.planar().unwrap() {
        assert_eq!(region.cuts.len(), 2);
        for z in [-0.7, 0.0, 0.4] {
            let on_axis = pattern.center + DVec3::Z * z;
            assert!(region.distance(on_axis).abs() < 1e-15);
        }
    }
    let ringed = Pattern::radial(&Radial { spokes: 12, rings: 4, jitter: 0.5, seed: 3 }).unwrap();
    assert_eq!(ringed.len(), 60);
}

#[test]
fn clustering_makes_small_cells_at_the_centre() {
    let mean_volume_at_center = |clustering: f64| {
        let volumes = (0..20).map(|seed| {
            let pattern =
                Pattern::voronoi(&Voronoi { cells: 30, clustering, seed, ..Voronoi::default() })
                    .unwrap();
            let at_center = |region: &&Region| region.distance(pattern.center) <= 0.0;
            pattern.region_volume(pattern.planar().unwrap().iter().find(at_center).unwrap())
        });
        volumes.sum::<f64>() / 20.0
    };
    assert!(mean_volume_at_center(4.0) < 0.2 * mean_volume_at_center(0.0));
}

#[test]
fn the_seed_decides_and_nothing_else() {
    let make = |seed| Pattern::voronoi(&Voronoi { seed, ..Voronoi::default() }).unwrap();
    let planes = |pattern: &Pattern| {
        let cuts = pattern.planar().unwrap().iter().flat_map(|region| &region.cuts);
        cuts.map(|cut| cut.half_space).collect::<Vec<_>>()
    };
    assert_eq!(planes(&make(7)), planes(&make(7)));
    assert_ne!(planes(&make(7)), planes(&make(8)));
}

#[test]
fn parameters_out_of_range_are_named() {
    let error = Pattern::radial(&Radial { spokes: 2, ..Radial::default() }).unwrap_err();
    assert_eq!(error.to_string(), "spokes: 2, must be from 3 to 10000");
    let jitter = Pattern::radial(&Radial { jitter: f64::NAN, ..Radial::default() });
    assert!(matches!(jitter, Err(PatternError::Parameter { parameter: "jitter", .. })));
    for voronoi in [
        Voronoi { cells: 0, ..Voronoi::default() },
        Voronoi { clustering: -1.0, ..Voronoi::default() },
        Voronoi { half_extent: DVec3::new(1.0, 0.0, 1.0), ..Voronoi::default() },
    ] {
        assert!(Pattern::voronoi(&voronoi).is_err());
    }
}

/// Each cell's mesh is closed and has the cell's volume, however finely its edges are cut.
#[test]
fn cell_meshes_are_closed_and_fill_their_cells() {
    for pattern in many_patterns().into_iter().step_by(3) {
        for (cell, region) in pattern.planar().unwrap().iter().enumerate() {
            let whole = pattern.region_mesh(cell, f64::INFINITY);
            assert!(whole.is_watertight());
            let volume = pattern.region_volume(region);
            let scale = 8.0 * pattern.half_extent.element_product();
            assert!((whole.mass_properties().volume - volume).abs() < 1e-8 * scale);
            if cell % 5 == 0 {
                let longest = 0.2;
                let fine = pattern.region_mesh(cell, longest);
                assert!(fine.is_watertight());
                assert!((fine.mass_properties().volume - volume).abs() < 1e-8 * scale);
                for triangle in 0..fine.triangles.len() {
                    let [a, b, c] = fine.corners(triangle);
                    let longest_side = a.distance(b).max(b.distance(c)).max(c.distance(a));
                    assert!(longest_side <= longest);
                }
            }
        }
    }
}

/// Cell triangles off the box match a neighbour's bit for bit, reversed.
#[test]
fn neighbours_share_the_triangles_between_them() {
    for pattern in many_patterns().into_iter().skip(1).step_by(4) {
        let e = pattern.half_extent;
        let mut faces = std::collections::BTreeMap::new();
        for cell in 0..pattern.len() {
            let mesh = pattern.region_mesh(cell, 0.4);
            for triangle in 0..mesh.triangles.len() {
                let corners = mesh.corners(triangle);
                let on_box = (0..3).any(|axis| {
                    let at =
                        |sign: f64| corners.iter().all(|c| (sign * c[axis] - e[axis]).abs() < 1e-9);
                    at(1.0) || at(-1.0)
                });
                if !on_box {
                    let mut keys = corners.map(|corner| corner.to_array().map(f64::to_bits));
                    let turns = (keys[0] < keys[1]) ^ (keys[1] < keys[2]) ^ (keys[0] < keys[2]);
                    keys.sort_unstable();
                    *faces.entry(keys).or_insert(0) += if turns { 1 } else { -1 };
                }
            }
        }
        let alone = faces.values().filter(|&&sum| sum != 0).count();
        assert_eq!(alone, 0, "of {} faces", faces.len());
    }
}

#[test]
fn vertices_of_cracks_lie_on_their_cell_and_on_another() {
    for pattern in many_patterns().into_iter().skip(2).step_by(5) {
        for cell in 0..pattern.len() {
            for point in common::inside_of_box(&pattern, &pattern.region_mesh(cell, 0.3)) {
                assert!(pattern.distance(cell, point).abs() < 1e-9);
                let others = (0..pattern.len()).filter(|&other| other != cell);
                let nearest = others
                    .map(|other| pattern.distance(other, point))
                    .fold(f64::INFINITY, f64::min);
                assert!(nearest.abs() < 1e-9);
            }
        }
    }
}
