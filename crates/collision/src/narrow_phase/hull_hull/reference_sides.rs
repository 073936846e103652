//! The sides of a reference face, which clip the other hull's face.

use crate::narrow_phase::hull_hull::hull_point::Feature;
use crate::narrow_phase::hull_hull::placement::View;
use crate::narrow_phase::hull_hull::scratch::Side;
use frangible_geometry::HullFace;
use glam::DVec3;

/// Sides of a reference face.
pub(crate) struct Sides<'a> {
    pub(crate) reference: &'a View<'a>,
    pub(crate) face: &'a HullFace<'a>,
    /// Of the face.
    pub(crate) normal: DVec3,
}

impl Sides<'_> {
    /// The start of each, and the direction out of the face, as long as the side [m].
    pub(crate) fn outward(&self) -> impl Iterator<Item = (DVec3, DVec3)> {
        let vertices = self.face.vertices;
        let vertex = |at: usize| self.reference.vertex(vertices[at % vertices.len()] as usize);
        let mut start = vertex(0);
        (0..vertices.len()).map(move |at| {
            let (from, end) = (start, vertex(at + 1));
            start = end;
            (from, (end - from).cross(self.normal))
        })
    }

    /// Feature of the crossing of a side of this face with one of the polygon.
    pub(crate) fn crossing(&self, at: usize, side: Side) -> Feature {
        match side {
            Side::Incident(edge) => Feature::Edges(self.face.edges[at], edge),
            // The corner of the reference face between the two sides.
            Side::Reference(other) => {
                let next = (at + 1) % self.face.vertices.len();
                let corner = if next == other { other } else { at };
                Feature::VertexOfFirst(self.face.vertices[corner])
            }
        }
    }
}
