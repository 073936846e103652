//! Convex polyhedra in double precision: exact, and cut exactly.

mod clip;
mod distance;
mod of_points;
mod samples;

pub use of_points::HullError;
pub use samples::hull_samples;

use crate::{HalfSpace, MassProperties, RigidTransform, TriMesh};
use glam::DVec3;
use std::collections::BTreeMap;

/// A convex polyhedron: vertices, the polygons between them and the edges between those.
#[derive(Clone, Debug, PartialEq)]
pub struct Hull {
    vertices: Vec<DVec3>,
    faces: Vec<HullFace>,
    edges: Vec<HullEdge>,
}

/// A polygon of a hull.
#[derive(Clone, Debug, PartialEq)]
pub struct HullFace {
    /// The hull lies inside of it; the normal is outward.
    pub plane: HalfSpace,
    /// Vertex indices, counter-clockwise seen from outside.
    pub vertices: Vec<u32>,
    /// Edge indices: from each of the vertices to the next.
    pub edges: Vec<u32>,
}

/// A face while a hull is made.
struct Polygon {
    plane: HalfSpace,
    vertices: Vec<u32>,
}

/// An edge of a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullEdge {
    /// Vertex indices, in the order in which the first face has them.
    pub vertices: [u32; 2],
    /// Face indices.
    pub faces: [u32; 2],
}

impl Hull {
    /// The box from `-half` to `half` [m].
    pub fn cuboid(half: DVec3) -> Self {
        // Vertex n is at the high end of the axes of its bits.
        let sign = |bit: usize| if bit & 1 == 1 { 1.0 } else { -1.0 };
        let vertices = (0..8).map(|n| half * DVec3::new(sign(n), sign(n >> 1), sign(n >> 2))).collect();
        let mut faces = Vec::with_capacity(6);
        for axis in 0..3 {
            let (high, u, v) = (1 << axis, 1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let face = |normal: DVec3, vertices: [u32; 4]| Polygon {
                plane: HalfSpace { normal, offset: half[axis] },
                vertices: vertices.to_vec(),
            };
            faces.push(face(DVec3::AXES[axis], [high, high + u, high + u + v, high + v]));
            faces.push(face(-DVec3::AXES[axis], [0, v, u + v, u]));
        }
        let (faces, edges) = connected(faces).unwrap_or_default();
        Self { vertices, faces, edges }
    }

    /// [m]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// At least four.
    pub fn faces(&self) -> &[HullFace] {
        &self.faces
    }

    /// Each once.
    pub fn edges(&self) -> &[HullEdge] {
        &self.edges
    }

    /// The two ends of an edge [m].
    pub fn edge_ends(&self, edge: usize) -> [DVec3; 2] {
        self.edges[edge].vertices.map(|vertex| self.vertices[vertex as usize])
    }

    /// Lowest and highest corner of the bounding box [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.vertices.iter().fold(DVec3::INFINITY, |low, &vertex| low.min(vertex));
        let high = self.vertices.iter().fold(DVec3::NEG_INFINITY, |high, &vertex| high.max(vertex));
        (low, high)
    }

    /// The same polyhedron in another frame.
    pub fn transformed(&self, to_from_hull: &RigidTransform) -> Self {
        let face = |face: &HullFace| {
            let normal = to_from_hull.direction(face.plane.normal);
            let offset = face.plane.offset + normal.dot(to_from_hull.translation);
            HullFace { plane: HalfSpace { normal, offset }, ..face.clone() }
        };
        Self {
            vertices: self.vertices.iter().map(|&vertex| to_from_hull.point(vertex)).collect(),
            faces: self.faces.iter().map(face).collect(),
            edges: self.edges.clone(),
        }
    }

    /// Volume, centre and inertia at unit density, by the divergence theorem.
    pub fn mass_properties(&self) -> MassProperties {
        self.surface().mass_properties()
    }

    /// The closed surface, its faces cut into fans of triangles.
    pub fn surface(&self) -> TriMesh {
        let fan = |face: &HullFace| {
            let apex = face.vertices[0];
            let corners = face.vertices[1..].windows(2);
            corners.map(move |pair| [apex, pair[0], pair[1]]).collect::<Vec<_>>()
        };
        TriMesh { positions: self.vertices.clone(), triangles: self.faces.iter().flat_map(fan).collect() }
    }

