//! Bodies that a caller holds, and its deeds since the last frame.

use crate::report::Fracture;
use frangible_bodies::BodyId;
use glam::DVec3;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The caller's part of a world's state.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Hand {
    /// In the order in which they were taken; at most one for a body.
    pub(crate) grips: Vec<Grip>,
    pub(crate) handled: Handled,
}

/// For the next report.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Handled {
    /// Kinetic energy that impulses gave [J].
    pub(crate) work: f64,
    /// Bodies that were cut or broken.
    #[serde(serialize_with = "write_text", deserialize_with = "read_text")]
    pub(crate) fractures: Vec<Fracture>,
}

/// A point of a body that is pulled to a place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Grip {
    pub(crate) body: BodyId,
    /// Body frame [m].
    pub(crate) point_body: DVec3,
    /// World frame [m].
    pub(crate) target: DVec3,
    /// [N]
    pub(crate) most_force: f64,
}

// Reports leave out what has no value, which the format of snapshots cannot: they are JSON there.
fn write_text<S: Serializer>(fractures: &[Fracture], to: S) -> Result<S::Ok, S::Error> {
    serde_json::to_string(fractures).map_err(serde::ser::Error::custom)?.serialize(to)
}

fn read_text<'de, D: Deserializer<'de>>(from: D) -> Result<Vec<Fracture>, D::Error> {
    let text = String::deserialize(from)?;
    serde_json::from_str(&text).map_err(serde::de::Error::custom)
}
