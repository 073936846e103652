//! Core of a fast-rotating body: the largest inscribed ball around its centre of mass. Vertices
//! rotate away from their detected points; the core does not.

use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seams::Seams;
use crate::narrow_phase::sphere::BallContact;
use frangible_bodies::BallisticPath;
use glam::DVec3;

/// Minimum rotation per frame [rad] for a core contact. Of 100 random worlds eleven had a body
/// below the ground without cores, and six with them.
const TURN: f64 = 0.25;

/// True if a body turns so far in the frame that its core counts.
fn turns(path: &BallisticPath, pair_motion: &PairMotion) -> bool {
    path.spin_speed * pair_motion.ahead > TURN * path.radius
}

/// True if a body turns so far in the frame, or may after an impact.
pub(crate) fn turns_far(path: &BallisticPath, pair_motion: &PairMotion) -> bool {
    turns(path, pair_motion) || pair_motion.faster > 0.0
}

/// Appends the contacts of the cores of bodies that turn far, where they come near a fixed body
/// within the frame. Among bodies that move, contact points of the vertices suffice.
pub(crate) fn core_points(
    pair_motion: &PairMotion,
    convex_shapes: [ConvexShape; 2],
    points: &mut Vec<ManifoldPoint>,
) {
    for (side, body) in convex_shapes.into_iter().enumerate() {
        let other = convex_shapes[1 - side];
        let has_core =
            matches!(body, ConvexShape::Hull(_) | ConvexShape::Revolved(_) | ConvexShape::Other(_));
        let is_convex = matches!(
            other,
            ConvexShape::Hull(_) | ConvexShape::Revolved(_) | ConvexShape::Ground(_)
        );
        // Half-spaces are not looked at again after an impact.
        let path = pair_motion.paths[side];
        let turns = match other {
            ConvexShape::Ground(_) => turns_far(path, pair_motion),
            _ => turns(path, pair_motion),
        };
        let is_fixed = pair_motion.bodies.inertias[pair_motion.pair.both()[1 - side]].is_infinite();
        if !has_core || !is_convex || !is_fixed || !turns {
            continue;
        }
        let radius = -body.distance_and_gradient(DVec3::ZERO).0;
        if radius <= 0.0 {
            continue;
        }
        let core =
            BallContact { pair_motion, ball_is_first: side == 0, radius, other, is_core: true };
        let point = core.point().and_then(|point| {
            let mut shapes = convex_shapes;
            shapes[side] = ConvexShape::Ball(radius);
            let Some(seams) = Seams::new(pair_motion, shapes, [None; 2]) else {
                return Some(point);
            };
            let Some(plane) = seams.plane_over(&[point]) else { return Some(point) };
            let on_plane = BallContact { other: ConvexShape::Ground(plane), ..core }.point();
            on_plane.map(
                |on_plane| if seams.is_over_face(&on_plane, &plane) { on_plane } else { point },
            )
        });
        let point = point
            .filter(|point| point.gap <= pair_motion.near + pair_motion.ahead * point.approach);
        let feature = FeatureId { is_of_first: side == 0, index: u64::MAX };
        points.extend(point.map(|point| ManifoldPoint { feature, ..point }));
    }
}
