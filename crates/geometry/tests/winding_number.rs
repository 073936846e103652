//! Winding numbers against exact sums.

mod common;

use common::{icosphere, joined, moved, open_box};
use frangible_geometry::Bvh;
use frangible_geometry::triangle_solid_angle;
use frangible_geometry::{TriMesh, WindingNumber};
use glam::DVec3;
use std::f64::consts::PI;

fn triangles(mesh: &TriMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect()
}

fn winding(mesh: &TriMesh) -> WindingNumber {
    WindingNumber::new(Bvh::new(&triangles(mesh)))
}

fn exact(mesh: &TriMesh, point: DVec3) -> f64 {
    triangles(mesh).iter().map(|corners| triangle_solid_angle(point, corners)).sum::<f64>()
        / (4.0 * PI)
}

/// Points of a lattice that avoids the faces of the meshes here.
fn lattice() -> impl Iterator<Item = DVec3> {
    let axis = || (0..18).map(|n| -1.71 + 0.201 * f64::from(n));
    axis().flat_map(move |x| axis().flat_map(move |y| axis().map(move |z| DVec3::new(x, y, z))))
}

#[test]
fn octant_is_an_eighth_of_the_sphere() {
    let angle = triangle_solid_angle(DVec3::ZERO, &[DVec3::X, DVec3::Y, DVec3::Z]);
    assert!((angle - PI / 2.0).abs() < 1e-15);
    assert!(
        (triangle_solid_angle(DVec3::ZERO, &[DVec3::Y, DVec3::X, DVec3::Z]) + PI / 2.0).abs()
            < 1e-15
    );
}

#[test]
fn counts_how_often_closed_surfaces_enclose_a_point() {
    let two = joined(icosphere(1.0, 3), &moved(icosphere(1.0, 3), DVec3::new(0.9, 0.0, 0.0)));
    let number = winding(&two);
    for point in lattice() {
        // The faces cut at most 1 per cent off the sphere.
        let radii = [point.length(), (point - DVec3::new(0.9, 0.0, 0.0)).length()];
        if radii.iter().all(|radius| !(0.98..1.001).contains(radius)) {
            let expected = radii.iter().filter(|&&radius| radius < 1.0).count();
            assert!(
                (number.at(point) - expected as f64).abs() < 0.05,
                "{point}: {} {expected}",
                number.at(point)
            );
        }
    }
}

/// The series misses the exact sum by some hundredths at worst, and by thousandths on average.
#[test]
fn tree_agrees_with_the_exact_sum() {
    let mesh =
        joined(icosphere(1.0, 4), &open_box(DVec3::splat(-1.3), DVec3::new(-0.1, 0.2, 1.4), 1));
    let number = winding(&mesh);
    let errors: Vec<f64> =
        lattice().map(|point| (number.at(point) - exact(&mesh, point)).abs()).collect();
    let worst = errors.iter().fold(0.0_f64, |worst, &error| worst.max(error));
    let mean = errors.iter().sum::<f64>() / errors.len() as f64;
    assert!(worst < 0.1, "worst error {worst}");
    assert!(mean < 0.006, "mean error {mean}");
    assert!(worst > 1e-4, "the series is in use");
}

/// From the plane of a hole, what is left of a convex surface fills half of the view.
#[test]
fn half_in_the_plane_of_a_hole() {
    let number = winding(&open_box(DVec3::ZERO, DVec3::ONE, 1));
    for (x, y) in [(0.5, 0.5), (0.1, 0.7), (0.9, 0.2)] {
        assert!((number.at(DVec3::new(x, y, 1.0)) - 0.5).abs() < 1e-12);
        assert!(number.at(DVec3::new(x, y, 0.9)) > 0.5);
        assert!(number.at(DVec3::new(x, y, 1.1)) < 0.5);
    }
}

/// The sum of angles keeps its whole turns: a thousand sheets seen from behind are five hundred
/// times half a sphere.
#[test]
fn many_sheets_add_up() {
    let far = 1e6;
    let sheet =
        [DVec3::new(-far, -far, 1.0), DVec3::new(far, -far, 1.0), DVec3::new(0.0, far, 1.0)];
    let number = WindingNumber::new(Bvh::new(&[sheet; 1000]));
    assert!((number.at(DVec3::ZERO) - 500.0).abs() < 0.01, "{}", number.at(DVec3::ZERO));
    assert!((number.at(DVec3::new(0.0, 0.0, 2.0)) + 500.0).abs() < 0.01);
}
