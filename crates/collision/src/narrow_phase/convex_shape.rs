//! Collision shapes: exact convex shapes, static triangles, or samples.

use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, Shape, StaticMesh};
use glam::DVec3;

/// Collision shape of a body, or of a part.
#[derive(Clone, Copy)]
pub(crate) enum ConvexShape<'a> {
    /// Radius [m].
    Ball(f64),
    /// In the body frame.
    Hull(&'a Hull),
    /// In the body frame.
    Ground(HalfSpace),
    /// Triangles of what does not move by itself, in the body frame.
    Mesh(&'a StaticMesh),
    /// Any other shape.
    Other(&'a Shape),
}

impl<'a> ConvexShape<'a> {
    #[inline]
    pub(crate) fn of(shape: &'a Shape) -> Self {
        match (&shape.geometry, &shape.hull) {
            (Geometry::ClosedForm(ClosedForm::Sphere { radius }), _) => Self::Ball(*radius),
            (Geometry::ClosedForm(ClosedForm::HalfSpace(half_space)), _) => {
                Self::Ground(*half_space)
            }
            (Geometry::Mesh(mesh), _) => Self::Mesh(mesh),
            (_, Some(hull)) => Self::Hull(hull),
            _ => Self::Other(shape),
        }
    }

    /// Signed distance [m] and its unit gradient at a point in the body frame [m].
    pub(crate) fn distance_and_gradient(&self, point_body: DVec3) -> (f64, DVec3) {
        match self {
            Self::Ball(radius) => {
                (point_body.length() - radius, point_body.try_normalize().unwrap_or(DVec3::Y))
            }
            Self::Hull(hull) => hull.distance_and_gradient(point_body),
            Self::Ground(half_space) => (half_space.distance(point_body), half_space.normal),
            Self::Mesh(mesh) => mesh.distance_and_gradient(point_body),
            Self::Other(shape) => shape.distance_and_gradient(point_body),
        }
    }
}

/// Maximum number of edge pairs of two hulls; beyond, samples are faster than separating axes.
pub(crate) const MOST_EDGE_PAIRS: usize = 1 << 16;
