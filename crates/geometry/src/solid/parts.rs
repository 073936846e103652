//! The connected parts of what cuts leave.

use super::Solid;
use super::clip::Loose;
use super::elements::{Edge, Face, FaceOrigin, NONE};
use super::regions::{Side, part_face};
use crate::mass_properties::MassProperties;
use crate::winding_number::triangle_solid_angle;
use frangible_math::DisjointSets;
use glam::DVec3;
use std::f64::consts::PI;

/// A connected part of a solid, and its mass properties at unit density.
#[derive(Clone, Debug)]
pub struct SolidPart {
    /// In the frame of what it was cut out of.
    pub solid: Solid,
    /// By the divergence theorem.
    pub mass: MassProperties,
}

/// The connected parts of more than `least` [m^3], each with its cavities; in the order of their
/// first edges. `face_of` tells of a face's number what it is.
pub(crate) fn connected_parts(
    mut loose: Loose,
    least: f64,
    face_of: impl Fn(u32) -> Face,
) -> Vec<SolidPart> {
    let faces = number_faces(&mut loose.edges, face_of);
    let faces = part_cracks(&loose.vertices, &mut loose.edges, faces);
    let mut sets = DisjointSets::new(faces.len());
    for edge in &loose.edges {
        sets.unite(edge.faces[0], edge.faces[1]);
    }
    let mut number = vec![NONE; faces.len()];
    let mut edges_of: Vec<Vec<Edge>> = Vec::new();
    for edge in &loose.edges {
        let number = &mut number[sets.root(edge.faces[0]) as usize];
        if *number == NONE {
            *number = edges_of.len() as u32;
            edges_of.push(Vec::new());
        }
        edges_of[*number as usize].push(*edge);
    }
    let whole = Solid { vertices: loose.vertices, faces, ..Solid::default() };
    let shells = edges_of.into_iter().map(|edges| {
        let solid = whole.with_edges(edges);
        SolidPart { mass: solid.mass_properties(), solid }
    });
    let (mut outer, inner): (Vec<SolidPart>, Vec<SolidPart>) = shells
        .filter(|part| part.mass.volume.abs() > least)
        .partition(|part| part.mass.volume > 0.0);
    for cavity in inner {
        // The smallest of those around it.
        let point = cavity.solid.point_on_a_face();
        let around = (0..outer.len()).filter(|&at| outer[at].solid.is_around(point));
        let volume = |at: usize| outer[at].mass.volume;
        if let Some(own) = around.min_by(|&a, &b| volume(a).total_cmp(&volume(b))) {
            let solid = std::mem::take(&mut outer[own].solid).beside(cavity.solid);
            outer[own] = SolidPart { mass: solid.mass_properties(), solid };
        }
    }
    outer
}

/// Numbers the faces in the order in which edges have them.
fn number_faces(edges: &mut [Edge], face_of: impl Fn(u32) -> Face) -> Vec<Face> {
    let mut known: Vec<u32> = edges.iter().flat_map(|edge| edge.faces).collect();
    known.sort_unstable();
    known.dedup();
    let place = |face: u32| known.partition_point(|&other| other < face);
    let mut number = vec![NONE; known.len()];
    let mut faces = Vec::with_capacity(known.len());
    for face in edges.iter_mut().flat_map(|edge| &mut edge.faces) {
        let number = &mut number[place(*face)];
        if *number == NONE {
            *number = faces.len() as u32;
            faces.push(face_of(*face));
        }
        *face = *number;
    }
    faces
}

/// Makes several faces of cracks that are several polygons.
fn part_cracks(vertices: &[DVec3], edges: &mut [Edge], mut faces: Vec<Face>) -> Vec<Face> {
    let mut sides: Vec<Vec<(Side, usize, usize)>> = vec![Vec::new(); faces.len()];
    for (index, &Edge { ends: [a, b], faces: both }) in edges.iter().enumerate() {
        for (slot, side) in [[a, b], [b, a]].into_iter().enumerate() {
            let face = both[slot] as usize;
            if faces[face].origin == FaceOrigin::Crack {
                sides[face].push((side, index, slot));
            }
        }
    }
    for (face, sides) in sides.iter().enumerate().filter(|(_, sides)| sides.len() > 3) {
        let first = faces.len() - 1;
        let normal = faces[face].plane.normal;
        let count = part_face(vertices, normal, sides, |edge, slot, region| {
            if region > 0 {
                edges[edge].faces[slot] = (first + region) as u32;
            }
        });
        faces.resize(faces.len() + count - 1, faces[face]);
    }
    faces
}

impl Solid {
    /// The part of some edges.
    fn with_edges(&self, mut edges: Vec<Edge>) -> Self {
        let mut part = Self::default();
        let mut number = vec![NONE; self.vertices.len()];
        let mut number_of_face = vec![NONE; self.faces.len()];
        for edge in &mut edges {
            for end in &mut edge.ends {
                let own = &mut number[*end as usize];
                if *own == NONE {
                    *own = part.vertices.len() as u32;
                    part.vertices.push(self.vertices[*end as usize]);
                }
                *end = *own;
            }
            for face in &mut edge.faces {
                let own = &mut number_of_face[*face as usize];
                if *own == NONE {
                    *own = part.faces.len() as u32;
                    part.faces.push(self.faces[*face as usize]);
                }
                *face = *own;
            }
        }
        part.edges = edges;
        part
    }

    /// Both as one: a shell and its cavity.
    pub(crate) fn beside(mut self, other: Self) -> Self {
        let (vertices, faces) = (self.vertices.len() as u32, self.faces.len() as u32);
        self.vertices.extend(other.vertices);
        self.faces.extend(other.faces);
        self.edges.extend(other.edges.iter().map(|edge| Edge {
            ends: edge.ends.map(|end| end + vertices),
            faces: edge.faces.map(|face| face + faces),
        }));
        self
    }

    /// The mean corner of a face: of a convex one it touches nothing else, unlike a vertex.
    fn point_on_a_face(&self) -> DVec3 {
        let is_triangle = |face: &Face| matches!(face.origin, FaceOrigin::Triangle(_));
        let face = self.faces.iter().position(is_triangle).unwrap_or(0) as u32;
        let (mut sum, mut count) = (DVec3::ZERO, 0.0);
        for edge in self.edges.iter().filter(|edge| edge.faces.contains(&face)) {
            sum += edge.ends.iter().map(|&end| self.vertices[end as usize]).sum::<DVec3>();
            count += 2.0;
        }
        sum / count
    }

    /// True if the surface runs around a point: by the solid angles of the faces' fans.
    pub(crate) fn is_around(&self, point: DVec3) -> bool {
        let mut angle = 0.0;
        self.fans(|corners| angle += triangle_solid_angle(point, &corners));
        angle > 2.0 * PI
    }
}
