//! Attributes of a mesh file's triangles: materials, coordinates, colours, normals, names.

use crate::mesh::TriMesh;
use glam::{DVec3, Vec2, Vec3};
use std::collections::BTreeMap;

/// Objects, materials and what each corner has, triangle by triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshAttributes {
    /// Names of each object and of the nodes above it, the root's first.
    pub objects: Vec<Vec<String>>,
    /// Names of the materials in OBJ, their numbers in glTF.
    pub materials: Vec<String>,
    /// One for each triangle; none at all in formats that say nothing.
    pub faces: Vec<FaceAttributes>,
}

/// Of one triangle.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaceAttributes {
    /// Index of its object, if it is in one.
    pub object: Option<u32>,
    /// Index of its material, if it has one.
    pub material: Option<u32>,
    /// In the order of the triangle's vertices.
    pub corners: [CornerAttributes; 3],
}

/// Of one corner.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CornerAttributes {
    /// Place in the texture, v up.
    pub coordinates: Option<Vec2>,
    /// Unit, in the mesh's frame.
    pub normal: Option<Vec3>,
    /// Linear red, green, blue, and opacity.
    pub colour: Option<[f32; 4]>,
}

/// The result of a parser.
#[derive(Default)]
pub(crate) struct Parsed {
    pub(super) mesh: TriMesh,
    /// Of no triangle, or of all.
    pub(super) attributes: MeshAttributes,
}

impl From<TriMesh> for Parsed {
    fn from(mesh: TriMesh) -> Self {
        Self { mesh, attributes: MeshAttributes::default() }
    }
}

impl Parsed {
    /// Gives attributes to the triangles of a polygon that were just appended to the mesh.
    /// `corners` are those of the polygon's vertices.
    pub(super) fn describe(
        &mut self,
        object: Option<u32>,
        material: Option<u32>,
        polygon: &[u32],
        corners: &[CornerAttributes],
    ) {
        let place: BTreeMap<u32, usize> = polygon.iter().copied().zip(0..).collect();
        for triangle in &self.mesh.triangles[self.attributes.faces.len()..] {
            let corners = triangle.map(|vertex| {
                place
                    .get(&vertex)
                    .and_then(|&place| corners.get(place))
                    .copied()
                    .unwrap_or_default()
            });
            self.attributes.faces.push(FaceAttributes { object, material, corners });
        }
    }

    /// Removes triangles without area, and vertices that no triangle uses.
    pub(super) fn drop_unused(&mut self) {
        let mesh = &self.mesh;
        let mut triangle = 0;
        self.attributes.faces.retain(|_| {
            triangle += 1;
            mesh.has_area(triangle - 1)
        });
        self.mesh.drop_unused();
    }

    /// Makes the triangles face the other way.
    pub(super) fn flip(&mut self) {
        self.mesh.flip();
        for face in &mut self.attributes.faces {
            face.corners.swap(1, 2);
            for normal in face.corners.iter_mut().filter_map(|corner| corner.normal.as_mut()) {
                *normal = -*normal;
            }
        }
    }
}

impl MeshAttributes {
    /// True if there is more than the shape.
    pub fn is_empty(&self) -> bool {
        let nothing = |face: &FaceAttributes| {
            face.object.is_none()
                && face.material.is_none()
                && face.corners.iter().all(|corner| *corner == CornerAttributes::default())
        };
        self.faces.iter().all(nothing)
    }
}

/// The number of a name in a list, which grows if it is new.
pub(super) fn number_of<T: PartialEq>(list: &mut Vec<T>, name: T) -> u32 {
    let known = list.iter().position(|other| *other == name);
    known.unwrap_or_else(|| {
        list.push(name);
        list.len() - 1
    }) as u32
}

/// A unit vector of three numbers; `None` if they have no direction.
pub(super) fn unit(vector: DVec3) -> Option<Vec3> {
    vector.try_normalize().map(|normal| normal.as_vec3())
}

/// A colour whose channels, from 0 to 1, are sRGB, as they are in files of vertices; `None` if one
/// is not finite.
pub(super) fn colour_from_srgb(srgb: [f64; 3], alpha: f64) -> Option<[f32; 4]> {
    let linear = |value: f64| {
        if value <= 0.04045 { value / 12.92 } else { libm::pow((value + 0.055) / 1.055, 2.4) }
    };
    let [red, green, blue] = srgb.map(|channel| linear(channel) as f32);
    Some([red, green, blue, alpha as f32])
        .filter(|colour| colour.iter().all(|channel| channel.is_finite()))
}
