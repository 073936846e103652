//! Level sets of meshes against brute force and closed forms.
#![allow(clippy::unwrap_used, reason = "a panic is how a test fails")]

mod common;

use common::{bunny, icosphere, joined, moved, open_box};
use frangible_geometry::{Grid, LevelSet, MeshToLevelSetError, TriMesh, mesh_to_level_set};
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

fn level_set(mesh: &TriMesh, voxels: [usize; 3], margin: usize) -> LevelSet {
    let (low, high) = mesh.bounds();
    mesh_to_level_set(mesh, Grid::around_box(low, high, voxels, margin)).unwrap()
}

/// Each node's position [m] and signed distance in cells.
fn nodes(level_set: &LevelSet) -> impl Iterator<Item = (DVec3, f64)> {
    let grid = *level_set.grid();
    level_set.phi().iter().enumerate().map(move |(index, &phi)| {
        let [i, j, k] = grid.coordinates(index);
        (grid.node(i, j, k), f64::from(phi) / grid.spacing)
    })
}

/// Distance to a triangle by its plane and its edges.
fn distance_to_triangle(point: DVec3, [a, b, c]: [DVec3; 3]) -> f64 {
    let to_edge = |from: DVec3, to: DVec3| {
        let way = to - from;
        let part = ((point - from).dot(way) / way.length_squared()).clamp(0.0, 1.0);
        (point - from - way * part).length()
    };
    let normal = (b - a).cross(c - a);
    let beside = |from: DVec3, to: DVec3| normal.cross(to - from).dot(point - from) >= 0.0;
    if beside(a, b) && beside(b, c) && beside(c, a) {
        (point - a).dot(normal.normalize()).abs()
    } else {
        to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
    }
}

fn brute_force_distance(mesh: &TriMesh, point: DVec3) -> f64 {
    let distances = (0..mesh.triangles.len())
        .map(|triangle| distance_to_triangle(point, mesh.corners(triangle)));
    distances.fold(f64::INFINITY, f64::min)
}

/// True if a ray along x leaves the mesh more often than it enters.
fn brute_force_inside(mesh: &TriMesh, point: DVec3) -> bool {
    let mut crossings = 0;
    for triangle in 0..mesh.triangles.len() {
        let [a, b, c] = mesh.corners(triangle).map(|corner| corner - point);
        let turn = |p: DVec3, q: DVec3| p.y * q.z - p.z * q.y;
        let (u, v, w) = (turn(b, c), turn(c, a), turn(a, b));
        let ahead = (u * a.x + v * b.x + w * c.x) / (u + v + w) > 0.0;
        if ahead && u > 0.0 && v > 0.0 && w > 0.0 {
            crossings += 1;
        } else if ahead && u < 0.0 && v < 0.0 && w < 0.0 {
            crossings -= 1;
        }
    }
    crossings > 0
}

/// The bunny on the grid of the paper's figure: exact in the band, near enough beyond it.
#[test]
fn bunny_has_its_exact_distance() {
    let bunny = bunny();
    let level_set = level_set(&bunny, [70, 60, 45], 2);
    let spacing = level_set.grid().spacing;
    let samples: Vec<(DVec3, f64)> = nodes(&level_set).step_by(17).collect();
    let errors: Vec<(f64, f64)> = samples
        .par_iter()
        .map(|&(point, phi)| {
            let distance = brute_force_distance(&bunny, point) / spacing;
            (distance, (phi.abs() - distance).abs())
        })
        .collect();
    let worst = |range: std::ops::Range<f64>| {
        let within = errors.iter().filter(|(distance, _)| range.contains(distance));
        within.fold((0, 0.0_f64), |(count, worst), &(_, error)| (count + 1, worst.max(error)))
    };
    let (band, far) = (worst(0.0..2.99), worst(3.0..1e9));
    assert!(band.0 > 2000 && far.0 > 8000, "{band:?} {far:?}");
    assert!(band.1 < 1e-5, "{} cells in the band", band.1);
    assert!(far.1 < 0.05, "{} cells beyond the band", far.1);
}

