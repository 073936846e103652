use super::*;
use crate::bvh::closest_point_on_triangle;
use crate::closed_form::ClosedForm;
use crate::closed_form_surface::closed_form_surface;
use crate::static_mesh::heightfield::heightfield_mesh;
use proptest::prelude::*;

fn point(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

/// Triangles of all sizes, slivers and points among them.
fn soup() -> impl Strategy<Value = TriMesh> {
    let triangle =
        (point(1.0), point(1.0), point(1.0), 0..5).prop_map(|(a, b, c, kind)| match kind {
            0 => [a, a + 0.05 * b, a + 0.05 * c],
            1 => [a, b, a],
            2 => [a, a, a],
            3 => [a, b, 0.5 * (a + b) + 1e-9 * c],
            _ => [a, b, c],
        });
    prop::collection::vec(triangle, 1..60).prop_map(|triangles| TriMesh {
        triangles: (0..triangles.len() as u32).map(|t| [3 * t, 3 * t + 1, 3 * t + 2]).collect(),
        positions: triangles.into_iter().flatten().collect(),
    })
}

fn cube(half: f64) -> TriMesh {
    closed_form_surface(&ClosedForm::Box { half: DVec3::splat(half) })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// The tree finds what trying every triangle finds: in a box, along a way, and the nearest.
    #[test]
    fn queries_are_those_of_brute_force(
        mesh in soup(), at in point(1.2), half in point(0.5), to in point(1.5), margin in 0.0..0.1_f64,
    ) {
        let Some(built) = StaticMesh::new(&mesh, Sides::Two) else { return Ok(()) };
        let count = built.triangles().len();
        prop_assert_eq!(count + built.dropped(), mesh.triangles.len());
        let bounds = |triangle: usize| {
            let [a, b, c] = built.corners(triangle);
            (a.min(b).min(c), a.max(b).max(c))
        };

        let (low, high) = (at - half.abs(), at + half.abs());
        let mut seen = vec![false; count];
        built.visit_box(low, high, |triangle| seen[triangle] = true);
        for triangle in 0..count {
            let (own_low, own_high) = bounds(triangle);
            let meets = own_low.cmple(high).all() && low.cmple(own_high).all();
            prop_assert!(seen[triangle] || !meets);
        }

        let mut seen = vec![false; count];
        built.visit_way([at, to], margin, |triangle| seen[triangle] = true);
        for triangle in 0..count {
            let corners = built.corners(triangle);
            let comes_near = (0..=50).any(|part| {
                let on_way = at.lerp(to, f64::from(part) / 50.0);
                closest_point_on_triangle(on_way, &corners).distance(on_way) <= margin
            });
            prop_assert!(seen[triangle] || !comes_near);
        }

        let distance = |triangle: usize| {
            closest_point_on_triangle(at, &built.corners(triangle)).distance(at)
        };
        let least = (0..count).map(distance).fold(f64::INFINITY, f64::min);
        let nearest = built.nearest(at, f64::INFINITY).unwrap();
        prop_assert!((nearest.point.distance(at) - least).abs() < 1e-9);
        prop_assert!((distance(nearest.triangle) - least).abs() < 1e-9);
        prop_assert_eq!(built.nearest(at, 0.9 * least), None);
        let (value, gradient) = built.distance_and_gradient(at);
        prop_assert!((value - least).abs() < 1e-9 && (gradient.length() - 1.0).abs() < 1e-9);
    }

    /// Around a box that is given as triangles, the signed distance is the box's.
    #[test]
    fn the_distance_of_a_closed_mesh_is_that_of_its_solid(at in point(1.2)) {
        let built = StaticMesh::new(&cube(0.7), Sides::One).unwrap();
        let (distance, gradient) = built.distance_and_gradient(at);
        let form = ClosedForm::Box { half: DVec3::splat(0.7) };
        let (expected, _) = form.distance_and_gradient(at);
        prop_assert!((distance - expected).abs() < 1e-9, "{distance} {expected}");
        prop_assert!((form.distance(at - distance * gradient)).abs() < 1e-9);
    }
}

/// A cube's twelve edges are convex, its six diagonals flat, and all eight corners may touch.
#[test]
fn a_cube_has_convex_edges_and_flat_diagonals() {
    let built = StaticMesh::new(&cube(0.5), Sides::One).unwrap();
    let count = |mesh: &StaticMesh, kind: EdgeKind| {
        let all = (0..mesh.triangles().len()).flat_map(|t| (0..3).map(move |at| (t, at)));
        all.filter(|&(t, at)| mesh.edge_kind(t, at) == kind).count()
    };
    assert_eq!(count(&built, EdgeKind::Convex), 24);
    assert_eq!(count(&built, EdgeKind::Flat), 12);
    let all = || (0..12).flat_map(|t| (0..3).map(move |at| (t, at)));
    assert_eq!(all().filter(|&(t, at)| built.owns_edge(t, at)).count(), 12);
    assert_eq!(all().filter(|&(t, at)| built.owns_vertex(t, at)).count(), 8);
    // Seen from inside, all of them are concave, and none may touch.
    let mut inward = cube(0.5);
    inward.flip();
    let built = StaticMesh::new(&inward, Sides::One).unwrap();
    assert_eq!(count(&built, EdgeKind::Concave), 24);
    assert_eq!(all().filter(|&(t, at)| built.owns_edge(t, at)).count(), 0);
}

/// A floor of quads that share no edges, shifted against each other, has borders only around it.
#[test]
fn borders_that_others_continue_are_flat() {
    let mut mesh = TriMesh::default();
    let mut quad = |x: f64, z: f64| {
        let first = mesh.positions.len() as u32;
        mesh.positions.extend([
            DVec3::new(x, 0.0, z),
            DVec3::new(x + 1.0, 0.0, z),
            DVec3::new(x, 0.0, z + 1.0),
            DVec3::new(x + 1.0, 0.0, z + 1.0),
        ]);
        mesh.triangles.extend([[first, first + 2, first + 3], [first, first + 3, first + 1]]);
    };
    (0..4).for_each(|k| {
        quad(f64::from(k), 0.0);
        quad(f64::from(k) + 0.3, 1.0);
    });
    let built = StaticMesh::new(&mesh, Sides::Two).unwrap();
    for triangle in 0..built.triangles().len() {
        let corners = built.corners(triangle);
        for at in 0..3 {
            let middle = 0.5 * (corners[at] + corners[(at + 1) % 3]);
            let is_inner = middle.z > 0.1 && middle.z < 1.9 && middle.x > 1.2 && middle.x < 3.6;
            if is_inner {
                assert_eq!(built.edge_kind(triangle, at), EdgeKind::Flat, "{middle}");
            }
            if middle.z == 0.0 || middle.z == 2.0 {
                assert_eq!(built.edge_kind(triangle, at), EdgeKind::Border, "{middle}");
            }
        }
    }
}

/// The same triangles give the same tree, whatever else was built.
#[test]
fn a_mesh_is_built_the_same_every_time() {
    let rows: Vec<Vec<f64>> =
        (0..40).map(|k| (0..50).map(|i| libm::sin(f64::from(i * k) * 0.1)).collect()).collect();
    let mesh = heightfield_mesh(&rows, [0.5, 0.25]);
    assert_eq!(mesh.triangles.len(), 2 * 39 * 49);
    assert_eq!(StaticMesh::new(&mesh, Sides::Two), StaticMesh::new(&mesh, Sides::Two));
    let built = StaticMesh::new(&mesh, Sides::Two).unwrap();
    assert!((0..built.triangles().len()).all(|t| built.normal(t).y > 0.0));
}

/// Two cubes side by side share an edge of four triangles: their tops go on across it, and the
/// walls between them face each other.
#[test]
fn solids_that_touch_are_one_floor() {
    let mut mesh = cube(0.5);
    let count = mesh.positions.len() as u32;
    let other: Vec<DVec3> = mesh.positions.iter().map(|&at| at + DVec3::X).collect();
    mesh.positions.extend(other);
    let shifted: Vec<[u32; 3]> =
        mesh.triangles.iter().map(|corners| corners.map(|vertex| vertex + count)).collect();
    mesh.triangles.extend(shifted);
    let built = StaticMesh::new(&mesh, Sides::One).unwrap();
    let mut seen = 0;
    for triangle in 0..built.triangles().len() {
        let corners = built.corners(triangle);
        for at in 0..3 {
            let (from, to) = (corners[at], corners[(at + 1) % 3]);
            if from.x != 0.5 || to.x != 0.5 || (from.y - to.y) * (from.z - to.z) != 0.0 {
                continue;
            }
            seen += 1;
            let is_between = built.normal(triangle).x.abs() > 0.5;
            let wanted = if is_between { EdgeKind::Concave } else { EdgeKind::Flat };
            assert_eq!(built.edge_kind(triangle, at), wanted, "{from} {to}");
        }
    }
    assert_eq!(seen, 16);
}
