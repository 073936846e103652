use super::*;
use frangible_bodies::{Motion, NewBody, StepSettings, SurfaceProperties, Velocity};
use frangible_geometry::{ClosedForm, HalfSpace, Shape};
use frangible_math::{Scalar, Width};
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::sync::Arc;

/// Swept bounds of a body.
fn swept_bounds(bodies: &Bodies, i: usize, end: &Pose, margin: f64, frame: &Frame) -> Bounds {
    let mut ends = bodies.poses.clone();
    ends[i] = *end;
    with_widest(frame.settings.width, AllSweptBounds { bodies, ends: &ends, margin, frame })[i]
}

/// Boxes in flat, tall, linear or arbitrary arrangements, with large boxes, coincident boxes, and
/// an outlier.
fn boxes() -> impl Strategy<Value = Vec<(Bounds, bool)>> {
    let one = (
        prop::array::uniform3(-1.0..1.0_f64),
        prop::array::uniform3(0.0..0.2_f64),
        0..40_u32,
        any::<bool>(),
    );
    (
        prop::collection::vec(one, 0..60),
        prop::array::uniform3(prop_oneof![Just(0.0), Just(1.0), Just(30.0)]),
    )
        .prop_map(|(ones, stretch)| {
            let of = |(at, half, kind, moves): ([f64; 3], [f64; 3], u32, bool)| {
                let scale = match kind {
                    0 => 20.0,
                    1 => 0.0,
                    _ => 1.0,
                };
                let away = if kind == 2 { 1e6 } else { 1.0 };
                let at = away * DVec3::from_array(at) * DVec3::from_array(stretch);
                let half = scale * DVec3::from_array(half);
                (Bounds { low: at - half, high: at + half }, moves)
            };
            ones.into_iter().map(of).collect()
        })
}

proptest! {
    /// Every overlapping pair of boxes is found once; other reported pairs are apart by rounding at
    /// most.
    #[test]
    fn strips_find_what_overlaps(boxes in boxes()) {
        let (bounds, moves): (Vec<Bounds>, Vec<bool>) = boxes.into_iter().unzip();
        let found = sorted(&overlapping_bounded(&bounds, &moves, &|_, _| true, false).0, bounds.len());
        prop_assert!(found.is_sorted_by(|a, b| a < b), "in order, none twice");
        for first in 0..bounds.len() {
            for second in first + 1..bounds.len() {
                let is_found = found.binary_search(&Pair { first, second }).is_ok();
                let counts = moves[first] || moves[second];
                let nearly = bounds[first].grown(1e-6 * (1.0 + bounds[first].low.abs().max_element()));
                prop_assert!(!is_found || (counts && nearly.overlaps(&bounds[second])));
                prop_assert!(is_found || !counts || !bounds[first].overlaps(&bounds[second]));
            }
        }
    }
}

