//! Plates made of open sheets, against their volumes.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod common;

use common::{icosphere, joined, moved, open_box};
use frangible_geometry::TriMesh;
use glam::{DQuat, DVec2, DVec3};
use std::f64::consts::PI;

/// A sheet of `n` x `m` squares over the unit square of the plane, each point placed by `place`.
fn sheet(n: u32, m: u32, place: impl Fn(DVec2) -> DVec3) -> TriMesh {
    let at = |i: u32, j: u32| i + (n + 1) * j;
    let mut mesh = TriMesh::default();
    for j in 0..=m {
        for i in 0..=n {
            let point = DVec2::new(f64::from(i) / f64::from(n), f64::from(j) / f64::from(m));
            mesh.positions.push(place(point));
        }
    }
    for j in 0..m {
        for i in 0..n {
            let [a, b] = [at(i, j), at(i + 1, j)];
            let [c, d] = [at(i + 1, j + 1), at(i, j + 1)];
            mesh.triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh
}

fn flat(point: DVec2) -> DVec3 {
    DVec3::new(2.0 * point.x, 0.0, point.y)
}

/// Half of a tube of radius 1 and length 2.
fn half_tube(point: DVec2) -> DVec3 {
    let (sin, cos) = libm::sincos(PI * point.x);
    DVec3::new(cos, sin, 2.0 * point.y)
}

/// Volume of the plates that a mesh becomes, which must be closed, and their number.
fn volume(mesh: &TriMesh, thickness: f64) -> (f64, usize) {
    let thick = mesh.thickened(thickness, "the sheet").unwrap();
    let clean = thick.mesh.cleaned("the plate").unwrap();
    assert!(clean.mesh.is_watertight());
    let changes = &clean.changes;
    assert_eq!((changes.holes, changes.turned, changes.sheets.len()), (0, 0, 0), "{changes:?}");
    (clean.mesh.mass_properties().volume, thick.plates)
}

/// Each triangle with vertices of its own, every second one turned round.
fn soup(mesh: &TriMesh) -> TriMesh {
    let corners = mesh.triangles.iter().flatten();
    let positions = corners.map(|&vertex| mesh.positions[vertex as usize]).collect();
    let one = |t: u32| {
        if t.is_multiple_of(2) {
            [3 * t, 3 * t + 1, 3 * t + 2]
        } else {
            [3 * t, 3 * t + 2, 3 * t + 1]
        }
    };
    TriMesh { positions, triangles: (0..mesh.triangles.len() as u32).map(one).collect() }
}

#[test]
fn a_flat_sheet_has_its_area_times_the_thickness() {
    let turn = DQuat::from_rotation_x(0.7) * DQuat::from_rotation_z(-2.1);
    for scale in [1e-3, 1.0, 1e3] {
        for (n, m) in [(1, 1), (3, 5)] {
            for part in [1e-4, 0.01, 0.3] {
                let mesh = sheet(n, m, |point| scale * (turn * (flat(point) + DVec3::ONE)));
                let expected = 2.0 * part * scale * scale * scale;
                for mesh in [mesh.clone(), soup(&mesh)] {
                    let (volume, plates) = volume(&mesh, part * scale);
                    assert_eq!(plates, 1);
                    assert!((volume / expected - 1.0).abs() < 1e-9, "{volume} {expected}");
                }
            }
        }
    }
}

/// With a hole in it, and with a triangle for each side of its rim.
#[test]
fn a_disc_and_a_ring_have_their_area_times_the_thickness() {
    let n = 48;
    let corner = |k: u32, radius: f64| {
        let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k) / f64::from(n));
        DVec3::new(radius * cos, 0.0, radius * sin)
    };
    let polygon =
        |radius: f64| 0.5 * f64::from(n) * radius * radius * libm::sin(2.0 * PI / f64::from(n));
    let mut disc = TriMesh::default();
    disc.positions.push(DVec3::ZERO);
    disc.positions.extend((0..n).map(|k| corner(k, 2.0)));
    disc.triangles.extend((0..n).map(|k| [0, 1 + (k + 1) % n, 1 + k]));
    let (found, _) = volume(&disc, 0.05);
    assert!((found / (0.05 * polygon(2.0)) - 1.0).abs() < 1e-9, "{found}");

    let mut ring = TriMesh::default();
    ring.positions.extend((0..n).flat_map(|k| [corner(k, 1.0), corner(k, 2.0)]));
    for k in 0..n {
        let (a, b) = (2 * k, 2 * ((k + 1) % n));
        ring.triangles.extend([[a, b, a + 1], [a + 1, b, b + 1]]);
    }
    let (found, plates) = volume(&ring, 0.05);
    assert_eq!(plates, 1);
    assert!((found / (0.05 * (polygon(2.0) - polygon(1.0))) - 1.0).abs() < 1e-9, "{found}");
}

