use crate::impulse_cache::ImpulseCache;
use crate::manifold::ManifoldPoint;
use crate::narrow_phase::finder::find_manifolds;
use crate::penetration::find_penetrations;
use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
};
use frangible_geometry::{
    ClosedForm, Hull, Shape, Sides, StaticMesh, TriMesh, closed_form_surface, heightfield_mesh,
};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

const DT: f64 = 1.0 / 30.0;

fn frame() -> Frame {
    Frame { dt: DT, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() }
}

/// A mesh and a body above it.
fn bodies(mesh: &TriMesh, sides: Sides, body: Shape, pose: Pose, velocity: DVec3) -> Bodies {
    let mut bodies = Bodies::default();
    let built = StaticMesh::new(mesh, sides).unwrap();
    let still = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    for (shape, motion, pose, linear) in [
        (Shape::static_mesh(built), Motion::Static, still, DVec3::ZERO),
        (body, Motion::Dynamic, pose, velocity),
    ] {
        bodies.spawn(NewBody {
            shape: Arc::new(shape),
            density: 1000.0,
            motion,
            pose,
            velocity: Velocity { linear, ..Velocity::default() },
            surface: SurfaceProperties::new(0.0, 0.5),
        });
    }
    bodies
}

fn at(x: f64, y: f64, z: f64) -> Pose {
    Pose { position: DVec3::new(x, y, z), orientation: DQuat::IDENTITY }
}

fn cube(half: f64) -> Shape {
    Shape::closed_form(ClosedForm::Box { half: DVec3::splat(half) }, 0.1 * half)
}

fn ball(radius: f64) -> Shape {
    Shape::closed_form(ClosedForm::Sphere { radius }, 0.1 * radius)
}

/// A flat square sheet of the given number of cells per side.
fn sheet(cells: usize, spacing: f64) -> TriMesh {
    heightfield_mesh(&vec![vec![0.0; cells + 1]; cells + 1], [spacing; 2])
}

fn points(bodies: &Bodies) -> Vec<ManifoldPoint> {
    let pairs = [Pair { first: 0, second: 1 }];
    let found = find_manifolds(bodies, &pairs, &ImpulseCache::default(), &frame());
    found.iter().flat_map(|manifold| manifold.points.to_vec()).collect()
}

/// A cube that falls on the border of a sheet touches it with two corners and two edges.
#[test]
fn a_cube_across_a_border_has_four_points() {
    for height in [0.011, 0.05, 0.089, 0.127] {
        for speed in [1.0, 4.2, 7.6] {
            let pose = at(0.095, height, 0.0);
            let world = bodies(&sheet(1, 0.2), Sides::Two, cube(0.01), pose, -speed * DVec3::Y);
            let found = points(&world);
            if height - 0.01 > 1.1 * speed * DT {
                continue;
            }
            assert_eq!(found.len(), 4, "{height} {speed}: {found:#?}");
            for point in &found {
                assert!((point.normal + DVec3::Y).length() < 1e-9);
                assert!((point.gap - (height - 0.01)).abs() < 1e-9);
            }
        }
    }
}

/// On a flat sheet of any cells, at rest or sliding, a body has the points that it has on a plane:
/// none of the edges inside of the sheet touches anything.
#[test]
fn edges_inside_of_a_flat_sheet_touch_nothing() {
    for sides in [Sides::One, Sides::Two] {
        for (cells, spacing) in [(2, 4.0), (80, 0.1), (160, 0.05)] {
            for speed in [0.0, 1.0, 10.0] {
                let velocity = speed * DVec3::new(0.8, 0.0, 0.6);
                let pose = at(-0.11, 0.25 - 2e-5, 0.07);
                let mesh = sheet(cells, spacing);
                let found = points(&bodies(&mesh, sides, cube(0.25), pose, velocity));
                assert_eq!(found.len(), 4);
                for point in &found {
                    assert!((point.normal + DVec3::Y).length() < 1e-12);
                    assert!((point.gap + 2e-5).abs() < 1e-12);
                }
                let found = points(&bodies(&mesh, sides, ball(0.25), pose, velocity));
                assert_eq!(found.len(), 1);
                assert!((found[0].normal + DVec3::Y).length() < 1e-12);
                assert!((found[0].gap + 2e-5).abs() < 1e-12);
            }
        }
    }
}

/// Below a sheet everything is as above it, turned over.
#[test]
fn a_sheet_has_two_sides() {
    for body in [cube(0.25), ball(0.25)] {
        let pose = at(0.1, -0.251, 0.0);
        let world = bodies(&sheet(20, 0.2), Sides::Two, body, pose, 3.0 * DVec3::Y);
        let found = points(&world);
        assert!(!found.is_empty());
        for point in &found {
            assert!((point.normal - DVec3::Y).length() < 1e-12);
            assert!((point.gap - 1e-3).abs() < 1e-9, "{}", point.gap);
        }
    }
    // One that is solid below has nothing for what is far below.
    let pose = at(0.1, -1.2, 0.0);
    let world = bodies(&sheet(20, 0.2), Sides::One, ball(0.25), pose, 3.0 * DVec3::Y);
    assert!(points(&world).is_empty());
}

