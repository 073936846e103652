//! Neighbours of triangles, and how the surface bends across their edges.

use crate::static_mesh::kinds::{EdgeKind, Neighbour, Sides};
use glam::DVec3;

/// Sine of the largest angle across a flat edge [rad]. A dome of triangles with a hundredth of a
/// degree between them keeps its edges; a floor whose vertices are rounded to single precision
/// costs a little more with them, and behaves the same.
const FLAT: f64 = 1e-4;

const NONE: u32 = u32::MAX;
const FLIPPED: u32 = 1 << 31;

/// Of each triangle, the neighbours and kinds of its three edges.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Adjacency {
    /// The highest bit says that the neighbour runs the other way round.
    neighbours: Vec<[u32; 3]>,
    /// Two bits for each edge.
    kinds: Vec<u8>,
    /// A bit for each corner that the triangle stands for, and one if it stands for an edge.
    owns: Vec<u8>,
}

impl Adjacency {
    #[inline]
    pub(crate) fn neighbour(&self, triangle: usize, corner: usize) -> Option<Neighbour> {
        let word = self.neighbours[triangle][corner];
        let neighbour =
            Neighbour { triangle: (word & !FLIPPED) as usize, is_flipped: word & FLIPPED != 0 };
        (word != NONE).then_some(neighbour)
    }

    #[inline]
    pub(crate) fn kind(&self, triangle: usize, corner: usize) -> EdgeKind {
        match self.kinds[triangle] >> (2 * corner) & 3 {
            0 => EdgeKind::Flat,
            1 => EdgeKind::Convex,
            2 => EdgeKind::Concave,
            _ => EdgeKind::Border,
        }
    }

    pub(crate) fn set_kind(&mut self, triangle: usize, corner: usize, kind: EdgeKind) {
        let bits = match kind {
            EdgeKind::Flat => 0,
            EdgeKind::Convex => 1,
            EdgeKind::Concave => 2,
            EdgeKind::Border => 3,
        };
        let word = &mut self.kinds[triangle];
        *word = *word & !(3 << (2 * corner)) | bits << (2 * corner);
    }

    #[inline]
    pub(crate) fn owns_vertex(&self, triangle: usize, corner: usize) -> bool {
        self.owns[triangle] >> corner & 1 == 1
    }

    #[inline]
    pub(crate) fn owns_nothing(&self, triangle: usize) -> bool {
        self.owns[triangle] == 0
    }

    /// Pairs those of many triangles at an edge, solid behind, that face each other across the free
    /// space around it: solids that touch along the edge.
    fn pair_around_edge(
        &mut self,
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        same: &[(u32, u32, u32)],
    ) {
        let [from, to] = [same[0].0, same[0].1];
        let origin = positions[from as usize];
        let along = (positions[to as usize] - origin).normalize_or(DVec3::X);
        let across = along.any_orthonormal_vector();
        let up = along.cross(across);
        // Angle around the edge, and whether the front looks to larger angles.
        let mut around: Vec<(f64, bool, usize, usize)> = same
            .iter()
            .map(|&(.., side)| {
                let (triangle, corner) = (side as usize / 3, side as usize % 3);
                let corners = &triangles[triangle];
                let into = positions[corners[(corner + 2) % 3] as usize] - origin;
                let angle = libm::atan2(into.dot(up), into.dot(across));
                (angle, corners[corner] == from, triangle, corner)
            })
            .collect();
        around.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.2.cmp(&b.2)));
        let count = around.len();
        // Triangles at one angle face each other, or away from each other: what pairs more.
        let pairs = |faces_up_first: bool| -> Vec<[usize; 2]> {
            let mut order: Vec<usize> = (0..count).collect();
            let (mut begin, mut sorted) = (0, Vec::with_capacity(count));
            while begin < count {
                let is_equal = |&&at: &&usize| around[at].0 - around[begin].0 <= FLAT;
                let end = begin + order[begin..].iter().take_while(is_equal).count();
                order[begin..end].sort_by_key(|&at| around[at].1 != faces_up_first);
                sorted.extend_from_slice(&order[begin..end]);
                begin = end;
            }
            let next = |at: usize| sorted[(at + 1) % count];
            (0..count)
                .map(|at| [sorted[at], next(at)])
                .filter(|&[a, b]| around[a].1 && !around[b].1)
                .collect()
        };
        let [facing, away] = [pairs(true), pairs(false)];
        let best = if facing.len() >= away.len() { facing } else { away };
        for [a, b] in best {
            let (first, second) = (around[a], around[b]);
            let wedge = second.0 - first.0;
            let wedge = if wedge < -FLAT { wedge + std::f64::consts::TAU } else { wedge };
            let bend = wedge - std::f64::consts::PI;
            let kind = if bend.abs() <= FLAT {
                EdgeKind::Flat
            } else if bend > 0.0 {
                EdgeKind::Convex
            } else {
                EdgeKind::Concave
            };
            self.neighbours[first.2][first.3] = second.2 as u32;
            self.neighbours[second.2][second.3] = first.2 as u32;
            self.set_kind(first.2, first.3, kind);
            self.set_kind(second.2, second.3, kind);
        }
    }

    /// Marks the triangle that stands for each vertex with at least two edges that are not flat,
    /// and the triangles with such edges.
    pub(crate) fn mark_owners(&mut self, triangles: &[[u32; 3]], begins: &[u32], around: &[u32]) {
        let bends = |kind: EdgeKind| kind != EdgeKind::Flat;
        for triangle in 0..triangles.len() {
            let has_edge = (0..3).any(|corner| bends(self.kind(triangle, corner)));
            self.owns[triangle] |= u8::from(has_edge) << 3;
        }
        for vertex in 0..begins.len() - 1 {
            let range = begins[vertex] as usize..begins[vertex + 1] as usize;
            let Some(&owner) = around[range.clone()].first() else { continue };
            // Each edge of two triangles is counted twice.
            let (mut doubled, mut at_owner) = (0, 0);
            for &triangle in &around[range] {
                let corners = &triangles[triangle as usize];
                let at = (0..3).find(|&at| corners[at] as usize == vertex).unwrap_or(0);
                if triangle == owner {
                    at_owner = at;
                }
                for corner in [at, (at + 2) % 3] {
                    doubled += match self.kind(triangle as usize, corner) {
                        EdgeKind::Flat => 0,
                        EdgeKind::Convex | EdgeKind::Concave => 1,
                        EdgeKind::Border => 2,
                    };
                }
            }
            if doubled >= 4 {
                self.owns[owner as usize] |= 1 << at_owner;
            }
        }
    }
}

