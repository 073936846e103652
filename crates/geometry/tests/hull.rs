//! Convex polyhedra: of points, cut, and measured.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible_geometry::{
    CellCutter, ClosedForm, Geometry, GridSolid, HalfSpace, Hull, HullError, HullFace,
    MassProperties, PlaneClipper, Shape,
};
use frangible_math::RigidTransform;
use glam::{DMat3, DQuat, DVec3};
use proptest::prelude::*;

fn vector(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

fn points() -> impl Strategy<Value = Vec<DVec3>> {
    prop::collection::vec(vector(1.0), 5..40)
}

/// Points whose hull has many coplanar faces and collinear edges: nodes of a lattice, turned.
fn lattice_points() -> impl Strategy<Value = Vec<DVec3>> {
    let node =
        prop::array::uniform3(0..4_i32).prop_map(|node| DVec3::from_array(node.map(f64::from)));
    (prop::collection::vec(node, 8..60), vector(2.0)).prop_map(|(nodes, turn)| {
        let turn = DQuat::from_scaled_axis(turn);
        nodes.into_iter().map(|node| turn * node).collect()
    })
}

/// Euler's formula, planes that hold all vertices, loops that lie on their planes and turn left,
/// edges between their faces.
fn check(hull: &Hull, flat: f64) {
    let (vertices, faces, edges) = (hull.vertices(), hull.faces(), hull.edges());
    assert_eq!(vertices.len() + faces.len(), edges.len() + 2);
    for face in faces.clone() {
        assert!((face.plane.normal.length() - 1.0).abs() < 1e-14);
        assert!(vertices.iter().all(|&vertex| face.plane.distance(vertex) < flat));
        let corner = |at: usize| vertices[face.vertices[at % face.vertices.len()] as usize];
        for at in 0..face.vertices.len() {
            assert!(face.plane.distance(corner(at)).abs() < flat);
            let turn = (corner(at + 1) - corner(at)).cross(corner(at + 2) - corner(at + 1));
            assert!(turn.dot(face.plane.normal) > -flat, "{turn}");
        }
    }
    for face in faces.clone() {
        for (at, &edge) in face.edges.iter().enumerate() {
            let mut ends = edges[edge as usize].vertices;
            ends.sort_unstable();
            let mut side = [face.vertices[at], face.vertices[(at + 1) % face.vertices.len()]];
            side.sort_unstable();
            assert_eq!(ends, side);
        }
    }
    for edge in edges {
        let runs = |face: u32, from: u32, to: u32| {
            let around = hull.face(face as usize).vertices;
            (0..around.len()).any(|at| around[at] == from && around[(at + 1) % around.len()] == to)
        };
        let [a, b] = edge.vertices;
        assert!(runs(edge.faces[0], a, b) && runs(edge.faces[1], b, a));
    }
}

fn assert_same_mass(a: &MassProperties, b: &MassProperties, tolerance: f64) {
    assert!((a.volume - b.volume).abs() < tolerance, "{} {}", a.volume, b.volume);
    assert!((a.center - b.center).length() < tolerance);
    assert!((a.inertia - b.inertia).abs_diff_eq(DMat3::ZERO, tolerance));
}

#[test]
fn a_cuboid_is_the_textbook_s() {
    let half = DVec3::new(0.5, 0.2, 0.3);
    let hull = Hull::cuboid(half);
    check(&hull, 1e-15);
    assert_eq!((hull.vertices().len(), hull.faces().len(), hull.edges().len()), (8, 6, 12));
    let form = ClosedForm::Box { half };
    assert_same_mass(&hull.mass_properties(), &form.mass_properties().unwrap(), 1e-16);
    assert_eq!(hull.bounds(), form.bounds());

    let again = Hull::of_points(hull.vertices()).unwrap();
    check(&again, 1e-15);
    assert_eq!((again.vertices(), again.faces().len()), (hull.vertices(), 6));
}

#[test]
fn what_has_no_inside_says_so() {
    let square = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::X + DVec3::Y, DVec3::new(0.5, 0.5, 1e-7)];
    assert_eq!(Hull::of_points(&square[..3]).unwrap_err(), HullError::TooFew);
    assert_eq!(Hull::of_points(&square).unwrap_err(), HullError::Flat);
    assert_eq!(Hull::of_points(&[DVec3::ONE; 9]).unwrap_err(), HullError::Flat);
    assert_eq!(
        Hull::of_points(&[0.0, 1.0, 2.0, 3.0].map(DVec3::splat)).unwrap_err(),
        HullError::Flat
    );
    assert_eq!(Hull::of_points(&[DVec3::NAN; 4]).unwrap_err(), HullError::NotFinite);
}

