//! Glued pieces of a body, and their loads.

use frangible_fracture::{Glued, PointLoad};
use serde::{Deserialize, Serialize};

/// Duration of an impact [s]: stiff bodies of about a metre touch for a few milliseconds (by
/// Hertz's law a ball of concrete, half a metre in radius and at 5 m/s, for 2 ms). The impact force
/// is impulse over duration.
pub(super) const IMPACT_TIME: f64 = 2e-3;

/// The pieces that a body is glued together of.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Bonds {
    pub(crate) glued: Glued,
    /// Loads that its contacts carried in the last frame or, where that is shorter, on the average
    /// over the time that a blow lasts; in the pieces' frame.
    pub(crate) carried: Vec<PointLoad>,
    /// Sample spacing of its fragments [m].
    pub(crate) sample_spacing: f64,
}

impl Bonds {
    /// Pieces and the bonds that hold, in the frame of the shape that the scene described.
    pub fn glued(&self) -> &Glued {
        &self.glued
    }

    pub(crate) fn is_anchored(&self) -> bool {
        self.glued.is_anchored()
    }
}