/// Pairs the triangles at each edge and tells how they bend.
pub(crate) fn find_adjacency(
    positions: &[DVec3],
    triangles: &[[u32; 3]],
    sides: Sides,
) -> Adjacency {
    let mut adjacency = Adjacency {
        neighbours: vec![[NONE; 3]; triangles.len()],
        kinds: vec![0xff; triangles.len()],
        owns: vec![0; triangles.len()],
    };
    let mut edges: Vec<(u32, u32, u32)> = Vec::with_capacity(3 * triangles.len());
    for (triangle, corners) in triangles.iter().enumerate() {
        for corner in 0..3 {
            let (from, to) = (corners[corner], corners[(corner + 1) % 3]);
            edges.push((from.min(to), from.max(to), (3 * triangle + corner) as u32));
        }
    }
    edges.sort_unstable();
    for same in edges.chunk_by(|a, b| (a.0, a.1) == (b.0, b.1)) {
        let &[(.., first), (.., second)] = same else {
            if sides == Sides::One && same.len() > 2 {
                adjacency.pair_around_edge(positions, triangles, same);
            }
            continue;
        };
        let [first, second] = [first, second].map(|side| (side as usize / 3, side as usize % 3));
        let is_flipped = triangles[first.0][first.1] == triangles[second.0][second.1];
        let flag = if is_flipped { FLIPPED } else { 0 };
        adjacency.neighbours[first.0][first.1] = second.0 as u32 | flag;
        adjacency.neighbours[second.0][second.1] = first.0 as u32 | flag;
        let kind = bend(positions, triangles, [first, second]);
        let of_second = match kind {
            EdgeKind::Convex if is_flipped => EdgeKind::Concave,
            EdgeKind::Concave if is_flipped => EdgeKind::Convex,
            kind => kind,
        };
        adjacency.set_kind(first.0, first.1, kind);
        adjacency.set_kind(second.0, second.1, of_second);
    }
    adjacency
}

/// How the surface bends across an edge, seen from the first triangle's front.
fn bend(positions: &[DVec3], triangles: &[[u32; 3]], sides: [(usize, usize); 2]) -> EdgeKind {
    let corner = |(triangle, corner): (usize, usize), next: usize| {
        positions[triangles[triangle][(corner + next) % 3] as usize]
    };
    let [first, second] = sides;
    let (from, to) = (corner(first, 0), corner(first, 1));
    let along = (to - from).normalize_or(DVec3::X);
    // From the edge into each triangle, at right angles to it.
    let into = |side: (usize, usize)| {
        let inward = corner(side, 2) - from;
        (inward - inward.dot(along) * along).normalize_or(DVec3::Y)
    };
    let (into_first, into_second) = (into(first), into(second));
    let normal = along.cross(into_first);
    let height = into_second.dot(normal);
    if into_first.dot(into_second) < 0.0 {
        if height.abs() <= FLAT {
            EdgeKind::Flat
        } else if height < 0.0 {
            EdgeKind::Convex
        } else {
            EdgeKind::Concave
        }
    } else if height.abs() <= FLAT {
        // Folded onto itself: both ends of the fold are borders.
        EdgeKind::Border
    } else if height < 0.0 {
        EdgeKind::Convex
    } else {
        EdgeKind::Concave
    }
}

/// Where the triangles around each vertex begin in the list of them all, and the list.
pub(crate) fn around_vertices(vertices: usize, triangles: &[[u32; 3]]) -> (Vec<u32>, Vec<u32>) {
    let mut begins = vec![0_u32; vertices + 1];
    triangles.iter().flatten().for_each(|&vertex| begins[vertex as usize + 1] += 1);
    for vertex in 0..vertices {
        begins[vertex + 1] += begins[vertex];
    }
    let mut next = begins.clone();
    let mut around = vec![0; 3 * triangles.len()];
    for (triangle, corners) in triangles.iter().enumerate() {
        for &vertex in corners {
            around[next[vertex as usize] as usize] = triangle as u32;
            next[vertex as usize] += 1;
        }
    }
    (begins, around)
}
