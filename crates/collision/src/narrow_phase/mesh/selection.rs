//! Contacts of a body with a mesh as points of a manifold.

use crate::manifold::{FeatureId, MOST_POINTS, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::core::turns_far;
use crate::narrow_phase::flat_contacts::few;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::mesh::hull_mesh::hull_contacts;
use crate::narrow_phase::mesh::mesh_contact::MeshContact;
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use crate::narrow_phase::mesh::moving_point::MovingPoint;
use crate::narrow_phase::mesh::round_mesh::round_contacts;
use crate::narrow_phase::mesh::sample_mesh::sample_contacts;
use crate::narrow_phase::mesh::sunken::sunken_contact;
use crate::narrow_phase::pair_motion::PairMotion;
use frangible_geometry::StaticMesh;
use glam::DVec3;

/// Radius of the ball inside of a body of revolution that touches a mesh in spite of other contacts,
/// relative to the largest such ball's [1].
const SUNKEN: f64 = 0.75;

/// Most points of a body on a mesh: on ground with many slopes each has its own normal.
const MOST_ON_MESH: usize = 2 * MOST_POINTS;

/// Appends the points of a body, or a part of it, with a mesh.
pub(crate) fn mesh_points(
    pair_motion: &PairMotion,
    (mesh, mesh_is_first): (&StaticMesh, bool),
    other: ConvexShape,
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) {
    let mut motion = MeshMotion::new(pair_motion, mesh, mesh_is_first);
    let contacts = contacts_of(&mut motion, other);
    let all: Vec<ManifoldPoint> =
        contacts.iter().map(|contact| contact.manifold_point(&motion)).collect();
    let mut chosen = few(pair_motion, &all, scratch);
    spread(&mut chosen, &motion);
    points.extend(unique(chosen));
}

/// All contacts of a body, or a part of it, with a mesh.
pub(crate) fn contacts_of(motion: &mut MeshMotion, other: ConvexShape) -> Vec<MeshContact> {
    let mut contacts = Vec::new();
    match other {
        ConvexShape::Ball(radius) => {
            ball_contacts(motion, radius, &mut contacts);
            if contacts.is_empty() {
                contacts.extend(sunken_contact(motion, (DVec3::ZERO, radius)));
            }
        }
        ConvexShape::Hull(hull) => {
            hull_contacts(motion, hull, &mut contacts);
            core_contacts(motion, other, &mut contacts);
            if contacts.is_empty() {
                let vertices = hull.vertices();
                let middle = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
                let radius = -hull.distance_and_gradient(middle).0;
                contacts.extend(sunken_contact(motion, (middle, radius)));
            }
        }
        ConvexShape::Revolved(ref revolved) => {
            round_contacts(motion, revolved, &mut contacts);
            core_contacts(motion, other, &mut contacts);
            // Points that lie deep behind a triangle are left out, as those of a body beside it.
            let radius = -other.distance_and_gradient(DVec3::ZERO).0;
            let held = if contacts.is_empty() { radius } else { SUNKEN * radius };
            contacts.extend(sunken_contact(motion, (DVec3::ZERO, held)));
        }
        ConvexShape::Other(shape) => sample_contacts(motion, shape, &mut contacts),
        // Nothing static meets a half-space or another mesh.
        ConvexShape::Ground(_) | ConvexShape::Mesh(_) => {}
    }
    contacts
}

/// Appends the contacts of a ball around the body's origin.
fn ball_contacts(motion: &MeshMotion, radius: f64, contacts: &mut Vec<MeshContact>) {
    let pair_motion = motion.pair_motion;
    let pair = pair_motion.pair;
    let surface = pair_motion.bodies.pair_surface(pair.first, pair.second);
    let bounce = if pair_motion.may_impact() { surface.restitution } else { 0.0 };
    let anchor = DVec3::ZERO;
    let feature = u64::from(u32::MAX);
    MovingPoint { motion, anchor, radius, inside: None, corners: &[], bounce, feature }
        .contacts(contacts);
}

/// Appends the contacts of the core of a body that turns far in the frame: its corners turn away
/// from where they were found.
fn core_contacts(motion: &MeshMotion, body: ConvexShape, contacts: &mut Vec<MeshContact>) {
    if turns_far(motion.body_path(), motion.pair_motion) {
        let radius = -body.distance_and_gradient(DVec3::ZERO).0;
        if radius > 0.0 {
            ball_contacts(motion, radius, contacts);
        }
    }
}

/// Keeps at most [`MOST_ON_MESH`] points: the deepest, then repeatedly the one that differs most
/// from all kept in place and normal.
fn spread(points: &mut Vec<ManifoldPoint>, motion: &MeshMotion) {
    if points.len() <= MOST_ON_MESH {
        return;
    }
    let size = motion.pair_motion.size;
    let on_body = |point: &ManifoldPoint| {
        if motion.mesh_is_first { point.anchor_second } else { point.anchor_first }
    };
    let differ = |a: &ManifoldPoint, b: &ManifoldPoint| {
        on_body(a).distance(on_body(b)) / size + a.normal.distance(b.normal)
    };
    // Later touches matter less.
    let nearness = |point: &ManifoldPoint| size / (size + 10.0 * point.gap.max(0.0));
    let mut kept = 0;
    let mut apart = vec![f64::INFINITY; points.len()];
    while kept < MOST_ON_MESH {
        let score = |at: usize| {
            if kept == 0 { -points[at].gap } else { apart[at] * nearness(&points[at]) }
        };
        let best =
            (kept..points.len()).max_by(|&a, &b| score(a).total_cmp(&score(b)).then(b.cmp(&a)));
        let Some(best) = best else { break };
        points[kept..=best].rotate_right(1);
        apart[kept..=best].rotate_right(1);
        let taken = points[kept];
        kept += 1;
        for at in kept..points.len() {
            apart[at] = apart[at].min(differ(&taken, &points[at]));
        }
    }
    points.truncate(MOST_ON_MESH);
}

/// The points with ids that differ.
fn unique(mut points: Vec<ManifoldPoint>) -> Vec<ManifoldPoint> {
    for at in 1..points.len() {
        let (before, rest) = points.split_at_mut(at);
        let same = |id: FeatureId| before.iter().any(|known| known.feature == id);
        while same(rest[0].feature) {
            rest[0].feature.index += 1;
        }
    }
    points
}
