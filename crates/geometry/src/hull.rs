//! Convex polyhedra in double precision: exact, and cut exactly.

pub(crate) mod cell_cutter;
pub(crate) mod cell_part;
pub(crate) mod columns;
pub(crate) mod distance;
pub(crate) mod edges;
pub(crate) mod face_loops;
pub(crate) mod flatten;
pub(crate) mod half_edges;
pub(crate) mod plane_clip;
pub(crate) mod quickhull;
pub(crate) mod round;
pub(crate) mod rounded;
pub(crate) mod samples;
pub(crate) mod weld;

use crate::half_space::HalfSpace;
use crate::hull::columns::Columns;
use crate::hull::edges::HullEdge;
use crate::mass_properties::MassProperties;
use crate::mesh::{Surface, Tetrahedra, TriMesh};
use columns::LazyColumns;
use face_loops::FaceLoops;
use frangible_math::RigidTransform;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use half_edges::HalfEdgeMesh;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// A convex polyhedron: vertices, polygonal faces and edges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Hull {
    vertices: Vec<DVec3>,
    /// Of the faces.
    planes: Vec<HalfSpace>,
    #[serde(with = "frangible_math::shared")]
    net: Arc<HalfEdgeMesh>,
    #[serde(skip)]
    columns: LazyColumns,
}

/// A polygon of a hull.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HullFace<'a> {
    /// The hull lies inside of it; the normal is outward.
    pub plane: HalfSpace,
    /// Vertex indices, counter-clockwise seen from outside.
    pub vertices: &'a [u32],
    /// Edge indices: from each of the vertices to the next.
    pub edges: &'a [u32],
    /// True for cut faces.
    pub inner: bool,
}

impl Check for Hull {
    fn check(&self) -> Checked {
        let corners = self.net.all_corners();
        let vertices = corners.iter().fold(0, |most, &vertex| most.max(vertex as usize + 1));
        let fits = vertices == self.vertices.len() && self.net.faces() == self.planes.len();
        require(fits && vertices > 0, "a polyhedron's vertices and faces")?;
        self.vertices.iter().try_for_each(|&vertex| finite_vector(vertex))?;
        self.planes.iter().try_for_each(Check::check)
    }
}

impl Hull {
    /// The box from `-half` to `half` [m].
    pub fn cuboid(half: DVec3) -> Self {
        // Vertex n is at the high end of the axes of its bits.
        let sign = |bit: usize| if bit & 1 == 1 { 1.0 } else { -1.0 };
        let vertices =
            (0..8).map(|n| half * DVec3::new(sign(n), sign(n >> 1), sign(n >> 2))).collect();
        let (mut loops, mut planes) = (FaceLoops::default(), Vec::with_capacity(6));
        for axis in 0..3 {
            let (high, u, v) = (1 << axis, 1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
            let mut face = |normal: DVec3, corners: [u32; 4]| {
                planes.push(HalfSpace { normal, offset: half[axis] });
                loops.push(false, corners);
            };
            face(DVec3::AXES[axis], [high, high + u, high + u + v, high + v]);
            face(-DVec3::AXES[axis], [0, v, u + v, u]);
        }
        Self::new(vertices, planes, HalfEdgeMesh::of(&loops).unwrap_or_default())
    }

    fn new(vertices: Vec<DVec3>, planes: Vec<HalfSpace>, net: HalfEdgeMesh) -> Self {
        Self { vertices, planes, net: Arc::new(net), columns: LazyColumns::default() }
    }

    /// Its faces and vertices side by side.
    #[inline]
    pub fn columns(&self) -> &Columns {
        self.columns.get_or_find(&self.vertices, &self.planes)
    }

    /// Columns already computed, for prefetching.
    #[inline]
    pub fn known_columns(&self) -> Option<&Columns> {
        self.columns.get()
    }

    /// [m]
    #[inline]
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// At least four.
    pub fn faces(
        &self,
    ) -> impl ExactSizeIterator<Item = HullFace<'_>> + DoubleEndedIterator + Clone {
        (0..self.planes.len()).map(|face| self.face(face))
    }

