//! Borders that other triangles continue.

use crate::bvh::closest_point_on_triangle;
use crate::static_mesh::StaticMesh;
use crate::static_mesh::kinds::EdgeKind;

/// Beyond a border covered by another triangle, relative to the edge's length [1]: as far aside as
/// is looked for it, and as far as it may be off.
const BESIDE: f64 = 1e-2;
const OFF: f64 = 1e-3;

/// Cosine of the largest angle between a triangle and another that continues it past a border.
const CONTINUES: f64 = 0.9998;

impl StaticMesh {
    /// Makes borders flat where another triangle continues theirs: at vertices in the middle of an
    /// edge, and beside triangles that were dropped. A body that slides over them must not catch.
    pub(crate) fn flatten_covered_borders(&mut self) {
        let mut covered = Vec::new();
        for triangle in 0..self.triangles().len() {
            for corner in 0..3 {
                let is_border = self.edge_kind(triangle, corner) == EdgeKind::Border;
                if is_border && is_continued(self, triangle, corner) {
                    covered.push((triangle, corner));
                }
            }
        }
        for (triangle, corner) in covered {
            self.adjacency.set_kind(triangle, corner, EdgeKind::Flat);
        }
    }
}

/// True if points beside a border, in its triangle's plane, lie on triangles that are parallel to
/// it.
fn is_continued(mesh: &StaticMesh, triangle: usize, corner: usize) -> bool {
    let corners = mesh.corners(triangle);
    let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
    let (normal, edge) = (mesh.normal(triangle), to - from);
    let length = edge.length();
    let outward = edge.cross(normal) / length;
    let is_on_another = |part: f64| {
        let point = from + part * edge + BESIDE * length * outward;
        let mut found = false;
        let off = OFF * length;
        mesh.visit_box(point - off, point + off, |other| {
            let is_near = || {
                let foot = closest_point_on_triangle(point, &mesh.corners(other));
                foot.distance_squared(point) <= off * off
            };
            found |=
                other != triangle && mesh.normal(other).dot(normal).abs() > CONTINUES && is_near();
        });
        found
    };
    [0.05, 0.35, 0.65, 0.95].into_iter().all(is_on_another)
}
