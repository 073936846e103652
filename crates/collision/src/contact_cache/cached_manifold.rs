//! Cached manifolds and their points.

use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use serde::{Deserialize, Serialize};

#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct CacheChunk {
    pub(crate) pairs: Vec<CachedManifold>,
    /// Points of all pairs, concatenated.
    pub(crate) points: Vec<CachedPoint>,
}

#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct CachedManifold {
    /// Indices of both bodies in the path list of the frame.
    pub(crate) bodies: [u32; 2],
    /// End of its points in the list.
    pub(crate) end: u32,
    /// `second_from_first` at detection.
    pub(crate) found_at: RigidTransform,
    /// Separation bound: all other features were further apart at detection [m]; minus infinity if
    /// the points must not persist.
    pub(crate) separation_bound: f64,
    /// True if all points were apart at detection: once they are not, another axis may separate the
    /// bodies.
    pub(crate) was_apart: bool,
    /// Reference sum of both path lengths [m]: the relative motion since detection is at most the
    /// increase beyond it.
    pub(crate) path_at_capture: f64,
}

/// A cached contact point, in body frames.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
pub(crate) struct CachedPoint {
    /// Points on the first and on the second body, each in its body frame [m].
    pub(crate) anchors: [DVec3; 2],
    /// Unit, from the second body to the first, in the first body's frame.
    pub(crate) normal: DVec3,
    pub(crate) feature: FeatureId,
}

impl CacheChunk {
    /// Checks that its pairs are of `bodies` bodies, and its points theirs.
    pub(crate) fn check(&self, bodies: usize) -> Checked {
        let mut begin = 0;
        for cached in &self.pairs {
            let are_bodies = cached.bodies.iter().all(|&body| (body as usize) < bodies);
            require(are_bodies, "pairs of bodies that there were")?;
            let is_range = cached.end >= begin && cached.end as usize <= self.points.len();
            require(is_range, "points of a pair that there are")?;
            begin = cached.end;
            cached.found_at.check()?;
            let bounds = [cached.separation_bound, cached.path_at_capture];
            require(!bounds.iter().any(|bound| bound.is_nan()), "bounds that are numbers")?;
        }
        self.points.iter().try_for_each(|CachedPoint { anchors, normal, .. }| {
            finite_vector(*normal)?;
            anchors.iter().try_for_each(|&anchor| finite_vector(anchor))
        })
    }
}

impl CachedPoint {
    /// Normal, points on both bodies and separation [m] at the present poses, world frame.
    #[inline]
    fn now(&self, pair_motion: &PairMotion) -> (DVec3, [DVec3; 2], f64) {
        let [first, second] = pair_motion.paths;
        let normal = first.start.orientation * self.normal;
        let on_first = first.start.world_from_body().point(self.anchors[0]);
        let on_second = second.start.world_from_body().point(self.anchors[1]);
        (normal, [on_first, on_second], (on_first - on_second).dot(normal))
    }

    /// True if the surfaces are apart at the present poses.
    pub(crate) fn is_apart(&self, pair_motion: &PairMotion) -> bool {
        self.now(pair_motion).2 > 0.0
    }

    /// The contact point at the present poses; `None` beyond the reach of the frame.
    #[inline]
    pub(crate) fn within_reach(&self, pair_motion: &PairMotion) -> Option<ManifoldPoint> {
        let [first, second] = pair_motion.paths;
        let (normal, [on_first, on_second], gap) = self.now(pair_motion);
        if gap > pair_motion.reach {
            return None;
        }
        let approach = if pair_motion.may_impact() {
            let velocity = first.velocity(on_first, 0.0) - second.velocity(on_second, 0.0);
            pair_motion.surface_speed(normal, -velocity.dot(normal), gap)
        } else {
            0.0
        };
        Some(ManifoldPoint {
            anchor_first: self.anchors[0],
            anchor_second: self.anchors[1],
            rounding: [0.0; 2],
            normal,
            feature: self.feature,
            approach,
            gap,
        })
    }
}
