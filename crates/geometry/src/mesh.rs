//! Triangle meshes.

use crate::mass_properties::{MassProperties, inertia_from_second_moments, outer};
use glam::{DMat3, DVec3, Vec2};

/// Indexed triangles, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TriMesh {
    /// Vertices [m].
    pub positions: Vec<DVec3>,
    /// Three vertex indices each.
    pub triangles: Vec<[u32; 3]>,
}

/// A closed surface, for drawing and for export: in the body frame from
/// [`Shape::surface`](crate::Shape::surface), in the grid frame from
/// [`polygonize`](crate::polygonize::polygonize).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Surface {
    /// Mesh in the frame of its function [m].
    pub mesh: TriMesh,
    /// Per triangle: true if a crack made it.
    pub interior: Vec<bool>,
    /// For each corner of each triangle, texture coordinates [m]: of an inner one in its crack's
    /// own plane, of an outer one along the axes of the grid frame.
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

    /// Volume, centre and inertia enclosed by the surface, by the divergence theorem
    /// [Su09 sec. 4.4].
    ///
    /// Each hole counts as closed by the cone from its rim to the surface's centroid. The volume is
    /// negative if the triangles face inward, and zero volume has its centre at the surface's
    /// centroid.
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
    pub(crate) fn vector_area(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }
}

/// Volume, centre and inertia enclosed by triangles, by the divergence theorem: see
/// [`TriMesh::mass_properties`]. Rounding is least from an origin in their middle.
fn enclosed_mass(origin: DVec3, triangles: impl Iterator<Item = [DVec3; 3]>) -> MassProperties {
    let mut sums = Tetrahedra::default();
    for corners in triangles {
        sums.add(corners.map(|corner| corner - origin));
    }
    sums.mass_properties(origin)
}

/// Tetrahedra that are summed up side by side.
const LANES: usize = 4;

/// Sums over tetrahedra with a corner in the origin, four at a time; each of their six volumes
/// times ...
#[derive(Default)]
pub(crate) struct Tetrahedra {
    /// ... one,
    determinant: [f64; LANES],
    /// the sum of the corners,
    first: [[f64; LANES]; 3],
    /// of the second moment's six numbers the squares
    squares: [[f64; LANES]; 3],
    /// and the products of x y, y z, z x.
    products: [[f64; LANES]; 3],
    /// Tetrahedra not yet added: their vertices, and their count.
    waiting: [[DVec3; 3]; LANES],
    count: usize,
}

impl Tetrahedra {
    /// Adds the tetrahedron of a triangle, counter-clockwise seen from outside.
    #[inline]
    pub(crate) fn add(&mut self, corners: [DVec3; 3]) {
        self.waiting[self.count] = corners;
        self.count += 1;
        if self.count == LANES {
            self.sum_up();
        }
    }

    fn sum_up(&mut self) {
        for (lane, corners) in self.waiting.iter().enumerate() {
            let [a, b, c] = corners.map(|corner| corner.to_array());
            let cross = |u: usize, v: usize| b[u] * c[v] - b[v] * c[u];
            let determinant = a[0] * cross(1, 2) + a[1] * cross(2, 0) + a[2] * cross(0, 1);
            self.determinant[lane] += determinant;
            let sum: [f64; 3] = std::array::from_fn(|axis| a[axis] + b[axis] + c[axis]);
            for axis in 0..3 {
                let product =
                    |u: usize, v: usize| a[u] * a[v] + b[u] * b[v] + c[u] * c[v] + sum[u] * sum[v];
                self.first[axis][lane] += determinant * sum[axis];
                self.squares[axis][lane] += determinant * product(axis, axis);
                self.products[axis][lane] += determinant * product(axis, (axis + 1) % 3);
            }
        }
        self.count = 0;
    }

    /// Mass properties of all tetrahedra with a common vertex at `origin`.
    pub(crate) fn mass_properties(mut self, origin: DVec3) -> MassProperties {
        // Pad the last batch with tetrahedra of zero volume.
        self.waiting[self.count..].fill([DVec3::ZERO; 3]);
        self.sum_up();
        let sum = |lanes: [f64; LANES]| lanes.iter().sum::<f64>();
        let vector = |sums: [[f64; LANES]; 3]| DVec3::from_array(sums.map(sum));
        let [first_moment, squares, products] =
            [self.first, self.squares, self.products].map(vector);

        // Move the moments from the origin to the centre of mass.
        let volume = sum(self.determinant) / 6.0;
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
