//! Surface samples of any other shape against a mesh: as points on their ways.

use crate::narrow_phase::mesh::mesh_contact::MeshContact;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::moving_point::MovingPoint;
use frangible_geometry::Shape;
use glam::DVec3;

/// Depth of the point inside of the body from which a sample has come, relative to the body's
/// radius [1]: overlaps go no deeper.
const DEPTH: f64 = 0.2;

/// Appends the contacts of a body's samples.
pub(crate) fn sample_contacts(motion: &MeshMotion, shape: &Shape, contacts: &mut Vec<MeshContact>) {
    let margin = motion.pair_motion.near + motion.thin;
    let depth = DEPTH * motion.pair_motion.size;
    for cluster in shape.sample_clusters() {
        let center = cluster.center.as_dvec3();
        let reach = f64::from(cluster.radius) + margin + depth;
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for (_, mesh_from_body) in &motion.instants {
            let at = mesh_from_body.point(center);
            (low, high) = (low.min(at - reach), high.max(at + reach));
        }
        let mut any = false;
        motion.mesh.visit_box(low, high, |_| any = true);
        if !any {
            continue;
        }
        for index in cluster.first..cluster.first + cluster.count {
            let anchor = shape.samples()[index as usize].as_dvec3();
            let (_, outward) = shape.distance_and_gradient(anchor);
            let point = MovingPoint {
                motion,
                anchor,
                radius: 0.0,
                inside: Some(anchor - depth * outward),
                corners: &[],
                bounce: 0.0,
                feature: index.into(),
            };
            point.contacts(contacts);
        }
    }
}
