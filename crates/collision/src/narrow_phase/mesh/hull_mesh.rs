//! Contacts of a convex polyhedron with a mesh.

use crate::narrow_phase::mesh::edge_contacts::{HullEdges, edge_contacts};
use crate::narrow_phase::mesh::hull_faces::corner_contacts;
use crate::narrow_phase::mesh::mesh_contact::MeshContact;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::moving_point::MovingPoint;
use frangible_geometry::{HalfSpace, Hull};
use frangible_math::RigidTransform;
use glam::DVec3;
use std::cell::Cell;

/// Faces of a hull that are looked at to leave out boxes of triangles: more cost more than they
/// save.
const MOST_PLANES: usize = 16;

/// Features of a mesh that a hull may touch.
#[derive(Default)]
pub(crate) struct NearFeatures {
    /// Triangles and their corners where edges begin.
    pub(crate) edges: Vec<(usize, usize)>,
    pub(crate) vertices: Vec<usize>,
}

/// Appends the contacts of a hull, whose own frame is the body's.
pub(crate) fn hull_contacts(motion: &mut MeshMotion, hull: &Hull, contacts: &mut Vec<MeshContact>) {
    let first = contacts.len();
    let Some(features) = near_features(motion, hull) else { return };
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
    if features.edges.is_empty() && features.vertices.is_empty() {
        return;
    }

    // Touching features hold the body up: its corners, or else all other features.
    let is_borne = support(motion, &contacts[first..]);
    let mut others = Vec::new();
    let find = |motion: &MeshMotion, others: &mut Vec<MeshContact>| {
        others.clear();
        corner_contacts(motion, hull, inside, &features.vertices, others);
        let edges = HullEdges::new(motion, hull);
        edge_contacts(motion, &edges, inside, &features.edges, others);
    };
    find(motion, &mut others);
    if !is_borne && support(motion, &others) {
        find(motion, &mut others);
    }
    contacts.append(&mut others);
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

/// Edges and vertices near the hull on its way; `None` if it comes near no triangle.
fn near_features(motion: &MeshMotion, hull: &Hull) -> Option<NearFeatures> {
    let (low, high) = motion.swept_bounds(hull.bounds());
    let margin = motion.pair_motion.near + motion.thin;
    let [first, last] = [&motion.instants[0].1, &motion.instants[motion.instants.len() - 1].1];
    let mesh = motion.mesh;
    let overlaps =
        |box_low: DVec3, box_high: DVec3| box_low.cmple(high).all() && low.cmple(box_high).all();
    let any = Cell::new(false);
    mesh.visit(|low, high| !any.get() && overlaps(low, high), |_| any.set(true));
    if !any.get() {
        return None;
    }

    let seen = |mesh_from_body: &RigidTransform, plane: &HalfSpace| {
        let normal = mesh_from_body.direction(plane.normal);
        let offset = plane.offset + normal.dot(mesh_from_body.translation) + margin;
        (HalfSpace { normal, offset }, normal.abs())
    };
    // Planes at the start and the end of a frame in which the body hardly turns.
    let count = if motion.instants.len() == 2 { hull.planes().len() } else { usize::MAX };
    let planes: Vec<[(HalfSpace, DVec3); 2]> = if count <= MOST_PLANES {
        hull.planes().iter().map(|plane| [seen(first, plane), seen(last, plane)]).collect()
    } else {
        Vec::new()
    };
    // Turning by a part of a radian, a face's corners leave its plane by no more than this.
    let turn = 0.125 * first.rotation.angle_between(last.rotation) * motion.pair_motion.size;
    let is_beyond = |low: DVec3, high: DVec3| {
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        planes.iter().any(|planes| {
            planes
                .iter()
                .all(|(plane, absolute)| plane.distance(middle) - half.dot(*absolute) > turn)
        })
    };
    let mut features = NearFeatures::default();
    let enters = |box_low: DVec3, box_high: DVec3| {
        overlaps(box_low, box_high) && !is_beyond(box_low, box_high)
    };
    mesh.visit_features(enters, |triangle| {
        if mesh.owns_nothing(triangle) {
            return;
        }
        let corners = mesh.corners(triangle);
        let [box_low, box_high] = [
            corners[0].min(corners[1]).min(corners[2]),
            corners[0].max(corners[1]).max(corners[2]),
        ];
        if !enters(box_low, box_high) {
            return;
        }
        for corner in 0..3 {
            if mesh.owns_edge(triangle, corner) {
                let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
                if enters(from.min(to), from.max(to)) {
                    features.edges.push((triangle, corner));
                }
            }
            let at = corners[corner];
            if mesh.owns_vertex(triangle, corner) && enters(at, at) {
                features.vertices.push(mesh.triangles()[triangle][corner] as usize);
            }
        }
    });
    Some(features)
}
