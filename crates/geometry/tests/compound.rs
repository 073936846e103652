//! Convex polyhedra that are one body.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible_geometry::{Compound, HalfSpace, Hull, NoMass, Shape};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};
use proptest::prelude::*;

/// A box between two corners [m].
fn cuboid(low: DVec3, high: DVec3) -> Hull {
    let middle = RigidTransform::new(DQuat::IDENTITY, 0.5 * (low + high));
    Hull::cuboid(0.5 * (high - low)).transformed(&middle)
}

/// A cube of edge 1 m as eight cubes.
fn cubelets() -> Vec<Hull> {
    let low =
        |n: i32| 0.5 * DVec3::new(f64::from(n & 1), f64::from(n >> 1 & 1), f64::from(n >> 2)) - 0.5;
    (0..8).map(|n| cuboid(low(n), low(n) + 0.5)).collect()
}

/// A foot of 3 x 1 x 1 m with a leg of 1 x 2 x 1 m on its end has the moments that the textbook
/// gives for them.
#[test]
fn an_l_of_two_boxes_has_its_textbook_mass() {
    let foot = cuboid(DVec3::ZERO, DVec3::new(3.0, 1.0, 1.0));
    let leg = cuboid(DVec3::new(0.0, 1.0, 0.0), DVec3::new(1.0, 3.0, 1.0));
    let mass = Compound::new(vec![foot, leg]).mass_properties();
    assert!((mass.volume - 5.0).abs() < 1e-14);
    // Of the foot (1.5, 0.5, 0.5) times 3, of the leg (0.5, 2, 0.5) times 2.
    assert!((mass.center - DVec3::new(5.5 / 5.0, 5.5 / 5.0, 0.5)).length() < 1e-14);
    // Second moments about the centre: each box's m (edge)^2 / 12 and m d^2.
    let xx = 3.0 * (9.0 / 12.0 + 0.16) + 2.0 * (1.0 / 12.0 + 0.36);
    let yy = 3.0 * (1.0 / 12.0 + 0.36) + 2.0 * (4.0 / 12.0 + 0.81);
    let zz = 5.0 / 12.0;
    let xy = 3.0 * 0.4 * -0.6 + 2.0 * -0.6 * 0.9;
    let inertia = mass.inertia;
    assert!((inertia.x_axis - DVec3::new(yy + zz, -xy, 0.0)).length() < 1e-13, "{inertia}");
    assert!((inertia.y_axis - DVec3::new(-xy, xx + zz, 0.0)).length() < 1e-13);
    assert!((inertia.z_axis - DVec3::new(0.0, 0.0, xx + yy)).length() < 1e-13);
    assert_eq!(Shape::compound(Compound::new(Vec::new()), 0.1).unwrap_err(), NoMass);
}

/// Eight cubes that form one: equal mass, distance, samples and surface.
#[test]
fn cubes_that_make_a_cube_are_one() {
    let (parts, whole) = (cubelets(), Hull::cuboid(DVec3::splat(0.5)));
    let compound = Compound::new(parts);
    for part in compound.parts() {
        assert_eq!(part.glued.iter().filter(|&&glued| glued).count(), 3);
    }
    let turn = RigidTransform::new(DQuat::from_rotation_z(0.4), DVec3::new(3.0, -2.0, 1.0));
    let shape = Shape::compound(compound.transformed(&turn), 0.1).unwrap();
    let exact = Shape::convex(whole.transformed(&turn), 0.1).unwrap();
    assert!((shape.volume - 1.0).abs() < 1e-14);
    assert!((shape.unit_moments - exact.unit_moments).length() < 1e-14);
    for sample in shape.samples() {
        let point = turn.inverse().point(shape.body_from_grid.inverse().point(sample.as_dvec3()));
        assert!(whole.distance_and_gradient(point).0.abs() < 1e-6);
    }
    // 6 faces of 11 x 11, of which edges and corners are shared.
    assert_eq!(shape.samples().len(), 6 * 81 + 12 * 9 + 8);

    // The surface is the cube's, without seams.
    let surface = compound.surface();
    assert_eq!(surface.interior, vec![false; surface.mesh.triangles.len()]);
    assert!((surface.mesh.mass_properties().volume - 1.0).abs() < 1e-14);
    assert!((surface.mesh.area() - 6.0).abs() < 1e-13);
    assert_eq!(surface.mesh.positions.len(), 26);
    let info = surface.mesh.info();
    assert!(info.watertight && info.parts == 1, "{info:?}");
}

