//! Processor time of laying patterns on one core: `cargo bench -p frangible-fracture --bench
//! laying`. Prints a row for each number of cells in a sphere of 70,000 triangles, and for each box
//! and number of cells: the best of some passes of [`Pattern::voronoi`], and of
//! [`Pattern::voronoi_in`] in a body of the box's form.

#![allow(clippy::expect_used, reason = "a benchmark with wrong parameters ends")]

use cpu_time::ThreadTime;
use frangible_fracture::{
    Filling, Impact, Natural, Pattern, Radial, ShatterSettings, Splinters, Voronoi,
};
use frangible_geometry::{Hull, Shape, TriMesh};
use glam::DVec3;
use std::f64::consts::PI;
use std::hint::black_box;

/// Passes of a pattern, of which the fastest counts.
const PASSES: usize = 5;

/// Half of the boxes' sides, and how far sites gather around the centre.
const BOXES: [(&str, DVec3, f64); 4] = [
    ("cube", DVec3::ONE, 0.0),
    ("flat 1:20", DVec3::new(1.0, 1.0, 0.05), 0.0),
    ("needle 1:100", DVec3::new(1.0, 0.01, 0.01), 0.0),
    ("clustered", DVec3::ONE, 8.0),
];

/// Time of the fastest pass [ms].
fn fastest<T>(lay: impl Fn() -> T) -> f64 {
    let pass = |_| {
        let start = ThreadTime::now();
        black_box(lay());
        start.elapsed().as_secs_f64() * 1e3
    };
    (0..PASSES).map(pass).fold(f64::INFINITY, f64::min)
}

/// A closed sphere of so many rings.
fn sphere(rings: usize) -> TriMesh {
    let around = 2 * rings;
    let point = |ring: usize, at: usize| {
        let (polar, angle) =
            (PI * ring as f64 / rings as f64, 2.0 * PI * at as f64 / around as f64);
        DVec3::new(polar.sin() * angle.cos(), polar.sin() * angle.sin(), polar.cos())
    };
    let mut positions = vec![DVec3::Z];
    positions.extend((1..rings).flat_map(|ring| (0..around).map(move |at| point(ring, at))));
    positions.push(-DVec3::Z);
    let last = positions.len() as u32 - 1;
    let number = |ring: usize, at: usize| match ring {
        0 => 0,
        _ if ring == rings => last,
        _ => 1 + ((ring - 1) * around + at % around) as u32,
    };
    let mut triangles = Vec::new();
    for (ring, at) in (0..rings).flat_map(|ring| (0..around).map(move |at| (ring, at))) {
        let [a, b] = [at, at + 1].map(|at| number(ring, at));
        let [c, d] = [at, at + 1].map(|at| number(ring + 1, at));
        triangles.extend((a != b).then_some([a, d, b]));
        triangles.extend((c != d).then_some([a, c, d]));
    }
    TriMesh { positions, triangles }
}

fn main() {
    let mesh = sphere(133);
    let impact = Impact { point_body: DVec3::Z, normal_body: DVec3::Z };
    println!("triangles,cells,points_ms,splinters_ms,natural_ms,radial_ms");
    for cells in [200, 1000, 5000] {
        let points = || Filling::of_mesh(&mesh, &impact, (cells, 1)).expect("a closed surface");
        let filling = points();
        let times = [
            fastest(points),
            fastest(|| Pattern::splinters_in(&Splinters::default(), cells, &filling)),
            fastest(|| Pattern::natural_in(&Natural { cells, ..Natural::default() }, &filling)),
            fastest(|| Pattern::radial_in(&Radial::default(), cells, &filling)),
        ];
        let times = times.map(|time| format!("{time:.2}")).join(",");
        println!("{},{cells},{times}", mesh.triangles.len());
    }
    println!("box,cells,voronoi_ms,points_ms,voronoi_in_ms");
    for (name, half_extent, clustering) in BOXES {
        let body = Shape::convex(Hull::cuboid(half_extent), 0.1).expect("a box has a mass");
        let impact = Impact { point_body: half_extent * DVec3::Z, normal_body: DVec3::Z };
        for cells in [60, 200, 1000, 5000] {
            let voronoi = Voronoi { cells, clustering, half_extent, ..Voronoi::default() };
            let in_box = fastest(|| Pattern::voronoi(&voronoi).expect("parameters in range"));
            let settings = ShatterSettings::default();
            let filling = Filling::of_body(&body, &impact, &settings, (cells, 1)).expect("a body");
            let start = ThreadTime::now();
            black_box(Filling::of_body(&body, &impact, &settings, (cells, 1)));
            let points = start.elapsed().as_secs_f64() * 1e3;
            let in_body = fastest(|| Pattern::voronoi_in(&voronoi, &filling));
            println!("{name},{cells},{in_box:.2},{points:.2},{in_body:.2}");
        }
    }
}