/// The sign at random points farther than a cell from the surface, against counting crossings.
#[test]
fn bunny_is_solid() {
    let bunny = bunny();
    let level_set = level_set(&bunny, [70, 60, 45], 2);
    let (low, high) = level_set.grid().bounds();
    let mut random = Pcg64Mcg::seed_from_u64(1);
    let mut point =
        || low + (high - low) * DVec3::from_array(std::array::from_fn(|_| random.random::<f64>()));
    let points: Vec<DVec3> = std::iter::repeat_with(&mut point)
        .filter(|&point| level_set.value(point).abs() > level_set.grid().spacing as f32)
        .take(10_000)
        .collect();
    let inside = points.iter().filter(|&&point| level_set.value(point) < 0.0).count();
    assert!((1000..9000).contains(&inside), "{inside} of 10000 points inside");
    points.par_iter().for_each(|&point| {
        assert_eq!(level_set.value(point) < 0.0, brute_force_inside(&bunny, point), "{point}");
    });

    // The voxels inside add up to the volume.
    let volume = nodes(&level_set).filter(|&(_, phi)| phi < 0.0).count() as f64
        * level_set.grid().voxel_volume();
    assert!((volume / bunny.mass_properties().volume - 1.0).abs() < 2e-3);
}

#[test]
fn icosphere_has_the_distance_of_a_sphere() {
    let level_set = level_set(&icosphere(1.0, 5), [40, 40, 40], 4);
    for (point, phi) in nodes(&level_set) {
        let expected = (point.length() - 1.0) / level_set.grid().spacing;
        let tolerance = if expected.abs() < 3.0 { 0.01 } else { 0.1 };
        assert!((phi - expected).abs() < tolerance, "{point}: {phi} {expected}");
    }
}

/// Where spheres overlap their surfaces are buried in the solid: the distance is to the outer parts
/// and the crease.
#[test]
fn overlapping_spheres_are_one_solid() {
    let (left, right) = (DVec3::new(-0.6, 0.1, 0.0), DVec3::new(0.6, 0.1, 0.0));
    let mesh = joined(moved(icosphere(1.0, 5), left), &moved(icosphere(1.0, 5), right));
    let level_set = level_set(&mesh, [66, 60, 60], 3);
    let spacing = level_set.grid().spacing;
    let expected = |point: DVec3| {
        // To the crease, a circle of radius 0.8 around the x axis, and to what is left of each
        // sphere.
        let across = DVec3::new(0.0, point.y - 0.1, point.z).length();
        let mut distance = DVec3::new(point.x, across - 0.8, 0.0).length();
        for (center, other) in [(left, right), (right, left)] {
            let foot = center + (point - center).normalize_or(DVec3::Y);
            if (foot - other).length() >= 1.0 {
                distance = distance.min((foot - point).length());
            }
        }
        let inside = (point - left).length() < 1.0 || (point - right).length() < 1.0;
        if inside { -distance } else { distance }
    };
    for (point, phi) in nodes(&level_set) {
        let expected = expected(point) / spacing;
        assert!((phi - expected).abs() < 0.15, "{point}: {phi} {expected}");
    }

    // The surfaces inside are there: the triangles alone would put one a tenth of the depth from
    // here.
    let point = DVec3::new(0.35, 0.1, 0.0);
    assert!(brute_force_distance(&mesh, point) < 0.06);
    assert!(f64::from(level_set.value(point)) < -0.6);
}

/// Boxes that share a wall are one box, and the wall leaves no trace.
#[test]
fn touching_boxes_have_no_wall_between() {
    let cube = open_box(DVec3::ZERO, DVec3::ONE, 0);
    let two = joined(cube.clone(), &moved(cube, DVec3::X));
    let one = open_box(DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0), 0);
    let (two, one) = (level_set(&two, [21, 10, 10], 3), level_set(&one, [21, 10, 10], 3));
    for ((point, phi), (_, expected)) in nodes(&two).zip(nodes(&one)) {
        assert!((phi - expected).abs() < 1e-4, "{point}: {phi} {expected}");
    }
}

/// A hole is closed where the winding number is one half: for a flat one in its plane.
#[test]
fn box_without_lid_is_closed() {
    let low = DVec3::new(-0.5, -0.3, -0.4);
    let (open, closed) = (open_box(low, -low, 1), open_box(low, -low, 0));
    let (open, closed) = (level_set(&open, [31, 19, 25], 4), level_set(&closed, [31, 19, 25], 4));
    for ((point, phi), (_, expected)) in nodes(&open).zip(nodes(&closed)) {
        assert_eq!(phi < 0.0, expected < 0.0, "{point}: {phi} {expected}");
        assert!((phi - expected).abs() < 0.1, "{point}: {phi} {expected}");
    }
}

