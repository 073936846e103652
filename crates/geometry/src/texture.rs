//! Texture coordinates of surfaces: metres along the surface, so that a texture is as large on a
//! small piece as on a large one.

use crate::mesh::{Surface, TriMesh};
use glam::{DVec2, DVec3, Vec2};

impl Surface {
    /// A surface with texture coordinates. `normals` are those of the surfaces that the triangles
    /// lie on: of an inner one its crack's. Outer triangles are projected along the coordinate axis
    /// that they face, inner ones onto their crack's own plane, without stretching, and the same on
    /// both of its sides.
    pub(crate) fn with_coordinates(mesh: TriMesh, interior: Vec<bool>, normals: &[DVec3]) -> Self {
        let lay_out = |triangle: usize| {
            let (u, v) = if interior[triangle] {
                axes_of_plane(normals[triangle])
            } else {
                axes_of_box(normals[triangle])
            };
            mesh.corners(triangle).map(|corner| DVec2::new(u.dot(corner), v.dot(corner)).as_vec2())
        };
        let coordinates: Vec<[Vec2; 3]> = (0..mesh.triangles.len()).map(lay_out).collect();
        Self { mesh, interior, coordinates }
    }
}

/// The two coordinate axes across the one that a normal lies nearest to, the first of equals.
fn axes_of_box(normal: DVec3) -> (DVec3, DVec3) {
    let [x, y, z] = normal.abs().to_array();
    if x >= y && x >= z {
        (DVec3::Z, DVec3::Y)
    } else if y >= z {
        (DVec3::X, DVec3::Z)
    } else {
        (DVec3::X, DVec3::Y)
    }
}

/// Two unit vectors in a plane, across each other: the same for a normal and its opposite.
fn axes_of_plane(normal: DVec3) -> (DVec3, DVec3) {
    // Round-off must not decide which way a plane that stands along an axis looks.
    const CLEARLY: f64 = 1e-9;
    let first = normal.to_array().into_iter().find(|part| part.abs() > CLEARLY).unwrap_or(1.0);
    let normal = if first < 0.0 { -normal } else { normal };
    let across = axes_of_box(normal).0;
    let u = (across - normal * normal.dot(across)).normalize_or(DVec3::X);
    (u, normal.cross(u))
}
