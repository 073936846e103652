//! The triangles that a sampled mesh's solid ends at: surface samples lie on them, not on the level
//! set, which rounds edges off by a third of a voxel.

use crate::bvh::{Bvh, closest_point_on_triangle};
use crate::contour_mesh::Vertex;
use crate::mesh::TriMesh;
use crate::qef::Qef;
use frangible_math::check::{Check, Checked, finite_vector};
use glam::DVec3;
use serde::{Deserialize, Serialize};

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
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(from = "BoundaryRecord")]
pub struct MeshBoundary {
    triangles: Vec<[DVec3; 3]>,
    #[serde(skip_serializing)]
    tree: Bvh,
}

/// What a snapshot holds of them.
#[derive(Deserialize)]
struct BoundaryRecord {
    triangles: Vec<[DVec3; 3]>,
}

impl From<BoundaryRecord> for MeshBoundary {
    fn from(BoundaryRecord { triangles }: BoundaryRecord) -> Self {
        Self::new(triangles)
    }
}

impl Check for MeshBoundary {
    fn check(&self) -> Checked {
        self.triangles.iter().flatten().try_for_each(|&corner| finite_vector(corner))
    }
}

impl MeshBoundary {
    /// Of triangles [m].
    pub fn new(triangles: Vec<[DVec3; 3]>) -> Self {
        Self { tree: Bvh::new(&triangles), triangles }
    }

    /// Of all triangles of a mesh.
    pub(crate) fn of_mesh(mesh: &TriMesh) -> Self {
        Self::new((0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect())
    }

    /// Unit normal of a triangle, outward; any for one without area.
    pub(crate) fn normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.triangles[triangle];
        (b - a).cross(c - a).normalize_or(DVec3::Y)
    }

    /// The nearest point of the triangles of which the nearest points are `shown`, and its triangle.
    pub(crate) fn nearest(
        &self,
        point: DVec3,
        is_shown: impl Fn(DVec3) -> bool,
    ) -> Option<(DVec3, usize)> {
        // Hidden ones are few: look again without them.
        let mut hidden = Vec::new();
        loop {
            let wanted = |triangle: usize| !hidden.contains(&triangle);
            let closest = self.tree.closest_of(point, f64::INFINITY, wanted)?;
            if is_shown(closest.point) {
                return Some((closest.point, closest.triangle));
            }
            hidden.push(closest.triangle);
        }
    }

    /// Visits the triangles within `reach` of a point [m], each with its nearest point.
    pub(crate) fn visit_near(&self, point: DVec3, reach: f64, mut visit: impl FnMut(usize, DVec3)) {
        let is_near = |other: DVec3| point.distance_squared(other) <= reach * reach;
        self.tree.visit(
            |low, high| is_near(point.clamp(low, high)),
            |triangle| {
                let at = closest_point_on_triangle(point, &self.triangles[triangle]);
                if is_near(at) {
                    visit(triangle, at);
                }
            },
        );
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

#[cfg(test)]
mod tests {
    use crate::grid::Grid;
    use crate::grid_solid::GridSolid;
    use crate::mesh::TriMesh;
    use crate::mesh_to_level_set::solids_and_boundary;
    use crate::surface_samples::mesh_samples;
    use glam::{DQuat, DVec3};

    /// An L of two boxes that overlap, turned: corner n of each at the high end of the axes of its
    /// bits.
    fn letter(turn: DQuat) -> TriMesh {
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let mut mesh = TriMesh { positions: Vec::new(), triangles: Vec::new() };
        for size in [DVec3::new(0.6, 0.15, 0.2), DVec3::new(0.15, 0.8, 0.2)] {
            let first = mesh.positions.len() as u32;
            let corner =
                |n: u32| size * DVec3::new((n & 1) as f64, (n >> 1 & 1) as f64, (n >> 2) as f64);
            mesh.positions.extend((0..8).map(|n| turn * corner(n)));
            let halves = |[a, b, c, d]: [u32; 4]| [[a, b, c], [a, c, d]];
            mesh.triangles.extend(faces.into_iter().flat_map(halves).map(|t| t.map(|n| n + first)));
        }
        mesh
    }

    /// All samples lie on the triangles that bound the solid, none on those inside of it, and each
    /// corner has one, however the grid lies.
    #[test]
    fn samples_of_a_mesh_lie_on_it_and_in_its_corners() {
        for (angle, voxels) in [(0.0, 0.0125), (0.4, 0.0125), (1.1, 0.03)] {
            let turn = DQuat::from_scaled_axis(angle * DVec3::new(0.3, 0.9, -0.3));
            let clean = letter(turn).cleaned("L").unwrap();
            let (low, high) = clean.mesh.bounds();
            let counts = ((high - low) / voxels).to_array().map(|n| n.ceil() as usize);
            let grid = Grid::around_box(low, high, counts, 2);
            let (level_set, boundary) = solids_and_boundary(&clean, grid).unwrap();
            let samples =
                mesh_samples(&GridSolid::from_level_set(level_set), &boundary, 2.0 * voxels);
            let back = turn.inverse();
            // Distance to the L's outline, and to its faces.
            let off = |point: DVec3| {
                let within = |size: DVec3| {
                    let half = 0.5 * size;
                    let beyond = (point - half).abs() - half;
                    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
                };
                within(DVec3::new(0.6, 0.15, 0.2)).min(within(DVec3::new(0.15, 0.8, 0.2)))
            };
            let worst = samples.iter().map(|s| off(back * s.as_dvec3()).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-6, "{angle}: {worst} m");
            let outline =
                [[0.0, 0.0], [0.6, 0.0], [0.6, 0.15], [0.15, 0.15], [0.15, 0.8], [0.0, 0.8]];
            for [x, y] in outline {
                for z in [0.0, 0.2] {
                    let corner = turn * DVec3::new(x, y, z);
                    let away = samples.iter().map(|s| s.as_dvec3().distance(corner));
                    let away = away.fold(f64::INFINITY, f64::min);
                    assert!(away < 1e-6, "{angle}: {x}, {y}, {z}: {away} m");
                }
            }
        }
    }
}
