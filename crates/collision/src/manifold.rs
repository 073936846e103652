//! Where two bodies touch: a few points.

pub(crate) mod list;

use frangible_bodies::{Bodies, Pair, Pose};
use glam::DVec3;

/// One point of contact: a point on each body's surface, that coincide when the gap is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// In the first body's frame [m].
    pub anchor_first: DVec3,
    /// In the second body's frame [m].
    pub anchor_second: DVec3,
    /// Distances from the anchors to the surfaces along the normal [m]: a ball's anchor is its
    /// centre, so that it need not turn with it.
    pub rounding: [f64; 2],
    /// Unit, world frame, from the second body to the first.
    pub normal: DVec3,
    /// Which sample or feature this is, and whether of the first body, to find it again in the next
    /// frame.
    pub sample: (bool, u64),
    /// Speed at which the surfaces will meet, or at which they close now if they touch already
    /// [m/s]; zero if they separate, and for points that are kept from frame to frame also if it
    /// cannot be a strike.
    pub approach: f64,
    /// Between the surfaces, where the bodies were when it was found or seen again [m].
    pub gap: f64,
}

impl ManifoldPoint {
    /// Where it is on the two surfaces, in the world [m].
    #[inline]
    pub fn on_surfaces(&self, bodies: &Bodies, pair: Pair) -> [DVec3; 2] {
        self.on_surfaces_at([&bodies.poses[pair.first], &bodies.poses[pair.second]])
    }

    /// The same for bodies at these poses.
    #[inline]
    pub(crate) fn on_surfaces_at(&self, poses: [&Pose; 2]) -> [DVec3; 2] {
        let first = poses[0].world_from_body().point(self.anchor_first);
        let second = poses[1].world_from_body().point(self.anchor_second);
        [first - self.rounding[0] * self.normal, second + self.rounding[1] * self.normal]
    }

    /// Where it acts, in the world [m]: between the surfaces, beside the corner that slides along
    /// the other body.
    #[inline]
    pub fn middle(&self, bodies: &Bodies, pair: Pair) -> DVec3 {
        let [on_first, on_second] = self.on_surfaces(bodies, pair);
        let half = 0.5 * (on_first - on_second).dot(self.normal) * self.normal;
        if self.sample.0 { on_first - half } else { on_second + half }
    }
}

/// The points of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manifold<'a> {
    /// Who.
    pub pair: Pair,
    /// At most [`MOST_POINTS`].
    pub points: &'a [ManifoldPoint],
}

/// Points of a pair that are kept: a face on a face needs four, a concave body in a corner some
/// more.
pub(crate) const MOST_POINTS: usize = 8;
