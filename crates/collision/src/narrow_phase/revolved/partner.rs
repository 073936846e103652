//! Partners of a body of revolution in a pair.

use crate::narrow_phase::revolved::placed::PlacedRevolved;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;

/// The other shape, in its own body frame: the frame in which a pair is solved.
#[derive(Clone, Copy)]
pub(crate) enum Partner<'a> {
    Hull(&'a Hull),
    Revolved(PlacedRevolved),
    Plane(HalfSpace),
}

impl Partner<'_> {
    /// Distance of the surface from the core [m].
    #[inline]
    pub(crate) fn rounding(&self) -> f64 {
        match self {
            Self::Revolved(placed) => placed.rounding,
            Self::Hull(_) | Self::Plane(_) => 0.0,
        }
    }

    /// A point of the core furthest in a direction [m]; for a plane, its foot.
    #[inline]
    pub(crate) fn support(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Revolved(placed) => placed.support(direction),
            Self::Hull(hull) => hull.vertices()[furthest_vertex(hull, direction)],
            Self::Plane(plane) => plane.offset * plane.normal,
        }
    }

    /// Largest component of the core in a direction [m]; of a plane only along its normal.
    #[inline]
    pub(crate) fn reach(&self, direction: DVec3) -> f64 {
        match self {
            Self::Revolved(placed) => placed.reach(direction),
            Self::Hull(hull) => hull
                .vertices()
                .iter()
                .map(|vertex| vertex.dot(direction))
                .fold(f64::NEG_INFINITY, f64::max),
            Self::Plane(plane) => plane.offset,
        }
    }
}

/// Index of the vertex furthest in a direction.
#[inline]
pub(crate) fn furthest_vertex(hull: &Hull, direction: DVec3) -> usize {
    let mut best = (f64::NEG_INFINITY, 0);
    for (index, vertex) in hull.vertices().iter().enumerate() {
        let reach = vertex.dot(direction);
        if reach > best.0 {
            best = (reach, index);
        }
    }
    best.1
}
