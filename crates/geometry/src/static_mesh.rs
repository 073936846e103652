//! Static triangle meshes: environments that other bodies meet triangle by triangle. No volume, any
//! topology.

pub(crate) mod adjacency;
pub(crate) mod box_tree;
pub(crate) mod closed_sheet;
pub(crate) mod compartments;
pub(crate) mod covered_borders;
pub(crate) mod distance;
pub(crate) mod heightfield;
pub(crate) mod kinds;

use crate::mesh::TriMesh;
use adjacency::{Adjacency, around_vertices, find_adjacency};
use box_tree::BoxTree;
use closed_sheet::ClosedSheet;
use frangible_math::check::{Check, Checked};
use glam::{DVec3, Vec3};
use kinds::{EdgeKind, Neighbour, Sides};
use serde::{Deserialize, Serialize};
use std::sync::OnceLock;

/// Smallest height of a triangle over its longest side, relative to that side: the normal of a
/// flatter one is rounding [1].
const LEAST_HEIGHT: f64 = 1e-6;

/// An immutable triangle mesh in its own frame, with its edges and a tree of boxes. About 100 bytes
/// per triangle.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "MeshRecord")]
pub struct StaticMesh {
    positions: Vec<DVec3>,
    /// In the order of the tree.
    triangles: Vec<[u32; 3]>,
    #[serde(skip_serializing)]
    pub(crate) adjacency: Adjacency,
    /// Triangles around each vertex, concatenated, and where each vertex's begin.
    #[serde(skip_serializing)]
    around: Vec<u32>,
    #[serde(skip_serializing)]
    begins: Vec<u32>,
    #[serde(skip_serializing)]
    tree: BoxTree,
    sides: Sides,
    /// If it is two-sided and closed.
    #[serde(skip_serializing)]
    closed: Option<Box<ClosedSheet>>,
    /// A closed sheet as it is seen from the outside, then from the inside of each surface; made when
    /// somebody is there.
    #[serde(skip_serializing)]
    seen: Vec<OnceLock<Box<Self>>>,
    dropped: usize,
}

/// What a snapshot holds of a mesh: all else follows. Triangles in the order of a tree make the
/// same tree again.
#[derive(Deserialize)]
struct MeshRecord {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    sides: Sides,
    dropped: usize,
}

impl TryFrom<MeshRecord> for StaticMesh {
    type Error = String;

    fn try_from(record: MeshRecord) -> Result<Self, String> {
        let MeshRecord { positions, triangles, sides, dropped } = record;
        let mesh = TriMesh { positions, triangles };
        mesh.check("a mesh").map_err(|error| error.to_string())?;
        let mesh = Self::new(&mesh, sides).ok_or("a mesh without area")?;
        Ok(Self { dropped, ..mesh })
    }
}

impl Check for StaticMesh {
    fn check(&self) -> Checked {
        // It is checked before it is made.
        Ok(())
    }
}

