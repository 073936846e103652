//! Axis-aligned bounds of bodies, and static half-spaces.

use crate::narrow_phase::hull_hull::feature_scan::extents;
use frangible_bodies::{Bodies, Motion, Pose};
use frangible_geometry::{ClosedForm, Geometry, Shape};
use frangible_math::{Instructions, RigidTransform};
use glam::DVec3;

/// An axis-aligned box [m], by default in the world frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub low: DVec3,
    /// Highest corner.
    pub high: DVec3,
}

impl Bounds {
    /// Bounds of a shape at a pose; infinite for a half-space.
    pub fn of(shape: &Shape, pose: &Pose) -> Self {
        let (low, high) = shape.bounds;
        if !low.is_finite() || !high.is_finite() {
            return Self { low: DVec3::NEG_INFINITY, high: DVec3::INFINITY };
        }
        Self { low, high }.seen_from(&pose.world_from_body())
    }

    /// Bounds of this box in another frame.
    pub(crate) fn seen_from(&self, to_from_other: &RigidTransform) -> Self {
        let Self { low, high } = *self;
        let center = to_from_other.point(0.5 * (low + high));
        let matrix = to_from_other.matrix();
        let half = 0.5 * (high - low);
        let reach = half.x * matrix.x_axis.abs()
            + half.y * matrix.y_axis.abs()
            + half.z * matrix.z_axis.abs();
        Self { low: center - reach, high: center + reach }
    }

    /// Bounds of a shape at a pose; for a polyhedron, of its vertices. Balls and cylinders use
    /// their own bounds, which are wider than their polyhedra.
    pub(crate) fn of_vertices<I: Instructions>(shape: &Shape, pose: &Pose) -> Self {
        let is_round = matches!(&shape.geometry, Geometry::ClosedForm(form) if !matches!(form, ClosedForm::Box { .. }));
        let Some(hull) = shape.hull.as_ref().filter(|_| !is_round) else {
            return Self::of(shape, pose);
        };
        let body_from_world = pose.orientation.conjugate();
        let along = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| body_from_world * axis);
        let (low, high) = extents::<I>(hull.columns(), along);
        Self { low: pose.position + low, high: pose.position + high }
    }

    /// Bounds of a shape at a position, for any rotation.
    pub(crate) fn of_any_turn(shape: &Shape, pose: &Pose) -> Self {
        let reach = DVec3::splat(shape.radius());
        Self { low: pose.position - reach, high: pose.position + reach }
    }

    /// Union of two boxes.
    #[inline]
    pub fn around(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// The box grown by `margin` [m] on every side.
    #[inline]
    pub fn grown(&self, margin: f64) -> Self {
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// True if any side is infinite.
    #[inline]
    pub fn is_boundless(&self) -> bool {
        !(self.is_nan() || self.low.is_finite() && self.high.is_finite())
    }

    pub(crate) fn is_nan(&self) -> bool {
        self.low.is_nan() || self.high.is_nan()
    }

    /// True if both boxes share a point.
    #[inline]
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// A static half-space.
pub struct Ground {
    /// Per list of poses: normal, position [m], and offset along the normal [m].
    planes: Vec<(DVec3, DVec3, f64)>,
}

impl Ground {
    /// Half-space of a static body, if it has this shape.
    pub fn of(bodies: &Bodies, i: usize, poses: &[&[Pose]]) -> Option<Self> {
        let Geometry::ClosedForm(ClosedForm::HalfSpace(half_space)) = &bodies.shapes[i].geometry
        else {
            return None;
        };
        let plane = |poses: &&[Pose]| {
            let pose = &poses[i];
            (pose.orientation * half_space.normal, pose.position, half_space.offset)
        };
        let does_not_move = bodies.motions[i] == Motion::Static;
        does_not_move.then(|| Self { planes: poses.iter().map(plane).collect() })
    }

    /// True for a box above the half-space.
    #[inline]
    pub fn is_below(&self, bounds: &Bounds) -> bool {
        self.planes.iter().all(|&(normal, position, offset)| {
            let lowest = DVec3::select(normal.cmpgt(DVec3::ZERO), bounds.low, bounds.high);
            normal.dot(lowest - position) > offset
        })
    }
}
