//! Half-edge connectivity of a hull.

use super::face_loops::FaceLoops;
use crate::hull::edges::HullEdge;
use frangible_math::check::{Check, Checked, require};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Faces, corners and edges, the same wherever the hull is moved; in two lists, because a break
/// makes thousands of them.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(super) struct HalfEdgeMesh {
    /// Sides of all faces.
    sides: usize,
    /// The vertex that each side begins at, face after face and counter-clockwise seen from
    /// outside; then each side's edge; then where each face's sides end, with [`INNER`] for one
    /// that a cut made.
    indices: Vec<u32>,
    /// Each once.
    edges: Vec<HullEdge>,
    /// Made when something is first cut out: equal bodies break often.
    #[serde(skip)]
    half_edges: OnceLock<HalfEdges>,
}

impl PartialEq for HalfEdgeMesh {
    fn eq(&self, other: &Self) -> bool {
        (self.sides, &self.indices, &self.edges) == (other.sides, &other.indices, &other.edges)
    }
}

/// Linked sides.
#[derive(Debug)]
pub(super) struct HalfEdges {
    /// Face after face.
    pub(super) sides: Vec<Side>,
    /// A side that begins at each vertex.
    pub(super) leaving: Vec<u32>,
}

/// From a vertex to the next around a face, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Where it begins.
    pub(super) origin: u32,
    /// Next side in its face.
    pub(super) next: u32,
    /// The same edge in the other direction, in the face beyond.
    pub(super) twin: u32,
    pub(super) face: u32,
}

/// Bit mark of cut faces.
const INNER: u32 = 1 << 31;

impl Check for HalfEdgeMesh {
    /// Each edge has two sides, one in each direction, and the whole is a sphere [Euler].
    fn check(&self) -> Checked {
        const CLOSED: &str = "a closed polyhedron";
        let twice = self.sides.checked_mul(2).filter(|&twice| twice <= self.indices.len());
        let Some(first_end) = twice else { return Err(CLOSED) };
        let ends = &self.indices[first_end..];
        let mut start = 0;
        for end in ends.iter().map(|&end| (end & !INNER) as usize) {
            require(end >= start + 3 && end <= self.sides, CLOSED)?;
            start = end;
        }
        require(start == self.sides && self.sides == 2 * self.edges.len(), CLOSED)?;

        let mut is_used = vec![false; self.sides];
        let mut sides_of = vec![[false; 2]; self.edges.len()];
        for face in 0..self.faces() {
            let corners = self.corners(face);
            let next = corners.iter().cycle().skip(1);
            for ((&from, &to), &edge) in corners.iter().zip(next).zip(self.edges_along(face)) {
                let Some(edge_of) = self.edges.get(edge as usize) else { return Err(CLOSED) };
                let HullEdge { vertices: [a, b], faces } = *edge_of;
                require(a != b && faces[0] != faces[1], CLOSED)?;
                let side = if (from, to) == (a, b) { 0 } else { 1 };
                let is_side = side == 0 || (from, to) == (b, a);
                require(is_side && faces.contains(&(face as u32)), CLOSED)?;
                let is_known = std::mem::replace(&mut sides_of[edge as usize][side], true);
                require(!is_known, CLOSED)?;
                *is_used.get_mut(from as usize).ok_or(CLOSED)? = true;
            }
        }
        let vertices = is_used.iter().take_while(|&&is_used| is_used).count();
        let is_dense = !is_used[vertices..].contains(&true);
        require(is_dense && vertices + self.faces() == self.edges.len() + 2, CLOSED)
    }
}

impl FaceLoops {
    /// Copies a net, reusing memory.
    pub(super) fn copy_from(&mut self, net: &HalfEdgeMesh) {
        self.clear();
        for face in 0..net.faces() {
            self.push(net.is_inner(face), net.corners(face).iter().copied());
        }
    }
}

impl HalfEdgeMesh {
    /// Of loops; `None` if a side has no other that runs along it in the opposite direction.
    pub(super) fn of(loops: &FaceLoops) -> Option<Self> {
        let (edges_along, edges) = loops.connected()?;
        let sides = edges_along.len();
        let mut indices = Vec::with_capacity(2 * sides + loops.len());
        indices.extend((0..sides).map(|side| loops.corner(side)));
        indices.extend(edges_along);
        indices.extend(
            (0..loops.len()).map(|face| face_end(loops.range(face).end, loops.is_inner(face))),
        );
        Some(Self { sides, indices, edges, half_edges: OnceLock::new() })
    }

    /// Number of faces.
    #[inline]
    pub(super) fn faces(&self) -> usize {
        self.indices.len() - 2 * self.sides
    }

    /// Of a face.
    #[inline]
    pub(super) fn sides(&self, face: usize) -> std::ops::Range<usize> {
        let ends = &self.indices[2 * self.sides..];
        let start = if face == 0 { 0 } else { (ends[face - 1] & !INNER) as usize };
        start..(ends[face] & !INNER) as usize
    }

    /// The vertices around a face.
    #[inline]
    pub(super) fn corners(&self, face: usize) -> &[u32] {
        &self.indices[self.sides(face)]
    }

