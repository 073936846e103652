//! The captions of the figures without fracture hold.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, reason = "a test that cannot go on fails")]

use frangible::{StepReport, World, step};
use frangible_shots::{Shot, ShotOptions};
use glam::DVec3;

fn world(name: &str) -> World {
    World::build(&Shot::find(name).unwrap().scene(&ShotOptions::default()).unwrap()).unwrap()
}

fn position(world: &World, body: usize) -> DVec3 {
    world.bodies().poses[body].position
}

/// "Collisions and contact behave correctly using our energy clamping. In this example, we drop several boxes to form a stack.
/// A larger box then disrupts this stack and scatters the objects." [Su09 fig. 2]
#[test]
fn figure_2_boxes_form_a_stack_and_a_larger_box_scatters_it() {
    let mut world = world("stack");
    let gain = |report: &StepReport| report.energy.gain / report.energy.kinetic.max(1.0);
    for _ in 0..85 {
        assert!(gain(&step(&mut world)) < 1e-9);
    }
    for level in 0..5 {
        let expected = DVec3::new(0.0, 0.25 + 0.5 * f64::from(level), 0.0);
        let at = position(&world, 1 + level as usize);
        assert!((at - expected).length() < 0.03, "box {level} rests at {at}");
    }
    for _ in 85..180 {
        assert!(gain(&step(&mut world)) < 1e-9);
    }
    let scattered = (1..6).filter(|&i| position(&world, i).with_y(0.0).length() > 0.5).count();
    assert!(scattered >= 3, "{scattered} boxes are scattered");
    assert!((1..6).all(|i| position(&world, i).y > 0.2), "none sank into the ground");
}

/// "A rigid cube sliding down an inclined plane and eventually stopping with friction, where the half sphere represents the
/// analytic solution." [Su09 fig. 3]
#[test]
fn figure_3_the_cube_stops_where_the_analytic_solution_does() {
    let mut world = world("incline");
    let start = position(&world, 1);
    let slope = 10_f64.to_radians();
    let brake = 9.8 * (0.2 * slope.cos() - slope.sin());
    let mut time = 0.0;
    for _ in 0..180 {
        time = step(&mut world).time;
        let moving = time.min(1.0 / brake);
        let expected = moving - 0.5 * brake * moving * moving;
        let slid = (position(&world, 1) - start).length();
        assert!((slid - expected).abs() < 0.01 * (0.5 / brake), "after {time} s: {slid} m of {expected} m");
    }
    assert!(time > 1.1 / brake, "it has stopped");
}
