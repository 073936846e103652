//! Exact contacts between balls, polyhedra and planes.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::encounter::Encounter;
use crate::narrow_phase::hull_hull::approach::hull_points;
use crate::narrow_phase::hull_hull::room::Room;
use crate::narrow_phase::hull_plane::plane_points;
use crate::narrow_phase::solid::{MOST_EDGE_PAIRS, Solid};
use crate::narrow_phase::sphere::BallContact;
use glam::DVec3;

/// Appends the points of a pair with a ball, or of two shapes with convex features; `false` for
/// other pairs.
pub(crate) fn exact_points(
    encounter: &Encounter,
    solids: [Solid; 2],
    room: &mut Room,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let ball = |ball_is_first: bool, radius: f64, other: Solid| {
        let surface = &|point: DVec3| other.distance_and_gradient(point);
        BallContact { encounter, ball_is_first, radius, surface }.point()
    };
    match solids {
        [Solid::Ball(radius), other] => points.extend(ball(true, radius, other)),
        [other, Solid::Ball(radius)] => points.extend(ball(false, radius, other)),
        [Solid::Hull(a), Solid::Hull(b)]
            if a.edges().len() * b.edges().len() <= MOST_EDGE_PAIRS =>
        {
            let _ = hull_points(encounter, [a, b], room, points);
        }
        [Solid::Hull(hull), Solid::Ground(ground)] => {
            let _ = plane_points(encounter, hull, true, ground, room, points);
        }
        [Solid::Ground(ground), Solid::Hull(hull)] => {
            let _ = plane_points(encounter, hull, false, ground, room, points);
        }
        _ => return false,
    }
    true
}
