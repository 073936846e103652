//! Strength that varies over a body.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Strength of a body at a point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StrengthPointDesc {
    /// In the shape's own frame [m].
    pub point: [f64; 3],
    /// Times the strength of the body, from 1e-6 to 1e6.
    pub factor: f64,
}
