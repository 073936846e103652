//! Compartments of closed sheets that bodies are in (`near_sheets.rs`).

use crate::body_id::BodyId;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Compartments of bodies that are near closed sheets.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Enclosures {
    /// By sheet and body.
    pub(crate) known: BTreeMap<[BodyId; 2], u32>,
}
