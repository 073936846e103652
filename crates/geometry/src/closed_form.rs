//! Plane, sphere, box and cylinder in closed form: bodies, and the oracles of the tests.

use crate::{HalfSpace, MassProperties};
use glam::DVec3;

/// A shape whose signed distance, gradient and mass properties are formulas. Centred at the origin of its frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClosedForm {
    /// The ground: everything below a plane. Has no volume, so it can only be static.
    HalfSpace(HalfSpace),
    /// `radius` [m].
    Sphere {
        /// [m]
        radius: f64,
    },
    /// Axis-aligned, from `-half` to `half` [m].
    Box {
        /// Half of the edge lengths [m].
        half: DVec3,
    },
    /// Around the y axis.
    Cylinder {
        /// [m]
        radius: f64,
        /// Half of the height [m].
        half_height: f64,
    },
}

impl ClosedForm {
    /// Signed distance [m], negative inside, and its unit gradient.
    pub fn distance_and_gradient(&self, _point: DVec3) -> (f64, DVec3) {
        todo!()
    }

    /// Lowest and highest corner of the bounding box [m]; infinite for a half-space.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        todo!()
    }

    /// Exact volume, centre and inertia at unit density; `None` for a half-space.
    pub fn mass_properties(&self) -> Option<MassProperties> {
        todo!()
    }
}
