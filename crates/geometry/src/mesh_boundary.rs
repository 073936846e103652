//! The triangles that a sampled mesh's solid ends at: surface samples lie on them, not on the level
//! set, which rounds edges off by a third of a voxel.

use crate::bvh::{Bvh, closest_point_on_triangle};
use crate::contour_mesh::Vertex;
use crate::qef::Qef;
use glam::DVec3;

/// Planes within this distance of a vertex form its feature, in voxels: a vertex of the contour
/// lies up to half a voxel beside its edge.
const FEATURE_REACH: f64 = 1.0;

/// A feature of more planes is a curved surface, without an edge to find.
const MOST_PLANES: usize = 32;

/// Faces of the same side have at least this cosine with the vertex's normal: the other side of a
/// thin plate is no part of the feature. A wedge of 20 degrees has it.
const SAME_SIDE: f64 = 0.15;

/// Planes closer than this in direction and, in voxels, in distance are one: a flat face counts
/// once, in however many triangles.
const SAME_PLANE: f64 = 1e-3;

/// Minimum eigenvalue of an edge relative to the largest: faces at 16 degrees have one.
const TRUNCATION: f64 = 0.02;

/// Triangles with outside in front and inside behind.
#[derive(Clone, Debug)]
pub struct MeshBoundary {
    triangles: Vec<[DVec3; 3]>,
    tree: Bvh,
}

impl MeshBoundary {
    /// Of triangles [m].
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        Self { tree: Bvh::new(&triangles), triangles }
    }

    /// Moves a vertex of the dual contour onto the triangles: onto the corner or edge that lies
    /// within a voxel, else onto the nearest face. `spacing` [m] is the grid's.
    pub(crate) fn settle(&self, vertex: &Vertex, spacing: f64) -> Vertex {
        let feature = self.feature(vertex, spacing);
        let rank = feature.map_or(1, |feature| feature.rank(TRUNCATION));
        let near = match feature {
            Some(feature) if rank > 1 => {
                let met = feature.minimize(DVec3::ZERO, TRUNCATION, FEATURE_REACH);
                vertex.position + spacing * met
            }
            _ => vertex.position,
        };
        // Far from all triangles the solid ends at a hole that was closed: no triangle is there.
        let reach = 2.0 * FEATURE_REACH * spacing;
        let Some(closest) = self.tree.closest(near, reach * reach) else { return *vertex };
        Vertex { position: closest.point, sharpness: rank as u8, ..*vertex }
    }

    /// The planes around a vertex, in voxels from there; `None` on a curved surface.
    fn feature(&self, vertex: &Vertex, spacing: f64) -> Option<Qef> {
        let at = vertex.position;
        let reach = FEATURE_REACH * spacing;
        let near = |point: DVec3| point.distance_squared(at) <= reach * reach;
        let mut planes: Vec<(DVec3, DVec3)> = Vec::new();
        self.tree.visit(
            |low, high| near(at.clamp(low, high)),
            |triangle| {
                let [a, b, c] = self.triangles[triangle];
                let Some(normal) = (b - a).cross(c - a).try_normalize() else { return };
                if planes.len() > MOST_PLANES || normal.dot(vertex.normal) < SAME_SIDE {
                    return;
                }
                let point = closest_point_on_triangle(at, &[a, b, c]);
                if !near(point) {
                    return;
                }
                let point = (point - at) / spacing;
                let is_known = |&(other, through): &(DVec3, DVec3)| {
                    other.dot(normal) > 1.0 - SAME_PLANE * SAME_PLANE
                        && other.dot(point - through).abs() < SAME_PLANE
                };
                if !planes.iter().any(is_known) {
                    planes.push((normal, point));
                }
            },
        );
        if planes.len() > MOST_PLANES {
            return None;
        }
        let mut feature = Qef::ZERO;
        planes.iter().for_each(|&(normal, point)| feature.add_plane(point, normal));
        (!feature.is_empty()).then_some(feature)
    }
}
