//! Where a convex polyhedron touches a half-space within a frame: its vertices say.

use crate::detection::radius;
use crate::flight::Flight;
use crate::hull_contact::{Feature, HullPoint, PREFERENCE, reduce};
use crate::manifold::{ManifoldPoint, into_body, reach, sag, surface_speed};
use crate::pair::Pair;
use crate::{Bodies, Frame};
use frangible_geometry::{HalfSpace, Hull};

/// The vertices that touch a half-space, or may within the frame: at most four.
pub(crate) fn plane_points(
    bodies: &Bodies,
    pair: Pair,
    hull: &Hull,
    hull_is_first: bool,
    half_space: HalfSpace,
    frame: &Frame,
) -> Vec<ManifoldPoint> {
    let (body, ground) = if hull_is_first { (pair.first, pair.second) } else { (pair.second, pair.first) };
    let (flight, flight_ground) = (Flight::of(bodies, body, frame), Flight::of(bodies, ground, frame));

    // The plane in the body's frame, now and at the frame's end.
    let plane_at = |time: f64| {
        let body_from_world = flight.pose(time).world_from_body().inverse();
        let body_from_ground = body_from_world.after(&flight_ground.pose(time).world_from_body());
        let normal = body_from_ground.direction(half_space.normal);
        HalfSpace { normal, offset: half_space.offset + normal.dot(body_from_ground.translation) }
    };
    let (now, then) = (plane_at(0.0), plane_at(frame.dt));
    let (reach, sag) = (reach(bodies, pair, frame), sag(frame));
    let world_from_body = bodies.poses[body].world_from_body();
    let outward = world_from_body.direction(now.normal);
    let closing = |point: &HullPoint| {
        let at = world_from_body.point(point.on[0]);
        (flight_ground.velocity(at, 0.0) - flight.velocity(at, 0.0)).dot(outward)
    };

    // What comes near now or later.
    let mut points = Vec::new();
    for (number, &vertex) in hull.vertices().iter().enumerate() {
        let gap = now.distance(vertex);
        if gap > reach {
            continue;
        }
        let on = [vertex, vertex - gap * now.normal];
        let point = HullPoint { on, normal: now.normal, gap, feature: Feature::VertexOfFirst(number as u32) };
        if gap.min(then.distance(vertex)) <= sag || gap <= frame.dt * closing(&point) + sag {
            points.push(point);
        }
    }

    let manifold_point = |point: &HullPoint| {
        let [on_body, on_ground] = point.on.map(|at| world_from_body.point(at));
        let (normal, on_first, on_second) =
            if hull_is_first { (outward, on_body, on_ground) } else { (-outward, on_ground, on_body) };
        let (_, vertex) = point.feature.sample(0);
        ManifoldPoint {
            anchor_first: into_body(bodies, pair.first, on_first),
            anchor_second: into_body(bodies, pair.second, on_second),
            rounding: [0.0; 2],
            normal,
            sample: (hull_is_first, vertex),
            approach: surface_speed(bodies, pair, normal, closing(point), point.gap, frame),
        }
    };
    let close = PREFERENCE * radius(&bodies.shapes[body]);
    reduce(points, now.normal, close).iter().map(manifold_point).collect()
}
