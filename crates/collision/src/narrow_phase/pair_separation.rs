//! Exact separation of two shapes at rest.

use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::hull_hull::separation::hull_separation;
use crate::narrow_phase::revolved::contact::{as_partner, round_and_partner};
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::separation::separation as separation_of_round;
use frangible_math::RigidTransform;
use glam::DVec3;

/// Separation along the best axis [m], negative for overlap, and the axis: unit, second body's
/// frame, from the second to the first. `None` for shapes that need samples or meet triangles.
/// `size` [m] is the smaller body's.
pub(crate) fn pair_separation(
    shapes: [ConvexShape; 2],
    second_from_first: &RigidTransform,
    size: f64,
) -> Option<(f64, DVec3)> {
    let first_from_second = second_from_first.inverse();
    match shapes {
        [ConvexShape::Ball(radius), other] => {
            let (distance, normal) = other.distance_and_gradient(second_from_first.translation);
            Some((distance - radius, normal))
        }
        [other, ConvexShape::Ball(radius)] => {
            let (distance, normal) = other.distance_and_gradient(first_from_second.translation);
            Some((distance - radius, -second_from_first.direction(normal)))
        }
        [ConvexShape::Hull(a), ConvexShape::Hull(b)] => {
            Some(hull_separation([a, b], second_from_first, size))
        }
        [ConvexShape::Hull(hull), ConvexShape::Ground(ground)] => {
            let heights =
                hull.vertices().iter().map(|&v| ground.distance(second_from_first.point(v)));
            Some((heights.fold(f64::INFINITY, f64::min), ground.normal))
        }
        [ConvexShape::Ground(ground), ConvexShape::Hull(hull)] => {
            let heights =
                hull.vertices().iter().map(|&v| ground.distance(first_from_second.point(v)));
            let normal = -second_from_first.direction(ground.normal);
            Some((heights.fold(f64::INFINITY, f64::min), normal))
        }
        _ => {
            let (round, partner, round_is_first) = round_and_partner(shapes)?;
            let partner_from_round =
                if round_is_first { second_from_first } else { &first_from_second };
            let round = PlacedRevolved::new(&round, partner_from_round);
            let found = separation_of_round(&round, &as_partner(&partner)?, size, round.middle);
            let normal = if round_is_first {
                found.normal
            } else {
                -second_from_first.direction(found.normal)
            };
            Some((found.gap, normal))
        }
    }
}
