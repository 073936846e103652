//! Thickness at points of the surface, against formulas.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a panic is how a test fails")]

use frangible_geometry::{
    ClosedForm, Compound, Grid, GridSolid, Hull, Shape, TriMesh, mesh_samples, solids_and_boundary,
};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use std::f64::consts::TAU;

fn cuboid(low: DVec3, high: DVec3) -> Hull {
    Hull::cuboid(0.5 * (high - low))
        .transformed(&RigidTransform::new(DQuat::IDENTITY, 0.5 * (low + high)))
}

/// A mesh as a scene samples it.
fn sampled(mesh: &TriMesh, voxels: usize) -> Shape {
    let clean = mesh.cleaned("mesh").unwrap();
    let (low, high) = mesh.bounds();
    let spacing = (high - low).max_element() / voxels as f64;
    let count = ((high - low) / spacing).to_array().map(|n| n.ceil() as usize);
    let (level_set, boundary) =
        solids_and_boundary(&clean, Grid::around_box(low, high, count, 2)).unwrap();
    let solid = GridSolid::from_level_set(level_set);
    let samples = mesh_samples(&solid, &boundary, 2.0 * spacing);
    Shape::from_grid_solid(solid.with_boundary(boundary), samples).unwrap()
}

/// A point of the surface of a mesh.
fn random_point(mesh: &TriMesh, random: &mut Pcg64Mcg) -> DVec3 {
    let areas: Vec<f64> = (0..mesh.triangles.len())
        .map(|triangle| {
            let [a, b, c] = mesh.corners(triangle);
            (b - a).cross(c - a).length()
        })
        .collect();
    let mut left = random.random_range(0.0..areas.iter().sum());
    let triangle = areas.iter().position(|area| {
        left -= area;
        left < 0.0
    });
    let [a, b, c] = mesh.corners(triangle.unwrap());
    let (mut u, mut v): (f64, f64) = (random.random_range(0.0..1.0), random.random_range(0.0..1.0));
    if u + v > 1.0 {
        (u, v) = (1.0 - u, 1.0 - v);
    }
    a + u * (b - a) + v * (c - a)
}

/// Thickness at a point of the grid frame.
fn thickness(shape: &Shape, point_grid: DVec3) -> f64 {
    shape.thickness(shape.body_from_grid.point(point_grid))
}

#[track_caller]
fn assert_near(found: f64, expected: f64, within: f64, what: &str) {
    assert!((found / expected - 1.0).abs() < within, "{what}: {found}, not {expected}");
}

/// Plates, columns and blocks have their shortest side everywhere: on faces, edges and corners.
#[test]
fn a_box_is_as_thick_as_its_shortest_side() {
    let mut random = Pcg64Mcg::seed_from_u64(1);
    for size in [
        DVec3::new(1.0, 0.01, 0.8),
        DVec3::new(0.1, 2.0, 0.1),
        DVec3::new(0.3, 0.2, 0.4),
        DVec3::ONE,
    ] {
        let hull = Hull::cuboid(0.5 * size);
        let turn = RigidTransform::new(
            DQuat::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7),
            DVec3::new(3.0, -1.0, 2.0),
        );
        let mesh = hull.surface();
        let parts = [cuboid(-0.5 * size, DVec3::new(0.1, 0.5, 0.5) * size), {
            cuboid(DVec3::new(0.1, -0.5, -0.5) * size, 0.5 * size)
        }];
        let shapes = [
            Shape::closed_form(ClosedForm::Box { half: 0.5 * size }, 0.1),
            Shape::convex(hull.clone(), 0.1).unwrap(),
            Shape::compound(Compound::new(parts.to_vec()), 0.1).unwrap(),
            sampled(&mesh, if size.y < 0.05 { 300 } else { 24 }),
        ];
        let turned = Shape::convex(hull.transformed(&turn), 0.1).unwrap();
        let mut points: Vec<DVec3> = (0..60).map(|_| random_point(&mesh, &mut random)).collect();
        points.extend(hull.vertices());
        points.extend(hull.edges().iter().map(|edge| {
            let [from, to] = edge.vertices.map(|vertex| hull.vertices()[vertex as usize]);
            from.lerp(to, random.random_range(0.0..1.0))
        }));
        for point in points {
            for (kind, shape) in shapes.iter().enumerate() {
                let what = format!("{size} at {point}, {kind}");
                assert_near(thickness(shape, point), size.min_element(), 3e-3, &what);
            }
            let what = format!("{size} at {point}, turned");
            assert_near(thickness(&turned, turn.point(point)), size.min_element(), 3e-3, &what);
        }
    }
}

