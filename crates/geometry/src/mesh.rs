//! Triangle meshes.

use crate::MassProperties;
use crate::mass_properties::{inertia_from_second_moments, outer};
use glam::{DMat3, DVec3, Vec2, Vec3Swizzles};

/// Indexed triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertices [m].
    pub positions: Vec<DVec3>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// A closed surface, for drawing and for export: in the body frame from [`Shape::surface`](crate::Shape::surface), in the grid
/// frame from [`polygonize`](crate::polygonize::polygonize).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// In the frame of the function that made it [m].
    pub mesh: TriMesh,
    /// For each triangle, whether a crack made it.
    pub interior: Vec<bool>,
    /// For each corner of each triangle, texture coordinates [m]: of an inner one in its crack's own plane, of an outer one along
    /// the axes of the grid frame.
    pub coordinates: Vec<[Vec2; 3]>,
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
    ///
    /// Each hole counts as closed by the cone from its rim to the surface's centroid. The volume is negative if the
    /// triangles face inward, and zero volume has its centre at the surface's centroid.
    pub fn mass_properties(&self) -> MassProperties {
        let triangles = (0..self.triangles.len()).map(|triangle| self.corners(triangle));
        enclosed_mass(surface_centroid(triangles.clone()), triangles)
    }

    /// Sum of the triangles' areas [m^2].
    pub fn area(&self) -> f64 {
        (0..self.triangles.len()).map(|triangle| self.vector_area(triangle).length()).sum()
    }

    /// Makes the triangles face the other way.
    pub fn flip(&mut self) {
        for triangle in &mut self.triangles {
            triangle.swap(1, 2);
        }
    }

    /// Outward normal times area [m^2].
    fn vector_area(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }
}

/// Volume, centre and inertia enclosed by triangles, by the divergence theorem: see [`TriMesh::mass_properties`]. Rounding is least
/// from an origin in their middle.
pub(crate) fn enclosed_mass(origin: DVec3, triangles: impl Iterator<Item = [DVec3; 3]>) -> MassProperties {
    // Sum the signed tetrahedra from the origin to each triangle.
    let mut six_volume = 0.0;
    let mut first_moment = DVec3::ZERO;
    // Of the second moment's six numbers, the squares and the products of x y, y z, z x.
    let (mut squares, mut products) = (DVec3::ZERO, DVec3::ZERO);
    for corners in triangles {
        let [a, b, c] = corners.map(|corner| corner - origin);
        let determinant = a.dot(b.cross(c));
        let sum = a + b + c;
        six_volume += determinant;
        first_moment += determinant * sum;
        squares += (a * a + b * b + c * c + sum * sum) * determinant;
        products += (a * a.yzx() + b * b.yzx() + c * c.yzx() + sum * sum.yzx()) * determinant;
    }

    // Move the moments from the origin to the centre of mass.
    let volume = six_volume / 6.0;
    if volume == 0.0 {
        return MassProperties { volume, center: origin, inertia: DMat3::ZERO };
    }
    let second_moment = DMat3::from_cols(
        DVec3::new(squares.x, products.x, products.z),
        DVec3::new(products.x, squares.y, products.y),
        DVec3::new(products.z, products.y, squares.z),
    );
    let offset = first_moment / (24.0 * volume);
    let central = second_moment * (1.0 / 120.0) - outer(offset, offset) * volume;
    let inertia = inertia_from_second_moments(central);
    MassProperties { volume, center: origin + offset, inertia }
}

/// Area-weighted mean of the triangles' points [m].
fn surface_centroid(triangles: impl Iterator<Item = [DVec3; 3]>) -> DVec3 {
    let mut area = 0.0;
    let mut moment = DVec3::ZERO;
    for [a, b, c] in triangles {
        let weight = (0.5 * (b - a).cross(c - a)).length();
        area += weight;
        moment += (a + b + c) * (weight / 3.0);
    }
    if area > 0.0 { moment / area } else { DVec3::ZERO }
}