    /// One of them.
    #[inline]
    pub fn face(&self, face: usize) -> HullFace<'_> {
        HullFace {
            plane: self.planes[face],
            vertices: self.net.corners(face),
            edges: self.net.edges_along(face),
            inner: self.net.is_inner(face),
        }
    }

    /// Planes of the faces, in their order.
    #[inline]
    pub fn planes(&self) -> &[HalfSpace] {
        &self.planes
    }

    /// Each once.
    #[inline]
    pub fn edges(&self) -> &[HullEdge] {
        self.net.edges()
    }

    /// Index of the face and edge lists, for prefetching.
    #[inline]
    pub fn net(&self) -> &[impl Sized + use<>] {
        std::slice::from_ref(&*self.net)
    }

    /// The vertices, then the edges around all faces, one face after the other, for who asks for
    /// memory before it is needed.
    #[inline]
    pub fn sides(&self) -> &[u32] {
        self.net.all_sides()
    }

    /// The two ends of an edge [m].
    #[inline]
    pub(crate) fn edge_ends(&self, edge: usize) -> [DVec3; 2] {
        self.net.edges()[edge].vertices.map(|vertex| self.vertices[vertex as usize])
    }

    /// Lowest and highest corner of the bounding box [m].
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let low = self.vertices.iter().fold(DVec3::INFINITY, |low, &vertex| low.min(vertex));
        let high = self.vertices.iter().fold(DVec3::NEG_INFINITY, |high, &vertex| high.max(vertex));
        (low, high)
    }

    /// The same polyhedron in another frame.
    pub fn transformed(&self, to_from_hull: &RigidTransform) -> Self {
        let (rotation, translation) = (to_from_hull.matrix(), to_from_hull.translation);
        let plane = |plane: &HalfSpace| {
            let normal = rotation * plane.normal;
            HalfSpace { normal, offset: plane.offset + normal.dot(translation) }
        };
        Self {
            vertices: self.vertices.iter().map(|&vertex| rotation * vertex + translation).collect(),
            planes: self.planes.iter().map(plane).collect(),
            net: self.net.clone(),
            columns: LazyColumns::default(),
        }
    }

    /// The same polyhedron with all of its faces tagged as a crack's: of another material than what
    /// it is a part of.
    pub fn all_inner(self) -> Self {
        Self { net: Arc::new(self.net.all_made_by_cuts(true)), ..self }
    }

    /// Volume, centre and inertia at unit density, by the divergence theorem.
    pub fn mass_properties(&self) -> MassProperties {
        // Relative to the mean vertex, to avoid cancellation.
        let middle = self.vertices.iter().sum::<DVec3>() / self.vertices.len() as f64;
        let mut sums = Tetrahedra::default();
        for face in 0..self.planes.len() {
            let corners = self.net.corners(face);
            let lever = |at: usize| self.vertices[corners[at] as usize] - middle;
            let (apex, mut last) = (lever(0), lever(1));
            for at in 2..corners.len() {
                let next = lever(at);
                sums.add([apex, last, next]);
                last = next;
            }
        }
        sums.mass_properties(middle)
    }

    /// [m^3]
    pub fn volume(&self) -> f64 {
        // Tetrahedra from a vertex, to avoid cancellation.
        let origin = self.vertices[0];
        let tetrahedron = |corners: [u32; 3]| {
            let [a, b, c] = corners.map(|vertex| self.vertices[vertex as usize] - origin);
            a.dot(b.cross(c))
        };
        self.triangles().map(tetrahedron).sum::<f64>() / 6.0
    }

    /// The closed surface, its faces cut into fans of triangles.
    pub fn surface(&self) -> TriMesh {
        TriMesh { positions: self.vertices.clone(), triangles: self.triangles().collect() }
    }

    /// The closed surface with its cracks' faces tagged.
    pub fn tagged_surface(&self) -> Surface {
        let mut surface = Surface::default();
        self.add_surface(&mut surface, |face| self.net.is_inner(face));
        surface
    }

    /// Adds the closed surface to another one, with a tag for each face.
    pub(crate) fn add_surface(&self, to: &mut Surface, is_inner: impl Fn(usize) -> bool) {
        let count = |face: usize| self.net.corners(face).len() - 2;
        let of_triangle: Vec<usize> = (0..self.planes.len())
            .flat_map(|face| std::iter::repeat_n(face, count(face)))
            .collect();
        let normals: Vec<DVec3> =
            of_triangle.iter().map(|&face| self.planes[face].normal).collect();
        let interior = of_triangle.iter().map(|&face| is_inner(face)).collect();
        let own = Surface::with_coordinates(self.surface(), interior, &normals);
        let first = to.mesh.positions.len() as u32;
        to.mesh.positions.extend(own.mesh.positions);
        to.mesh
            .triangles
            .extend(own.mesh.triangles.iter().map(|corners| corners.map(|corner| first + corner)));
        to.interior.extend(own.interior);
        to.coordinates.extend(own.coordinates);
    }

    /// A fan for each face, in their order.
    fn triangles(&self) -> impl Iterator<Item = [u32; 3]> + Clone {
        (0..self.planes.len()).flat_map(move |face| {
            let apex = self.net.corners(face)[0];
            self.net.corners(face)[1..].windows(2).map(move |pair| [apex, pair[0], pair[1]])
        })
    }

    /// The polyhedron of these faces. Vertices that lie between two faces only, on a straight edge,
    /// are left out, and so are faces that have lost all but two. `None` if what is left is not
    /// closed.
    fn from_loops(
        vertices: &[DVec3],
        mut planes: Vec<HalfSpace>,
        mut loops: FaceLoops,
    ) -> Option<Self> {
        loops.straighten(vertices.len(), &mut planes);
        let mut corners = Vec::with_capacity(vertices.len());
        loops.renumber(vertices, &mut corners);

        // Euler's formula distinguishes a sphere from other closed surfaces.
        let net = HalfEdgeMesh::of(&loops)?;
        let is_sphere = planes.len() >= 4 && corners.len() + planes.len() == net.edges().len() + 2;
        is_sphere.then(|| Self::new(corners, planes, net))
    }
}
