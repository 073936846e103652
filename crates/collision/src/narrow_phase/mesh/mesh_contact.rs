//! A contact of a body with a mesh, in the mesh's frame.

use crate::manifold::{BALL_BITS, FeatureId, ManifoldPoint};
use crate::narrow_phase::mesh::mesh_motion::MeshMotion;
use glam::DVec3;

/// A touch of a body with a mesh within the frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct MeshContact {
    /// Anchor on the body, body frame [m].
    pub(crate) on_body: DVec3,
    /// Distance from the anchor to the surface along the normal [m].
    pub(crate) rounding: f64,
    /// Anchor on the mesh, mesh frame [m].
    pub(crate) on_mesh: DVec3,
    /// Unit, out of the mesh, mesh frame, at the touch.
    pub(crate) normal: DVec3,
    /// Of the touch, or of the closest approach [s].
    pub(crate) time: f64,
    pub(crate) feature: FeatureId,
}

/// Features in contact.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Meets {
    /// A corner of the body, or the body as a ball, and the side that the normal looks to.
    PointOnFace(u64),
    FaceOnCorner,
    EdgeOnEdge,
}

/// Feature id of a contact in 32 bits, so that a compound can add its parts; see
/// [`compound_points`](crate::narrow_phase::compound::compound_points).
pub(crate) fn feature_of(meets: Meets, number: u64) -> FeatureId {
    let kind = match meets {
        Meets::PointOnFace(side) => side,
        Meets::FaceOnCorner => 6,
        Meets::EdgeOnEdge => 7,
    };
    FeatureId { is_of_first: true, index: kind << BALL_BITS.count_ones() | number & BALL_BITS }
}

/// The side that a normal looks to most, from 0 to 5: contacts of one corner with a floor and a
/// wall differ by it, while neighbouring triangles of a floor share it.
pub(crate) fn side_of(normal: DVec3) -> u64 {
    let size = normal.abs();
    let axis = if size.x >= size.y && size.x >= size.z {
        0
    } else if size.y >= size.z {
        1
    } else {
        2
    };
    2 * axis + u64::from(normal[axis as usize] < 0.0)
}

impl MeshContact {
    /// Separation along the normal at the frame's start [m].
    pub(crate) fn gap_at_start(&self, motion: &MeshMotion) -> f64 {
        // The normal belongs to the touch: in the world it stays for the whole frame.
        let normal_world = motion.world_direction(self.normal, self.time);
        let [body, mesh] = motion.starts;
        let apart = body.point(self.on_body) - mesh.point(self.on_mesh);
        apart.dot(normal_world) - self.rounding
    }

    /// The contact as a point of the pair's manifold.
    pub(crate) fn manifold_point(&self, motion: &MeshMotion) -> ManifoldPoint {
        let outward = motion.world_direction(self.normal, self.time);
        let gap = self.gap_at_start(motion);
        let at = motion.body_path().pose(self.time).world_from_body().point(self.on_body)
            - self.rounding * outward;
        let closing = (motion.mesh_path().velocity(at, self.time)
            - motion.body_path().velocity(at, self.time))
        .dot(outward);
        let pair_motion = motion.pair_motion;
        let approach = if self.time > 0.0 {
            closing.max(0.0)
        } else {
            let normal = if motion.mesh_is_first { -outward } else { outward };
            pair_motion.surface_speed(normal, closing, gap)
        };
        let of_body = FeatureId { is_of_first: !motion.mesh_is_first, ..self.feature };
        if motion.mesh_is_first {
            ManifoldPoint {
                anchor_first: self.on_mesh,
                anchor_second: self.on_body,
                rounding: [0.0, self.rounding],
                normal: -outward,
                feature: of_body,
                approach,
                gap,
            }
        } else {
            ManifoldPoint {
                anchor_first: self.on_body,
                anchor_second: self.on_mesh,
                rounding: [self.rounding, 0.0],
                normal: outward,
                feature: of_body,
                approach,
                gap,
            }
        }
    }
}