/// Single precision takes the corners of a turned box off their planes, but its faces stay six.
#[test]
fn rounded_points_keep_their_faces() {
    for turn in 0..50 {
        let turn = DQuat::from_scaled_axis(DVec3::new(0.1, 0.3, -0.2) * f64::from(turn));
        let cuboid = Hull::cuboid(DVec3::new(0.5, 0.02, 0.3));
        let rounded: Vec<DVec3> =
            cuboid.vertices().iter().map(|&v| (turn * v).as_vec3().as_dvec3()).collect();
        let hull = Hull::of_points(&rounded).unwrap();
        check(&hull, 1e-6);
        assert_eq!((hull.vertices().len(), hull.faces().len(), hull.edges().len()), (8, 6, 12));
    }
}

#[test]
fn a_ball_of_many_points_is_a_hull() {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let ball: Vec<DVec3> = (0..4000)
        .map(|n| {
            let y = 1.0 - (2.0 * f64::from(n) + 1.0) / 4000.0;
            let (sin, cos) = (golden * f64::from(n)).sin_cos();
            DVec3::new((1.0 - y * y).sqrt() * cos, y, (1.0 - y * y).sqrt() * sin)
        })
        .collect();
    let hull = Hull::of_points(&ball).unwrap();
    check(&hull, 1e-6);
    assert_eq!(hull.vertices().len(), 4000);
    assert!(
        (hull.mass_properties().volume / (4.0 / 3.0 * std::f64::consts::PI) - 1.0).abs() < 2e-3
    );
}