impl StaticMesh {
    /// Welds vertices at equal positions, drops triangles without an area, and sorts the rest into
    /// a tree. `None` if nothing is left. The mesh must pass [`TriMesh::check`].
    pub fn new(mesh: &TriMesh, sides: Sides) -> Option<Self> {
        let (positions, mut triangles) = welded(mesh);
        let has_area = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
            let doubled = (b - a).cross(c - a).length();
            let longest = (b - a).length_squared().max((c - b).length_squared());
            doubled > LEAST_HEIGHT * longest.max((a - c).length_squared())
        };
        triangles.retain(has_area);
        if triangles.is_empty() {
            return None;
        }
        let dropped = mesh.triangles.len() - triangles.len();
        let boxes: Vec<[Vec3; 2]> =
            triangles.iter().map(|corners| box_tree::box_around(&positions, corners)).collect();
        let (tree, order) = BoxTree::new(&boxes);
        let triangles: Vec<[u32; 3]> =
            order.iter().map(|&triangle| triangles[triangle as usize]).collect();
        let adjacency = find_adjacency(&positions, &triangles, sides);
        let (begins, around) = around_vertices(positions.len(), &triangles);
        let closed = (sides == Sides::Two)
            .then(|| ClosedSheet::of(&positions, &triangles, &adjacency).map(Box::new))
            .flatten();
        let sides_seen = closed.as_ref().map_or(0, |closed| closed.volumes.len() + 1);
        let seen = vec![OnceLock::new(); sides_seen];
        let mut built = Self {
            positions,
            triangles,
            adjacency,
            around,
            begins,
            tree,
            sides,
            closed,
            seen,
            dropped,
        };
        built.flatten_covered_borders();
        built.adjacency.mark_owners(&built.triangles, &built.begins, &built.around);
        let Self { tree, adjacency, .. } = &mut built;
        tree.mark(|triangle| !adjacency.owns_nothing(triangle));
        Some(built)
    }

    /// Vertices [m].
    pub fn positions(&self) -> &[DVec3] {
        &self.positions
    }

    /// Three vertex indices each.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// Number of given triangles that were dropped because they have no area.
    pub fn dropped(&self) -> usize {
        self.dropped
    }

    /// Solid sides.
    pub fn sides(&self) -> Sides {
        self.sides
    }

    /// Lowest and highest corner [m], rounded outwards to single precision.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.tree.bounds()
    }

    /// The three corners of a triangle [m].
    #[inline]
    pub fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [self.positions[a as usize], self.positions[b as usize], self.positions[c as usize]]
    }

    /// Unit normal of a triangle, out of its front.
    #[inline]
    pub fn normal(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a).normalize_or(DVec3::Y)
    }

    /// The triangle across the edge that begins at a corner (0, 1 or 2).
    #[inline]
    pub fn neighbour(&self, triangle: usize, corner: usize) -> Option<Neighbour> {
        self.adjacency.neighbour(triangle, corner)
    }

    /// Unit normal of the neighbour across an edge, for this triangle's front.
    #[inline]
    pub fn neighbour_normal(&self, triangle: usize, corner: usize) -> Option<DVec3> {
        let Neighbour { triangle, is_flipped } = self.neighbour(triangle, corner)?;
        let normal = self.normal(triangle);
        Some(if is_flipped { -normal } else { normal })
    }

    /// Kind of the edge that begins at a corner.
    #[inline]
    pub fn edge_kind(&self, triangle: usize, corner: usize) -> EdgeKind {
        self.adjacency.kind(triangle, corner)
    }

    /// True if a triangle is the one that stands for an edge which a body may touch: not flat, and
    /// not concave unless it has a convex back.
    #[inline]
    pub fn owns_edge(&self, triangle: usize, corner: usize) -> bool {
        match self.edge_kind(triangle, corner) {
            EdgeKind::Flat => false,
            EdgeKind::Border => true,
            EdgeKind::Concave if self.sides == Sides::One => false,
            EdgeKind::Concave | EdgeKind::Convex => {
                self.neighbour(triangle, corner).is_none_or(|other| triangle <= other.triangle)
            }
        }
    }

    /// True if a triangle is the one that stands for a corner which a body may touch: at least two
    /// of the edges there are neither flat nor concave.
    #[inline]
    pub fn owns_vertex(&self, triangle: usize, corner: usize) -> bool {
        self.adjacency.owns_vertex(triangle, corner)
    }

    /// True if a triangle stands for no edge and no vertex.
    #[inline]
    pub fn owns_nothing(&self, triangle: usize) -> bool {
        self.adjacency.owns_nothing(triangle)
    }

    /// Triangles around a vertex.
    #[inline]
    pub fn around(&self, vertex: usize) -> &[u32] {
        &self.around[self.begins[vertex] as usize..self.begins[vertex + 1] as usize]
    }

    /// True if no edge at a vertex leaves it by more than `tolerance` (the sine of the angle) along
    /// a unit direction: the vertex is the furthest along it, around itself.
    pub fn is_peak(&self, vertex: usize, direction: DVec3, tolerance: f64) -> bool {
        let peak = self.positions[vertex];
        let others = self.around(vertex).iter().flat_map(|&t| self.triangles[t as usize]);
        others.filter(|&other| other as usize != vertex).all(|other| {
            let edge = self.positions[other as usize] - peak;
            edge.dot(direction) <= tolerance * edge.length()
        })
    }

    /// Calls `visit` with the triangles of all leaves whose boxes (lowest and highest corner [m])
    /// pass `enters`, as do all boxes above them.
    #[inline]
    pub fn visit(&self, enters: impl FnMut(DVec3, DVec3) -> bool, visit: impl FnMut(usize)) {
        self.tree.visit(false, enters, visit);
    }

    /// The same with triangles that stand for an edge or a corner, and some beside them.
    #[inline]
    pub fn visit_features(
        &self,
        enters: impl FnMut(DVec3, DVec3) -> bool,
        visit: impl FnMut(usize),
    ) {
        self.tree.visit(true, enters, visit);
    }

    /// Calls `visit` with all triangles whose own boxes meet a box [m].
    #[inline]
    pub fn visit_box(&self, low: DVec3, high: DVec3, mut visit: impl FnMut(usize)) {
        let meets = |box_low: DVec3, box_high: DVec3| {
            box_low.cmple(high).all() && low.cmple(box_high).all()
        };
        self.tree.visit(false, meets, |triangle| {
            let [a, b, c] = self.corners(triangle);
            if meets(a.min(b).min(c), a.max(b).max(c)) {
                visit(triangle);
            }
        });
    }

    /// Calls `visit` with all triangles whose leaves' boxes come within `margin` [m] of a straight
    /// way.
    pub fn visit_way(&self, [from, to]: [DVec3; 2], margin: f64, visit: impl FnMut(usize)) {
        let middle = 0.5 * (from + to);
        let half = 0.5 * (to - from);
        let reach = half.abs();
        // Axes of the box, and the cross products of its axes with the way [Eri05 sec. 5.3.3].
        self.tree.visit(
            false,
            |low, high| {
                let size = 0.5 * (high - low) + margin;
                let off = middle - 0.5 * (low + high);
                let away = off.abs();
                if away.cmpgt(size + reach).any() {
                    return false;
                }
                let across = |u: f64, v: f64, most: f64| (u - v).abs() <= most;
                let slack = 1e-12 * (size.max_element() + reach.max_element()).powi(2);
                across(off.y * half.z, off.z * half.y, size.y * reach.z + size.z * reach.y + slack)
                    && across(
                        off.z * half.x,
                        off.x * half.z,
                        size.x * reach.z + size.z * reach.x + slack,
                    )
                    && across(
                        off.x * half.y,
                        off.y * half.x,
                        size.x * reach.y + size.y * reach.x + slack,
                    )
            },
            visit,
        );
    }

    /// The mesh as plain triangles.
    pub fn to_tri_mesh(&self) -> TriMesh {
        TriMesh { positions: self.positions.clone(), triangles: self.triangles.clone() }
    }
}

