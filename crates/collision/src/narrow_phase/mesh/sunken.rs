//! Bodies that lie so deep in a mesh that no feature of theirs meets one of it: with their middle
//! behind triangles that are solid there, or nearer to a triangle than the ball inside of them. They
//! come out by the nearest way.

use crate::narrow_phase::mesh::mesh_contact::{Meets, MeshContact, feature_of};
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use frangible_geometry::{EdgeKind, NearestPoint, Sides, StaticMesh};
use glam::DVec3;

/// Depth from which a body comes out, relative to its radius [1]: what fell through further is
/// lost.
const DEPTH: f64 = 2.0;

/// A nearest point within this fraction of the body's size of a border is beside the mesh, not
/// behind it [1].
const BESIDE: f64 = 1e-3;

/// The contact of the ball of `radius` [m] inside of a body, around a point of the body frame, that
/// is behind the mesh or overlaps it.
pub(crate) fn sunken_contact(
    motion: &MeshMotion,
    (center, radius): (DVec3, f64),
) -> Option<MeshContact> {
    let (mesh, size) = (motion.mesh, motion.pair_motion.size);
    let center_mesh = motion.start().point(center);
    let most = match mesh.sides() {
        _ if motion.is_enclosed => f64::INFINITY,
        Sides::One => DEPTH * size,
        Sides::Two => radius,
    };
    let nearest = mesh.nearest(center_mesh, most)?;
    let (distance, normal) = mesh.distance_and_gradient(center_mesh);
    let is_beside = distance < 0.0 && is_on_border(mesh, &nearest, BESIDE * size);
    if distance >= radius || is_beside {
        return None;
    }
    Some(MeshContact {
        on_body: center,
        rounding: radius,
        on_mesh: nearest.point,
        normal,
        time: 0.0,
        feature: feature_of(Meets::FaceOnCorner, u64::MAX),
    })
}

/// True if a point of a triangle lies within `near` [m] of a border.
fn is_on_border(mesh: &StaticMesh, nearest: &NearestPoint, near: f64) -> bool {
    let corners = mesh.corners(nearest.triangle);
    (0..3).any(|corner| {
        let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
        let off = (to - from).cross(nearest.point - from).length();
        mesh.edge_kind(nearest.triangle, corner) == EdgeKind::Border
            && off <= near * (to - from).length()
    })
}