/// Polyhedra of round bodies have their volume, lie close to them, and have their symmetry.
#[test]
fn round_bodies_keep_their_volume_as_polyhedra() {
    let (radius, half_height) = (0.7, 0.4);
    let ball = ClosedForm::Sphere { radius };
    let drum = ClosedForm::Cylinder { radius, half_height };
    let capsule = ClosedForm::Capsule { radius, half_height };
    let cone = ClosedForm::Cone { radius, height: 0.9 };
    for (form, hull, counts, off, moments_off) in [
        (ball, Hull::ball(radius), (80, 42, 120), 0.0445, 1e-2),
        (drum, Hull::cylinder(radius, half_height), (48, 26, 72), 0.006, 1e-3),
        (capsule, Hull::capsule(radius, half_height), (72, 62, 132), 0.0625, 3e-2),
        (cone, Hull::cone(radius, 0.9), (25, 25, 48), 0.006, 1e-3),
    ] {
        check(&hull, 1e-14);
        assert_eq!((hull.vertices().len(), hull.faces().len(), hull.edges().len()), counts);
        assert!(hull.faces().all(|face| !face.inner));
        let (exact, mass) = (form.mass_properties().unwrap(), hull.mass_properties());
        assert!((mass.volume / exact.volume - 1.0).abs() < 1e-14);
        assert!((hull.volume() / exact.volume - 1.0).abs() < 1e-14);
        assert!(mass.center.length() < 1e-15);
        assert!(mass.inertia.abs_diff_eq(exact.inertia, moments_off * exact.inertia.x_axis.x));
        // The corners stick out, and the middles of the faces lie below.
        let distances = hull.vertices().iter().map(|&vertex| form.distance(vertex));
        let furthest = distances.fold(f64::NEG_INFINITY, f64::max);
        let middle = |face: HullFace<'_>| {
            let corners = face.vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]);
            form.distance(corners.sum::<DVec3>() / face.vertices.len() as f64)
        };
        let deepest = hull.faces().map(middle).fold(f64::INFINITY, f64::min);
        let off = off * radius;
        assert!((0.9 * off..off).contains(&furthest.max(-deepest)), "{furthest} {deepest}");

        // The shape that breaks has the formula's contacts and frame, and the polyhedron's mass.
        let shape = Shape::breakable(form, 0.1).unwrap();
        assert_eq!((shape.volume, shape.breaks_as()), (mass.volume, Some(&hull)));
        assert!(matches!(shape.geometry, Geometry::ClosedForm(_)));
        assert_eq!(shape.body_from_grid, RigidTransform::IDENTITY);
        let inertia = DMat3::from_diagonal(shape.unit_moments);
        assert!(inertia.abs_diff_eq(mass.inertia, 1e-14));
    }
    let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
    assert!(Shape::breakable(ground, 0.1).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// All points are inside, vertices are points, and the hull of the vertices is the same.
    #[test]
    fn the_hull_of_points_holds_them(points in prop_oneof![points(), lattice_points()]) {
        let Ok(hull) = Hull::of_points(&points) else { return Ok(()) };
        check(&hull, 2e-5);
        let (low, high) = hull.bounds();
        let size = (high - low).max_element();
        for &point in &points {
            prop_assert!(hull.distance_and_gradient(point).0 < 1e-6 * size);
        }
        let near = |a: &DVec3, b: &DVec3| a.distance(*b) < 1e-4 * size;
        prop_assert!(hull.vertices().iter().all(|vertex| points.iter().any(|point| near(point, vertex))));
        let again = Hull::of_points(hull.vertices()).unwrap();
        prop_assert_eq!(again.vertices().len(), hull.vertices().len());
        prop_assert!(again.vertices().iter().zip(hull.vertices()).all(|(a, b)| a.distance(*b) < 1e-12 * size));
        assert_same_mass(&again.mass_properties(), &hull.mass_properties(), 1e-12 * size.powi(5));
    }

    /// Duplicates and points inside make no difference.
    #[test]
    fn points_inside_do_not_matter(points in points(), seeds in prop::collection::vec(0.0..1.0f64, 10)) {
        let Ok(hull) = Hull::of_points(&points) else { return Ok(()) };
        let mut more = hull.vertices().to_vec();
        for (at, seed) in seeds.iter().enumerate() {
            more.push(points[at % points.len()].lerp(points[(3 * at + 1) % points.len()], *seed));
            more.push(points[at % points.len()]);
        }
        let more = Hull::of_points(&more).unwrap();
        assert_same_mass(&more.mass_properties(), &hull.mass_properties(), 1e-5);
    }

    /// The two sides of a cut add up to the whole, and share the cut bit for bit.
    #[test]
    fn cuts_add_up(
        points in prop_oneof![points(), lattice_points()],
        cuts in prop::collection::vec((vector(1.0), -1.0..1.0f64), 1..6),
    ) {
        let Ok(mut hull) = Hull::of_points(&points) else { return Ok(()) };
        for (normal, part) in cuts {
            let Some(normal) = normal.try_normalize() else { continue };
            let middle = hull.mass_properties().center;
            let cut = HalfSpace { normal, offset: normal.dot(middle) + 0.5 * part };
            let other = cut.flipped();
            let whole = hull.mass_properties();
            match (hull.clipped(&cut), hull.clipped(&other)) {
                (Some(inside), Some(outside)) => {
                    check(&inside, 2e-5);
                    check(&outside, 2e-5);
                    let (a, b) = (inside.mass_properties(), outside.mass_properties());
                    prop_assert!((a.volume + b.volume - whole.volume).abs() < 1e-12);
                    let first = a.volume * a.center + b.volume * b.center - whole.volume * whole.center;
                    prop_assert!(first.length() < 1e-12);
                    let on_cut = |hull: &Hull| {
                        let mut on: Vec<[u64; 3]> = hull
                            .vertices()
                            .iter()
                            .filter(|&&vertex| cut.distance(vertex).abs() < 1e-9)
                            .map(|vertex| vertex.to_array().map(f64::to_bits))
                            .collect();
                        on.sort_unstable();
                        on
                    };
                    prop_assert_eq!(on_cut(&inside), on_cut(&outside));
                    hull = if a.volume > b.volume { inside } else { outside };
                }
                (Some(same), None) | (None, Some(same)) => prop_assert_eq!(&same, &hull),
                (None, None) => prop_assert!(false, "a hull has at least one side of a plane"),
            }
        }
    }

    /// A cube that is cut along its own faces, edges and diagonals.
    #[test]
    fn cuts_through_corners_add_up(node in prop::array::uniform3(-1..=1_i32), shift in -2..=2_i32) {
        let normal = DVec3::from_array(node.map(f64::from));
        let Some(unit) = normal.try_normalize() else { return Ok(()) };
        let cube = Hull::cuboid(DVec3::ONE);
        let cut = HalfSpace { normal: unit, offset: 0.5 * f64::from(shift) * normal.length() };
        let other = cut.flipped();
        let sides: Vec<Hull> = [cut, other].iter().filter_map(|cut| cube.clipped(cut)).collect();
        sides.iter().for_each(|hull| check(hull, 1e-9));
        let volume: f64 = sides.iter().map(|hull| hull.mass_properties().volume).sum();
        prop_assert!((volume - 8.0).abs() < 1e-12);
    }

    /// Distance outside against the nearest of all combinations of corners, edges and faces; inside
    /// against the planes; and the foot is on the surface.
    #[test]
    fn distances_are_exact(points in points(), samples in prop::collection::vec(vector(2.0), 20)) {
        let Ok(hull) = Hull::of_points(&points) else { return Ok(()) };
        let triangles = hull.surface();
        for point in samples {
            let (distance, gradient) = hull.distance_and_gradient(point);
            prop_assert!((gradient.length() - 1.0).abs() < 1e-12);
            let expected = (0..triangles.triangles.len())
                .map(|n| distance_to_triangle(point, triangles.corners(n)))
                .fold(f64::INFINITY, f64::min);
            prop_assert!((distance.abs() - expected).abs() < 3e-6, "{distance} {expected}");
            prop_assert!(hull.distance_and_gradient(point - distance * gradient).0.abs() < 3e-6);
            let height = |point: DVec3| {
                hull.planes().iter().map(|plane| plane.distance(point)).fold(f64::NEG_INFINITY, f64::max)
            };
            prop_assert_eq!(distance < 0.0, height(point) < 0.0);
            prop_assert_eq!(hull.distance_up_to(point, f64::INFINITY), distance);
            if distance > 0.1 {
                prop_assert!((0.1..=distance).contains(&hull.distance_up_to(point, 0.1).max(0.1)));
            }
        }
    }

    /// A box agrees with its formula, gradient and all.
    #[test]
    fn a_cuboid_is_as_far_as_its_formula_says(point in vector(1.5)) {
        let half = DVec3::new(0.5, 0.9, 0.2);
        let (distance, gradient) = Hull::cuboid(half).distance_and_gradient(point);
        let (expected, slope) = ClosedForm::Box { half }.distance_and_gradient(point);
        prop_assert!((distance - expected).abs() < 1e-14);
        prop_assert!((gradient - slope).length() < 1e-12);
    }

    #[test]
    fn moving_a_hull_moves_all_of_it(points in points(), turn in vector(3.0), shift in vector(5.0), at in vector(3.0)) {
        let Ok(hull) = Hull::of_points(&points) else { return Ok(()) };
        let to_from_hull = RigidTransform::new(DQuat::from_scaled_axis(turn), shift);
        let moved = hull.transformed(&to_from_hull);
        check(&moved, 2e-5);
        let (distance, gradient) = hull.distance_and_gradient(at);
        let (there, slope) = moved.distance_and_gradient(to_from_hull.point(at));
        prop_assert!((distance - there).abs() < 1e-12);
        prop_assert!(distance < 1e-3 || (to_from_hull.direction(gradient) - slope).length() < 1e-9);
    }
}

