//! A body of revolution in another body's frame.

use frangible_geometry::{Revolved, RevolvedEnd};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec2, DVec3};

/// A body of revolution at a place. Its *core* is the hull of both discs, without the rounding.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PlacedRevolved {
    /// The body's origin [m].
    pub(crate) middle: DVec3,
    /// Unit.
    pub(crate) axis: DVec3,
    /// Unit, across the axis, fixed in the body.
    pub(crate) across: DVec3,
    pub(crate) ends: [RevolvedEnd; 2],
    /// [m]
    pub(crate) rounding: f64,
    /// Side's normal: away from the axis, and along it.
    pub(crate) side: DVec2,
}

/// Directions this near to the axis have no direction across it [rad]: rounding.
const LEAST_ACROSS: f64 = 1e-14;

impl PlacedRevolved {
    pub(crate) fn new(revolved: &Revolved, here_from_body: &RigidTransform) -> Self {
        Self {
            middle: here_from_body.translation,
            axis: here_from_body.direction(DVec3::Y),
            across: here_from_body.direction(DVec3::X),
            ends: revolved.ends,
            rounding: revolved.rounding,
            side: revolved.side_normal(),
        }
    }

    /// Signed distance of a point from the surface [m], and its unit gradient.
    pub(crate) fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let here_from_body = DMat3::from_cols(self.across, self.axis, self.across.cross(self.axis));
        let revolved = Revolved { ends: self.ends, rounding: self.rounding };
        let (distance, gradient) =
            revolved.distance_and_gradient(here_from_body.transpose() * (point - self.middle));
        (distance, here_from_body * gradient)
    }

    /// Middle of a disc [m].
    #[inline]
    pub(crate) fn center(&self, end: usize) -> DVec3 {
        self.middle + self.ends[end].height * self.axis
    }

    /// A direction's parts along the axis and across it: the component along, the vector across and
    /// its length.
    #[inline]
    pub(crate) fn split(&self, direction: DVec3) -> (f64, DVec3, f64) {
        let along = direction.dot(self.axis);
        let rough = direction - along * self.axis;
        // Of a direction near the axis, rounding along the axis is left over.
        let across = rough - rough.dot(self.axis) * self.axis;
        let length = across.length();
        (along, across, if length > LEAST_ACROSS * along.abs() { length } else { 0.0 })
    }

    /// Unit vector across the axis on the side of a direction; a fixed one for the axis itself.
    #[inline]
    pub(crate) fn radial(&self, direction: DVec3) -> DVec3 {
        let (_, across, length) = self.split(direction);
        if length > 0.0 { across / length } else { self.across }
    }

    /// The disc that reaches furthest in a direction.
    #[inline]
    pub(crate) fn furthest_end(&self, direction: DVec3) -> usize {
        let (along, _, across) = self.split(direction);
        let reach = self.ends.map(|end| end.height * along + end.radius * across);
        usize::from(reach[1] > reach[0])
    }

    /// Largest component of the core in a direction [m].
    #[inline]
    pub(crate) fn reach(&self, direction: DVec3) -> f64 {
        let (along, _, across) = self.split(direction);
        let [low, high] = self.ends.map(|end| end.height * along + end.radius * across);
        self.middle.dot(direction) + low.max(high)
    }

    /// A point of the core furthest in a direction [m].
    #[inline]
    pub(crate) fn support(&self, direction: DVec3) -> DVec3 {
        let (along, across, length) = self.split(direction);
        let [low, high] = self.ends.map(|end| end.height * along + end.radius * length);
        let end = if high > low { self.ends[1] } else { self.ends[0] };
        let center = self.middle + end.height * self.axis;
        if length > 0.0 { center + (end.radius / length) * across } else { center }
    }

    /// Point of a rim in a direction across the axis [m].
    #[inline]
    pub(crate) fn rim(&self, end: usize, radial: DVec3) -> DVec3 {
        self.center(end) + self.ends[end].radius * radial
    }

    /// The point of a disc nearest to a point [m].
    pub(crate) fn nearest_on_disc(&self, end: usize, point: DVec3) -> DVec3 {
        let (_, across, length) = self.split(point - self.center(end));
        let part =
            if length > self.ends[end].radius { self.ends[end].radius / length } else { 1.0 };
        self.center(end) + part * across
    }

    /// The side's outward normal at a direction across the axis.
    #[inline]
    pub(crate) fn side_normal(&self, radial: DVec3) -> DVec3 {
        self.side.x * radial + self.side.y * self.axis
    }

    /// Outward normal of a disc.
    #[inline]
    pub(crate) fn end_normal(&self, end: usize) -> DVec3 {
        if end == 0 { -self.axis } else { self.axis }
    }
}
