//! What contact points carry from one substep, and from one frame, to the next.

use crate::pair::Pair;
use crate::{Bodies, BodyId};
use glam::DVec3;
use std::collections::HashMap;

/// A sample of a pair, over the frames: which bodies, whether it is the first one's, and which.
pub type SampleKey = (BodyId, BodyId, bool, u64);

/// The last substep's impulses of each contact point, before and after its drift.
pub type WarmStart = HashMap<SampleKey, [PointImpulse; 2]>;

/// What acts at one contact point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointImpulse {
    /// Along the normal, not negative [N s].
    pub normal: f64,
    /// Across it, world frame [N s].
    pub tangent: DVec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: DVec3,
}

/// What a contact point is known by.
pub fn sample_key(bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> SampleKey {
    (bodies.ids[pair.first], bodies.ids[pair.second], sample.0, sample.1)
}
