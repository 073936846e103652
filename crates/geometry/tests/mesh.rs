//! Mass properties and topology of meshes against closed forms.

mod common;

use common::{icosphere, joined, moved, open_box};
use frangible_geometry::{MeshError, TriMesh};
use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

fn assert_close(actual: DMat3, expected: DMat3, tolerance: f64) {
    let difference = actual - expected;
    let largest =
        difference.to_cols_array().iter().fold(0.0_f64, |largest, entry| largest.max(entry.abs()));
    assert!(largest < tolerance, "{actual} against {expected}");
}

#[test]
fn tetrahedron_has_its_textbook_moments() {
    // Corner at the origin, legs of 1 m.
    let mesh = TriMesh {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z],
        triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]],
    };
    let properties = mesh.mass_properties();
    assert!((properties.volume - 1.0 / 6.0).abs() < 1e-15);
    assert!((properties.center - 0.25).length() < 1e-15);
    let [diagonal, off] = [1.0 / 80.0, 1.0 / 480.0];
    let expected = DMat3::from_cols(
        DVec3::new(diagonal, off, off),
        DVec3::new(off, diagonal, off),
        DVec3::new(off, off, diagonal),
    );
    assert_close(properties.inertia, expected, 1e-15);
}

proptest! {
    /// A box far from the origin, turned any way.
    #[test]
    fn box_has_its_closed_form(
        half in prop::array::uniform3(0.01..3.0f64),
        center in prop::array::uniform3(-50.0..50.0f64),
        angles in prop::array::uniform3(-3.0..3.0f64),
    ) {
        let (half, center) = (DVec3::from_array(half), DVec3::from_array(center));
        let turn = DQuat::from_rotation_x(angles[0]) * DQuat::from_rotation_y(angles[1]) * DQuat::from_rotation_z(angles[2]);
        let mut mesh = open_box(-half, half, 0);
        for position in &mut mesh.positions {
            *position = turn * *position + center;
        }
        let properties = mesh.mass_properties();
        let volume = 8.0 * half.element_product();
        let square = half * half;
        let sums = DVec3::new(square.y + square.z, square.z + square.x, square.x + square.y);
        let rotation = DMat3::from_quat(turn);
        let expected = rotation * DMat3::from_diagonal(sums * (volume / 3.0)) * rotation.transpose();
        prop_assert!((properties.volume / volume - 1.0).abs() < 1e-10);
        prop_assert!((properties.center - center).length() < 1e-10);
        assert_close(properties.inertia, expected, 1e-10 * volume * square.element_sum().max(1.0));
    }
}

/// An icosphere's volume and moments approach the sphere's, four times closer with each level.
#[test]
fn sphere_is_approached_at_second_order() {
    let (volume, moment) = (4.0 / 3.0 * std::f64::consts::PI, 8.0 / 15.0 * std::f64::consts::PI);
    let errors = [3, 4, 5].map(|levels| {
        let properties = icosphere(1.0, levels).mass_properties();
        assert!(properties.center.length() < 1e-14);
        (1.0 - properties.volume / volume, 1.0 - properties.inertia.x_axis.x / moment)
    });
    for pair in errors.windows(2) {
        assert!((pair[0].0 / pair[1].0 - 4.0).abs() < 0.05, "{errors:?}");
        assert!((pair[0].1 / pair[1].1 - 4.0).abs() < 0.05, "{errors:?}");
    }
    assert!(errors[2].0 < 2e-3);
}

#[test]
fn holes_and_seams_show_in_the_topology() {
    let closed = open_box(DVec3::ZERO, DVec3::ONE, 0);
    assert!(closed.is_watertight());
    assert_eq!(closed.parts(), 1);
    assert!(!open_box(DVec3::ZERO, DVec3::ONE, 1).is_watertight());

    // Vertices split at seams, as in a file with normals, are one vertex each.
    let positions: Vec<DVec3> = closed
        .triangles
        .iter()
        .flatten()
        .map(|&vertex| closed.positions[vertex as usize])
        .collect();
    let triangles =
        (0..12).map(|triangle| [3 * triangle, 3 * triangle + 1, 3 * triangle + 2]).collect();
    let mut split = TriMesh { positions, triangles };
    split.positions[0] += DVec3::new(-0.0, 0.0, -0.0);
    assert!(split.is_watertight());
    assert_eq!(split.parts(), 1);
    split.weld();
    assert_eq!(split.positions.len(), 8);

    // A triangle that faces the other way breaks the match, and so does a third one at an edge.
    let mut wrong = closed.clone();
    wrong.triangles[3].swap(0, 1);
    assert!(!wrong.is_watertight());
    let mut fin = closed.clone();
    fin.triangles.push([0, 1, 7]);
    assert!(!fin.is_watertight());

    let two = joined(closed.clone(), &moved(closed, DVec3::new(5.0, 0.0, 0.0)));
    assert!(two.is_watertight());
    let info = two.info();
    assert_eq!((info.parts, info.vertices, info.triangles), (2, 16, 24));
    assert!((info.volume - 2.0).abs() < 1e-14);
    assert!((info.center - DVec3::new(3.0, 0.5, 0.5)).length() < 1e-14);
    assert_eq!(info.bounds, (DVec3::ZERO, DVec3::new(6.0, 1.0, 1.0)));
}

#[test]
fn each_broken_rule_has_its_sentence() {
    let good = open_box(DVec3::ZERO, DVec3::ONE, 0);
    assert_eq!(good.check("box"), Ok(()));

    let mut bad = good.clone();
    bad.positions[7].x = f64::NAN;
    assert_eq!(
        bad.check("bunny.obj").unwrap_err().to_string(),
        "bunny.obj: vertex 7 is (NaN, 1, 1), coordinates must be finite and at most 1e12"
    );
    let mut bad = good.clone();
    bad.triangles[5] = [0, 8, 1];
    assert_eq!(
        bad.check("the mesh").unwrap_err().to_string(),
        "the mesh: triangle 5 refers to vertex 8, must be 0 to 7"
    );
    let bad = TriMesh { positions: vec![DVec3::ZERO; 3], triangles: vec![[0, 1, 2]] };
    assert_eq!(bad.check("x").unwrap_err(), MeshError::NoTriangles { mesh: "x".to_owned() });
    assert!(TriMesh::default().check("x").is_err());
}