/// A triangular groove along z, of right angles.
fn groove() -> TriMesh {
    let rows = vec![vec![2.0, 0.0, 2.0]; 2];
    heightfield_mesh(&rows, [2.0, 8.0])
}

/// A ball in a groove touches both its walls, and not the edge between them, also where it comes
/// from above and touches one of them first.
#[test]
fn a_ball_in_a_groove_has_two_points() {
    let (radius, speed) = (0.2, 6.0);
    let lowest = radius * 2.0_f64.sqrt();
    for (x, height) in [(0.0, 0.0), (0.0, 0.05), (0.02, 0.1), (-0.05, 0.12)] {
        let pose = at(x, lowest + height, 0.0);
        let world = bodies(&groove(), Sides::Two, ball(radius), pose, -speed * DVec3::Y);
        let found = points(&world);
        assert_eq!(found.len(), 2, "{x} {height}: {found:?}");
        for point in &found {
            assert!((point.normal.y + 0.5_f64.sqrt()).abs() < 1e-9);
            let side = -point.normal.x.signum();
            let gap = (x * side + lowest + height) * 0.5_f64.sqrt() - radius;
            assert!((point.gap - gap).abs() < 1e-9, "{} {gap}", point.gap);
        }
    }
}

/// A cube that stands across a ridge touches it where its lower edges cross it.
#[test]
fn a_ridge_carries_a_cube() {
    let rows = vec![vec![-1.0, 0.0, -1.0]; 9];
    let ridge = heightfield_mesh(&rows, [2.0, 0.3]);
    for sides in [Sides::One, Sides::Two] {
        let pose = at(0.01, 0.25 - 1e-5, 0.02);
        let found = points(&bodies(&ridge, sides, cube(0.25), pose, DVec3::ZERO));
        let least = found.iter().map(|point| point.anchor_first.z).fold(f64::INFINITY, f64::min);
        let most = found.iter().map(|point| point.anchor_first.z).fold(-1.0, f64::max);
        assert!((least + 0.23).abs() < 1e-9 && (most - 0.27).abs() < 1e-9, "{found:?}");
        for point in &found {
            assert!((point.normal + DVec3::Y).length() < 1e-9 && point.anchor_first.x.abs() < 1e-9);
        }
    }
}

/// A cube much larger than a plate lies on its four corners.
#[test]
fn a_plate_carries_what_is_larger() {
    let pose = at(0.01, 0.25 + 1e-4, 0.02);
    let found = points(&bodies(&sheet(3, 0.05), Sides::Two, cube(0.25), pose, DVec3::ZERO));
    let corners = found
        .iter()
        .filter(|point| (point.anchor_first.abs() - DVec3::new(0.075, 0.0, 0.075)).length() < 1e-9);
    assert_eq!(corners.count(), 4, "{found:?}");
    assert!(found.iter().all(|point| (point.normal + DVec3::Y).length() < 1e-9));
    assert!(found.iter().all(|point| (point.gap - 1e-4).abs() < 1e-9));
}

/// A fast body touches a thin sheet on its way, wherever it ends.
#[test]
fn fast_bodies_do_not_pass_thin_sheets() {
    for speed in [30.0, 300.0, 3000.0] {
        for body in [cube(0.01), ball(0.01)] {
            let pose = at(0.003, 0.4, 0.001);
            let world = bodies(&sheet(1, 0.2), Sides::Two, body, pose, -speed * DVec3::Y);
            let found = points(&world);
            assert!(speed * DT < 0.39 || !found.is_empty(), "{speed}");
            assert!(found.iter().all(|point| (point.gap - 0.39).abs() < 1e-9));
            assert!(found.iter().all(|point| (point.approach / speed - 1.0).abs() < 0.02));
        }
    }
}

/// Points of a bouncing ball in a room of 2 m that is one mesh.
fn points_in_a_room(position: DVec3, velocity: DVec3) -> Vec<ManifoldPoint> {
    let mut room = closed_form_surface(&ClosedForm::Box { half: DVec3::ONE });
    room.flip();
    let pose = Pose { position, orientation: DQuat::IDENTITY };
    let mut world = bodies(&room, Sides::One, ball(0.06), pose, velocity);
    world.surfaces.iter_mut().for_each(|surface| surface.restitution = 1.0);
    points(&world)
}

fn walls(points: &[ManifoldPoint]) -> BTreeSet<[i64; 3]> {
    let whole = |part: f64| part.round() as i64;
    points.iter().map(|point| point.normal.to_array().map(whole)).collect()
}

/// A ball that crosses a room several times in a frame has points with all walls that it meets.
/// Those that left it did not know the third.
#[test]
fn what_bounces_to_and_fro_meets_all_walls() {
    let found = points_in_a_room(DVec3::new(0.1, 0.2, 0.3), DVec3::new(-120.0, 3.0, 150.0));
    let sides = [[-1, 0, 0], [1, 0, 0], [0, 0, -1], [0, 0, 1]];
    assert!(sides.iter().all(|side| walls(&found).contains(side)), "{found:#?}");
}

