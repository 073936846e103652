//! Half-spaces: the planes that cut, and the ground.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// The points with `normal . point <= offset`; negative distance inside.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HalfSpace {
    /// Unit normal, outward.
    pub normal: DVec3,
    /// Distance of the plane from the origin along the normal [m].
    pub offset: f64,
}

impl HalfSpace {
    /// Signed distance [m], negative inside.
    #[inline]
    pub fn distance(&self, point: DVec3) -> f64 {
        self.normal.dot(point) - self.offset
    }

    /// The other side of the plane.
    #[inline]
    pub fn flipped(&self) -> Self {
        Self { normal: -self.normal, offset: -self.offset }
    }
}