#[test]
fn round_bodies_are_as_thick_as_their_largest_ball() {
    let mut random = Pcg64Mcg::seed_from_u64(2);
    let mut direction = || {
        let mut one = || random.random_range(-1.0..1.0);
        DVec3::new(one(), one(), one()).normalize()
    };
    let ball = Shape::closed_form(ClosedForm::Sphere { radius: 0.3 }, 0.1);
    let faceted = Hull::ball(0.3);
    let inner = faceted.planes().iter().map(|plane| plane.offset).fold(f64::INFINITY, f64::min);
    let ball_mesh = sampled(&faceted.surface(), 20);
    let cylinder = ClosedForm::Cylinder { radius: 0.2, half_height: 0.5 };
    let disc = ClosedForm::Cylinder { radius: 0.4, half_height: 0.02 };
    let capsule = ClosedForm::Capsule { radius: 0.2, half_height: 0.5 };
    for _ in 0..50 {
        let away = direction();
        assert_eq!(thickness(&ball, 0.3 * away), 0.6);
        assert_near(thickness(&ball_mesh, 0.3 * away), 2.0 * inner, 0.02, "a ball of triangles");
        for (form, expected) in [(cylinder, 0.4), (disc, 0.04), (capsule, 0.4)] {
            let shape = Shape::closed_form(form, 0.1);
            // From far outside, the nearest point.
            let (distance, gradient) = form.distance_and_gradient(2.0 * away);
            let point = 2.0 * away - distance * gradient;
            assert_near(thickness(&shape, point), expected, 1e-3, &format!("{form:?} at {point}"));
        }
    }
}

/// A closed prism of a ring of outlines, `outer` counter-clockwise and `inner` inside of it, each of
/// as many corners; both around the y axis, from 0 to `height`.
fn tube(outer: &[DVec3], inner: &[DVec3], height: f64) -> TriMesh {
    let count = outer.len() as u32;
    let up = height * DVec3::Y;
    let rings: [Vec<DVec3>; 4] = [
        outer.to_vec(),
        outer.iter().map(|at| *at + up).collect(),
        inner.to_vec(),
        inner.iter().map(|at| *at + up).collect(),
    ];
    let mut triangles = Vec::new();
    for at in 0..count {
        let next = (at + 1) % count;
        let mut quad = |[a, b, c, d]: [u32; 4]| triangles.extend([[a, b, c], [a, c, d]]);
        let ring = |ring: u32, at: u32| ring * count + at;
        quad([ring(0, at), ring(1, at), ring(1, next), ring(0, next)]);
        quad([ring(2, next), ring(3, next), ring(3, at), ring(2, at)]);
        quad([ring(1, at), ring(3, at), ring(3, next), ring(1, next)]);
        quad([ring(2, at), ring(0, at), ring(0, next), ring(2, next)]);
    }
    TriMesh { positions: rings.concat(), triangles }
}

#[test]
fn a_pipe_is_as_thick_as_its_wall() {
    let mut random = Pcg64Mcg::seed_from_u64(3);
    for (radius, wall) in [(0.1, 0.01), (0.25, 0.05), (0.06, 0.005)] {
        let ring = |radius: f64| -> Vec<DVec3> {
            let corner = |n: usize| {
                let angle = TAU * n as f64 / 48.0;
                radius * DVec3::new(angle.cos(), 0.0, angle.sin())
            };
            (0..48).map(corner).collect()
        };
        let mesh = tube(&ring(radius), &ring(radius - wall), 0.3);
        assert!(mesh.mass_properties().volume > 0.0);
        let shape = sampled(&mesh, 90);
        for _ in 0..80 {
            let point = random_point(&mesh, &mut random);
            assert_near(thickness(&shape, point), wall, 0.02, &format!("{wall} at {point}"));
        }
    }
}

