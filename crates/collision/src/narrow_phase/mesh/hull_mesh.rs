//! Contacts of a convex polyhedron with a mesh.

use crate::narrow_phase::mesh::edge_contacts::{HullEdges, edge_contacts};
use crate::narrow_phase::mesh::hull_faces::corner_contacts;
use crate::narrow_phase::mesh::hull_way::HullWay;
use crate::narrow_phase::mesh::mesh_contact::MeshContact;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::moving_point::MovingPoint;
use crate::narrow_phase::mesh::near_features::{FoundFeatures, NearFeatures};
use crate::narrow_phase::mesh::nearby::{Holds, Nearby};
use frangible_geometry::Hull;
use glam::DVec3;

/// Appends the contacts of a hull, whose own frame is the body's.
pub(crate) fn hull_contacts(motion: &mut MeshMotion, hull: &Hull, contacts: &mut Vec<MeshContact>) {
    let first = contacts.len();
    let (low, high) = motion.swept_bounds(hull.bounds());
    let (holds, nearby) = Nearby::gather(motion.mesh, low, high);
    motion.nearby = nearby;
    if holds == Holds::Nothing {
        return;
    }
    let vertices = hull.vertices();
    let inside = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
    for (number, &anchor) in vertices.iter().enumerate() {
        let feature = number as u64;
        let point = MovingPoint {
            motion,
            anchor,
            radius: 0.0,
            inside: Some(inside),
            corners: vertices,
            bounce: 0.0,
            feature,
        };
        point.contacts(contacts);
    }

    if holds == Holds::Faces {
        return;
    }

    // Touching features hold the body up: its corners, or else all other features.
    let is_borne = support(motion, &contacts[first..]);
    let mut others = Vec::new();
    let hull_way = HullWay::new(motion, hull, inside);
    let found = FoundFeatures::new(&hull_way);
    feature_contacts(&hull_way, &found.features, &mut others);
    drop(hull_way);
    if !is_borne && support(motion, &others) {
        others.clear();
        let hull_way = HullWay::new(motion, hull, inside);
        let found = found.renewed(&hull_way);
        feature_contacts(&hull_way, &found.features, &mut others);
    }
    contacts.append(&mut others);
}

/// Appends the contacts with edges and vertices of the mesh.
fn feature_contacts(hull_way: &HullWay, features: &NearFeatures, contacts: &mut Vec<MeshContact>) {
    corner_contacts(hull_way, &features.vertices, contacts);
    if !features.edges.is_empty() {
        edge_contacts(&HullEdges::new(hull_way), &features.edges, contacts);
    }
}

/// Takes the motion away that goes into what touches at the frame's start; `true` if anything does.
pub(crate) fn support(motion: &mut MeshMotion, contacts: &[MeshContact]) -> bool {
    let near = motion.pair_motion.frame.speculative_margin();
    let mut any = false;
    for contact in contacts {
        let [body, mesh] = motion.starts;
        let apart = body.point(contact.on_body).distance(mesh.point(contact.on_mesh));
        // Features further along the way do not hold it up yet.
        if contact.gap_at_start(motion) <= near && (contact.time == 0.0 || apart <= 2.0 * near) {
            motion.support(contact.normal);
            any = true;
        }
    }
    any
}
