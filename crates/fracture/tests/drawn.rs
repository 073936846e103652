//! Drawn cells fill their box, or an error message locates the misfit.

#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use frangible_fracture::{Cells, Natural, Pattern, Voronoi};
use frangible_geometry::{Bvh, TriMesh};
use glam::DVec3;
use proptest::prelude::*;
use rand::RngExt;
use std::fmt::Write;

/// The cells of a pattern as an artist's meshes, off the origin and in another unit.
fn as_meshes(pattern: &Pattern) -> Vec<TriMesh> {
    let place = |point: DVec3| 3.0 * point + DVec3::new(5.0, -1.0, 0.25);
    (0..pattern.len())
        .map(|cell| {
            let mesh = pattern.region_mesh(cell, f64::INFINITY);
            TriMesh { positions: mesh.positions.into_iter().map(place).collect(), ..mesh }
        })
        .collect()
}

fn voronoi(cells: usize, seed: u64) -> Pattern {
    let half_extent = DVec3::new(1.0, 0.6, 0.8);
    Pattern::voronoi(&Voronoi { cells, seed, half_extent, ..Voronoi::default() }).unwrap()
}

/// Distance to the nearest of the other cells' surfaces, from inside of one [m].
fn to_others(surfaces: &[Bvh], cell: usize, point: DVec3) -> f64 {
    let others = surfaces.iter().enumerate().filter(|&(other, _)| other != cell);
    let squared = others.filter_map(|(_, surface)| surface.closest(point, f64::INFINITY));
    squared.map(|closest| closest.distance_squared).fold(f64::INFINITY, f64::min).sqrt()
}

/// An OBJ file of meshes; with `split` each triangle has vertices of its own.
fn obj(meshes: &[TriMesh], split: bool) -> String {
    let mut text = String::new();
    let mut count = 0;
    for (cell, mesh) in meshes.iter().enumerate() {
        writeln!(text, "o cell{cell}").unwrap();
        let corners: Vec<DVec3> =
            (0..mesh.triangles.len()).flat_map(|triangle| mesh.corners(triangle)).collect();
        let positions = if split { &corners } else { &mesh.positions };
        for p in positions {
            writeln!(text, "v {} {} {}", p.x, p.y, p.z).unwrap();
        }
        for (triangle, corners) in mesh.triangles.iter().enumerate() {
            let corners =
                if split { [0, 1, 2].map(|corner| 3 * triangle as u32 + corner) } else { *corners };
            let [a, b, c] = corners.map(|corner| count + 1 + corner);
            writeln!(text, "f {a} {b} {c}").unwrap();
        }
        count += positions.len() as u32;
    }
    text
}

fn load(text: &str) -> Result<Pattern, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("drawn.obj");
    std::fs::write(&path, text).unwrap();
    let sentence = |error: String| error.replace(&path.display().to_string(), "drawn.obj");
    Pattern::load(&path).map_err(|error| sentence(error.to_string()))
}