/// A ball that lies deep in the floor and a wall bounces off the floor, and meets the ceiling.
#[test]
fn what_is_deep_in_two_walls_meets_the_third() {
    let found = points_in_a_room(DVec3::new(0.1, -0.98, -0.99), DVec3::new(10.0, -90.0, 0.0));
    let sides = [[0, -1, 0], [0, 1, 0], [0, 0, -1]];
    assert!(sides.iter().all(|side| walls(&found).contains(side)), "{found:#?}");
}

/// Depths of overlaps are those of closed forms.
#[test]
fn overlaps_are_as_deep_as_they_are() {
    let depth = |mesh: &TriMesh, body: Shape, pose: Pose| {
        let world = bodies(mesh, Sides::Two, body, pose, DVec3::ZERO);
        find_penetrations(&world).first().map(|&(_, depth)| depth)
    };
    let close = |found: Option<f64>, expected: f64| {
        assert!(found.is_some_and(|found| (found - expected).abs() < 1e-9), "{found:?} {expected}");
    };
    let floor = sheet(10, 0.3);
    close(depth(&floor, cube(0.25), at(0.1, 0.24, 0.0)), 0.01);
    close(depth(&floor, ball(0.25), at(0.1, 0.24, 0.0)), 0.01);
    close(depth(&floor, cube(0.25), at(0.1, -0.2, 0.0)), 0.05);
    assert_eq!(depth(&floor, cube(0.25), at(0.1, 0.2501, 0.0)), None);
    assert_eq!(depth(&floor, ball(0.25), at(0.1, 0.2501, 0.0)), None);
    close(depth(&groove(), ball(0.2), at(0.0, 0.2, 0.0)), 0.2 - 0.02_f64.sqrt());
}

/// A body that has got behind triangles that are solid there comes out by the nearest way; beside
/// the border of an open mesh nothing is behind it.
#[test]
fn what_is_behind_a_solid_comes_out() {
    for body in [cube(0.25), ball(0.25)] {
        let world = bodies(&sheet(10, 0.5), Sides::One, body, at(0.1, -0.3, 0.1), DVec3::ZERO);
        let found = points(&world);
        assert_eq!(found.len(), 1);
        assert!((found[0].normal + DVec3::Y).length() < 1e-9, "{}", found[0].normal);
        assert!((found[0].gap + 0.55).abs() < 1e-9);
    }
    let world = bodies(&sheet(10, 0.5), Sides::One, ball(0.25), at(2.6, -0.2, 0.1), DVec3::ZERO);
    assert!(points(&world).is_empty());
}

fn vector(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

/// Triangles of all shapes: neighbours, slivers, points.
fn soup() -> impl Strategy<Value = TriMesh> {
    (
        prop::collection::vec(vector(1.0), 3..20),
        prop::collection::vec((0..20_u32, 0..20_u32, 0..20_u32, 0..4), 1..40),
    )
        .prop_map(|(mut positions, triangles)| {
            let count = positions.len() as u32;
            let triangles = triangles
                .into_iter()
                .map(|(a, b, c, kind)| {
                    let [a, b, mut c] = [a % count, b % count, c % count];
                    if kind == 0 {
                        let between = positions[a as usize].lerp(positions[b as usize], 0.3);
                        positions.push(between + DVec3::splat(1e-7));
                        c = positions.len() as u32 - 1;
                    }
                    [a, b, c]
                })
                .collect();
            TriMesh { positions, triangles }
        })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(300))]

    /// Points have finite numbers and unit normals on any mesh, and are few.
    #[test]
    fn points_are_finite_on_any_mesh(
        mesh in soup(), position in vector(1.5), turn in vector(3.0), velocity in vector(40.0),
        spin in vector(20.0), shape in 0..4, is_sheet in any::<bool>(),
    ) {
        let sides = if is_sheet { Sides::Two } else { Sides::One };
        if StaticMesh::new(&mesh, sides).is_none() {
            return Ok(());
        }
        let body = match shape {
            0 => cube(0.2),
            1 => ball(0.2),
            2 => Shape::closed_form(ClosedForm::Cylinder { radius: 0.2, half_height: 0.1 }, 0.05),
            _ => Shape::convex(Hull::ball(0.2), 0.05).unwrap(),
        };
        let orientation = DQuat::from_scaled_axis(turn);
        let mut world = bodies(&mesh, sides, body, Pose { position, orientation }, velocity);
        let shape = world.shapes[1].clone();
        world.velocities[1] = Velocity::spinning(velocity, spin, orientation, &shape, 1000.0);
        let found = points(&world);
        prop_assert!(found.len() <= 16);
        for point in &found {
            prop_assert!(point.gap.is_finite() && point.approach.is_finite());
            prop_assert!(point.anchor_first.is_finite() && point.anchor_second.is_finite());
            prop_assert!((point.normal.length() - 1.0).abs() < 1e-9);
        }
        let ids: BTreeSet<_> = found.iter().map(|point| point.feature).collect();
        prop_assert_eq!(ids.len(), found.len());
        prop_assert!(find_penetrations(&world).iter().all(|(_, depth)| depth.is_finite()));
    }
}