/// Of parts and of triangles: the wall's thickness, and at its edges and corners at most the ball's
/// that fits there, 1.27 times as much.
#[test]
fn a_hollow_cube_is_as_thick_as_its_walls() {
    let mut random = Pcg64Mcg::seed_from_u64(4);
    for wall in [0.02, 0.05] {
        let half = 0.25;
        let inner = half - wall;
        let mut parts = Vec::new();
        for axis in 0..3 {
            for side in [-1.0, 1.0] {
                // Of each later axis the walls are shorter.
                let mut low = DVec3::splat(-half);
                let mut high = DVec3::splat(half);
                for other in 0..axis {
                    low[other] = -inner;
                    high[other] = inner;
                }
                (low[axis], high[axis]) = if side < 0.0 { (-half, -inner) } else { (inner, half) };
                parts.push(cuboid(low, high));
            }
        }
        let outside = Hull::cuboid(DVec3::splat(half)).surface();
        let mut mesh = outside.clone();
        let cavity = Hull::cuboid(DVec3::splat(inner)).surface();
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(&cavity.positions);
        mesh.triangles
            .extend(cavity.triangles.iter().map(|&[a, b, c]| [a + first, c + first, b + first]));
        let shapes = [Shape::compound(Compound::new(parts), 0.1).unwrap(), sampled(&mesh, 64)];
        for _ in 0..100 {
            let point = random_point(&mesh, &mut random);
            let from_edge = {
                let mut away = point.abs().to_array().map(|at| half - at);
                away.sort_by(f64::total_cmp);
                away[1]
            };
            for shape in &shapes {
                let found = thickness(shape, point);
                assert!(found > 0.997 * wall && found < 1.28 * wall, "{wall} at {point}: {found}");
                if from_edge > 2.0 * wall {
                    assert_near(found, wall, 3e-3, &format!("{wall} at {point}"));
                }
            }
        }
        // The largest ball that touches the very corner's three walls is 1.27 times as thick; the way
        // to it ends early (docs/limits.md).
        let corner = DVec3::splat(half);
        for shape in &shapes {
            let found = thickness(shape, corner);
            assert!(found > 0.6 * wall && found < 1.28 * wall, "{wall} in the corner: {found}");
        }
    }
}

#[test]
fn the_arms_of_an_l_have_their_own_thickness() {
    let mut random = Pcg64Mcg::seed_from_u64(5);
    let (thin, thick) = (0.05, 0.2);
    let foot = cuboid(DVec3::ZERO, DVec3::new(1.0, thick, 0.5));
    let arm = cuboid(DVec3::new(0.0, thick, 0.0), DVec3::new(thin, 1.0, 0.5));
    let compound = Compound::new(vec![foot, arm]);
    let mesh = compound.surface().mesh;
    let shapes = [Shape::compound(compound, 0.1).unwrap(), sampled(&mesh, 60)];
    for _ in 0..200 {
        let point = random_point(&mesh, &mut random);
        let expected = if point.y > thick + thin {
            thin
        } else if point.x > thin + thick {
            thick
        } else {
            continue;
        };
        for shape in &shapes {
            assert_near(thickness(shape, point), expected, 5e-3, &format!("at {point}"));
        }
    }
}

/// Along a wedge the thickness rises with the wedge's, without jumps; it vanishes nowhere, and in
/// the middle of the faces it is that of the ball that touches the point.
#[test]
fn thickness_rises_along_a_wedge_and_is_continuous() {
    for tangent in [0.1, 0.3, 1.0] {
        let end = 2.0 * tangent;
        let corners = [-1.0, 1.0]
            .map(|z| [DVec3::new(0.0, 0.0, z), DVec3::new(2.0, end, z), DVec3::new(2.0, -end, z)]);
        let shape = Shape::convex(Hull::of_points(&corners.concat()).unwrap(), 0.1).unwrap();
        let mut before = 0.0;
        let steps = 400;
        for n in 0..steps {
            let x = 1.2 * n as f64 / steps as f64;
            let found = thickness(&shape, DVec3::new(x, tangent * x, 0.1));
            assert!(found > 0.0 && found > before * (1.0 - 1e-6), "{tangent} at {x}: {found}");
            let jump = found - before;
            assert!(n == 0 || jump < 0.05 * found.max(0.1), "{tangent} at {x}: {before}, {found}");
            before = found;
            if tangent == 0.1 && x > 0.3 {
                // r = (x / cos^2) tan with the half angle's: of the ball that touches there.
                let length = x * (1.0 + tangent * tangent).sqrt();
                assert_near(found, 2.0 * length * tangent, 0.25, &format!("at {x}"));
            }
        }
    }
}