/// Positions that triangles use, each once, in their order, and triangles of them.
fn welded(mesh: &TriMesh) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    const UNUSED: u32 = u32::MAX;
    // Zero has two signs.
    let bits =
        |vertex: u32| (mesh.positions[vertex as usize] + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut sorted: Vec<([u64; 3], u32)> =
        (0..mesh.positions.len() as u32).map(|vertex| (bits(vertex), vertex)).collect();
    sorted.sort_unstable();
    let mut first_at = vec![UNUSED; mesh.positions.len()];
    for same in sorted.chunk_by(|a, b| a.0 == b.0) {
        same.iter().for_each(|&(_, vertex)| first_at[vertex as usize] = same[0].1);
    }
    let mut is_used = vec![false; mesh.positions.len()];
    let used = mesh.triangles.iter().flatten().map(|&vertex| first_at[vertex as usize]);
    used.for_each(|vertex| is_used[vertex as usize] = true);
    let mut positions = Vec::with_capacity(mesh.positions.len());
    let mut index_of = vec![UNUSED; mesh.positions.len()];
    for (vertex, &position) in mesh.positions.iter().enumerate().filter(|&(v, _)| is_used[v]) {
        index_of[vertex] = positions.len() as u32;
        positions.push(position);
    }
    let index = |vertex: u32| index_of[first_at[vertex as usize] as usize];
    (positions, mesh.triangles.iter().map(|corners| corners.map(index)).collect())
}

#[cfg(test)]
mod tests;