/// However ragged the mesh, the distance changes by no more than the way from node to node.
#[test]
fn level_set_is_continuous_across_holes() {
    let mut mesh = joined(icosphere(1.0, 4), &moved(icosphere(0.8, 3), DVec3::new(0.9, 0.3, 0.0)));
    let mut random = Pcg64Mcg::seed_from_u64(2);
    mesh.triangles.retain(|_| random.random::<f64>() < 0.8);
    let level_set = level_set(&mesh, [40, 36, 36], 3);
    let [nx, ny, nz] = level_set.grid().dims;
    let mut inside = 0;
    for (k, j, i) in
        (0..nz - 1).flat_map(|k| (0..ny - 1).flat_map(move |j| (0..nx - 1).map(move |i| (k, j, i))))
    {
        let phi = level_set.at(i, j, k);
        inside += usize::from(phi < 0.0);
        for neighbour in
            [level_set.at(i + 1, j, k), level_set.at(i, j + 1, k), level_set.at(i, j, k + 1)]
        {
            let slope = f64::from(phi - neighbour).abs() / level_set.grid().spacing;
            assert!(slope < 1.01, "slope {slope} at {i} {j} {k}");
        }
    }
    assert!(inside > 10_000, "{inside} nodes inside");
}

/// Rods in all directions: near the surface of the union the distance is exact, deep in it none of
/// their own faces is in the way.
#[test]
fn rods_that_cross_are_one_solid() {
    let mut mesh = TriMesh::default();
    let mut planes = Vec::new();
    for n in 0..12 {
        let turn =
            DQuat::from_rotation_y(0.5 * f64::from(n)) * DQuat::from_rotation_z(1.3 * f64::from(n));
        let mut rod = open_box(DVec3::new(-1.0, -0.06, -0.05), DVec3::new(1.0, 0.06, 0.05), 0);
        rod.positions.iter_mut().for_each(|position| *position = turn * *position);
        mesh = joined(mesh, &rod);
        planes.push(turn);
    }
    // Below zero in a box, the distance outside of it.
    let of_box = |point: DVec3| {
        let apart = point.abs() - DVec3::new(1.0, 0.06, 0.05);
        apart.max(DVec3::ZERO).length() + apart.max_element().min(0.0)
    };
    let set = level_set(&mesh, [80, 80, 80], 2);
    let spacing = set.grid().spacing;
    // Faces of crossing rods are divided along their intersection.
    let crease = 0.01 * spacing;
    let (mut inside, mut outside) = (0, 0);
    for (point, cells) in nodes(&set) {
        let phi = cells * spacing;
        let expected =
            planes.iter().map(|turn| of_box(turn.inverse() * point)).fold(f64::INFINITY, f64::min);
        assert!(
            expected.abs() < 1e-9 || (phi < 0.0) == (expected < 0.0),
            "{point}: {phi} {expected}"
        );
        if expected > 0.0 && expected < 2.5 * spacing {
            assert!((phi - expected).abs() < crease, "{point}: {phi} {expected}");
            outside += 1;
        }
        // The union is deeper than any of its parts.
        assert!(expected > 0.0 || phi < expected + crease, "{point}: {phi} {expected}");
        inside += i32::from(expected < 0.0);
    }
    assert!(inside > 2000 && outside > 5000, "{inside} {outside}");
}

#[test]
fn mesh_that_faces_inward_is_turned() {
    let mesh = icosphere(0.7, 3);
    let mut inward = mesh.clone();
    inward.flip();
    let (outward, inward) =
        (level_set(&mesh, [20, 20, 20], 2), level_set(&inward, [20, 20, 20], 2));
    for ((point, phi), (_, expected)) in nodes(&inward).zip(nodes(&outward)) {
        assert!((phi - expected).abs() < 1e-5, "{point}: {phi} {expected}");
    }
}

