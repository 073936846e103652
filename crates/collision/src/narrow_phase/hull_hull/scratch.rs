//! Scratch memory of the hull-hull narrow phase.

use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::placement::Ridge;
use frangible_math::Singles;
use glam::DVec3;

/// Scratch memory of the narrow phase, reused across pairs without state.
#[derive(Clone, Debug, Default)]
pub(crate) struct Scratch {
    /// Contact points of two hulls.
    pub(crate) points: Vec<HullPoint>,
    pub(crate) spare: Vec<HullPoint>,
    pub(crate) polygon: Vec<Corner>,
    pub(crate) clipped: Vec<Corner>,
    /// Corners before and after each corner of a polygon.
    pub(crate) links: Vec<[u32; 2]>,
    /// Marks of a hull's vertices within two layers, from `mark_within`.
    pub(crate) marks: Vec<u8>,
    pub(crate) face_blocks: Vec<FaceBlock>,
    /// By side, vertices of the other hull that the search for its best face has looked at.
    pub(crate) lowest: [Vec<u32>; 2],
    pub(crate) ridges: [Vec<Ridge>; 2],
    pub(crate) ridge_columns: Vec<RidgeColumns>,
}

/// Origin of a polygon's side.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Side {
    /// An edge of the incident hull.
    Incident(u32),
    /// A side of the reference face, by its index around the face.
    Reference(usize),
}

/// A vertex of the clipped polygon.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Corner {
    pub(crate) point: DVec3,
    /// Feature, with the reference hull as the first.
    pub(crate) feature: Feature,
    /// Origin of the polygon's side that begins here.
    pub(crate) side: Side,
    /// Distance beyond the clipping side of the reference face, unscaled at first, then [m].
    pub(crate) beyond: f64,
}

/// Eight ridges: start points, edge vectors, both face normals, and outward directions.
pub(crate) type RidgeColumns = [[Singles; 3]; 5];

/// Eight faces of a hull, and bounds of their separation from another hull.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceBlock {
    /// Normals in the other hull's frame.
    pub(crate) up: [Singles; 3],
    /// Height of the other hull's middle above the hull's middle along the normals [m].
    pub(crate) middle: Singles,
    /// Distances of the planes from the hull's middle [m].
    pub(crate) offset: Singles,
    /// Of the lowest known vertex of the other hull above its middle [m].
    pub(crate) height: Singles,
    /// Number of the block.
    pub(crate) number: f32,
}
