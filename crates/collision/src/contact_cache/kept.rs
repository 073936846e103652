//! A pair as it is kept from frame to frame, and its points.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::encounter::Encounter;
use frangible_math::RigidTransform;
use glam::DVec3;

#[derive(Clone, Debug, Default)]
pub(crate) struct Kept {
    pub(crate) pairs: Vec<KeptPair>,
    /// Of all pairs, one after the other.
    pub(crate) points: Vec<KeptPoint>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptPair {
    /// Their places among the ways of the frame.
    pub(crate) bodies: [u32; 2],
    /// Its last point, among those of all pairs.
    pub(crate) end: u32,
    /// `second_from_first` when it was looked at.
    pub(crate) found_at: RigidTransform,
    /// Nothing but its points was nearer then [m]; minus infinity if they do not last.
    pub(crate) beyond: f64,
    /// The two have moved against each other by no more than their ways are longer than this [m].
    pub(crate) since: f64,
}

/// A point of contact, in the frames of its bodies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct KeptPoint {
    /// On the first and on the second body, each in its own frame [m].
    pub(crate) anchors: [DVec3; 2],
    /// Unit, from the second to the first, in the first one's frame.
    pub(crate) normal: DVec3,
    pub(crate) sample: (bool, u64),
}

impl KeptPoint {
    /// The point where its bodies are now; `None` if it is too far to touch within the frame.
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
