//! Bodies at their poses, and bounds of relative motion.

use frangible_bodies::{Bodies, Pair, Pose};
use frangible_geometry::Shape;
use frangible_math::RigidTransform;
use glam::DVec4;

/// A body for detection: shape and pose.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// Geometry and samples.
    pub shape: &'a Shape,
    /// Pose at the queried time level.
    pub pose: &'a Pose,
}

/// Upper bound of the relative displacement [m] of any point of the smaller body, or within
/// `beyond` [m] of it, since `second_from_first` was `then`.
pub(crate) fn moved_since(
    then: &RigidTransform,
    first: Placed,
    second: Placed,
    beyond: f64,
) -> f64 {
    moved_between(
        then,
        &second_from_first(first, second),
        [first.shape.radius(), second.shape.radius()],
        beyond,
    )
}

/// Upper bound of relative displacement for bodies of these radii [m], between two values of
/// `second_from_first`.
pub(crate) fn moved_between(
    then: &RigidTransform,
    now: &RigidTransform,
    radii: [f64; 2],
    beyond: f64,
) -> f64 {
    let (now, then, reach) = if radii[0] <= radii[1] {
        (*now, *then, radii[0])
    } else {
        (now.inverse(), then.inverse(), radii[1])
    };
    let shift = (now.translation - then.translation).length();
    // Of unit quaternions, |R - R'| <= 2 |q - q'|, up to the sign of q.
    let (q, p) = (DVec4::from(now.rotation), DVec4::from(then.rotation));
    let turn = 2.0 * (q - p).length().min((q + p).length());
    shift + turn * (reach + beyond)
}

/// Upper bound of the displacement of any point of a body of this radius [m] between two poses [m].
pub(crate) fn moved(from: &Pose, to: &Pose, radius: f64) -> f64 {
    // As above, up to the sign of q. Unbounded bodies must not rotate.
    let (q, p) = (DVec4::from(from.orientation), DVec4::from(to.orientation));
    let turn = 2.0 * (q - p).length().min((q + p).length());
    (to.position - from.position).length() + if turn > 0.0 { turn * radius } else { 0.0 }
}

/// Transform from the first body's frame to the second's.
pub(crate) fn second_from_first(first: Placed, second: Placed) -> RigidTransform {
    second.pose.world_from_body().inverse().after(&first.pose.world_from_body())
}

/// Both bodies of a pair at the given poses.
#[inline]
pub fn placed<'a>(bodies: &'a Bodies, pair: Pair, poses: &'a [Pose]) -> (Placed<'a>, Placed<'a>) {
    let at = |i: usize| Placed { shape: &bodies.shapes[i], pose: &poses[i] };
    (at(pair.first), at(pair.second))
}