    /// The polyhedron of these faces. Vertices that lie between two faces only, on a straight edge, are left out, and so are
    /// faces that have lost all but two. `None` if what is left is not closed.
    fn from_faces(vertices: &[DVec3], mut faces: Vec<Polygon>) -> Option<Self> {
        // Straighten the edges until every vertex is a corner.
        loop {
            let mut faces_at = vec![0_u32; vertices.len()];
            for &vertex in faces.iter().flat_map(|face| &face.vertices) {
                faces_at[vertex as usize] += 1;
            }
            let before = (faces.len(), faces_at.iter().filter(|&&count| count > 0).count());
            for face in &mut faces {
                face.vertices.retain(|&vertex| faces_at[vertex as usize] > 2);
            }
            faces.retain(|face| face.vertices.len() > 2);
            if before == (faces.len(), faces_at.iter().filter(|&&count| count > 2).count()) {
                break;
            }
        }

        // Number the corners that are left in their old order.
        let mut used = vec![false; vertices.len()];
        for &vertex in faces.iter().flat_map(|face| &face.vertices) {
            used[vertex as usize] = true;
        }
        let mut corners = Vec::new();
        let number: Vec<u32> = (0..vertices.len())
            .map(|vertex| {
                if used[vertex] {
                    corners.push(vertices[vertex]);
                }
                corners.len().saturating_sub(1) as u32
            })
            .collect();
        for vertex in faces.iter_mut().flat_map(|face| &mut face.vertices) {
            *vertex = number[*vertex as usize];
        }

        // Euler's formula tells a sphere from anything else that is closed.
        let (faces, edges) = connected(faces)?;
        let is_sphere = faces.len() >= 4 && corners.len() + faces.len() == edges.len() + 2;
        is_sphere.then_some(Self { vertices: corners, faces, edges })
    }
}

/// Faces with the edges between them, in the order of the faces; `None` if an edge does not have two that run along it in
/// opposite directions.
fn connected(polygons: Vec<Polygon>) -> Option<(Vec<HullFace>, Vec<HullEdge>)> {
    let mut face_along: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    for (index, polygon) in polygons.iter().enumerate() {
        for side in sides(&polygon.vertices) {
            if face_along.insert(side, index as u32).is_some() {
                return None;
            }
        }
    }
    let mut edges = Vec::with_capacity(face_along.len() / 2);
    let mut edge_along: BTreeMap<[u32; 2], u32> = BTreeMap::new();
    let mut faces = Vec::with_capacity(polygons.len());
    for (index, Polygon { plane, vertices }) in polygons.into_iter().enumerate() {
        let mut around = Vec::with_capacity(vertices.len());
        for [a, b] in sides(&vertices) {
            let beside = *face_along.get(&[b, a])?;
            // The other face may have come before.
            let edge = edge_along.get(&[b, a]).copied().unwrap_or_else(|| {
                edges.push(HullEdge { vertices: [a, b], faces: [index as u32, beside] });
                edges.len() as u32 - 1
            });
            edge_along.insert([a, b], edge);
            around.push(edge);
        }
        faces.push(HullFace { plane, vertices, edges: around });
    }
    Some((faces, edges))
}

/// The directed edges of a loop.
fn sides(loop_of: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..loop_of.len()).map(|at| [loop_of[at], loop_of[(at + 1) % loop_of.len()]])
}

/// The plane of a loop of points, outward if they run counter-clockwise; none of them lies outside.
fn plane_of(points: impl Iterator<Item = DVec3> + Clone) -> Option<HalfSpace> {
    // Twice the area vector, Newell's way: from the first point, so that nothing large cancels.
    let origin = points.clone().next()?;
    let levers = points.clone().map(|point| point - origin);
    let area: DVec3 = levers.clone().zip(levers.skip(1)).map(|(a, b)| a.cross(b)).sum();
    let normal = area.try_normalize()?;
    let offset = points.map(|point| normal.dot(point)).fold(f64::NEG_INFINITY, f64::max);
    Some(HalfSpace { normal, offset })
}
