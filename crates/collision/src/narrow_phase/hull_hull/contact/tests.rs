use super::*;
use crate::impulse_cache::ImpulseCache;
use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::finder::find_manifolds;
use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::hull_hull::reduction::reduce;
use frangible_bodies::{
    BallisticPath, Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties,
    Velocity,
};
use frangible_geometry::Hull;
use frangible_geometry::{ClosedForm, HalfSpace, Shape};
use frangible_math::RigidTransform;
use frangible_math::Width;
use glam::{DQuat, DVec3};
use proptest::prelude::*;
use std::collections::BTreeSet;
use std::sync::Arc;

fn vector(half: f64) -> impl Strategy<Value = DVec3> {
    prop::array::uniform3(-half..half).prop_map(DVec3::from_array)
}

/// Rocks and boxes with edges up to a metre.
fn hull() -> impl Strategy<Value = Hull> {
    let rock = prop::collection::vec(vector(0.5), 8..16)
        .prop_filter_map("flat", |points| Hull::of_points(&points).ok());
    let cuboid =
        prop::array::uniform3(0.1..0.5_f64).prop_map(|half| Hull::cuboid(DVec3::from_array(half)));
    prop_oneof![rock, cuboid]
}

fn at(position: DVec3, turn: DVec3) -> RigidTransform {
    RigidTransform::new(DQuat::from_scaled_axis(turn), position)
}

/// Contact of two hulls.
struct Met {
    normal: DVec3,
    gap: f64,
    points: Vec<HullPoint>,
}

fn contact(first: &Hull, second: &Hull, first_from_second: &RigidTransform) -> Met {
    let (pair, mut scratch) =
        (HullPair::new([first, second], first_from_second, 1.0, Width::Avx512), Scratch::default());
    let axes = pair.face_axes(10.0, &mut Scratch::default()).unwrap();
    let HullContact { normal, gap } = pair.contact(&axes, 10.0, &mut scratch).unwrap();
    Met { normal, gap, points: scratch.points }
}

fn names(contact: &Met) -> BTreeSet<FeatureId> {
    contact.points.iter().map(|point| point.feature.id(100)).collect()
}

/// Distance by alternating projections onto the two hulls, independent of features [m].
fn distance(first: &Hull, second: &Hull, first_from_second: &RigidTransform) -> f64 {
    let second_from_first = first_from_second.inverse();
    let onto = |hull: &Hull, point: DVec3| {
        let (distance, gradient) = hull.distance_and_gradient(point);
        point - distance.max(0.0) * gradient
    };
    let (mut on_first, mut on_second) = (DVec3::ZERO, DVec3::ZERO);
    for _ in 0..3000 {
        on_second = first_from_second.point(onto(second, second_from_first.point(on_first)));
        on_first = onto(first, on_second);
    }
    on_first.distance(on_second)
}

/// A cube on a cube, 1 cm deep: the corners of the common rectangle, with either cube first.
#[test]
fn a_face_on_a_face_has_the_corners_of_what_they_share() {
    let cube = Hull::cuboid(DVec3::splat(0.5));
    for side in [1.0, -1.0] {
        let above = contact(&cube, &cube, &at(side * DVec3::new(0.3, -0.99, 0.2), DVec3::ZERO));
        assert!((above.normal - side * DVec3::Y).length() < 1e-15);
        assert!((above.gap + 0.01).abs() < 1e-15);
        assert_eq!(above.points.len(), 4);
        let mut seen: Vec<[i64; 2]> = Vec::new();
        for point in &above.points {
            assert!((point.gap + 0.01).abs() < 1e-15);
            assert!(
                (point.on[0].y + side * 0.5).abs() < 1e-15
                    && (point.on[1].y + side * 0.49).abs() < 1e-15
            );
            assert!((point.on[0] - point.on[1]).with_y(0.0).length() < 1e-15);
            seen.push([point.on[0].x, point.on[0].z].map(|x| (side * x * 1000.0).round() as i64));
        }
        seen.sort_unstable();
        assert_eq!(seen, [[-200, -300], [-200, 500], [500, -300], [500, 500]]);
    }
}