/// A small block on a large one hides its own foot, and a part of the face that it stands on; what
/// stands across an edge, or in a corner of three, leaves a closed surface too.
#[test]
fn faces_that_parts_turn_to_each_other_are_no_surface() {
    let ground = || cuboid(DVec3::new(-2.0, -1.0, -2.0), DVec3::new(2.0, 0.0, 2.0));
    let block = |x: f64, z: f64| {
        cuboid(DVec3::new(x - 0.5, 0.0, z - 0.5), DVec3::new(x + 0.5, 1.0, z + 0.5))
    };
    // Area of the ground 2 (16 + 4 + 4), without what is covered; of a block 6, likewise.
    for (blocks, area) in [
        (vec![block(0.3, -0.4)], 48.0 - 1.0 + 5.0),
        (vec![block(2.0, 0.1)], 48.0 - 0.5 + 5.5),
        (vec![block(0.3, 0.0), block(1.0, 0.0), block(1.0, 1.0)], 0.0),
        (vec![block(0.0, 0.0), block(1.0, 0.2)], 48.0 - 2.0 + 10.0 - 2.0 * 0.8),
    ] {
        let count = blocks.len();
        let compound = Compound::new([vec![ground()], blocks].concat());
        let surface = compound.surface();
        let mesh = &surface.mesh;
        assert!(mesh.is_watertight(), "{count}");
        assert!((mesh.mass_properties().volume - 16.0 - count as f64).abs() < 1e-12);
        // The first of the three blocks and the second overlap: their surfaces are as they were.
        if count < 3 {
            assert!((mesh.area() - area).abs() < 1e-12, "{}: {}", area, mesh.area());
            for triangle in 0..mesh.triangles.len() {
                let [a, b, c] = mesh.corners(triangle);
                assert!((b - a).cross(c - a).length() > 1e-9);
            }
        }
    }
}

/// Parts that meet but for rounding: turned, cut again and again, and welded.
#[test]
fn parts_of_a_cut_polyhedron_have_its_surface() {
    let turn = RigidTransform::new(DQuat::from_scaled_axis(DVec3::new(0.4, -0.7, 1.1)), DVec3::ONE);
    let mut parts = vec![Hull::cuboid(DVec3::new(1.0, 0.7, 0.01)).transformed(&turn)];
    for n in 0..7 {
        let normal = DVec3::new(f64::from(n * 37 % 11) - 5.0, f64::from(n * 29 % 13) - 6.0, 0.7);
        let plane = HalfSpace { normal: turn.rotation * normal.normalize(), offset: 0.0 };
        let offset = plane.normal.dot(turn.translation) + 0.05 * f64::from(n);
        let plane = HalfSpace { offset, ..plane };
        let halves = |part: &Hull| {
            let mut cutter = frangible_geometry::CellCutter::new(part);
            [cutter.part(&[plane]), cutter.part(&[plane.flipped()])].into_iter().flatten().collect()
        };
        parts = parts.iter().flat_map(|part| -> Vec<Hull> { halves(part) }).collect();
    }
    assert!(parts.len() > 15, "{}", parts.len());
    let surface = Compound::new(parts).surface();
    assert!(surface.mesh.is_watertight() && surface.mesh.parts() == 1);
    let area = 8.0 * (0.7 + 0.01 + 0.007);
    assert!((surface.mesh.area() / area - 1.0).abs() < 1e-9, "{} of {area}", surface.mesh.area());
    assert!(!surface.interior.contains(&true));
}

/// A half-covered face is not glued; a face covered by two other parts is.
#[test]
fn glued_faces_are_those_that_are_covered() {
    let (low, high) = (DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0));
    let above = |from: f64, to: f64| cuboid(DVec3::new(from, 1.0, 0.0), DVec3::new(to, 2.0, 1.0));
    let top = |compound: &Compound| {
        let mut faces = compound.parts()[0].hull.faces();
        compound.parts()[0].glued[faces.position(|face| face.plane.normal.y > 0.9).unwrap()]
    };
    assert!(!top(&Compound::new(vec![cuboid(low, high), above(0.0, 1.0)])));
    assert!(top(&Compound::new(vec![cuboid(low, high), above(0.0, 0.7), above(0.7, 2.0)])));
    assert!(!top(&Compound::new(vec![cuboid(low, high), above(0.0, 0.7), above(0.8, 2.0)])));
    // Beside each other, not on each other.
    assert!(!top(&Compound::new(vec![cuboid(low, high), above(2.0, 4.0)])));
}

/// On a seam the flat top's own normal counts, and no other; at a wall's foot the normals of both,
/// and none between them.
#[test]
fn what_glued_parts_hide_of_each_other_is_no_surface() {
    let floor = |x: f64| cuboid(DVec3::new(x, -1.0, 0.0), DVec3::new(x + 1.0, 0.0, 1.0));
    let compound = Compound::new(vec![floor(0.0), floor(1.0)]);
    let seam = DVec3::new(1.0, 0.0, 0.5);
    let is_covered = |part: usize, point: DVec3, normal: [f64; 3]| {
        compound.is_covered(part, point, normal.into(), SLACK)
    };
    assert!(!is_covered(0, seam, [0.0, 1.0, 0.0]) && !is_covered(1, seam, [0.0, 1.0, 0.0]));
    assert!(is_covered(0, seam, [0.6, 0.8, 0.0]) && is_covered(1, seam, [-0.6, 0.8, 0.0]));
    assert!(is_covered(0, DVec3::new(1.0, -0.01, 0.5), [1.0, 0.0, 0.0]));
    assert!(!is_covered(1, DVec3::new(2.0, 0.0, 0.5), [0.6, 0.8, 0.0]));
    // Under the seam the nearest surface is the top, for either part.
    for x in [0.99, 1.0, 1.01] {
        let (distance, gradient) = compound.distance_and_gradient(DVec3::new(x, -0.1, 0.5));
        assert!((distance + 0.1).abs() < 1e-15 && gradient == DVec3::Y, "{distance}, {gradient}");
    }
}

