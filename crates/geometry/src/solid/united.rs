//! The solid in surfaces that cross, touch or lie in one another.

use super::Solid;
use crate::cleaning::clean_mesh::CleanMesh;
use crate::mesh::TriMesh;
use glam::DVec3;
use manifold_rust::manifold::Manifold;
use manifold_rust::types::{MeshGL64, WindingRule};

impl Solid {
    /// The solid in a clean mesh: where its surfaces wind around. Surfaces that meet no other keep
    /// their triangles; the others are cut along the lines where they cross, in exact arithmetic,
    /// and lose what lies inside. Faces have the numbers of the mesh's triangles. `None` if nothing
    /// closed is left.
    pub fn of_clean(clean: &CleanMesh) -> Option<Self> {
        let meeting = clean.meeting();
        let crosses = meeting.buried.iter().any(|&part| part > 0.0);
        if !crosses && !meeting.others.contains(&true) {
            return Self::of_mesh(&clean.mesh);
        }
        let (mesh, source) = united(&clean.mesh);
        Self::of_triangles(&mesh, |triangle| source.get(triangle as usize).copied().unwrap_or(0))
    }
}

/// Triangles that bound what a closed mesh winds around, with the numbers of those that they are
/// parts of.
fn united(mesh: &TriMesh) -> (TriMesh, Vec<u32>) {
    let given = MeshGL64 {
        num_prop: 3,
        vert_properties: mesh.positions.iter().flat_map(|place| place.to_array()).collect(),
        tri_verts: mesh.triangles.iter().flatten().map(|&corner| u64::from(corner)).collect(),
        face_id: (0..mesh.triangles.len() as u64).collect(),
        ..MeshGL64::default()
    };
    let soup = Manifold::from_mesh_gl64_robust(&given);
    let found = soup.rebuild_solid(WindingRule::Positive).get_mesh_gl64(-1);
    let place = |at: &[f64]| DVec3::new(at[0], at[1], at[2]);
    let positions = found.vert_properties.chunks_exact(3).map(place).collect();
    let corners = |at: &[u64]| [at[0] as u32, at[1] as u32, at[2] as u32];
    let triangles = found.tri_verts.chunks_exact(3).map(corners).collect();
    let source = found.face_id.iter().map(|&face| face as u32).collect();
    (TriMesh { positions, triangles }, source)
}
