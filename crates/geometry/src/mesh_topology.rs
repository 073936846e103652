//! Connectivity of a mesh's triangles.

use crate::mesh::TriMesh;
use frangible_math::DisjointSets;
use glam::{DMat3, DVec3};

/// Summary of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshInfo {
    /// Number of vertices.
    pub vertices: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Number of parts that share no vertex position.
    pub parts: usize,
    /// True if each edge has an opposite edge in a neighbouring triangle.
    pub watertight: bool,
    /// Lowest and highest corner of the bounding box [m].
    pub bounds: (DVec3, DVec3),
    /// [m^3], see [`TriMesh::mass_properties`] for meshes with holes.
    pub volume: f64,
    /// Centre of mass [m].
    pub center: DVec3,
    /// Inertia tensor about the centre of mass at unit density [m^5].
    pub inertia: DMat3,
}

impl TriMesh {
    /// Counts and measures; the mesh must pass [`TriMesh::check`].
    pub fn info(&self) -> MeshInfo {
        let properties = self.mass_properties();
        MeshInfo {
            vertices: self.positions.len(),
            triangles: self.triangles.len(),
            parts: self.parts(),
            watertight: self.is_watertight(),
            bounds: self.bounds(),
            volume: properties.volume,
            center: properties.center,
            inertia: properties.inertia,
        }
    }

    /// True if each directed edge has an opposite edge; vertices at equal positions count as equal.
    pub fn is_watertight(&self) -> bool {
        // An edge and its opposite differ only in the sign, so that in sorted order they lie side
        // by side.
        let first_at = self.first_vertex_at_position();
        let mut edges = Vec::with_capacity(3 * self.triangles.len());
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(|vertex| first_at[vertex as usize]);
            for (from, to) in [(a, b), (b, c), (c, a)] {
                if from != to {
                    edges.push((from.min(to), from.max(to), from < to));
                }
            }
        }
        edges.sort_unstable();
        edges
            .chunk_by(|x, y| (x.0, x.1) == (y.0, y.1))
            .all(|same| 2 * same.iter().filter(|edge| edge.2).count() == same.len())
    }

    /// Number of connected parts, vertices at equal positions being one.
    pub fn parts(&self) -> usize {
        // Join the corners of each triangle; a part is known by its lowest vertex.
        let mut sets = DisjointSets::new(self.positions.len());
        for (vertex, first) in self.first_vertex_at_position().into_iter().enumerate() {
            sets.unite(vertex as u32, first);
        }
        for &[a, b, c] in &self.triangles {
            sets.unite(a, b);
            sets.unite(a, c);
        }
        let mut roots: Vec<u32> = self.triangles.iter().map(|&[a, _, _]| sets.root(a)).collect();
        roots.sort_unstable();
        roots.dedup();
        roots.len()
    }

    /// Makes one vertex of all at the same position.
    pub fn weld(&mut self) {
        let first_at = self.first_vertex_at_position();
        for corner in self.triangles.iter_mut().flatten() {
            *corner = first_at[*corner as usize];
        }
        self.drop_unused();
    }

    /// True if a triangle has an area.
    pub(crate) fn has_area(&self, triangle: usize) -> bool {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a) != DVec3::ZERO
    }

    /// Removes triangles without area, and vertices that no triangle uses.
    pub(crate) fn drop_unused(&mut self) {
        let kept = (0..self.triangles.len()).filter(|&triangle| self.has_area(triangle));
        let kept: Vec<[u32; 3]> = kept.map(|triangle| self.triangles[triangle]).collect();
        self.triangles = kept;

        // Renumber the vertices in use, in their order.
        let mut number = vec![0; self.positions.len()];
        for &corner in self.triangles.iter().flatten() {
            number[corner as usize] = 1;
        }
        let mut used = Vec::new();
        for (vertex, number) in number.iter_mut().enumerate().filter(|(_, number)| **number == 1) {
            *number = used.len() as u32;
            used.push(self.positions[vertex]);
        }
        for corner in self.triangles.iter_mut().flatten() {
            *corner = number[*corner as usize];
        }
        self.positions = used;
    }

    /// For each vertex, the lowest one at the same position.
    pub(crate) fn first_vertex_at_position(&self) -> Vec<u32> {
        // Adding zero makes -0 and 0 the same.
        let key = |vertex: u32| {
            (self.positions[vertex as usize] + DVec3::ZERO).to_array().map(f64::to_bits)
        };
        let mut order: Vec<u32> = (0..self.positions.len() as u32).collect();
        order.sort_unstable_by_key(|&vertex| (key(vertex), vertex));
        let mut first_at = vec![0; order.len()];
        for same in order.chunk_by(|&a, &b| key(a) == key(b)) {
            for &vertex in same {
                first_at[vertex as usize] = same[0];
            }
        }
        first_at
    }
}
