//! Edges and faces of solids.

use crate::half_space::HalfSpace;
use serde::{Deserialize, Serialize};

/// No vertex, no face.
pub(crate) const NONE: u32 = u32::MAX;

/// An edge between two faces.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Edge {
    /// Its vertices.
    pub ends: [u32; 2],
    /// The first has it from its first to its second vertex, the second the other way round.
    pub faces: [u32; 2],
}

/// A planar face.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Face {
    /// The solid lies inside of it, at the face.
    pub plane: HalfSpace,
    /// What it is a part of.
    pub origin: FaceOrigin,
}

/// What a face is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum FaceOrigin {
    /// A triangle of the mesh that the first solid was made of.
    Triangle(u32),
    /// A crack.
    Crack,
}
