//! Glue between pieces with any common face, against beam theory.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

mod common;

use frangible_fracture::{
    BondStrength, CutPiece, Glued, Impact, Interface, Pattern, PointLoad, ShatterSettings, Voronoi,
    interfaces, mesh_interfaces, shatter,
};
use frangible_geometry::{ClosedForm, Hull, Shape, TriMesh};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

const DENSITY: f64 = 2400.0;

/// A rectangle of a section, in the plane of y and z [m].
#[derive(Clone, Copy)]
struct Rectangle {
    center: DVec2,
    size: DVec2,
}

/// Second moments and product of a section about its centroid, and the centroid.
fn moments(section: &[Rectangle]) -> ([f64; 3], DVec2, f64) {
    let area: f64 = section.iter().map(|one| one.size.element_product()).sum();
    let center =
        section.iter().map(|one| one.size.element_product() * one.center).sum::<DVec2>() / area;
    let mut sums = [0.0; 3];
    for Rectangle { center: own, size } in section {
        let (part, d) = (size.element_product(), *own - center);
        sums[0] += part * (size.x * size.x / 12.0 + d.x * d.x);
        sums[1] += part * (size.y * size.y / 12.0 + d.y * d.y);
        sums[2] += part * d.x * d.y;
    }
    (sums, center, area)
}

/// The largest pull in a section by a moment [N m] about y and z, and a pull [N] along x.
fn beam_theory(section: &[Rectangle], moment: DVec2, pull: f64) -> f64 {
    let ([yy, zz, yz], center, area) = moments(section);
    // The stress a y + b z has the moment (a yz + b zz) about y and -(a yy + b yz) about z.
    let determinant = yy * zz - yz * yz;
    let a = (-moment.y * zz - moment.x * yz) / determinant;
    let b = (moment.x * yy + moment.y * yz) / determinant;
    let corners = section.iter().flat_map(|one| {
        [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)]
            .map(|(u, v)| one.center + one.size * DVec2::new(u, v) - center)
    });
    pull / area + corners.map(|d| a * d.x + b * d.y).fold(f64::NEG_INFINITY, f64::max)
}

/// Stations along x, each of the boxes of a section, turned by `turn`.
fn beam(section: &[Rectangle], stations: usize, step: f64, turn: DQuat) -> Vec<Hull> {
    let of_station = |station: usize| {
        section.iter().map(move |Rectangle { center, size }| {
            let half = 0.5 * DVec3::new(step, size.x, size.y);
            let center = DVec3::new((station as f64 + 0.5) * step, center.x, center.y);
            Hull::cuboid(half).transformed(&RigidTransform::new(turn, turn * center))
        })
    };
    (0..stations).flat_map(of_station).collect()
}

/// The worst strain at the root of a cantilever of which the first station is anchored, at a
/// strength of 1 Pa, under a force on the end [N].
fn worst_strain(
    section: &[Rectangle],
    stations: usize,
    step: f64,
    turn: DQuat,
    force: DVec3,
) -> f64 {
    let anchored = |center: DVec3| (turn.inverse() * center).x < step;
    let strength = BondStrength { tension: 1.0, shear: 1e12 };
    let mut glued = Glued::new(beam(section, stations, step, turn).into(), anchored, strength);
    // On each box of the last station, by its area: a force alone would bend the station.
    let (_, _, area) = moments(section);
    let load = |one: &Rectangle| {
        let end = DVec3::new((stations as f64 - 0.5) * step, one.center.x, one.center.y);
        let part = one.size.element_product() / area;
        PointLoad { point: turn * end, force: turn * (part * force) }
    };
    let loads: Vec<PointLoad> = section.iter().map(load).collect();
    let strains = glued.strains(&loads, DVec3::ZERO, DENSITY);
    strains.into_iter().fold(0.0, f64::max)
}

/// The moment about y and z, and the pull, of a force on the middle of the last station at the first
/// bond.
fn root_load(stations: usize, step: f64, force: DVec3) -> (DVec2, f64) {
    let lever = (stations as f64 - 1.5) * step;
    let moment = (lever * DVec3::X).cross(force);
    (DVec2::new(moment.y, moment.z), force.x)
}

#[test]
fn rectangles_of_any_width_and_height_bend_as_beams_do() {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    for _ in 0..40 {
        let size = DVec2::new(random.random_range(0.02..0.6), random.random_range(0.02..0.6));
        let axis = DVec3::new(
            random.random_range(-1.0..1.0),
            random.random_range(-1.0..1.0),
            random.random_range(-1.0..1.0),
        );
        let turn = DQuat::from_axis_angle(axis.normalize(), random.random_range(0.0..3.0));
        let force = DVec3::new(
            random.random_range(-50.0..50.0),
            random.random_range(-100.0..100.0),
            random.random_range(-100.0..100.0),
        );
        let section = [Rectangle { center: DVec2::ZERO, size }];
        let (stations, step) = (random.random_range(4..12), random.random_range(0.05..0.4));
        let (moment, pull) = root_load(stations, step, force);
        let expected = beam_theory(&section, moment, pull);
        let found = worst_strain(&section, stations, step, turn, force);
        assert!((found / expected - 1.0).abs() < 2e-3, "{size}: {found} Pa, not {expected}");
    }
}

