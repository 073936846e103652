//! Triangle meshes.

use crate::MassProperties;
use glam::DVec3;

/// Indexed triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertices [m].
    pub positions: Vec<DVec3>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// The closed surface of a body, for drawing and for export.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// In the body frame [m].
    pub mesh: TriMesh,
    /// For each triangle, whether a crack made it.
    pub interior: Vec<bool>,
}

impl TriMesh {
    /// Lowest and highest corner of the bounding box [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let mut low = DVec3::INFINITY;
        let mut high = DVec3::NEG_INFINITY;
        for &position in &self.positions {
            low = low.min(position);
            high = high.max(position);
        }
        (low, high)
    }

    /// The three corners of a triangle [m].
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.triangles[triangle].map(|vertex| self.positions[vertex as usize])
    }

    /// Volume, centre and inertia enclosed by the surface, by the divergence theorem [Su09 sec. 4.4].
    pub fn mass_properties(&self) -> MassProperties {
        todo!()
    }
}