/// Drawn cells match their planar originals within the lattice resolution.
fn check_drawn(cells: usize, seed: u64) {
    let planar = voronoi(cells, seed);
    let meshes = as_meshes(&planar);
    let drawn = Pattern::drawn(&meshes, "drawn.obj").unwrap();
    assert_eq!(drawn.len(), cells);
    assert!((drawn.half_extent - 3.0 * planar.half_extent).length() < 1e-12);
    assert!(drawn.tiling_defect() < 1e-9);
    let Cells::Drawn(drawn_cells) = &drawn.cells else { unreachable!() };
    let triangles =
        |mesh: &TriMesh| (0..mesh.triangles.len()).map(|at| mesh.corners(at)).collect::<Vec<_>>();
    let surfaces: Vec<Bvh> =
        drawn_cells.meshes().iter().map(|mesh| Bvh::new(&triangles(mesh))).collect();
    let spacing = 6.0 / 64.0;
    let mut random = common::random(seed);
    for _ in 0..300 {
        let share = 2.0 * DVec3::new(random.random(), random.random(), random.random()) - 1.0;
        let (point, other) =
            (share * planar.half_extent, planar.region_at(share * planar.half_extent));
        let holder = drawn.region_at(3.0 * point).unwrap();
        for cell in 0..cells {
            let distance = drawn.distance(cell, 3.0 * point);
            assert_eq!(distance < 0.0, cell == holder);
            let exact = 3.0 * planar.distance(cell, point);
            if Some(cell) == other && exact.is_finite() {
                // Never deeper than the other cells are far: beside a wall, where planes go on and
                // cells end, that is farther than the planes. Near a crack as deep as that or the
                // wall, whichever is nearer.
                let far = to_others(&surfaces, cell, 3.0 * point);
                let wall = 3.0 * (planar.half_extent - point.abs()).min_element();
                assert!(distance >= -far - 0.3 * spacing, "{distance} {far}");
                let deep = exact < -2.0 * spacing;
                assert!(
                    deep || distance <= exact.max(-wall) + 0.5 * spacing,
                    "{distance} {exact} {wall}"
                );
            }
        }
        let near = 3.0 * point + 0.01 * common::direction(&mut random);
        for cell in 0..cells.min(3) {
            let change = (drawn.distance(cell, 3.0 * point) - drawn.distance(cell, near)).abs();
            assert!(!change.is_finite() || change <= 1.2 * 0.01, "{change}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(6))]

    #[test]
    fn drawn_cells_are_those_they_were_drawn_from(cells in 1..8usize, seed in any::<u64>()) {
        check_drawn(cells, seed);
    }
}

/// A crack so oblique to a wall that the other cell is farther from many points than its plane.
#[test]
fn drawn_cells_beside_an_oblique_crack() {
    check_drawn(2, 10_066_544_545_919_312_530);
}

/// A file of one vertex list, or of triangles that share no vertex, holds the same cells; saved,
/// they come back equal.
#[test]
fn drawn_cells_come_from_files_and_go_to_files() {
    let meshes =
        as_meshes(&Pattern::natural(&Natural { cells: 6, seed: 3, ..Natural::default() }).unwrap());
    for split in [false, true] {
        let pattern = load(&obj(&meshes, split)).unwrap();
        assert_eq!(pattern.len(), 6);
        assert!(pattern.planar().is_none() && matches!(pattern.cells, Cells::Drawn(_)));
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pattern.json");
        pattern.save(&path).unwrap();
        assert!(Pattern::load(&path).unwrap() == pattern);
        for (cell, shape) in pattern.cell_shapes().iter().enumerate() {
            let mesh = pattern.region_mesh(cell, 1.0);
            assert!(
                mesh.is_watertight() && shape.faces >= 4 && shape.corners <= 2 * shape.faces - 4
            );
        }
    }
}

#[test]
fn a_large_gap_is_told_with_its_place_and_size() {
    let planar = voronoi(8, 4);
    let mut meshes = as_meshes(&planar);
    let lost = meshes.remove(3).mass_properties();
    let sentence = load(&obj(&meshes, false)).unwrap_err();
    let rest =
        sentence.strip_prefix("drawn.obj: a gap of ").unwrap_or_else(|| panic!("{sentence}"));
    let (volume, rest) = rest.split_once(" m^3 (").unwrap();
    assert!(
        (volume.parse::<f64>().unwrap() / lost.volume - 1.0).abs() < 0.1,
        "{sentence} {}",
        lost.volume
    );
    let (percent, rest) = rest.split_once(" % of the box) around (").unwrap();
    let share = 100.0 * lost.volume / (27.0 * 8.0 * planar.half_extent.element_product());
    assert!((percent.parse::<f64>().unwrap() / share - 1.0).abs() < 0.1, "{sentence} {share}");
    let (place, rest) = rest.split_once(')').unwrap();
    let place: Vec<f64> = place.split(", ").map(|number| number.parse().unwrap()).collect();
    assert!(
        DVec3::new(place[0], place[1], place[2]).distance(lost.center) < 0.15,
        "{sentence} {}",
        lost.center
    );
    assert_eq!(rest, "; cells must fill their box");
}

/// Nine boxes side by side, as a pane.
fn pane(thickness: f64) -> Vec<TriMesh> {
    let edge = DVec3::new(1.6 / 3.0, 1.2 / 3.0, thickness);
    let unit = Pattern::voronoi(&Voronoi {
        cells: 1,
        half_extent: DVec3::splat(0.5),
        ..Voronoi::default()
    })
    .unwrap();
    let cell = unit.region_mesh(0, 1.0);
    let place = |n: usize| DVec3::new((n % 3) as f64, (n / 3) as f64, 0.0);
    let moved = |n: usize| {
        cell.positions.iter().map(move |&position| edge * (position + place(n))).collect()
    };
    (0..9).map(|n| TriMesh { positions: moved(n), triangles: cell.triangles.clone() }).collect()
}

#[test]
fn a_thin_pane_is_a_pattern_and_its_gap_has_its_size() {
    for thickness in [0.008, 0.0235] {
        let mut meshes = pane(thickness);
        assert_eq!(load(&obj(&meshes, false)).unwrap().len(), 9);
        meshes.remove(4);
        let sentence = load(&obj(&meshes, false)).unwrap_err();
        assert!(
            sentence.contains(" m^3 (11 % of the box) around (0.5333, 0.4, "),
            "{thickness}: {sentence}"
        );
    }
}

#[test]
fn a_gap_around_a_cell_is_not_said_to_be_in_it() {
    let mut meshes = as_meshes(&voronoi(8, 4));
    let middle = meshes[2].mass_properties().center;
    meshes[2]
        .positions
        .iter_mut()
        .for_each(|position| *position = middle + 0.7 * (*position - middle));
    let sentence = load(&obj(&meshes, false)).unwrap_err();
    let (_, place) = sentence.split_once("around (").unwrap_or_else(|| panic!("{sentence}"));
    let place: Vec<f64> = place
        .split_once(')')
        .unwrap()
        .0
        .split(", ")
        .map(|number| number.parse().unwrap())
        .collect();
    let place = DVec3::new(place[0], place[1], place[2]);
    let corners: Vec<[DVec3; 3]> =
        (0..meshes[2].triangles.len()).map(|triangle| meshes[2].corners(triangle)).collect();
    let surface = Bvh::new(&corners);
    let nearest = surface.closest(place, f64::INFINITY).unwrap().distance_squared.sqrt();
    let inward = (middle - place).normalize();
    let deeper = surface
        .closest(place + 0.5 * nearest * inward, f64::INFINITY)
        .unwrap()
        .distance_squared
        .sqrt();
    assert!(deeper < nearest, "{place} is in the cell: {sentence}");
}

#[test]
fn overlaps_and_holes_are_told_too() {
    let mut meshes = as_meshes(&voronoi(8, 4));
    // A cell that has grown beyond its neighbours.
    let middle = meshes[2].mass_properties().center;
    let (low, high) = (meshes[2].positions.clone(), 1.3);
    meshes[2].positions = low.iter().map(|&position| middle + high * (position - middle)).collect();
    let sentence = load(&obj(&meshes, false)).unwrap_err();
    assert!(
        sentence.starts_with("drawn.obj: an overlap of ")
            || sentence.starts_with("drawn.obj: a gap of "),
        "{sentence}"
    );

    let mut meshes = as_meshes(&voronoi(8, 4));
    meshes[5].triangles.pop();
    let sentence = load(&obj(&meshes, false)).unwrap_err();
    assert!(
        sentence.starts_with("drawn.obj: cell 5 is not closed: there is an open edge at ("),
        "{sentence}"
    );
    assert!(load("v 0 0 0\n").is_err());
}

/// Gaps of less than a hundredth of the box close, and small overlaps go to one of the two: every
/// point has one cell.
#[test]
fn small_misfits_are_repaired() {
    for scale in [0.995, 1.005] {
        let mut meshes = as_meshes(&voronoi(8, 4));
        let whole =
            meshes.iter().map(TriMesh::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1))).unwrap();
        for mesh in &mut meshes[..4] {
            let middle = mesh.mass_properties().center;
            for position in &mut mesh.positions {
                *position = (middle + scale * (*position - middle)).clamp(whole.0, whole.1);
            }
        }
        let pattern = Pattern::drawn(&meshes, "drawn.obj").unwrap();
        assert!(pattern.tiling_defect() > 1e-4, "{}", pattern.tiling_defect());
        let mut random = common::random(9);
        for _ in 0..500 {
            let share = 2.0 * DVec3::new(random.random(), random.random(), random.random()) - 1.0;
            let point = share * pattern.half_extent;
            let inside = (0..8).filter(|&cell| pattern.distance(cell, point) < 0.0).count();
            assert_eq!(inside, 1);
        }
    }
}
