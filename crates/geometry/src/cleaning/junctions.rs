//! Edges that end in the middle of another triangle's edge.

use super::pairing::Pairing;
use crate::bvh::Bvh;
use crate::mesh::TriMesh;
use crate::polygon::triangulate;
use glam::DVec3;

/// Triangles, and for each the one of the raw mesh that it is a part of.
pub(super) struct Split {
    pub(super) triangles: Vec<[u32; 3]>,
    pub(super) source: Vec<u32>,
}

/// Divides triangles at the open vertices that lie on their open edges, closer than `tolerance`
/// [m]; `None` if there is none.
pub(super) fn split_at_junctions(
    pairing: &Pairing,
    source: &[u32],
    tolerance: f64,
) -> Option<Split> {
    // The open edges in a tree.
    let TriMesh { positions, triangles } = &pairing.mesh;
    let at = |place: u32| positions[place as usize];
    let open: Vec<u32> = pairing.open().collect();
    let ends: Vec<[u32; 2]> = open.iter().map(|&half_edge| pairing.ends(half_edge)).collect();
    let around = |&[from, to]: &[u32; 2]| {
        let (a, b) = (at(from), at(to));
        (a.min(b) - tolerance, a.max(b) + tolerance)
    };
    let tree = Bvh::of_boxes(&ends.iter().map(around).collect::<Vec<_>>());

    // Which vertices lie on them, and how far along.
    let mut found: Vec<(u32, f64, u32)> = Vec::new();
    for place in pairing.open_places() {
        let point = at(place);
        let enters = |low: DVec3, high: DVec3| point.cmpge(low).all() && point.cmple(high).all();
        tree.visit(enters, |number| {
            let corners = triangles[open[number] as usize / 3];
            if corners.iter().any(|&vertex| pairing.place[vertex as usize] == place) {
                return;
            }
            let [from, to] = ends[number].map(at);
            let way = to - from;
            let along = (point - from).dot(way) / way.length_squared();
            let apart = tolerance / way.length();
            let off = (point - from - along * way).length();
            if off <= tolerance && along > apart && along < 1.0 - apart {
                found.push((open[number], along, place));
            }
        });
    }
    if found.is_empty() {
        return None;
    }
    found.sort_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)).then(a.2.cmp(&b.2)));
    found.dedup_by_key(|&mut (half_edge, _, place)| (half_edge, place));

    // Divide the triangles.
    let mut split = Split { triangles: Vec::new(), source: Vec::new() };
    let mut rest = found.as_slice();
    for (triangle, corners) in triangles.iter().enumerate() {
        let count = rest.partition_point(|&(half_edge, _, _)| half_edge as usize / 3 <= triangle);
        let (own, later) = rest.split_at(count);
        rest = later;
        if own.is_empty() {
            split.triangles.push(*corners);
        } else {
            let mut polygon = Vec::new();
            for (corner, &vertex) in corners.iter().enumerate() {
                polygon.push(vertex);
                let on_edge = own.iter().filter(|split| split.0 as usize % 3 == corner);
                polygon.extend(on_edge.map(|&(_, _, place)| place));
            }
            split
                .triangles
                .extend(triangulate(&polygon, &|vertex| at(pairing.place[vertex as usize])));
        }
        split.source.resize(split.triangles.len(), source[triangle]);
    }
    Some(split)
}
