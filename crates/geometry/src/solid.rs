//! Closed polyhedral solids, of any form and with cavities, cut exactly by planes.
//!
//! A face is a set of directed edges in a plane: a polygon, one with holes, or several. Each edge
//! belongs to two faces, which it runs around in opposite directions. A cut keeps that so whatever
//! rounding does to the vertices: what it leaves is closed by construction, and its volume is the
//! sum over edges.

pub(crate) mod cell_tree;
pub(crate) mod clip;
pub(crate) mod contact_hulls;
pub(crate) mod convex_parts;
pub(crate) mod elements;
mod joining;
pub(crate) mod parts;
mod quick_hull;
pub(crate) mod regions;
pub(crate) mod united;

use crate::half_space::HalfSpace;
use crate::mass_properties::MassProperties;
use crate::mesh::{Surface, Tetrahedra, TriMesh};
use crate::mesh_boundary::MeshBoundary;
use elements::{Edge, Face, FaceOrigin, NONE};
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use regions::{linked, loops_of_faces, triangulate_face};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::sync::OnceLock;

/// A closed polyhedral solid.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Solid {
    /// [m]
    vertices: Vec<DVec3>,
    edges: Vec<Edge>,
    faces: Vec<Face>,
    /// Made when it is asked for.
    #[serde(skip)]
    boundary: OnceLock<MeshBoundary>,
}

impl Check for Solid {
    fn check(&self) -> Checked {
        self.vertices.iter().try_for_each(|&vertex| finite_vector(vertex))?;
        self.faces.iter().try_for_each(|face| face.plane.check())?;
        let fits = |edge: &Edge| {
            edge.ends.iter().all(|&end| (end as usize) < self.vertices.len())
                && edge.faces.iter().all(|&face| (face as usize) < self.faces.len())
        };
        require(!self.edges.is_empty() && self.edges.iter().all(fits), "edges of a solid")?;
        require(self.is_closed(), "a closed solid")
    }
}

impl Solid {
    /// The solid in a closed mesh: each directed edge has an opposite one. `None` if it is open, or
    /// without a volume. Triangles without an area are left out where their neighbours close
    /// without them.
    pub fn of_mesh(mesh: &TriMesh) -> Option<Self> {
        Self::of_triangles(mesh, |triangle| triangle)
    }

    /// The same of parts of the triangles with other numbers.
    fn of_triangles(mesh: &TriMesh, number: impl Fn(u32) -> u32) -> Option<Self> {
        /// From a vertex to another one, in a face.
        type Side = (u32, u32, u32);
        let mut directed: Vec<Side> = Vec::with_capacity(3 * mesh.triangles.len());
        let mut faces = Vec::with_capacity(mesh.triangles.len());
        for (&[a, b, c], triangle) in mesh.triangles.iter().zip(0..) {
            let normal = mesh.vector_area(triangle as usize).normalize_or(DVec3::Y);
            let offset = normal.dot(mesh.positions[a as usize]);
            let plane = HalfSpace { normal, offset };
            faces.push(Face { plane, origin: FaceOrigin::Triangle(number(triangle)) });
            directed.extend([(a, b, triangle), (b, c, triangle), (c, a, triangle)]);
        }
        directed.retain(|(from, to, _)| from != to);

        // An edge and its opposite lie side by side. Where more than two faces meet, any pairs do.
        let key = |&(from, to, face): &Side| (from.min(to), from.max(to), face);
        directed.sort_unstable_by_key(key);
        let mut edges = Vec::with_capacity(directed.len() / 2);
        for same in directed.chunk_by(|a, b| (key(a).0, key(a).1) == (key(b).0, key(b).1)) {
            let (up, down): (Vec<Side>, Vec<Side>) = same.iter().partition(|side| side.0 < side.1);
            if up.len() != down.len() {
                return None;
            }
            edges.extend(
                up.iter()
                    .zip(&down)
                    .map(|(a, b)| Edge { ends: [a.0, a.1], faces: [a.2, b.2] })
                    .filter(|edge| edge.faces[0] != edge.faces[1]),
            );
        }
        let solid = Self { vertices: mesh.positions.clone(), edges, faces, ..Self::default() };
        (solid.mass_properties().volume > 0.0).then_some(solid)
    }

    /// [m]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// Each once.
    pub fn edges(&self) -> &[Edge] {
        &self.edges
    }

    /// In no order that matters.
    pub fn faces(&self) -> &[Face] {
        &self.faces
    }