#[test]
fn number_of_threads_changes_no_bit() {
    let mut mesh = joined(icosphere(1.0, 4), &moved(icosphere(0.8, 3), DVec3::new(0.9, 0.3, 0.0)));
    mesh.triangles.truncate(6000);
    let with_threads = |threads| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let phi = pool.install(|| level_set(&mesh, [30, 26, 26], 3)).phi().to_vec();
        phi.into_iter().map(f32::to_bits).collect::<Vec<u32>>()
    };
    assert_eq!(with_threads(1), with_threads(5));
}

#[test]
fn what_has_no_level_set_is_refused() {
    let cube = open_box(DVec3::ZERO, DVec3::ONE, 0);
    let grid = Grid { origin: DVec3::ZERO, spacing: 0.1, dims: [700, 700, 700] };
    let error = mesh_to_level_set(&cube, grid).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the grid has 700 x 700 x 700 nodes, must have at most 268435456 in all"
    );
    let error = mesh_to_level_set(&cube, Grid { dims: [usize::MAX, 3, 3], ..grid }).unwrap_err();
    assert!(matches!(error, MeshToLevelSetError::TooManyNodes { .. }));

    let plate = open_box(DVec3::new(0.0, 0.01, 0.0), DVec3::new(1.0, 0.09, 1.0), 0);
    let grid = Grid { dims: [12, 12, 12], ..grid };
    assert_eq!(
        mesh_to_level_set(&plate, grid).unwrap_err().to_string(),
        "the mesh has 0 grid nodes inside, must have at least 1 (the grid's spacing is 0.1 m, and the mesh about 0.06897 m \
         thick; use 29 voxels along its longest side)"
    );
    let plate = open_box(DVec3::new(0.0, 0.01, 0.0), DVec3::new(1.0, 0.0101, 1.0), 0);
    let sentence = mesh_to_level_set(&plate, grid).unwrap_err().to_string();
    assert!(!sentence.contains("voxels"), "{sentence}");

    let quad = open_box(DVec3::ZERO, DVec3::ONE, 5);
    assert!(matches!(mesh_to_level_set(&quad, grid).unwrap_err(), MeshToLevelSetError::Mesh(_)));
    let mut bad = cube;
    bad.triangles[0][0] = 99;
    assert_eq!(
        mesh_to_level_set(&bad, grid).unwrap_err().to_string(),
        "the mesh: triangle 0 refers to vertex 99, must be 0 to 7"
    );
}

/// A box, given by its half extents and where it lies.
fn placed_box(half: f64, turned: DQuat, center: DVec3) -> TriMesh {
    let sign = |bit: usize, corner: usize| if corner >> bit & 1 == 1 { half } else { -half };
    let place = |corner: usize| {
        center + turned * DVec3::new(sign(2, corner), sign(1, corner), sign(0, corner))
    };
    let quads =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriMesh { positions: (0..8).map(place).collect(), triangles }
}

/// A vertex amid an edge, which one of its faces has and the other has not: a triangle without a
/// height closes the gap. Another box crosses it there.
#[test]
fn triangles_without_height_are_divided_once() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for _ in 0..24 {
        let mut direction =
            || DVec3::from_array(std::array::from_fn(|_| random.random_range(-1.0..1.0)));
        let axes = [direction(), direction()].map(|axis| axis.normalize());
        let turned = DQuat::from_axis_angle(axes[0], 1.3);
        let mut mesh = placed_box(0.5, turned, DVec3::ZERO);
        let [a, b] = [mesh.positions[0], mesh.positions[1]];
        mesh.positions.push(a.lerp(b, random.random_range(0.2..0.8)));
        mesh.triangles[0] = [0, 8, 3];
        mesh.triangles.extend([[8, 1, 3], [0, 1, 8]]);
        let place = a.lerp(b, random.random_range(0.2..0.8));
        let crossing = placed_box(0.15, DQuat::from_axis_angle(axes[1], 1.0), place);
        let level_set = level_set(&joined(mesh, &crossing), [24; 3], 2);
        let voxel = level_set.grid().voxel_volume();
        let volume = voxel * nodes(&level_set).filter(|(_, phi)| *phi < 0.0).count() as f64;
        assert!(volume > 1.0 && volume < 1.0 + 0.3f64.powi(3), "{volume}");
    }
}