/// Two cubes on their edges, crosswise: the edges meet in their middles.
#[test]
fn edges_across_edges_meet_where_they_cross() {
    let cube = Hull::cuboid(DVec3::splat(0.5));
    let quarter = std::f64::consts::FRAC_PI_4;
    let upper = at(DVec3::new(0.1, 2.0_f64.sqrt() - 0.02, 0.05), quarter * DVec3::Z);
    let lower = at(DVec3::ZERO, quarter * DVec3::X);
    let met = contact(&cube, &cube, &upper.inverse().after(&lower));
    let edges: Vec<&HullPoint> =
        met.points.iter().filter(|point| matches!(point.feature, Feature::Edges(..))).collect();
    assert_eq!(edges.len(), 1);
    assert!((met.gap + 0.02).abs() < 1e-14 && (edges[0].gap + 0.02).abs() < 1e-14);
    assert!((upper.direction(met.normal) - DVec3::Y).length() < 1e-14);
    let half = 0.5_f64.sqrt();
    assert!((upper.point(edges[0].on[0]) - DVec3::new(0.1, half - 0.02, 0.0)).length() < 1e-14);
    assert!((upper.point(edges[0].on[1]) - DVec3::new(0.1, half, 0.0)).length() < 1e-14);
}

/// A cube on its corner, 3 cm above a face.
#[test]
fn a_corner_over_a_face_is_as_far_as_it_is() {
    let cube = Hull::cuboid(DVec3::splat(0.5));
    let on_corner = DQuat::from_rotation_arc(DVec3::NEG_ONE.normalize(), DVec3::NEG_Y);
    let height = 0.5 + 0.75_f64.sqrt() + 0.03;
    let upper = RigidTransform::new(on_corner, DVec3::new(0.1, height, -0.2));
    let met = contact(&cube, &cube, &upper.inverse());
    assert!((met.gap - 0.03).abs() < 1e-14);
    assert!((upper.direction(met.normal) - DVec3::Y).length() < 1e-12);
    let nearest = met.points.iter().min_by(|a, b| a.gap.total_cmp(&b.gap)).unwrap();
    assert_eq!(nearest.feature, Feature::VertexOfFirst(0));
    assert!((upper.point(nearest.on[1]) - DVec3::new(0.1, 0.5, -0.2)).length() < 1e-12);
}

