//! Volume, centre of mass and inertia at unit density.

use glam::{DMat3, DQuat, DVec3};

/// Inertial properties at unit density; multiply by a density [kg/m^3] for a body's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MassProperties {
    /// [m^3]
    pub volume: f64,
    /// Centre of mass [m].
    pub center: DVec3,
    /// Inertia tensor about the centre of mass [m^5].
    pub inertia: DMat3,
}

impl MassProperties {
    /// Principal moments [m^5] and the rotation `frame_from_principal`, a proper one: inertia is
    /// `R diag(moments) R^T`.
    pub fn principal_axes(&self) -> (DVec3, DQuat) {
        todo!()
    }
}
