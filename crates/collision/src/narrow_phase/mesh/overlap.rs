//! Overlap of a body with a mesh.

use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::selection::contacts_of;
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_bodies::{BallisticPath, Bodies, Frame, Pair, Pose, StepSettings};
use frangible_geometry::StaticMesh;
use glam::DVec3;

/// Separation of a body, or of a part of it, from a mesh at the given poses [m]: the deepest of its
/// contacts; negative for overlap, infinite without contacts.
pub(crate) fn mesh_separation(
    bodies: &Bodies,
    pair: Pair,
    poses: &[Pose],
    (mesh, mesh_is_first): (&StaticMesh, bool),
    other: ConvexShape,
) -> f64 {
    let frame = Frame { dt: 0.0, gravity: DVec3::ZERO, settings: StepSettings::default() };
    let still = |i: usize| BallisticPath {
        start: poses[i],
        linear: DVec3::ZERO,
        angular: DVec3::ZERO,
        acceleration: DVec3::ZERO,
        radius: bodies.radii[i],
        spin_speed: 0.0,
    };
    let paths = [still(pair.first), still(pair.second)];
    let pair_motion = PairMotion::new(bodies, pair, [&paths[0], &paths[1]], &frame);
    let mut motion = MeshMotion::new(&pair_motion, mesh, mesh_is_first);
    let contacts = contacts_of(&mut motion, other);
    let gaps = contacts.iter().map(|contact| contact.gap_at_start(&motion));
    gaps.fold(f64::INFINITY, f64::min)
}
