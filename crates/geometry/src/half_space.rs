//! Half-spaces: the planes that cut, and the ground.

use crate::RigidTransform;
use glam::DVec3;

/// The points with `normal . point <= offset`; negative distance inside.
#[derive(Clone, Copy, Debug, PartialEq)]
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

    /// The same half-space in another frame.
    pub fn transformed(&self, to_from_here: &RigidTransform) -> Self {
        let normal = to_from_here.direction(self.normal);
        Self { normal, offset: self.offset + normal.dot(to_from_here.translation) }
    }
}
