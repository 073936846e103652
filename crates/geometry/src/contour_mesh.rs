//! The surface of a level set on its way to triangles: sheets of cells, their vertices, quads.

use glam::DVec3;

/// A point on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// [m]
    pub(crate) position: DVec3,
    /// Unit: the mean of the normals around.
    pub(crate) normal: DVec3,
    /// 1 on a smooth face, 2 on an edge, 3 at a corner.
    pub(crate) sharpness: u8,
    /// True if the outline contains all of the surface nearby.
    pub(crate) in_outline: bool,
}

/// Around a crossed edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quad {
    /// Vertices, counter-clockwise seen from outside.
    pub(crate) vertices: [u32; 4],
    /// Unit normal at the crossing.
    pub(crate) normal: DVec3,
    /// The piece of the outline that is crossed.
    pub(crate) piece: Option<usize>,
}

/// A connected part of the surface within one cell.
#[derive(Clone, Copy)]
pub(crate) struct Sheet {
    /// Index of the cell's lowest node.
    pub(crate) cell: usize,
    /// One bit per inside corner.
    pub(crate) inside: u8,
    /// Indices of its crossings.
    pub(crate) crossings: [u32; 12],
    pub(crate) count: usize,
}
