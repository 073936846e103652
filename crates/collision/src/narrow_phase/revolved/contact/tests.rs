//! Contact points of bodies of revolution in a frame.

use crate::impulse_cache::ImpulseCache;
use crate::manifold::ManifoldPoint;
use crate::narrow_phase::finder::find_manifolds;
use frangible_bodies::{
    Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
};
use frangible_geometry::{ClosedForm, HalfSpace, Shape};
use glam::{DQuat, DVec3};
use std::f64::consts::FRAC_PI_2;
use std::sync::Arc;

const FRAME: f64 = 1.0 / 30.0;
const GROUND: ClosedForm = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
const DRUM: ClosedForm = ClosedForm::Cylinder { radius: 0.3, half_height: 0.2 };

struct Placed {
    form: ClosedForm,
    position: DVec3,
    orientation: DQuat,
    linear: DVec3,
    angular: DVec3,
}

fn still(form: ClosedForm, position: DVec3, orientation: DQuat) -> Placed {
    Placed { form, position, orientation, linear: DVec3::ZERO, angular: DVec3::ZERO }
}

/// Contact points of a static first body and a second one.
fn points(fixed: Placed, moving: Placed) -> Vec<ManifoldPoint> {
    let mut bodies = Bodies::default();
    for (placed, motion) in [(fixed, Motion::Static), (moving, Motion::Dynamic)] {
        let shape = Arc::new(Shape::closed_form(placed.form, 0.1));
        let (linear, angular) = (placed.linear, placed.angular);
        let velocity = if motion == Motion::Dynamic {
            Velocity::spinning(linear, angular, placed.orientation, &shape, 1000.0)
        } else {
            Velocity::default()
        };
        bodies.spawn(NewBody {
            shape,
            density: 1000.0,
            motion,
            pose: Pose { position: placed.position, orientation: placed.orientation },
            velocity,
            surface: SurfaceProperties::new(0.0, 0.5),
        });
    }
    let frame = Frame { dt: FRAME, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
    let pair = Pair { first: 0, second: 1 };
    let mut found = find_manifolds(&bodies, &[pair], &ImpulseCache::default(), &frame);
    found.iter_mut().flat_map(|(_, points)| points.to_vec()).collect()
}

fn ground() -> Placed {
    still(GROUND, DVec3::ZERO, DQuat::IDENTITY)
}

/// Points of what rolls are the same at any spin: on the axis, as far as the surface is.
#[test]
fn spin_changes_no_point_of_what_rolls() {
    let lying = DQuat::from_rotation_x(FRAC_PI_2);
    for form in [DRUM, ClosedForm::Capsule { radius: 0.3, half_height: 0.2 }] {
        let at = |speed: f64, turn: f64| Placed {
            linear: speed * DVec3::X,
            angular: -speed / 0.3 * DVec3::Z,
            ..still(form, 0.3 * DVec3::Y, DQuat::from_rotation_z(turn) * lying)
        };
        for floor in [GROUND, ClosedForm::Box { half: DVec3::new(9.0, 1.0, 9.0) }] {
            let down = if floor == GROUND { 0.0 } else { -1.0 };
            let on = |moving| points(still(floor, down * DVec3::Y, DQuat::IDENTITY), moving);
            let slow = on(at(0.0, 0.0));
            assert_eq!(slow.len(), 2);
            for point in &slow {
                assert!(point.anchor_second.with_y(0.0).length() < 1e-12);
                assert!((point.anchor_second.y.abs() - 0.2).abs() < 1e-12);
                assert!((point.rounding[1] - 0.3).abs() < 1e-12 && point.gap.abs() < 1e-12);
                assert!((point.normal + DVec3::Y).length() < 1e-12);
            }
            for (speed, turn) in [(1.0, 0.3), (30.0, 2.0), (100.0, 4.0)] {
                let fast = on(at(speed, turn));
                assert_eq!(fast.len(), 2, "{form:?} {speed}");
                for (a, b) in slow.iter().zip(&fast) {
                    assert_eq!(a.feature, b.feature);
                    assert!(a.anchor_second.distance(b.anchor_second) < 1e-9);
                    assert!(b.gap.abs() < 1e-9, "{}", b.gap);
                }
            }
        }
    }
}

/// A flat end has four points that stay the same as it tilts; the lowest one is among them.
#[test]
fn a_flat_end_stands_on_four_points() {
    let standing = |tilt: f64| {
        let lowest = 0.2 * tilt.cos() + 0.3 * tilt.sin();
        let orientation = DQuat::from_rotation_z(tilt) * DQuat::from_rotation_y(0.3);
        points(ground(), still(DRUM, lowest * DVec3::Y, orientation))
    };
    let level = standing(0.0);
    assert_eq!(level.len(), 4);
    assert!(level.iter().all(|point| point.gap.abs() < 1e-12));
    let tilted = standing(3e-3);
    assert_eq!(tilted.len(), 4);
    let ids =
        |points: &[ManifoldPoint]| points.iter().map(|point| point.feature).collect::<Vec<_>>();
    assert_eq!(ids(&level), ids(&tilted));
    let lowest = tilted.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
    assert!(lowest.abs() < 1e-12);
    // Further, it stands on its rim alone.
    let rim = standing(0.5);
    assert_eq!(rim.len(), 1);
    assert!(rim[0].gap.abs() < 1e-12);
    assert_eq!(rim[0].feature, tilted[0].feature);
}

/// On a slope one of the four points is the one downhill, about which the body would tip: of four
/// others the body would tip at 0.7 of its angle.
#[test]
fn a_flat_end_stands_on_its_lowest_point_on_a_slope() {
    let slope = DQuat::from_rotation_z(0.4);
    for turn in [0.0, 0.3, 0.8] {
        let floor = still(GROUND, DVec3::ZERO, slope);
        let orientation = slope * DQuat::from_rotation_y(turn);
        let found = points(floor, still(DRUM, slope * (0.2 * DVec3::Y), orientation));
        assert_eq!(found.len(), 4);
        let downhill = slope * (-0.3 * DVec3::X);
        let nearest = found.iter().map(|point| point.anchor_first.distance(-0.3 * DVec3::X));
        let nearest = nearest.fold(f64::INFINITY, f64::min);
        assert!(nearest < 1e-9, "{turn}: {nearest} from {downhill}");
    }
}

/// One end on another: flat, with four points, as large as the smaller one; and beside the middle.
#[test]
fn ends_lie_on_ends() {
    let small = ClosedForm::Cylinder { radius: 0.1, half_height: 0.2 };
    for (form, aside) in [(DRUM, 0.0), (DRUM, 0.2), (small, 0.0), (small, 0.25), (DRUM, 0.45)] {
        let moving = still(form, DVec3::new(aside, 0.4, 0.0), DQuat::from_rotation_y(0.7));
        let found = points(still(DRUM, DVec3::ZERO, DQuat::IDENTITY), moving);
        assert!((3..=4).contains(&found.len()), "{form:?} {aside}: {}", found.len());
        for point in &found {
            assert!(point.gap.abs() < 1e-12);
            assert!((point.normal + DVec3::Y).length() < 1e-9);
            assert!(point.anchor_first.with_y(0.0).length() < 0.3 + 1e-9);
            let radius = if form == DRUM { 0.3 } else { 0.1 };
            assert!(point.anchor_second.with_y(0.0).length() < radius + 1e-9);
        }
    }
}

/// A cone lies on the line from its apex to its base, each point as far from the axis as there.
#[test]
fn a_cone_lies_on_its_line() {
    let (radius, height) = (0.3, 0.6_f64);
    let cone = ClosedForm::Cone { radius, height };
    let half_angle = libm::atan2(radius, height);
    let orientation = DQuat::from_rotation_z(FRAC_PI_2 + half_angle);
    let position = 0.75 * height * half_angle.sin() * DVec3::Y;
    let found = points(ground(), still(cone, position, orientation));
    assert_eq!(found.len(), 2);
    for point in &found {
        assert!(point.gap.abs() < 1e-12, "{}", point.gap);
        assert!(point.anchor_second.with_y(0.0).length() < 1e-12);
        let from_apex = 0.75 * height - point.anchor_second.y;
        assert!((point.rounding[1] - from_apex * half_angle.sin()).abs() < 1e-12);
    }
}

/// A fast fall has the normal and the points of its touch; a pass has none.
#[test]
fn fast_bodies_touch_where_they_get_to() {
    let block = || still(ClosedForm::Box { half: DVec3::ONE }, -DVec3::Y, DQuat::IDENTITY);
    let lying = DQuat::from_rotation_x(FRAC_PI_2);
    let falling = |x: f64, y: f64| Placed {
        linear: DVec3::new(0.0, -60.0, 0.0),
        ..still(DRUM, DVec3::new(x, y, 0.0), lying)
    };
    let found = points(block(), falling(0.0, 1.3));
    assert_eq!(found.len(), 2);
    assert!(found.iter().all(|point| (point.gap - 1.0).abs() < 1e-3));
    assert!(found.iter().all(|point| (point.normal + DVec3::Y).length() < 1e-9));
    assert!(found.iter().all(|point| (point.approach - 60.0).abs() < 0.5));
    assert_eq!(points(block(), falling(1.4, 1.3)).len(), 0);
    assert_eq!(points(block(), falling(0.0, 4.0)).len(), 0);
}

/// Sides across each other touch in one point on both axes.
#[test]
fn sides_across_each_other_touch_in_a_point() {
    let lying = DQuat::from_rotation_x(FRAC_PI_2);
    let across = DQuat::from_rotation_z(FRAC_PI_2);
    let found =
        points(still(DRUM, DVec3::ZERO, lying), still(DRUM, DVec3::new(0.05, 0.6, 0.1), across));
    let touching: Vec<&ManifoldPoint> =
        found.iter().filter(|point| point.gap.abs() < 1e-9).collect();
    assert_eq!(touching.len(), 1);
    assert!((touching[0].normal + DVec3::Y).length() < 1e-9);
    assert_eq!(touching[0].rounding.map(|rounding| (rounding * 1e6).round()), [3e5; 2]);
    assert!(found.iter().all(|point| point.gap > -1e-9));
}

/// All that just overlaps has a point where it does: on the surfaces of both bodies. A side on a
/// rim had it at the far end of the side, and rocked for ever.
#[test]
fn the_deepest_point_is_where_bodies_touch() {
    use crate::narrow_phase::revolved::partner::Partner;
    use crate::narrow_phase::revolved::placed::PlacedRevolved;
    use crate::narrow_phase::revolved::separation::separation;
    use frangible_geometry::Hull;
    use frangible_math::RigidTransform;
    use rand::{RngExt, SeedableRng};
    const DEPTH: f64 = 1e-4;
    /// A normal as good within 5e-4 of the size has its point as far beside the best one's [m].
    const MISSES: f64 = 1.5e-2;
    let mut random = rand_pcg::Pcg64::seed_from_u64(7);
    let mut any = |low: f64, high: f64| random.random_range(low..high);
    for number in 0..600 {
        let mut form = |kind: i32| {
            let (radius, length) = (any(0.05, 0.3), any(0.05, 0.3));
            match kind {
                0 => ClosedForm::Cylinder { radius, half_height: length },
                1 => ClosedForm::Capsule { radius, half_height: length },
                2 => ClosedForm::Cone { radius, height: 2.0 * length },
                _ => ClosedForm::Box { half: DVec3::new(radius, length, any(0.05, 0.3)) },
            }
        };
        let (fixed, moving) = (form(number % 4), form(number / 4 % 3));
        let mut turn = || DQuat::from_xyzw(any(-1.0, 1.0), any(-1.0, 1.0), any(-1.0, 1.0), 0.3);
        let mut pose = RigidTransform::new(turn().normalize(), turn().normalize() * DVec3::X);
        // Moved until they overlap by as much.
        let hull =
            if let ClosedForm::Box { half } = fixed { Some(Hull::cuboid(half)) } else { None };
        for _ in 0..30 {
            let round = PlacedRevolved::new(&moving.revolved().unwrap(), &pose);
            let partner = match (&hull, fixed.revolved()) {
                (Some(hull), _) => Partner::Hull(hull),
                (_, Some(fixed)) => {
                    Partner::Revolved(PlacedRevolved::new(&fixed, &RigidTransform::IDENTITY))
                }
                _ => unreachable!(),
            };
            let found = separation(&round, &partner, 0.3, round.middle);
            pose.translation -= (found.gap + DEPTH) * found.normal;
        }
        let at = || still(moving, pose.translation, pose.rotation);
        let found = points(still(fixed, DVec3::ZERO, DQuat::IDENTITY), at());
        let deepest = found.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).unwrap();
        assert!((deepest.gap + DEPTH).abs() < 6e-4, "{number}: {}", deepest.gap);
        let on = [
            deepest.anchor_first - deepest.rounding[0] * deepest.normal,
            pose.point(deepest.anchor_second) + deepest.rounding[1] * deepest.normal,
        ];
        for point in on {
            let own = [fixed.distance(point), moving.distance(pose.inverse().point(point))];
            assert!(
                own.iter().all(|distance| distance.abs() < MISSES),
                "{number} {fixed:?} {moving:?}: {own:?}"
            );
        }
    }
}
