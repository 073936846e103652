//! What a body is made of: immutable, shared by all bodies that look alike.

use crate::{ClosedForm, GridSolid, RigidTransform};
use glam::{DVec3, Vec3};

/// Geometry, surface samples and mass properties. The body frame has its origin at the centre of mass and its axes along
/// the principal axes.
#[derive(Clone, Debug)]
pub struct Shape {
    /// Where inside and outside are.
    pub geometry: Geometry,
    /// The grid frame, or the frame of the closed form, in the body frame.
    pub body_from_grid: RigidTransform,
    /// Points on the surface in the body frame [m]: what is tested against other bodies' level sets.
    pub samples: Vec<Vec3>,
    /// Lowest and highest corner in the body frame [m].
    pub bounds: (DVec3, DVec3),
    /// [m^3]; zero for a half-space.
    pub volume: f64,
    /// Principal moments at unit density [m^5].
    pub unit_moments: DVec3,
}

/// Where inside and outside are.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// A formula: exact, but cannot break.
    ClosedForm(ClosedForm),
    /// Samples on a grid: can break.
    Grid(GridSolid),
}
