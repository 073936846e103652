//! Cached manifolds and their points.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::encounter::Encounter;
use frangible_math::RigidTransform;
use glam::DVec3;

#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    pub(crate) pairs: Vec<KeptPair>,
    /// Points of all pairs, concatenated.
    pub(crate) points: Vec<KeptPoint>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptPair {
    /// Indices of both bodies in the path list of the frame.
    pub(crate) bodies: [u32; 2],
    /// End of its points in the list.
    pub(crate) end: u32,
    /// `second_from_first` at detection.
    pub(crate) found_at: RigidTransform,
    /// Separation bound: all other features were further apart at detection [m]; minus infinity if
    /// the points must not persist.
    pub(crate) beyond: f64,
    /// Reference sum of both path lengths [m]: the relative motion since detection is at most the
    /// increase beyond it.
    pub(crate) since: f64,
}

/// A cached contact point, in body frames.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptPoint {
    /// Points on the first and on the second body, each in its body frame [m].
    pub(crate) anchors: [DVec3; 2],
    /// Unit, from the second body to the first, in the first body's frame.
    pub(crate) normal: DVec3,
    pub(crate) sample: (bool, u64),
}

impl KeptPoint {
    /// The contact point at the present poses; `None` beyond the reach of the frame.
    #[inline]
    pub(crate) fn within_reach(&self, encounter: &Encounter) -> Option<ManifoldPoint> {
        let [first, second] = encounter.flights;
        let normal = first.start.orientation * self.normal;
        let on_first = first.start.world_from_body().point(self.anchors[0]);
        let on_second = second.start.world_from_body().point(self.anchors[1]);
        let gap = (on_first - on_second).dot(normal);
        if gap > encounter.reach {
            return None;
        }
        let approach = if encounter.may_strike() {
            let velocity = first.velocity(on_first, 0.0) - second.velocity(on_second, 0.0);
            encounter.surface_speed(normal, -velocity.dot(normal), gap)
        } else {
            0.0
        };
        Some(ManifoldPoint {
            anchor_first: self.anchors[0],
            anchor_second: self.anchors[1],
            rounding: [0.0; 2],
            normal,
            sample: self.sample,
            approach,
            gap,
        })
    }
}
