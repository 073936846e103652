//! When a body begins to move.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// When a body begins to move: at a frame, or when it is struck; one of the two. Until then it
/// holds still and is to others a body of infinite mass that does not break.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct StartsDesc {
    /// At this frame it is still where it was, and moves from there, with its initial velocities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub frame: Option<u32>,
    /// In the frame-rate method.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub when: Option<StartsWhen>,
}

/// An event that a body waits for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum StartsWhen {
    /// In the frame in which a moving body hits it, so that the blow moves and breaks it. Bodies
    /// that wait likewise and touch it start with it.
    Struck,
}