/// Distance from a point to a triangle, by the nearest of its plane's foot, its edges and its
/// corners [m].
fn distance_to_triangle(point: DVec3, corners: [DVec3; 3]) -> f64 {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a).normalize_or_zero();
    let over = (0..3).all(|at| {
        let (start, end) = (corners[at], corners[(at + 1) % 3]);
        (end - start).cross(point - start).dot(normal) >= 0.0
    });
    let to_edges = (0..3).map(|at| {
        let (start, along) = (corners[at], corners[(at + 1) % 3] - corners[at]);
        let part = ((point - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
        point.distance(start + part * along)
    });
    let nearest = to_edges.fold(f64::INFINITY, f64::min);
    if over && normal != DVec3::ZERO { nearest.min(normal.dot(point - a).abs()) } else { nearest }
}

/// A shape finds the principal frame, and everything in it agrees.
#[test]
fn a_convex_shape_lies_in_its_principal_frame() {
    let turned = RigidTransform::new(
        DQuat::from_scaled_axis(DVec3::new(0.4, -0.2, 0.9)),
        DVec3::new(3.0, -1.0, 2.0),
    );
    let half = DVec3::new(0.5, 0.2, 0.3);
    let points: Vec<DVec3> =
        Hull::cuboid(half).vertices().iter().map(|&v| turned.point(v)).collect();
    let shape = Shape::convex(Hull::of_points(&points).unwrap(), 0.1).unwrap();
    let exact = Shape::closed_form(ClosedForm::Box { half }, 0.1);
    assert!((shape.volume - exact.volume).abs() < 1e-14);
    let sorted = |v: DVec3| {
        let mut sorted = v.abs().to_array();
        sorted.sort_by(f64::total_cmp);
        DVec3::from_array(sorted)
    };
    assert!((sorted(shape.unit_moments) - sorted(exact.unit_moments)).length() < 1e-14);
    assert!((sorted(shape.bounds.1) - sorted(half)).length() < 1e-12);
    assert!(shape.body_from_grid.point(turned.translation).length() < 1e-12);

    // As many samples as the box's formula has, on the surface, and the corners among them.
    assert_eq!(shape.samples().len(), exact.samples().len());
    let in_body = shape.hull.as_ref().unwrap();
    for sample in shape.samples() {
        let distance = shape.distance_and_gradient(sample.as_dvec3()).0;
        assert!(distance.abs() < 1e-7);
        assert!((in_body.distance_and_gradient(sample.as_dvec3()).0 - distance).abs() < 1e-12);
    }
    for vertex in in_body.vertices() {
        assert!(shape.samples().contains(&vertex.as_vec3()));
    }

    // Its surface is closed and encloses the volume; nothing is cracked.
    let surface = shape.surface();
    assert!((surface.mesh.mass_properties().volume - shape.volume).abs() < 1e-14);
    assert!(!surface.interior.contains(&true));
    assert!(exact.hull.as_ref().is_some_and(|hull| hull.faces().len() == 6));
}

/// On a grid it keeps its volume and its sharp edges.
#[test]
fn a_hull_on_a_grid_keeps_its_edges() {
    let hull = Hull::of_points(&[DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z]).unwrap();
    let solid = GridSolid::from_hull(hull.clone(), [40; 3], 2);
    let shape = Shape::from_grid_solid(solid, Vec::new()).unwrap();
    assert!((shape.volume * 6.0 - 1.0).abs() < 1e-3, "{}", shape.volume);
    let mesh = shape.surface().mesh;
    assert!((mesh.mass_properties().volume * 6.0 - 1.0).abs() < 1e-3);
    let grid_from_body = shape.body_from_grid.inverse();
    for vertex in hull.vertices() {
        let nearest = mesh.positions.iter().map(|&p| grid_from_body.point(p).distance(*vertex));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-6, "{nearest}");
    }
    assert!(matches!(shape.geometry, Geometry::Grid(_)) && shape.hull.is_none());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Carved parts equal clipped parts, for cuts beside vertices or through them.
    #[test]
    fn carved_parts_are_the_clipped_ones(
        points in points(), cuts in prop::collection::vec((vector(1.0), -0.2..0.8f64), 1..12), through in 0..3_usize,
    ) {
        let Ok(hull) = Hull::of_points(&points) else { return Ok(()) };
        let cut = |(at, (direction, offset)): (usize, (DVec3, f64))| {
            let normal = direction.try_normalize().unwrap_or(DVec3::X);
            // Some go through a vertex.
            let vertex = hull.vertices()[at % hull.vertices().len()];
            HalfSpace { normal, offset: if at < through { normal.dot(vertex) } else { offset } }
        };
        let cuts: Vec<HalfSpace> = cuts.into_iter().enumerate().map(cut).collect();
        let mut cutter = CellCutter::new(&hull);
        // Earlier carving has no effect.
        cutter.part(&cuts[..1]);
        let (carved, clipped) = (cutter.part(&cuts), PlaneClipper::default().clipped(&hull, &cuts));
        prop_assert_eq!(carved.is_some(), clipped.is_some());
        if let (Some(carved), Some(clipped)) = (carved, clipped) {
            check(&carved, 1e-9);
            prop_assert!((carved.volume() - clipped.volume()).abs() < 1e-12);
            prop_assert_eq!(carved.planes(), clipped.planes());
            prop_assert_eq!(carved.vertices().len(), clipped.vertices().len());
            let inner = |hull: &Hull| hull.faces().map(|face| face.inner).collect::<Vec<_>>();
            prop_assert_eq!(inner(&carved), inner(&clipped));
        }
    }
}
