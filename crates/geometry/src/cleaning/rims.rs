//! Holes, closed by triangles between the vertices of their rims.

use super::pairing::{NONE, Pairing};
use crate::mesh::TriMesh;
use crate::polygon::triangulate;
use frangible_math::DisjointSets;
use glam::DVec3;

/// Triangles that close open rims. Corners have the index `3 t + k`; corners united in `vertices`
/// are one vertex.
pub(super) struct Closed {
    pub(super) vertices: DisjointSets,
    /// Corners of the triangles of each hole.
    pub(super) holes: Vec<Vec<[u32; 3]>>,
}

/// Closes each hole.
pub(super) fn close(pairing: &Pairing, turned: &[bool]) -> Closed {
    let TriMesh { positions, triangles } = &pairing.mesh;
    // Corners that meet along a paired edge are one vertex.
    let mut vertices = DisjointSets::new(3 * triangles.len());
    for half_edge in 0..pairing.partner.len() as u32 {
        let partner = pairing.partner[half_edge as usize];
        if partner != NONE && half_edge < partner {
            let ([a, b], [c, d]) = (corners_of(half_edge), corners_of(partner));
            let same_way = pairing.ends(half_edge)[0] == pairing.ends(partner)[0];
            let (c, d) = if same_way { (c, d) } else { (d, c) };
            vertices.unite(a, c);
            vertices.unite(b, d);
        }
    }

    // Along each open edge, against the direction of its triangle.
    let mut next = vec![NONE; 3 * triangles.len()];
    for half_edge in pairing.open() {
        let [from, to] = corners_of(half_edge).map(|corner| vertices.root(corner));
        let (from, to) = if turned[half_edge as usize / 3] { (to, from) } else { (from, to) };
        next[to as usize] = from;
    }
    let place_of =
        |corner: u32| pairing.place[triangles[corner as usize / 3][corner as usize % 3] as usize];
    let at = |corner: u32| positions[place_of(corner) as usize];

    // Walk along the rims, and cut off a loop whenever a place comes again.
    let mut holes = Vec::new();
    let mut seen_at = vec![NONE; positions.len()];
    for start in 0..next.len() as u32 {
        if next[start as usize] == NONE {
            continue;
        }
        let mut walked: Vec<u32> = Vec::new();
        let mut vertex = start;
        loop {
            let place = place_of(vertex) as usize;
            if seen_at[place] != NONE {
                let rim = walked.split_off(seen_at[place] as usize);
                rim.iter().for_each(|&passed| seen_at[place_of(passed) as usize] = NONE);
                vertices.unite(rim[0], vertex);
                if rim.len() > 2 {
                    holes.push(triangulate(&from_least(rim, &at), &at));
                }
            }
            let to = std::mem::replace(&mut next[vertex as usize], NONE);
            if to == NONE {
                break;
            }
            seen_at[place] = walked.len() as u32;
            walked.push(vertex);
            vertex = to;
        }
        walked.iter().for_each(|&passed| seen_at[place_of(passed) as usize] = NONE);
    }
    Closed { vertices, holes }
}

/// The loop rotated to start at its least vertex by coordinates: a non-planar rim is closed
/// independent of the file's order.
fn from_least(mut rim: Vec<u32>, at: &impl Fn(u32) -> DVec3) -> Vec<u32> {
    let in_order = |&(_, a): &(usize, DVec3), &(_, b): &(usize, DVec3)| {
        a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
    };
    let places = rim.iter().map(|&corner| at(corner)).enumerate();
    let first = places.min_by(in_order).map_or(0, |(first, _)| first);
    rim.rotate_left(first);
    rim
}

/// The corners that a half-edge joins.
fn corners_of(half_edge: u32) -> [u32; 2] {
    let first = half_edge / 3 * 3;
    [half_edge, first + (half_edge - first + 1) % 3]
}
