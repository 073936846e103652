//! Contacts of a convex polyhedron with a half-space, by its vertices.

use crate::manifold::{FeatureId, MOST_POINTS, ManifoldPoint};
use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::reduction::reduce;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_geometry::{HalfSpace, Hull};

/// Appends the vertices that touch a half-space within the frame. For slow pairs returns the
/// separation bound of all other vertices [m]: the points then include every near vertex.
pub(crate) fn plane_points(
    pair_motion: &PairMotion,
    hull: &Hull,
    hull_is_first: bool,
    half_space: HalfSpace,
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> Option<f64> {
    let [first, second] = pair_motion.paths;
    let (path, flight_ground) = if hull_is_first { (first, second) } else { (second, first) };

    // Plane in the body's frame, at a time of the frame.
    let plane_at = |time: f64| {
        let body_from_world = path.pose(time).world_from_body().inverse();
        let body_from_ground = body_from_world.after(&flight_ground.pose(time).world_from_body());
        let normal = body_from_ground.direction(half_space.normal);
        HalfSpace { normal, offset: half_space.offset + normal.dot(body_from_ground.translation) }
    };
    let PairMotion { near, reach, search, frame, ahead, .. } = *pair_motion;
    let now = plane_at(0.0);
    let is_slow = reach - near <= frame.speculative_margin();
    let beyond = is_slow.then_some(search);
    scratch.points.clear();
    if -now.offset > path.radius + search {
        return beyond;
    }
    let mut then = None;
    let world_from_body = path.start.world_from_body();
    let outward = world_from_body.direction(now.normal);
    let closing = |point: &HullPoint| {
        let at = world_from_body.point(point.on[0]);
        (flight_ground.velocity(at, 0.0) - path.velocity(at, 0.0)).dot(outward)
    };

    // Vertices near the plane at the start or the end of the frame.
    for (number, &vertex) in hull.vertices().iter().enumerate() {
        let gap = now.distance(vertex);
        if gap > search {
            continue;
        }
        let on = [vertex, vertex - gap * now.normal];
        let point = HullPoint {
            on,
            normal: now.normal,
            gap,
            feature: Feature::VertexOfFirst(number as u32),
        };
        let comes_near = is_slow
            || gap <= near
            || gap <= ahead * closing(&point) + near
            || then.get_or_insert_with(|| plane_at(ahead)).distance(vertex) <= near;
        if comes_near {
            scratch.points.push(point);
        }
    }

    let ground_from_body = flight_ground.start.world_from_body().inverse().after(&world_from_body);
    let manifold_point = |point: &HullPoint| {
        let on_ground = ground_from_body.point(point.on[1]);
        let (normal, anchor_first, anchor_second) = if hull_is_first {
            (outward, point.on[0], on_ground)
        } else {
            (-outward, on_ground, point.on[0])
        };
        let FeatureId { index, .. } = point.feature.id(0);
        ManifoldPoint {
            anchor_first,
            anchor_second,
            rounding: [0.0; 2],
            normal,
            feature: FeatureId { is_of_first: hull_is_first, index },
            approach: pair_motion.surface_speed(normal, closing(point), point.gap),
            gap: point.gap,
        }
    };
    // Keep more points than usual: a body on few of its vertices would rock over the others.
    reduce(
        &mut scratch.points,
        &mut scratch.spare,
        MOST_POINTS,
        (now.normal, PREFERENCE * path.radius),
    );
    points.extend(scratch.points.iter().map(manifold_point));
    beyond
}