proptest! {
    /// Swept bounds of a polyhedron contain all its vertices at any time of the frame, near the
    /// origin or far away, are tight, and are equal for all instruction sets.
    #[test]
    fn bounds_of_polyhedra_are_tight(
        corners in prop::collection::vec(prop::array::uniform3(-1.0..1.0_f64), 8..40),
        away in prop::array::uniform3(-100.0..100.0_f64),
        turn in prop::array::uniform3(-3.0..3.0_f64),
        linear in prop::array::uniform3(-1.0..1.0_f64),
        spin in prop::array::uniform3(-1.0..1.0_f64),
        slow in any::<bool>(),
    ) {
        let corners: Vec<DVec3> = corners.into_iter().map(DVec3::from_array).collect();
        let Ok(hull) = Hull::of_points(&corners) else { return Ok(()) };
        let Ok(shape) = Shape::convex(hull, 0.1) else { return Ok(()) };
        let mut bodies = Bodies::default();
        let frame = frame();
        let spin = if slow { 1e-4 } else { 8.0 } * DVec3::from_array(spin);
        let turn_by = |time: f64| DQuat::from_scaled_axis(time * spin);
        let orientation = DQuat::from_scaled_axis(DVec3::from_array(turn));
        let start = Pose { position: DVec3::from_array(away), orientation };
        let velocity = Velocity::spinning(DVec3::from_array(linear), spin, orientation, &shape, 1.0);
        let corners = shape.hull.as_ref().unwrap().vertices().to_vec();
        let motion = Motion::Dynamic;
        let surface = SurfaceProperties::new(0.0, 0.0);
        bodies.spawn(NewBody { shape: Arc::new(shape), density: 1.0, motion, pose: start, velocity, surface });
        let at = |time: f64| Pose {
            position: start.position + time * velocity.linear,
            orientation: turn_by(time) * start.orientation,
        };
        let end = at(frame.dt);
        let bounds = swept_bounds(&bodies, 0, &end, MARGIN, &frame);
        prop_assert_eq!(bounds, swept_bounds_with::<Scalar>(&bodies, 0, &end, MARGIN, &frame));
        let bounds = bounds.grown(-0.5 * MARGIN);

        let size = bodies.shapes[0].radius();
        let around = |time: f64| {
            let pose = at(time).world_from_body();
            let of = |corner: &DVec3| Bounds { low: pose.point(*corner), high: pose.point(*corner) };
            corners.iter().map(of).reduce(|a, b| a.around(&b)).unwrap()
        };
        for step in 0..=10 {
            let Bounds { low, high } = around(0.1 * f64::from(step) * frame.dt);
            let Bounds { low: lowest, high: highest } = bounds.grown(1e-12);
            prop_assert!(lowest.cmple(low).all() && high.cmple(highest).all(), "{step}");
        }
        let turn = spin.length() * frame.dt;
        if turn <= LARGE_TURN {
            let bulge = 0.125 * turn * turn * size;
            let tight = around(0.0).around(&around(frame.dt)).grown(bulge + 1e-5 * size + HARDLY * MARGIN);
            prop_assert!(tight.low.cmple(bounds.low).all() && bounds.high.cmple(tight.high).all(), "{tight:?} {bounds:?}");
        }
    }
}

/// Bounds contain the collision shape of breakable bodies; half-spaces stay unbounded in any
/// motion.
#[test]
fn bounds_hold_all_kinds_of_bodies() {
    let frame = frame();
    let around = |shape: Shape, motion: Motion, orientation: DQuat| {
        let mut bodies = Bodies::default();
        let (start, velocity) = (Pose { position: DVec3::ZERO, orientation }, Velocity::default());
        let surface = SurfaceProperties::new(0.0, 0.0);
        bodies.spawn(NewBody {
            shape: Arc::new(shape),
            density: 1.0,
            motion,
            pose: start,
            velocity,
            surface,
        });
        // Normalise again, as every step does.
        let end = Pose { orientation: (orientation * 1.5).normalize(), ..start };
        swept_bounds(&bodies, 0, &end, 0.0, &frame)
    };
    let ball = ClosedForm::Sphere { radius: 0.5 };
    let cylinder = ClosedForm::Cylinder { radius: 0.5, half_height: 0.5 };
    for step in 0..20 {
        let orientation =
            DQuat::from_scaled_axis(0.3 * f64::from(step) * DVec3::new(0.3, 0.5, 0.8));
        for form in [ball, cylinder] {
            let bounds = around(Shape::breakable(form, 0.1).unwrap(), Motion::Dynamic, orientation);
            // Half extents to contain: along the axis for a cylinder, along all axes for a ball.
            let half = DVec3::splat(0.5 - 1e-12);
            let held = if form == ball { half } else { 0.5 * (orientation * DVec3::Y).abs() };
            assert!(
                bounds.low.cmple(-held).all() && bounds.high.cmpge(held).all(),
                "{step}: {bounds:?}"
            );
        }
        let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
        let drifts = Motion::Kinematic { linear: DVec3::X, angular: DVec3::ZERO };
        for motion in [Motion::Static, drifts] {
            assert!(around(Shape::closed_form(ground, 0.1), motion, orientation).is_boundless());
        }
    }
}

/// [m]
const MARGIN: f64 = 0.01;

