//! Collision shapes: exact convex shapes, static triangles, or samples.

use crate::narrow_phase::revolved::placed::PlacedRevolved;
use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, Revolved, Shape, StaticMesh};
use frangible_math::RigidTransform;
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
    /// Around the y axis of the body frame.
    Revolved(Revolved),
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
            (Geometry::ClosedForm(form), hull) => match (form.revolved(), hull) {
                (Some(revolved), _) => Self::Revolved(revolved),
                (None, Some(hull)) => Self::Hull(hull),
                (None, None) => Self::Other(shape),
            },
            (Geometry::Mesh(mesh), _) => Self::Mesh(mesh),
            (_, Some(hull)) => Self::Hull(hull),
            _ => Self::Other(shape),
        }
    }

    /// Largest component of a body at a place in a direction [m]; infinite for shapes that are not
    /// convex, or have no end.
    pub(crate) fn reach(&self, here_from_body: &RigidTransform, direction: DVec3) -> f64 {
        match self {
            Self::Ball(radius) => here_from_body.translation.dot(direction) + radius,
            Self::Hull(hull) => hull
                .vertices()
                .iter()
                .map(|&vertex| here_from_body.point(vertex).dot(direction))
                .fold(f64::NEG_INFINITY, f64::max),
            Self::Revolved(revolved) => {
                PlacedRevolved::new(revolved, here_from_body).reach(direction) + revolved.rounding
            }
            Self::Ground(_) | Self::Mesh(_) | Self::Other(_) => f64::INFINITY,
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
            Self::Revolved(revolved) => revolved.distance_and_gradient(point_body),
            Self::Mesh(mesh) => mesh.distance_and_gradient(point_body),
            Self::Other(shape) => shape.distance_and_gradient(point_body),
        }
    }
}

/// True for bodies whose contacts act without a second look: by samples, or with a plane or
/// triangles, whose points meet along fixed normals. Bodies of revolution have points on their axis
/// and at rims, which are right only as long as they do not turn.
pub fn needs_one_look(shapes: [&Shape; 2]) -> bool {
    let by_parts = shapes.map(ConvexShape::of);
    let has_samples = |side: usize| {
        shapes[side].compound.is_none() && matches!(by_parts[side], ConvexShape::Other(_))
    };
    let has_fixed_normals =
        |shape: &ConvexShape| matches!(shape, ConvexShape::Ground(_) | ConvexShape::Mesh(_));
    let is_round = |shape: &ConvexShape| matches!(shape, ConvexShape::Revolved(_));
    has_samples(0)
        || has_samples(1)
        || by_parts.iter().any(has_fixed_normals) && !by_parts.iter().any(is_round)
}