/// Of several boxes a station: each bond bends, and all of them together.
#[test]
fn sections_of_several_faces_bend_as_one() {
    let at = |y: f64, z: f64, height: f64, width: f64| Rectangle {
        center: DVec2::new(y, z),
        size: DVec2::new(height, width),
    };
    let i_beam =
        vec![at(0.14, 0.0, 0.04, 0.2), at(0.0, 0.0, 0.24, 0.03), at(-0.14, 0.0, 0.04, 0.2)];
    let l_beam = vec![at(0.02, 0.12, 0.04, 0.2), at(0.12, 0.0, 0.24, 0.04)];
    for section in [i_beam, l_beam] {
        for force in [DVec3::Y, -DVec3::Y, DVec3::new(0.0, 0.6, 0.8)] {
            let force = 100.0 * force;
            let (stations, step) = (12, 0.3);
            let (moment, pull) = root_load(stations, step, force);
            let expected = beam_theory(&section, moment, pull);
            let found = worst_strain(&section, stations, step, DQuat::IDENTITY, force);
            assert!((found / expected - 1.0).abs() < 0.1, "{force}: {found} Pa, not {expected}");
        }
    }
}

/// Second moments along and across two axes, and how far the rim reaches along them.
fn spread(contact: &Interface, axes: [DVec3; 2]) -> ([f64; 3], [f64; 4]) {
    let second = contact.section.second_moment;
    let reach = |axis: DVec3| {
        contact.section.rim.iter().map(|corner| axis.dot(*corner)).fold(0.0, f64::max)
    };
    let [u, v] = axes;
    (
        [u.dot(second * u), v.dot(second * v), u.dot(second * v)],
        [reach(u), reach(-u), reach(v), reach(-v)],
    )
}

#[test]
fn the_common_face_of_two_meshes_has_the_moments_of_its_outline() {
    let outline = [(0.0, 0.0), (0.3, 0.0), (0.3, 0.05), (0.04, 0.05), (0.04, 0.2), (0.0, 0.2)]
        .map(|(x, y)| DVec2::new(x, y));
    let section = [
        Rectangle { center: DVec2::new(0.15, 0.025), size: DVec2::new(0.3, 0.05) },
        Rectangle { center: DVec2::new(0.02, 0.125), size: DVec2::new(0.04, 0.15) },
    ];
    // Of each prism the face that it shares, in triangles of its own.
    let piece = |triangles: [[u32; 3]; 4]| {
        let positions = outline.iter().map(|corner| corner.extend(0.4)).collect();
        let mesh = TriMesh { positions, triangles: triangles.to_vec() };
        CutPiece { inner: vec![true; 4], mesh }
    };
    let below = piece([[0, 1, 2], [0, 2, 3], [0, 3, 4], [0, 4, 5]]);
    let above = piece([[3, 2, 1], [3, 1, 0], [3, 0, 5], [3, 5, 4]]);
    let [contact] = mesh_interfaces(&[below, above]).try_into().unwrap();
    let (expected, center, area) = moments(&section);
    assert!((contact.area - area).abs() < 1e-12);
    assert!((contact.centroid.truncate() - center).length() < 1e-12);
    let (found, reaches) = spread(&contact, [DVec3::X, DVec3::Y]);
    for (found, expected) in found.into_iter().zip(expected) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
    let corners = [0.3 - center.x, center.x, 0.2 - center.y, center.y];
    for (found, expected) in reaches.into_iter().zip(corners) {
        assert!((found - expected).abs() < 1e-12, "{found}, not {expected}");
    }
    assert_eq!(contact.section.rim.len(), 5, "without the corner that is no corner of the hull");
}

/// The exact path is the oracle of the grid path.
#[test]
fn sections_on_a_grid_are_those_of_polyhedra() {
    let form = ClosedForm::Box { half: DVec3::new(0.5, 0.1, 0.4) };
    let [exact, sampled] =
        [Shape::breakable(form, 0.1).unwrap(), common::sampled_form(form, [80, 16, 64])];
    let impact = Impact { point_body: DVec3::new(0.1, 0.1, -0.05), normal_body: DVec3::Y };
    for seed in 1..=6 {
        let pattern = Pattern::voronoi(&Voronoi { cells: 2, seed, ..Voronoi::default() }).unwrap();
        let contact = |shape| {
            let pieces = shatter(shape, &pattern, &impact, &ShatterSettings::default());
            interfaces(&pieces).into_iter().next()
        };
        let (Some(exact), Some(found)) = (contact(&exact), contact(&sampled)) else { continue };
        let (across, along) = exact.normal.any_orthonormal_pair();
        let (wanted, reaches) = spread(&exact, [across, along]);
        let (moments, found_reaches) = spread(&found, [across, along]);
        let size = wanted[0] + wanted[1];
        for (found, wanted) in moments.into_iter().zip(wanted) {
            assert!((found - wanted).abs() < 0.03 * size, "seed {seed}: {found}, not {wanted}");
        }
        for (found, wanted) in found_reaches.into_iter().zip(reaches) {
            assert!((found / wanted - 1.0).abs() < 0.08, "seed {seed}: {found}, not {wanted}");
        }
    }
}
