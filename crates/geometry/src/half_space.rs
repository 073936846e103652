//! Half-spaces: the planes that cut, and the ground.

use frangible_math::check::{Check, Checked, finite, require};
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

impl Check for HalfSpace {
    fn check(&self) -> Checked {
        let is_unit = (self.normal.length_squared() - 1.0).abs() < 1e-3;
        require(is_unit, "a plane with a unit normal")?;
        finite(self.offset)
    }
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