/// Corner to corner no face lies over the other cube: the closest points give the contact and the
/// normal.
#[test]
fn corners_that_face_each_other_are_nearest() {
    let cube = Hull::cuboid(DVec3::splat(0.5));
    let met = contact(&cube, &cube, &at(DVec3::splat(1.1), DVec3::ZERO));
    assert!((met.gap - 0.1 * 3.0_f64.sqrt()).abs() < 1e-14);
    assert!((met.normal + DVec3::ONE.normalize()).length() < 1e-14);
    assert_eq!(met.points.len(), 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    /// Face, vertex and depth of eight-lane scans at every width match a scalar double-precision
    /// search, including balls of 42 faces, and hulls far from their frame's origin.
    #[test]
    fn eight_at_a_time_finds_what_one_by_one_does(
        rock in hull(), shift in vector(1.5), turn in vector(3.0), is_ball in any::<bool>(), is_first in any::<bool>(),
        origin in vector(50.0),
    ) {
        const CLOSE: f64 = 1e-5;
        let other = if is_ball { Hull::ball(0.4) } else { Hull::cuboid(DVec3::new(0.3, 0.4, 0.5)) };
        let hulls = if is_first { [other, rock] } else { [rock, other] };
        let away = [at(origin, turn), RigidTransform::new(DQuat::IDENTITY, DVec3::ZERO)];
        let hulls = [hulls[0].transformed(&away[0]), hulls[1].transformed(&away[1])];
        let first_from_second = at(origin + shift, turn);
        let height = |plane: &HalfSpace| {
            let heights = hulls[1].vertices().iter().map(|&vertex| plane.distance(first_from_second.point(vertex)));
            heights.fold(f64::INFINITY, f64::min)
        };
        let furthest = hulls[0].planes().iter().map(height).fold(f64::NEG_INFINITY, f64::max);
        let point = origin + 0.1 * shift;
        let depth = hulls[0].planes().iter().map(|plane| -plane.distance(point)).fold(f64::INFINITY, f64::min);

        let mut found = BTreeSet::new();
        for width in [Width::Scalar, Width::Sse2, Width::Avx2, Width::Avx512] {
            let pair = HullPair::new([&hulls[0], &hulls[1]], &first_from_second, 0.5, width);
            let axis = face_axis(&pair, 0, &mut Scratch::default());
            prop_assert!((axis.separation - furthest).abs() < CLOSE, "{} {furthest}", axis.separation);
            let lowest = first_from_second.point(hulls[1].vertices()[axis.vertex]);
            prop_assert!((hulls[0].planes()[axis.face].distance(lowest) - axis.separation).abs() < 1e-12);

            let first = hulls[0].columns();
            let inside = with_widest(width, Inside { hull: first, point });
            prop_assert!((inside - depth).abs() < CLOSE);

            // Compare edge axes, bit by bit.
            let mut scratch = Scratch::default();
            let axes = [axis, face_axis(&pair, 1, &mut Scratch::default())];
            gather_ridges(&pair, &axes, 0.5, &mut scratch);
            let edges = edge_axis(&pair, f64::NEG_INFINITY, &mut scratch);
            let numbers = [with_widest(width, Inside { hull: first, point }), edges.map_or(0.0, |axis| axis.separation)];
            let ridges = scratch.ridges.each_ref().map(Vec::len);
            let features = axes.map(|axis| [axis.face, axis.vertex]);
            found.insert((features, ridges, numbers.map(f64::to_bits)));
        }
        prop_assert_eq!(found.len(), 1);
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Overlapping hulls have points with unique ids, and separation by the depth along the normal
    /// removes the overlap. The gap of separated hulls is a lower bound of their distance.
    #[test]
    fn the_normal_separates(
        first in hull(), second in hull(), shift in vector(0.8), turn in vector(3.0),
    ) {
        let first_from_second = at(shift, turn);
        let met = contact(&first, &second, &first_from_second);
        prop_assert!((met.normal.length() - 1.0).abs() < 1e-12);
        prop_assert!(!met.points.is_empty());
        prop_assert_eq!(names(&met).len(), met.points.len(), "each has a name of its own");
        for point in &met.points {
            prop_assert!((point.normal.dot(point.on[0] - point.on[1]) - point.gap).abs() < 1e-9);
            // Beyond an acute corner, a point close to both sides is further from the corner.
            let on_second = first_from_second.inverse().point(point.on[1]);
            prop_assert!(first.distance_and_gradient(point.on[0]).0 < 20.0 * PREFERENCE);
            prop_assert!(second.distance_and_gradient(on_second).0 < 20.0 * PREFERENCE);
        }
        // The chosen axis is within the hysteresis of the best.
        let out = (PREFERENCE - met.gap).max(0.0) / (1.0 - DEEP_PREFERENCE) + 1e-9;
        let apart = RigidTransform { translation: shift - out * met.normal, ..first_from_second };
        prop_assert!(distance(&first, &second, &apart) > 0.0 || contact(&first, &second, &apart).gap > -1e-9);
        if met.gap > 0.0 {
            let exact = distance(&first, &second, &first_from_second);
            prop_assert!(exact > met.gap - 1e-9, "{exact} {}", met.gap);
            let nearest = met.points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
            prop_assert!(nearest > exact - 20.0 * PREFERENCE, "{nearest} {exact}");
        } else {
            // Projections converge slowly for shallow overlaps.
            let exact = distance(&first, &second, &first_from_second);
            prop_assert!(exact < 0.01, "{exact} {}", met.gap);
        }
    }

    /// With the best face over the other hull, crossing edges are chosen only for a clearly smaller
    /// overlap.
    #[test]
    fn deep_overlaps_stay_on_faces(first in hull(), second in hull(), shift in vector(0.4), turn in vector(3.0)) {
        let first_from_second = at(shift, turn);
        let pair = HullPair::new([&first, &second], &first_from_second, 1.0, Width::Avx512);
        let (axes, mut scratch) = (pair.face_axes(10.0, &mut Scratch::default()).unwrap(), Scratch::default());
        let is_over = |of_first: bool, scratch: &mut Scratch| {
            pair.face_points(&axes, of_first, scratch);
            !scratch.points.is_empty()
        };
        let met = contact(&first, &second, &first_from_second);
        let of_faces = [
            -first.planes()[axes[0].face].normal,
            first_from_second.direction(second.planes()[axes[1].face].normal),
        ];
        if met.gap < 0.0 && of_faces.iter().all(|normal| normal.dot(met.normal) < 1.0 - 1e-9) {
            let face = axes[0].separation.max(axes[1].separation);
            let prefer_first = axes[1].separation <= axes[0].separation + PREFERENCE;
            let is_over = is_over(prefer_first, &mut scratch);
            prop_assert!(!is_over || met.gap > (1.0 - DEEP_PREFERENCE) * face, "{} {face}", met.gap);
        }
    }

    /// Swapping the bodies reverses the normal and keeps the gap.
    #[test]
    fn who_is_first_does_not_matter(first in hull(), second in hull(), shift in vector(0.8), turn in vector(3.0)) {
        let first_from_second = at(shift, turn);
        let (ab, ba) = (
            contact(&first, &second, &first_from_second),
            contact(&second, &first, &first_from_second.inverse()),
        );
        prop_assert!((ab.gap - ba.gap).abs() < 1e-9);
    }

    /// A box on a box keeps its features under small motions, independent of body order.
    #[test]
    fn features_persist(
        shift in vector(0.3), turn in -1.0..1.0_f64, depth in -0.01..0.01_f64, nudge in vector(1e-5), tilt in vector(1e-5),
    ) {
        let (upper, lower) = (Hull::cuboid(DVec3::new(0.5, 0.2, 0.3)), Hull::cuboid(DVec3::new(0.6, 0.3, 0.4)));
        let start = at(DVec3::new(shift.x, -0.5 + depth, shift.z), turn * DVec3::Y);
        let moved = at(start.translation + nudge, DVec3::ZERO).after(&at(DVec3::ZERO, tilt));
        let moved = RigidTransform { rotation: moved.rotation * start.rotation, translation: moved.translation };
        // Vertices on sides may count as vertices or as crossings: leave such cases out.
        prop_assume!(is_clear_of_sides(&upper, &lower, &start.inverse()));
        prop_assume!(is_clear_of_sides(&lower, &upper, &start));
        let (before, after) = (contact(&upper, &lower, &start), contact(&upper, &lower, &moved));
        prop_assert_eq!(names(&before), names(&after));
        prop_assert!((3..=8).contains(&before.points.len()));
        let swapped = contact(&lower, &upper, &start.inverse());
        let name = |point: &HullPoint| point.feature.swapped().id(100);
        let of_swapped = swapped.points.iter().map(name).collect();
        prop_assert_eq!(names(&before), of_swapped);
        prop_assert!((before.normal + start.direction(swapped.normal)).length() < 1e-12);
    }

    /// A reduced manifold has at most the wanted number of points, including a deepest point, and
    /// all corners of a polygon.
    #[test]
    fn few_points_are_kept(
        points in prop::collection::vec((vector(0.5), -0.01..0.01_f64), 1..12), most in 4..9_usize, corners in 3..9_u32,
    ) {
        let point = |(at, gap): (DVec3, f64)| {
            let on = at.with_y(0.0);
            HullPoint {
                on: [on + gap * DVec3::Y, on], normal: DVec3::Y, gap, feature: Feature::VertexOfFirst(0),
            }
        };
        let points: Vec<HullPoint> = points.into_iter().map(point).collect();
        let mut kept = points.clone();
        reduce(&mut kept, &mut Vec::new(), most, (DVec3::Y, 1e-4));
        prop_assert!((1..=most).contains(&kept.len()));
        let deepest = |points: &[HullPoint]| points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
        prop_assert!(deepest(&kept) <= deepest(&points) + 2e-4);

        let corner = |number: u32| {
            let (sine, cosine) = libm::sincos(std::f64::consts::TAU * f64::from(number) / f64::from(corners));
            point((DVec3::new(sine, 0.0, cosine), 0.0))
        };
        let within = (0..12).map(|_| point((0.1 * points[0].on[1], 0.0)));
        let mut polygon: Vec<HullPoint> = within.chain((0..corners).map(corner)).collect();
        reduce(&mut polygon, &mut Vec::new(), 8, (DVec3::Y, 1e-4));
        prop_assert_eq!(polygon.iter().filter(|point| point.on[1].length() > 0.9).count(), corners as usize);
    }

    /// Of the feet of a table, which rounding puts on sides or just beyond, the four outer corners
    /// stay, in any order and however it leans.
    #[test]
    fn feet_stand_on_their_outer_corners(
        order in Just((0..16).collect::<Vec<u32>>()).prop_shuffle(),
        noise in prop::collection::vec(vector(1e-7), 16), lean in vector(2e-3),
    ) {
        let point = |number: u32| {
            let side = |bit: u32| f64::from(number >> bit & 1) - 0.5;
            let on = DVec3::new(0.8 * side(0) + 0.2 * side(1), 0.0, 0.8 * side(2) + 0.2 * side(3));
            let on = on + noise[number as usize].with_y(0.0);
            let gap = on.dot(lean);
            HullPoint {
                on: [on + gap * DVec3::Y, on],
                normal: DVec3::Y,
                gap,
                feature: Feature::VertexOfFirst(number),
            }
        };
        let mut kept: Vec<HullPoint> = order.into_iter().map(point).collect();
        reduce(&mut kept, &mut Vec::new(), 8, (DVec3::Y, 1e-4));
        let mut kept: Vec<FeatureId> = kept.iter().map(|point| point.feature.id(0)).collect();
        kept.sort_unstable();
        let corner = |index: u64| FeatureId { is_of_first: true, index };
        prop_assert_eq!(kept, [0, 3, 12, 15].map(corner));
    }
}

/// True if no vertex of a box is above a side of the other, within a few millimetres.
fn is_clear_of_sides(hull: &Hull, other: &Hull, other_from_hull: &RigidTransform) -> bool {
    let half = other.bounds().1;
    hull.vertices().iter().all(|&vertex| {
        let beyond = other_from_hull.point(vertex).abs() - half;
        beyond.x.abs() > 0.003 && beyond.z.abs() > 0.003
    })
}

fn spawn(
    bodies: &mut Bodies,
    form: ClosedForm,
    motion: Motion,
    position: DVec3,
    linear: DVec3,
    angular: DVec3,
) {
    let shape = Arc::new(Shape::closed_form(form, 0.1));
    let pose = Pose { position, orientation: DQuat::IDENTITY };
    let velocity = Velocity::spinning(linear, angular, pose.orientation, &shape, 1.0);
    let surface = SurfaceProperties::new(0.5, 0.5);
    bodies.spawn(NewBody { shape, density: 1.0, motion, pose, velocity, surface });
}

fn frame() -> Frame {
    Frame { dt: 1.0 / 30.0, gravity: DVec3::ZERO, settings: StepSettings::default() }
}

/// Separations of a pair's points at the start and after a frame of flight [m].
fn gaps(bodies: &Bodies) -> Vec<[f64; 2]> {
    let (pair, frame) = (Pair { first: 0, second: 1 }, frame());
    let manifolds = find_manifolds(bodies, &[pair], &ImpulseCache::default(), &frame);
    let mut later = bodies.clone();
    for i in 0..2 {
        later.poses[i] = BallisticPath::of(bodies, i, &frame).pose(frame.dt);
    }
    let gap = |bodies: &Bodies, point: &ManifoldPoint| {
        let [on_first, on_second] = point.on_surfaces(bodies, pair);
        (on_first - on_second).dot(point.normal)
    };
    let points = manifolds.iter().flat_map(|manifold| manifold.points);
    points.map(|point| [gap(bodies, point), gap(&later, point)]).collect()
}

/// Two bricks, 2 m apart along x, `aside` [m] apart along y, flying at each other at 90 m/s.
fn flying(aside: f64) -> Bodies {
    let mut bodies = Bodies::default();
    let brick = ClosedForm::Box { half: DVec3::new(0.3, 0.2, 0.2) };
    spawn(&mut bodies, brick, Motion::Dynamic, DVec3::ZERO, 45.0 * DVec3::X, DVec3::ZERO);
    let position = DVec3::new(2.6, 0.4 + aside, 0.1);
    spawn(&mut bodies, brick, Motion::Dynamic, position, -45.0 * DVec3::X, DVec3::ZERO);
    bodies
}

#[test]
fn a_fast_brick_that_passes_another_does_not_feel_it() {
    for aside in [0.002, 0.01, 0.05, 0.3] {
        for [start, end] in gaps(&flying(aside)) {
            assert!(start >= 0.0 && end >= 0.0, "{aside} m aside: {start} m, {end} m");
        }
    }
}

/// Approaching cubes have points if they end the frame within the speculative margin, and none
/// otherwise.
#[test]
fn cubes_that_come_near_have_points() {
    let frame = frame();
    for (sags, expected) in [(0.5, 4), (2.0, 0), (20.0, 0)] {
        let mut bodies = Bodies::default();
        let cube = ClosedForm::Box { half: DVec3::splat(0.2) };
        let closing = (0.1 - sags * frame.speculative_margin()) / frame.dt * DVec3::X;
        spawn(&mut bodies, cube, Motion::Dynamic, DVec3::ZERO, closing, DVec3::ZERO);
        spawn(&mut bodies, cube, Motion::Static, 0.5 * DVec3::X, DVec3::ZERO, DVec3::ZERO);
        assert_eq!(gaps(&bodies).len(), expected, "{sags} times what gravity closes");
    }
}

#[test]
fn a_fast_brick_that_hits_another_does_feel_it() {
    for aside in [-0.002, -0.01, -0.1, -0.4] {
        let gaps = gaps(&flying(aside));
        assert!(gaps.len() >= 3);
        for [start, end] in gaps {
            assert!((start - 2.0).abs() < 1e-3, "{aside} m aside: {start} m apart");
            assert!((end + 1.0).abs() < 1e-3, "{aside} m aside: would be {end} m deep");
        }
    }
}

/// A rod rotating into a post within the frame stops at the touched point, not at its nearest point
/// at the start.
#[test]
fn a_rod_that_turns_meets_a_post() {
    let mut bodies = Bodies::default();
    let rod = ClosedForm::Box { half: DVec3::new(1.0, 0.05, 0.05) };
    spawn(&mut bodies, rod, Motion::Dynamic, DVec3::ZERO, DVec3::ZERO, 20.0 * DVec3::Y);
    let post = ClosedForm::Box { half: DVec3::new(0.05, 1.0, 0.05) };
    spawn(&mut bodies, post, Motion::Static, DVec3::new(0.8, 0.0, -0.4), DVec3::ZERO, DVec3::ZERO);
    let gaps = gaps(&bodies);
    assert!(!gaps.is_empty());
    assert!(gaps.iter().all(|&[start, _]| start > 0.0));
    assert!(gaps.iter().any(|&[_, end]| end < -0.05), "{gaps:?}");
}

/// A cube flat on the ground has its four lower vertices as contacts, also in a fast fall; a cube
/// on its edge has two.
#[test]
fn a_cube_meets_the_ground_with_its_lowest_corners() {
    let cube = ClosedForm::Box { half: DVec3::splat(0.5) };
    let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
    for (height, fall, turn, expected) in [
        (0.5, 0.0, 0.0, 4),
        (0.8, 30.0, 0.0, 4),
        (0.5_f64.sqrt(), 0.0, std::f64::consts::FRAC_PI_4, 2),
    ] {
        let mut bodies = Bodies::default();
        spawn(&mut bodies, ground, Motion::Static, DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        spawn(&mut bodies, cube, Motion::Dynamic, height * DVec3::Y, -fall * DVec3::Y, DVec3::ZERO);
        bodies.poses[1].orientation = DQuat::from_rotation_z(turn);
        let lowest = if turn == 0.0 { height - 0.5 } else { 0.0 };
        let gaps = gaps(&bodies);
        assert_eq!(gaps.len(), expected, "{gaps:?}");
        assert!(gaps.iter().all(|&[start, _]| (start - lowest).abs() < 1e-12), "{gaps:?}");
    }
}
