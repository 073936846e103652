//! Names of bodies.

use serde::{Deserialize, Serialize};

/// Names a body for as long as it lives; a slot's next tenant has another generation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct BodyId {
    /// Slot.
    pub index: u32,
    /// Number of earlier bodies in this slot.
    pub generation: u32,
}
