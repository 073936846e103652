//! Contacts of pieces that were cut out of a mesh: where triangles of their cracks lie on one
//! another.

use super::hulls::{SAME_PLANE, overlap_of_faces};
use crate::interfaces::interface::{Contacts, Interface};
use frangible_geometry::Bvh;
use frangible_geometry::TriMesh;
use glam::DVec3;

/// A piece of a mesh: a connected part of the mesh within one cell of a pattern.
#[derive(Clone, Debug, PartialEq)]
pub struct CutPiece {
    /// Closed [m].
    pub mesh: TriMesh,
    /// Per triangle: true if a crack made it.
    pub inner: Vec<bool>,
}

/// A triangle of a crack.
pub(super) struct CrackTriangle {
    piece: usize,
    corners: [DVec3; 3],
    /// Unit, outward.
    normal: DVec3,
    low: DVec3,
    high: DVec3,
}

impl CrackTriangle {
    pub(super) fn new(piece: usize, corners: [DVec3; 3], normal: DVec3) -> Self {
        let [a, b, c] = corners;
        Self { piece, corners, normal, low: a.min(b).min(c), high: a.max(b).max(c) }
    }
}

/// The contacts between the pieces of one mesh, in the order of `a`, then of `b`, in the mesh's
/// frame. Exact: the two sides of a crack are cut into different triangles, but lie in the same
/// planes.
pub fn mesh_interfaces(pieces: &[CutPiece]) -> Vec<Interface> {
    mesh_interfaces_within(pieces, SAME_PLANE)
}

/// The same of pieces whose two sides of a crack are apart by `apart`, relative to the longest side
/// of all: files have single precision.
pub(crate) fn mesh_interfaces_within(pieces: &[CutPiece], apart: f64) -> Vec<Interface> {
    let triangles: Vec<CrackTriangle> = pieces
        .iter()
        .enumerate()
        .flat_map(|(number, piece)| crack_triangles(number, piece))
        .collect();
    interfaces_of_triangles(&triangles, apart)
}

/// The contacts between pieces with these cracks.
pub(super) fn interfaces_of_triangles(triangles: &[CrackTriangle], apart: f64) -> Vec<Interface> {
    let boxes: Vec<(DVec3, DVec3)> = triangles.iter().map(|one| (one.low, one.high)).collect();
    let low = boxes.iter().fold(DVec3::INFINITY, |low, bounds| low.min(bounds.0));
    let high = boxes.iter().fold(DVec3::NEG_INFINITY, |high, bounds| high.max(bounds.1));
    let near = apart * (high - low).max_element();

    let tree = Bvh::of_boxes(&boxes);
    let mut contacts = Contacts::default();
    for (at, first) in triangles.iter().enumerate() {
        let enters = |low: DVec3, high: DVec3| {
            low.cmple(first.high + near).all() && first.low.cmple(high + near).all()
        };
        tree.visit(enters, |other| {
            let second = &triangles[other];
            let is_counted = other <= at || first.piece == second.piece;
            if is_counted
                || !enters(second.low, second.high)
                || first.normal.dot(second.normal) > 0.0
            {
                return;
            }
            let (a, b) = if first.piece < second.piece { (first, second) } else { (second, first) };
            let from_plane = |corner: &DVec3| (a.normal.dot(*corner - a.corners[0])).abs();
            if b.corners.iter().all(|corner| from_plane(corner) <= near)
                && let Some(part) = overlap_of_faces(&a.corners, &b.corners, a.normal)
            {
                contacts.add((a.piece, b.piece), part);
            }
        });
    }
    contacts.into_interfaces()
}

/// Crack triangles of a piece, without degenerate triangles.
fn crack_triangles(number: usize, piece: &CutPiece) -> impl Iterator<Item = CrackTriangle> {
    let inner = (0..piece.mesh.triangles.len()).filter(|&triangle| piece.inner[triangle]);
    inner.filter_map(move |triangle| {
        let corners = piece.mesh.corners(triangle);
        let [a, b, c] = corners;
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(CrackTriangle::new(number, corners, normal))
    })
}
