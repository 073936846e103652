//! Contact manifolds: a few points per pair.

pub(crate) mod list;

use frangible_bodies::{Bodies, Pair, Pose};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A vertex, edge pair or surface sample of a pair of bodies.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct FeatureId {
    /// True for a feature of the first body.
    pub is_of_first: bool,
    /// Index of the feature.
    pub index: u64,
}

/// Low bits of the index of the feature that is a ball, or a body's core.
pub(crate) const BALL_BITS: u64 = (1 << 27) - 1;

impl FeatureId {
    /// True for a ball, or the ball inside a body that turns far.
    pub fn is_ball(&self) -> bool {
        self.index & BALL_BITS == BALL_BITS
    }
}

/// One contact point: a point on each body's surface; both coincide at zero gap.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// In the first body's frame [m].
    pub anchor_first: DVec3,
    /// In the second body's frame [m].
    pub anchor_second: DVec3,
    /// Distances from the anchors to the surfaces along the normal [m]: a ball's anchor is its
    /// centre, independent of rotation.
    pub rounding: [f64; 2],
    /// Unit, world frame, from the second body to the first.
    pub normal: DVec3,
    /// Matches points across frames.
    pub feature: FeatureId,
    /// Closing speed at the time of impact, or the present closing speed of touching surfaces
    /// [m/s]; zero for separating points. Cached points skip speeds too low for an impact.
    pub approach: f64,
    /// Separation of the surfaces at the poses of detection or of the last update [m].
    pub gap: f64,
}

impl ManifoldPoint {
    /// Points on both surfaces, world frame [m].
    #[inline]
    pub fn on_surfaces(&self, bodies: &Bodies, pair: Pair) -> [DVec3; 2] {
        self.on_surfaces_at([&bodies.poses[pair.first], &bodies.poses[pair.second]])
    }

    /// Points on both surfaces, for bodies at these poses.
    #[inline]
    pub(crate) fn on_surfaces_at(&self, poses: [&Pose; 2]) -> [DVec3; 2] {
        let first = poses[0].world_from_body().point(self.anchor_first);
        let second = poses[1].world_from_body().point(self.anchor_second);
        [first - self.rounding[0] * self.normal, second + self.rounding[1] * self.normal]
    }

    /// Point of action, world frame [m]: halfway between the surfaces, next to the sliding vertex
    /// or sample.
    #[inline]
    pub fn middle(&self, bodies: &Bodies, pair: Pair) -> DVec3 {
        let [on_first, on_second] = self.on_surfaces(bodies, pair);
        let half = 0.5 * (on_first - on_second).dot(self.normal) * self.normal;
        if self.feature.is_of_first { on_first - half } else { on_second + half }
    }
}

/// Contact points of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manifold<'a> {
    /// Dense indices of both bodies.
    pub pair: Pair,
    /// At most eight points.
    pub points: &'a [ManifoldPoint],
}

/// Maximum number of points per pair: four for face on face, more for a concave body in a corner.
pub(crate) const MOST_POINTS: usize = 8;
