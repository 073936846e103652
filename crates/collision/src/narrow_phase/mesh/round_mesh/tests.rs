//! Round bodies on meshes are as on half-spaces where the mesh is flat, and as near to single
//! triangles and ridges as the oracle says.

use crate::impulse_cache::ImpulseCache;
use crate::manifold::ManifoldPoint;
use crate::narrow_phase::finder::find_manifolds;
use crate::oracle::body::Convex;
use crate::oracle::draw::Draw;
use crate::oracle::truth;
use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
};
use frangible_geometry::{
    ClosedForm, HalfSpace, Shape, Sides, StaticMesh, TriMesh, heightfield_mesh,
};
use frangible_math::RigidTransform;
use glam::{DQuat, DVec3};
use std::sync::Arc;

/// Points of a body on something static, both at rest or the body on its way.
fn points(ground: Shape, form: ClosedForm, pose: Pose, linear: DVec3) -> Vec<ManifoldPoint> {
    let still = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
    let mut bodies = Bodies::default();
    for (shape, motion, pose, linear) in [
        (ground, Motion::Static, still, DVec3::ZERO),
        (Shape::closed_form(form, 0.1), Motion::Dynamic, pose, linear),
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
    let frame = Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let pairs = [Pair { first: 0, second: 1 }];
    let found = find_manifolds(&bodies, &pairs, &ImpulseCache::default(), &frame);
    found.iter().flat_map(|manifold| manifold.points.to_vec()).collect()
}

fn mesh(mesh: &TriMesh, sides: Sides) -> Shape {
    Shape::static_mesh(StaticMesh::new(mesh, sides).unwrap())
}

fn deepest(points: &[ManifoldPoint]) -> Option<ManifoldPoint> {
    points.iter().copied().min_by(|a, b| a.gap.total_cmp(&b.gap))
}

/// Any cylinder, capsule or cone of about 20 cm.
fn any_form(draw: &mut Draw) -> ClosedForm {
    let (radius, length) = (draw.any(0.02, 0.2), draw.any(0.02, 0.2));
    match draw.of(3) {
        0 => ClosedForm::Cylinder { radius, half_height: length },
        1 => ClosedForm::Capsule { radius, half_height: length },
        _ => ClosedForm::Cone { radius, height: 2.0 * length },
    }
}

/// Any, lying or standing.
fn any_orientation(draw: &mut Draw) -> DQuat {
    let quarter = std::f64::consts::FRAC_PI_2;
    match draw.of(3) {
        0 => DQuat::from_axis_angle(draw.direction(), draw.any(0.0, 3.0)),
        1 => DQuat::from_rotation_y(draw.any(0.0, 6.0)) * DQuat::from_rotation_x(quarter),
        _ => DQuat::from_rotation_x(quarter * 2.0 * draw.of(2) as f64),
    }
}

/// On a flat sheet a body is as on a half-space, at rest and sliding; no edge inside touches it.
#[test]
fn flat_sheets_are_flat() {
    let mut draw = Draw::new(3);
    for number in 0..150 {
        let (form, orientation) = (any_form(&mut draw), any_orientation(&mut draw));
        let (cells, spacing) = [(2, 4.0), (80, 0.1), (160, 0.05)][number % 3];
        let sides = if number % 2 == 0 { Sides::One } else { Sides::Two };
        let flat = heightfield_mesh(&vec![vec![0.0; cells + 1]; cells + 1], [spacing; 2]);
        let linear = [0.0, 1.0, 10.0][draw.of(3)] * DVec3::new(0.8, 0.0, 0.6);
        let placed = RigidTransform::new(orientation, DVec3::ZERO);
        let low = Convex::of_form(&form, &placed).unwrap();
        let height = low.rounding - low.support(DVec3::NEG_Y).y - 2e-5;
        let pose = Pose { position: DVec3::new(-0.11, height, 0.07), orientation };
        let found = points(mesh(&flat, sides), form, pose, linear);
        let up = HalfSpace { normal: DVec3::Y, offset: 0.0 };
        let ground = Shape::closed_form(ClosedForm::HalfSpace(up), 0.1);
        let expected = deepest(&points(ground, form, pose, linear)).unwrap();
        assert!(!found.is_empty() && found.len() <= 8, "{number} {form:?}: {found:#?}");
        for point in &found {
            assert!((point.normal + DVec3::Y).length() < 1e-12, "{number} {form:?}");
        }
        let gap = deepest(&found).unwrap().gap;
        assert!((gap - expected.gap).abs() < 1e-9, "{number} {form:?}: {gap} {}", expected.gap);
    }
}

/// Near a single triangle, and near two with a common edge, the nearest point is as far as the
/// oracle says; most of what overlaps by 0.01 mm is found as well.
#[test]
fn triangles_are_as_near_as_they_are() {
    let mut draw = Draw::new(5);
    let (mut overlaps, mut missed) = (0, 0);
    for number in 0..160 {
        let mut corner = || 0.5 * draw.any(0.1, 1.0) * draw.direction();
        let corners = [corner(), corner(), corner(), corner()];
        let faces: &[[u32; 3]] =
            if number % 2 == 0 { &[[0, 1, 2]] } else { &[[0, 1, 2], [1, 0, 3]] };
        let triangles = TriMesh { positions: corners.to_vec(), triangles: faces.to_vec() };
        let (form, rotation) = (any_form(&mut draw), any_orientation(&mut draw));
        let parts: Vec<Convex> = faces
            .iter()
            .map(|face| Convex::of_triangle(face.map(|vertex| corners[vertex as usize])))
            .collect();
        // Moved along the normal of the nearer one, until they are this far apart.
        let mut pose = RigidTransform::new(rotation, 2.0 * draw.direction());
        let to = [1e-4, 2e-4, -1e-5][draw.of(3)];
        let nearest = |pose: &RigidTransform| {
            let round = Convex::of_form(&form, pose).unwrap();
            let all = parts.iter().map(|part| truth(&round, part));
            all.min_by(|a, b| a.gap.total_cmp(&b.gap)).unwrap()
        };
        for _ in 0..12 {
            let now = nearest(&pose);
            pose.translation += (to - now.gap) * now.normal;
        }
        let now = nearest(&pose);
        let at = Pose { position: pose.translation, orientation: pose.rotation };
        let found = points(mesh(&triangles, Sides::Two), form, at, DVec3::ZERO);
        let met = deepest(&found);
        let case = format!("{number} {form:?}: {now:?} {met:?}");
        // A normal as good within 5e-4 of the size has its point beside the nearest one.
        let is_near = met.is_some_and(|met| (met.gap - now.gap).abs() < 2e-3);
        if to > 0.0 {
            assert!(is_near, "{case}");
        }
        overlaps += i32::from(to < 0.0);
        missed += i32::from(to < 0.0 && !is_near);
    }
    // Where a rim has gone past a corner, each of its edges alone gives way along the triangle.
    assert!(10 * missed < overlaps, "{missed} of {overlaps}");
}
