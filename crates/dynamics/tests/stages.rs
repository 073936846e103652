//! Single stages on two bodies: effects of a blow, and separation by push-out.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on fails"
)]

use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
};
use frangible_collision::{Placed, deepest};
use frangible_dynamics::{Collisions, Displacements, Response, contact_graph, push_out};
use frangible_geometry::{ClosedForm, Shape};
use glam::{DQuat, DVec3};
use std::sync::Arc;

const FRAME_LENGTH: f64 = 1.0 / 30.0;

fn frame(gravity: DVec3) -> Frame {
    Frame { dt: FRAME_LENGTH, gravity, settings: StepSettings::default() }
}

fn body(
    form: ClosedForm,
    motion: Motion,
    position: DVec3,
    linear: DVec3,
    strength: f64,
) -> NewBody {
    NewBody {
        shape: Arc::new(Shape::closed_form(form, 0.1)),
        density: 1000.0,
        motion,
        pose: Pose { position, orientation: DQuat::IDENTITY },
        velocity: Velocity { linear, angular_momentum: DVec3::ZERO },
        surface: SurfaceProperties { strength, ..SurfaceProperties::new(0.5, 0.5) },
    }
}

/// Both bodies feel an impulse of the struck body's strength, in opposite directions.
#[test]
fn a_blow_passes_on_what_the_weaker_body_bears() {
    let ball = ClosedForm::Sphere { radius: 0.5 };
    let cube = ClosedForm::Box { half: DVec3::splat(0.5) };
    let mut bodies = Bodies::default();
    bodies.spawn(body(cube, Motion::Dynamic, DVec3::ZERO, DVec3::ZERO, 100.0));
    bodies.spawn(body(
        ball,
        Motion::Dynamic,
        DVec3::new(1.1, 0.0, 0.0),
        DVec3::new(-15.0, 0.0, 0.0),
        f64::INFINITY,
    ));
    let before = bodies.velocities.clone();
    let frame = frame(DVec3::ZERO);
    let pass = Collisions::new(&bodies, &frame).pass(
        &mut bodies,
        Response::BounceAndBreak,
        |_, _, _, _| None,
        &frame,
    );

    assert_eq!(pass.blows.len(), 1);
    let blow = &pass.blows[0];
    assert_eq!((blow.body, blow.striker), (bodies.ids[0], bodies.ids[1]));
    assert!(blow.borne == 100.0 && blow.impulse > 1000.0);
    let change = |i: usize| bodies.masses[i] * (bodies.velocities[i].linear - before[i].linear);
    assert!((change(0).length() - 100.0).abs() < 1e-9, "{}", change(0));
    assert!((change(0) + change(1)).length() < 1e-9);
    assert!((blow.point_body - DVec3::new(0.5, 0.0, 0.0)).length() < 0.02, "{}", blow.point_body);
}

/// The same blow on an unbreakable body acts in full.
#[test]
fn without_leave_to_break_the_whole_impulse_acts() {
    let ball = ClosedForm::Sphere { radius: 0.5 };
    let mut bodies = Bodies::default();
    bodies.spawn(body(ball, Motion::Dynamic, DVec3::ZERO, DVec3::ZERO, 100.0));
    bodies.spawn(body(
        ball,
        Motion::Dynamic,
        DVec3::new(1.1, 0.0, 0.0),
        DVec3::new(-15.0, 0.0, 0.0),
        f64::INFINITY,
    ));
    let frame = frame(DVec3::ZERO);
    let pass = Collisions::new(&bodies, &frame).pass(
        &mut bodies,
        Response::Bounce,
        |_, _, _, _| None,
        &frame,
    );
    assert!(pass.any && pass.blows.is_empty());
    assert!(bodies.velocities[0].linear.x < -7.0, "{}", bodies.velocities[0].linear);
}

/// Two cubes with an overlap of a centimetre are separated.
#[test]
fn push_out_separates_what_overlaps() {
    let cube = ClosedForm::Box { half: DVec3::splat(0.5) };
    let mut bodies = Bodies::default();
    bodies.spawn(body(cube, Motion::Static, DVec3::ZERO, DVec3::ZERO, f64::INFINITY));
    bodies.spawn(body(
        cube,
        Motion::Dynamic,
        DVec3::new(0.1, 0.99, 0.0),
        DVec3::ZERO,
        f64::INFINITY,
    ));
    let frame = frame(DVec3::new(0.0, -9.8, 0.0));
    let pair = Pair { first: 0, second: 1 };
    let graph = contact_graph(&bodies, &[pair], &frame);
    assert_eq!(graph.levels.len(), 1, "the upper cube rests on the lower");

    let mut poses = bodies.poses.clone();
    push_out(&bodies, &mut poses, &graph, &mut Displacements::default(), &frame);
    let depth = |poses: &[Pose]| {
        let at = |i: usize| Placed { shape: &bodies.shapes[i], pose: &poses[i] };
        deepest(at(0), at(1)).map_or(0.0, |phi| -phi)
    };
    assert!(depth(&bodies.poses) > 0.009);
    assert!(depth(&poses) < 0.001, "{} m are left", depth(&poses));
    assert!(poses[1].position.y < 1.01, "and it is not thrown up");
}