/// Way to the side of a point on which a surface counts [m].
const SLACK: f64 = 1e-3;

/// At the foot of a wall, beside floors or on them, both have their normals: on its line, a little
/// behind it, and where two walls meet.
#[test]
fn walls_hide_no_floor_at_their_feet() {
    let floors = [0.0, 1.0].map(|x| (DVec3::new(x, -1.0, 0.0), DVec3::new(x + 1.0, 0.0, 1.0)));
    let walls = |depth: f64, foot: f64| {
        let behind = (DVec3::new(0.0, -depth, foot), DVec3::new(2.0, 1.0, foot + 0.5));
        let beside = (DVec3::new(-0.5, -depth, 0.0), DVec3::new(0.0, 1.0, foot + 0.5));
        [behind, beside]
    };
    for (depth, foot) in [(0.0, 1.0), (1.0, 1.0), (0.0, 0.8)] {
        let parts = floors.into_iter().chain(walls(depth, foot));
        let compound = Compound::new(parts.map(|(low, high)| cuboid(low, high)).collect());
        for turn in [DQuat::IDENTITY, DQuat::from_rotation_y(0.3)] {
            let turned = compound.transformed(&RigidTransform::new(turn, DVec3::ZERO));
            let is_covered = |part: usize, at: [f64; 3], normal: [f64; 3]| {
                turned.is_covered(part, turn * DVec3::from(at), turn * DVec3::from(normal), SLACK)
            };
            let (up, out, along) = ([0.0, 1.0, 0.0], [0.0, 0.0, -1.0], [1.0, 0.0, 0.0]);
            for (floor, x) in [(0, 0.5), (0, 1.0), (1, 1.0), (0, 0.0)] {
                assert!(!is_covered(floor, [x, 0.0, foot], up), "{depth} {foot} {x}");
                assert!(!is_covered(floor, [x, 0.0, (foot + 1e-4).min(1.0)], up), "{depth} {x}");
            }
            assert!(!is_covered(2, [0.5, 0.0, foot], out) && !is_covered(2, [0.0, 0.0, foot], out));
            assert!(!is_covered(3, [0.0, 0.0, foot], along));
            let between = [0.0, 0.8, -0.6];
            assert!(is_covered(0, [0.5, 0.0, foot], between), "{depth} {foot}");
            assert!(is_covered(2, [0.5, 0.0, foot], between), "{depth} {foot}");
            // Sides of floors that touch, and of what stands on one.
            assert!(
                is_covered(0, [1.0, 0.0, 0.5], along) && is_covered(0, [1.0, -1e-4, 0.5], along)
            );
            assert!(is_covered(2, [0.5, -depth, foot + 0.1], [0.0, -1.0, 0.0]) == (foot < 1.0));
        }
    }
}

fn vector(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

proptest! {
    /// The tree finds what asking every part finds.
    #[test]
    fn distances_and_parts_are_those_of_brute_force(
        corners in prop::collection::vec((vector(2.0), prop::array::uniform3(0.1..1.0f64)), 1..12),
        point in vector(3.0),
        size in prop::array::uniform3(0.0..1.0f64),
        normal in vector(1.0),
    ) {
        let hulls: Vec<Hull> =
            corners.iter().map(|&(low, size)| cuboid(low, low + DVec3::from_array(size))).collect();
        let compound = Compound::new(hulls.clone());
        let expected = hulls.iter().map(|hull| hull.distance_and_gradient(point).0).fold(f64::INFINITY, f64::min);
        let (distance, gradient) = compound.distance_and_gradient(point);
        prop_assert!((distance - expected).abs() < 1e-12);
        prop_assert!((gradient.length() - 1.0).abs() < 1e-12);
        prop_assert!((compound.distance_up_to(point, distance + 1e-9) - expected).abs() < 1e-12);
        prop_assert_eq!(compound.distance_up_to(point, expected - 1e-9), f64::INFINITY);

        let high = point + DVec3::from_array(size);
        let meets = |hull: &Hull| {
            let (from, to) = hull.bounds();
            from.cmple(high).all() && point.cmple(to).all()
        };
        let near: Vec<usize> = (0..hulls.len()).filter(|&index| meets(&hulls[index])).collect();
        prop_assert_eq!(compound.parts_near(point, high), near);

        let half_space = HalfSpace { normal: normal.try_normalize().unwrap_or(DVec3::Y), offset: 0.5 * point.x };
        let reaches = |hull: &Hull| hull.vertices().iter().any(|&vertex| half_space.distance(vertex) <= 0.0);
        let inside: Vec<usize> = (0..hulls.len()).filter(|&index| reaches(&hulls[index])).collect();
        prop_assert_eq!(compound.parts_in(&half_space), inside);
    }
}