    /// Lowest and highest corner of the bounding box [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds_in(&RigidTransform::IDENTITY)
    }

    /// The same in another frame.
    pub(crate) fn bounds_in(&self, to_from_solid: &RigidTransform) -> (DVec3, DVec3) {
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.vertices.iter().fold(none, |(low, high), &vertex| {
            let place = to_from_solid.point(vertex);
            (low.min(place), high.max(place))
        })
    }

    /// Volume, centre and inertia at unit density, by the divergence theorem [Su09 sec. 4.4].
    pub fn mass_properties(&self) -> MassProperties {
        let (low, high) = self.bounds();
        let middle = 0.5 * (low + high);
        let mut sums = Tetrahedra::default();
        self.fans(|corners| sums.add(corners.map(|corner| corner - middle)));
        sums.mass_properties(middle)
    }

    /// Visits triangles that make up each face as a fan from one of its vertices: all of a triangle
    /// and of a convex face, and of others those too that the rest takes away again.
    pub fn fans(&self, mut visit: impl FnMut([DVec3; 3])) {
        let mut apex = vec![NONE; self.faces.len()];
        for &Edge { ends: [a, b], faces } in &self.edges {
            for (face, [from, to]) in faces.into_iter().zip([[a, b], [b, a]]) {
                let apex = &mut apex[face as usize];
                if *apex == NONE {
                    *apex = from;
                }
                if *apex != from && *apex != to {
                    visit([*apex, from, to].map(|at| self.vertices[at as usize]));
                }
            }
        }
    }

    /// True if each face's edges run around it: as many begin at each of its vertices as end there.
    pub fn is_closed(&self) -> bool {
        let mut turns: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for &Edge { ends: [a, b], faces: [left, right] } in &self.edges {
            for (face, from, to) in [(left, a, b), (right, b, a)] {
                *turns.entry((face, from)).or_default() += 1;
                *turns.entry((face, to)).or_default() -= 1;
            }
        }
        turns.values().all(|&turns| turns == 0)
    }

    /// Closed triangles between its vertices, and the face of each.
    pub fn triangles(&self) -> (TriMesh, Vec<u32>) {
        let (mut triangles, mut of_face) = (Vec::new(), Vec::new());
        for (face, loops) in loops_of_faces(&self.edges, self.faces.len()).into_iter().enumerate() {
            let normal = self.faces[face].plane.normal;
            let own = triangulate_face(&self.vertices, normal, loops);
            of_face.resize(of_face.len() + own.len(), face as u32);
            triangles.extend(own);
        }
        (TriMesh { positions: self.vertices.clone(), triangles }, of_face)
    }

    /// The faces that are cracks, each with its directed edges.
    pub fn cracks(&self) -> Vec<(&Face, Vec<[u32; 2]>)> {
        let mut number = vec![NONE; self.faces.len()];
        let mut cracks: Vec<(&Face, Vec<[u32; 2]>)> = Vec::new();
        for (number, face) in number.iter_mut().zip(&self.faces) {
            if face.origin == FaceOrigin::Crack {
                *number = cracks.len() as u32;
                cracks.push((face, Vec::new()));
            }
        }
        for &Edge { ends: [a, b], faces: [left, right] } in &self.edges {
            for (face, side) in [(left, [a, b]), (right, [b, a])] {
                if let Some((_, sides)) = cracks.get_mut(number[face as usize] as usize) {
                    sides.push(side);
                }
            }
        }
        cracks
    }

    /// Triangles that fill a face with these edges and this normal, by their corners [m].
    pub fn filled(&self, mut sides: Vec<[u32; 2]>, normal: DVec3) -> Vec<[DVec3; 3]> {
        let triangles = triangulate_face(&self.vertices, normal, linked(&mut sides));
        let place = |at: u32| self.vertices[at as usize];
        triangles.into_iter().map(|corners| corners.map(place)).collect()
    }

    /// The triangles that it ends at.
    pub(crate) fn boundary(&self) -> &MeshBoundary {
        self.boundary.get_or_init(|| MeshBoundary::of_mesh(&self.triangles().0))
    }

    /// Signed distance [m] and its unit gradient.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let boundary = self.boundary();
        let Some((at, triangle)) = boundary.nearest(point, |_| true) else {
            return (f64::INFINITY, DVec3::Y);
        };
        let (way, is_inside) = (point - at, self.is_around(point));
        let outward = if is_inside { -way } else { way };
        let normal = outward.try_normalize().unwrap_or_else(|| boundary.normal(triangle));
        (if is_inside { -way.length() } else { way.length() }, normal)
    }

    /// The surface, its cracks tagged, with texture coordinates in metres.
    pub fn surface(&self) -> Surface {
        let (mesh, of_face) = self.triangles();
        let face = |&face: &u32| &self.faces[face as usize];
        let interior = of_face.iter().map(|at| face(at).origin == FaceOrigin::Crack).collect();
        let normals: Vec<DVec3> = of_face.iter().map(|at| face(at).plane.normal).collect();
        Surface::with_coordinates(mesh, interior, &normals)
    }
}

#[cfg(test)]
mod random_solids;
#[cfg(test)]
mod random_tests;
#[cfg(test)]
mod tests;
