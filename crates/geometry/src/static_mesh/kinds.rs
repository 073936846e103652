//! Kinds of edges, and sides of meshes.

use serde::{Deserialize, Serialize};

/// How the surface bends across an edge, seen from the fronts of its triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EdgeKind {
    /// Both triangles lie in a plane, within a ten-thousandth of a radian.
    Flat,
    /// As a roof's ridge.
    Convex,
    /// As a gutter.
    Concave,
    /// The edge of one triangle, or of more than two.
    Border,
}

/// Which sides of its triangles a mesh is solid on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Sides {
    /// Solid behind its triangles, which run counter-clockwise seen from the front.
    One,
    /// A sheet: both sides of a triangle are its front, for a body that is there.
    Two,
}

/// The triangle across an edge.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Neighbour {
    /// Its index.
    pub triangle: usize,
    /// True if it runs the other way round, so that its normal points to the other side.
    pub is_flipped: bool,
}