    /// The edges around a face, from each of its vertices to the next.
    #[inline]
    pub(super) fn edges_along(&self, face: usize) -> &[u32] {
        let range = self.sides(face);
        &self.indices[self.sides + range.start..self.sides + range.end]
    }

    /// The vertices that all sides begin at.
    pub(super) fn all_corners(&self) -> &[u32] {
        &self.indices[..self.sides]
    }

    /// All indices, as they lie in memory.
    #[inline]
    pub(super) fn all_sides(&self) -> &[u32] {
        &self.indices
    }

    /// True for cut faces.
    #[inline]
    pub(super) fn is_inner(&self, face: usize) -> bool {
        self.indices[2 * self.sides + face] & INNER != 0
    }

    /// Each once.
    #[inline]
    pub(super) fn edges(&self) -> &[HullEdge] {
        &self.edges
    }

    /// The sides, to be walked along.
    pub(super) fn half_edges(&self) -> &HalfEdges {
        self.half_edges.get_or_init(|| {
            let vertices = self.indices[..self.sides]
                .iter()
                .fold(0, |most, &vertex| most.max(vertex as usize + 1));
            let (mut sides, mut leaving) = (Vec::with_capacity(self.sides), vec![0; vertices]);
            let mut side_of = vec![u32::MAX; self.edges.len()];
            for face in 0..self.faces() {
                let first = sides.len() as u32;
                for ((&origin, &edge), at) in
                    self.corners(face).iter().zip(self.edges_along(face)).zip(first..)
                {
                    leaving[origin as usize] = at;
                    let twin = std::mem::replace(&mut side_of[edge as usize], at);
                    sides.push(Side { origin, next: at + 1, twin, face: face as u32 });
                }
                if let Some(last) = sides.last_mut() {
                    last.next = first;
                }
            }
            // The second side of an edge knows the first.
            for at in 0..sides.len() {
                if let Some(first) =
                    sides.get(sides[at].twin as usize).map(|_| sides[at].twin as usize)
                {
                    sides[first].twin = at as u32;
                }
            }
            HalfEdges { sides, leaving }
        })
    }

    /// The same faces, all or none of them made by a cut.
    pub(super) fn all_made_by_cuts(&self, inner: bool) -> Self {
        let (indices, edges) = (self.indices.clone(), self.edges.clone());
        let mut net = Self { sides: self.sides, indices, edges, half_edges: OnceLock::new() };
        for end in &mut net.indices[2 * self.sides..] {
            *end = face_end((*end & !INNER) as usize, inner);
        }
        net
    }
}

/// The entry of a face in [`HalfEdgeMesh::indices`].
fn face_end(side: usize, inner: bool) -> u32 {
    side as u32 | if inner { INNER } else { 0 }
}

/// A net of which the sides come face after face, two for each edge.
pub(super) struct HalfEdgeBuilder {
    net: HalfEdgeMesh,
    /// Numbers of sides, edges and faces to date.
    sides: usize,
    edges: u32,
    faces: usize,
}

impl HalfEdgeBuilder {
    /// A builder for `edges` and `faces`.
    pub(super) fn new(edges: usize, faces: usize) -> Self {
        let none = HullEdge { vertices: [0; 2], faces: [0; 2] };
        let indices = vec![0; 4 * edges + faces];
        let net = HalfEdgeMesh {
            sides: 2 * edges,
            indices,
            edges: vec![none; edges],
            half_edges: OnceLock::new(),
        };
        Self { net, sides: 0, edges: 0, faces: 0 }
    }

    /// Adds an edge, of which the second face is not known yet; `None` if there are too many.
    #[inline]
    pub(super) fn add_edge(&mut self, vertices: [u32; 2], face: u32) -> Option<u32> {
        *self.net.edges.get_mut(self.edges as usize)? = HullEdge { vertices, faces: [face; 2] };
        self.edges += 1;
        Some(self.edges - 1)
    }

    /// Says which face is on the other side of an edge.
    #[inline]
    pub(super) fn close_edge(&mut self, edge: u32, face: u32) -> u32 {
        self.net.edges[edge as usize].faces[1] = face;
        edge
    }

    /// Adds a side of the face that is being made; `None` if there are too many.
    #[inline]
    pub(super) fn add_side(&mut self, vertex: u32, edge: u32) -> Option<()> {
        if self.sides == self.net.sides {
            return None;
        }
        self.net.indices[self.sides] = vertex;
        self.net.indices[self.net.sides + self.sides] = edge;
        self.sides += 1;
        Some(())
    }

    /// Makes a face of the sides added since the last face.
    #[inline]
    pub(super) fn end_face(&mut self, inner: bool) {
        self.net.indices[2 * self.net.sides + self.faces] = face_end(self.sides, inner);
        self.faces += 1;
    }

    /// The net, if complete.
    pub(super) fn finished(self) -> Option<HalfEdgeMesh> {
        let Self { net, sides, edges, faces } = self;
        (sides == net.sides && edges as usize == net.edges.len() && faces == net.faces())
            .then_some(net)
    }
}
