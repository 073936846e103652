//! Rows of heights as triangles.

use crate::mesh::TriMesh;
use glam::DVec3;

/// Triangles of a heightfield: row k, column i stands at (i, height, k) times the spacing, the
/// middle of the field above the origin. Each cell is split across the diagonal between its nearer
/// heights. Faces look up. Rows must have equal lengths of at least two.
pub fn heightfield_mesh(heights: &[Vec<f64>], spacing: [f64; 2]) -> TriMesh {
    let (rows, columns) = (heights.len(), heights.first().map_or(0, Vec::len));
    let middle = |count: usize| 0.5 * (count.max(1) - 1) as f64;
    let (across, along) = (middle(columns), middle(rows));
    let mut mesh = TriMesh::default();
    mesh.positions.reserve(rows * columns);
    for (k, row) in heights.iter().enumerate() {
        for (i, &height) in row.iter().enumerate() {
            let [x, z] = [(i as f64 - across) * spacing[0], (k as f64 - along) * spacing[1]];
            mesh.positions.push(DVec3::new(x, height, z));
        }
    }
    mesh.triangles.reserve(2 * rows.saturating_sub(1) * columns.saturating_sub(1));
    for k in 1..rows {
        for i in 1..columns {
            let vertex = |row: usize, column: usize| (row * columns + column) as u32;
            let [a, b, c, d] =
                [vertex(k - 1, i - 1), vertex(k - 1, i), vertex(k, i - 1), vertex(k, i)];
            let apart = |one: u32, other: u32| {
                (mesh.positions[one as usize].y - mesh.positions[other as usize].y).abs()
            };
            mesh.triangles.extend(if apart(a, d) <= apart(b, c) {
                [[a, d, b], [a, c, d]]
            } else {
                [[a, c, b], [b, c, d]]
            });
        }
    }
    mesh
}