#[test]
fn a_bent_sheet_is_as_thick_beside_its_folds() {
    // Of a tube, half a polygon: what is more outside of the sheet is less inside of it.
    for n in [6, 24, 96] {
        let length = f64::from(n) * 2.0 * libm::sin(0.5 * PI / f64::from(n));
        let (found, _) = volume(&sheet(n, 3, half_tube), 0.1);
        assert!((found / (0.1 * 2.0 * length) - 1.0).abs() < 1e-9, "{n} sides: {found}");
    }
    // A corner of a room, and a bowl: a shell of the sphere.
    let (found, plates) = volume(&open_box(DVec3::ZERO, DVec3::ONE, 3), 0.02);
    assert_eq!(plates, 1);
    assert!((found / (3.0 * 0.02) - 1.0).abs() < 0.03, "{found}");
    let mut bowl = icosphere(1.0, 4);
    let heights: Vec<f64> = bowl.positions.iter().map(|position| position.y).collect();
    bowl.triangles.retain(|triangle| triangle.iter().all(|&vertex| heights[vertex as usize] < 0.3));
    let area = bowl.area();
    let (found, _) = volume(&bowl, 0.02);
    assert!((found / (0.02 * area) - 1.0).abs() < 0.01, "{found} {area}");
}

#[test]
fn parts_are_thickened_one_by_one_and_closed_ones_stay() {
    let floor = sheet(4, 2, flat);
    let two = joined(floor.clone(), &moved(floor.clone(), DVec3::new(5.0, 1.0, 0.0)));
    let (found, plates) = volume(&two, 0.1);
    assert_eq!(plates, 2);
    assert!((found / (2.0 * 2.0 * 0.1) - 1.0).abs() < 1e-9, "{found}");

    let cube = open_box(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 2.0, 1.0), 0);
    let both = joined(floor, &cube);
    let (found, plates) = volume(&both, 0.1);
    assert_eq!(plates, 1);
    assert!((found / (1.0 + 2.0 * 0.1) - 1.0).abs() < 1e-9, "{found}");
    assert_eq!(cube.thickened(0.1, "cube").unwrap().mesh.triangles, cube.triangles);
    assert_eq!(cube.thickened(0.1, "cube").unwrap().plates, 0);
}

#[test]
fn the_sides_lie_half_of_the_thickness_from_the_sheet() {
    let thick = sheet(5, 4, flat).thickened(0.1, "the sheet").unwrap().mesh;
    let mut walls = 0;
    for triangle in 0..thick.triangles.len() {
        let corners = thick.corners(triangle);
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let across = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        if across.y.abs() < 0.5 {
            walls += 1;
        } else {
            assert!((middle.y - 0.05 * across.y).abs() < 1e-12, "{middle} faces {across}");
        }
    }
    assert_eq!(walls, 2 * 2 * (5 + 4));
}

#[test]
fn a_thickness_is_above_zero() {
    let floor = sheet(1, 1, flat);
    for (thickness, said) in [(0.0, "0"), (-0.1, "-0.1"), (f64::NAN, "NaN"), (f64::INFINITY, "inf")]
    {
        assert_eq!(
            floor.thickened(thickness, "floor.obj").unwrap_err().to_string(),
            format!("floor.obj: thickness {said} m, must be above 0")
        );
    }
    assert!(floor.cleaned("floor.obj").unwrap_err().to_string().contains("--thickness"));
}