fn frame() -> Frame {
    let settings = StepSettings { width: Width::Avx512, ..StepSettings::default() };
    Frame { dt: 0.1, gravity: -9.81 * DVec3::Y, settings }
}

fn spawn(bodies: &mut Bodies, form: ClosedForm, motion: Motion, position: DVec3) {
    let pose = Pose { position, orientation: DQuat::from_rotation_z(0.1) };
    bodies.spawn(NewBody {
        shape: Arc::new(Shape::closed_form(form, 0.1)),
        density: 1.0,
        motion,
        pose,
        velocity: Velocity::default(),
        surface: SurfaceProperties::new(0.0, 0.0),
    });
}

/// The ground pairs with every body not above it; two grounds, and removed bodies, form no pairs.
#[test]
fn ground_meets_what_is_not_above_it() {
    let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.5 });
    let ball = ClosedForm::Sphere { radius: 1.0 };
    let mut bodies = Bodies::default();
    spawn(&mut bodies, ball, Motion::Dynamic, DVec3::new(1000.0, 0.0, 0.0));
    spawn(&mut bodies, ground, Motion::Static, DVec3::ZERO);
    // On the slope of 0.1 rad the second ball is above the ground, the third is not.
    spawn(&mut bodies, ball, Motion::Dynamic, DVec3::new(-10.0, 1.2, 0.0));
    spawn(&mut bodies, ball, Motion::Dynamic, DVec3::new(10.0, 1.2, 0.0));
    spawn(&mut bodies, ground, Motion::Static, DVec3::new(0.0, -10.0, 0.0));
    spawn(&mut bodies, ball, Motion::Dynamic, DVec3::new(f64::NAN, 0.0, 0.0));
    let of =
        |pairs: Vec<Pair>| pairs.iter().map(|pair| [pair.first, pair.second]).collect::<Vec<_>>();
    assert_eq!(of(find_pairs(&bodies, &bodies.poses, 0.0)), [[0, 1], [0, 4], [1, 3]]);
    // The second ball falls onto it within the frame.
    let mut ends = bodies.poses.clone();
    ends[2].position.y = -0.5;
    assert_eq!(
        of(find_swept_pairs(&bodies, &ends, 0.0, &frame())),
        [[0, 1], [0, 4], [1, 2], [1, 3]]
    );
}

/// Bodies that pass through each other form no pairs, with the ground neither, and take no place
/// of others in a crowd: 600 of them in one place, and a ball that collides with all.
#[test]
fn bodies_that_pass_through_each_other_form_no_pairs() {
    let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.5 });
    let ball = ClosedForm::Sphere { radius: 1.0 };
    let mut bodies = Bodies::default();
    spawn(&mut bodies, ground, Motion::Static, DVec3::ZERO);
    spawn(&mut bodies, ball, Motion::Dynamic, DVec3::ZERO);
    (0..600).for_each(|_| spawn(&mut bodies, ball, Motion::Dynamic, DVec3::ZERO));
    let [floor, ghosts] = ["floor", "ghosts"].map(|name| vec![name.to_string()]);
    let solid = bodies.classes.class_of(&floor, &[]);
    let ghost = bodies.classes.class_of(&ghosts, &[floor, ghosts.clone()].concat());
    bodies.surfaces[0].class = solid;
    bodies.surfaces[2..].iter_mut().for_each(|surface| surface.class = ghost);
    let swept = Swept::new(&bodies, &bodies.poses, 0.0, &frame());
    let of_the_ball = |second: usize| Pair { first: 1, second };
    let expected: Vec<Pair> =
        std::iter::once(Pair { first: 0, second: 1 }).chain((2..602).map(of_the_ball)).collect();
    assert_eq!((swept.pairs, swept.left_out), (expected.clone(), 0));
    assert_eq!(find_pairs(&bodies, &bodies.poses, 0.0), expected);
    // Without the classes they are a crowd.
    bodies.surfaces.iter_mut().for_each(|surface| surface.class = Default::default());
    assert!(Swept::new(&bodies, &bodies.poses, 0.0, &frame()).left_out > 100_000);
}
