//! Which triangles of a file are one cell.

use frangible_geometry::TriMesh;
use glam::DVec3;
use std::collections::BTreeMap;

/// A place in a sentence.
pub(super) fn place(point: DVec3) -> String {
    let short = |number: f64| format!("{}", libm::round(number * 1e4) / 1e4);
    format!("({}, {}, {})", short(point.x), short(point.y), short(point.z))
}

/// The closed parts of a mesh, in the order of their first triangles.
///
/// Parts that share a vertex of the file are one. A file may give each face of a cell vertices of
/// its own; then parts that follow one another are one cell until it is closed.
///
/// # Errors
/// If a part is not closed.
pub fn closed_parts(mesh: &TriMesh) -> Result<Vec<TriMesh>, String> {
    // Join the triangles that share a vertex; a part is known by the lowest.
    let mut part_of: Vec<usize> = (0..mesh.positions.len()).collect();
    for triangle in &mesh.triangles {
        let roots = triangle.map(|vertex| root(&mut part_of, vertex as usize));
        let lowest = roots[0].min(roots[1]).min(roots[2]);
        for root in roots {
            part_of[root] = lowest;
        }
    }
    let mut order: Vec<usize> = Vec::new();
    let mut triangles: BTreeMap<usize, Vec<[u32; 3]>> = BTreeMap::new();
    for &triangle in &mesh.triangles {
        let part = root(&mut part_of, triangle[0] as usize);
        let known = triangles.entry(part).or_default();
        if known.is_empty() {
            order.push(part);
        }
        known.push(triangle);
    }

    // Gather them until they are closed.
    let mut cells = Vec::new();
    let mut gathered = Vec::new();
    for part in order {
        gathered.extend(triangles.remove(&part).unwrap_or_default());
        let mut cell = TriMesh { positions: mesh.positions.clone(), triangles: gathered.clone() };
        cell.weld();
        if cell.is_watertight() {
            cells.push(cell);
            gathered.clear();
        }
    }
    if gathered.is_empty() {
        return Ok(cells);
    }
    let rest = TriMesh { positions: mesh.positions.clone(), triangles: gathered };
    let at = open_edge(&rest)
        .map_or(String::new(), |edge| format!(": there is an open edge at {}", place(edge)));
    Err(format!("cell {} is not closed{at}", cells.len()))
}

/// The lowest vertex of a part, with paths to it halved on the way.
fn root(part_of: &mut [usize], mut vertex: usize) -> usize {
    while part_of[vertex] != vertex {
        part_of[vertex] = part_of[part_of[vertex]];
        vertex = part_of[vertex];
    }
    vertex
}

/// The middle of an edge that no other triangle meets in the opposite direction.
pub(super) fn open_edge(mesh: &TriMesh) -> Option<DVec3> {
    let key = |point: DVec3| (point + DVec3::ZERO).to_array().map(f64::to_bits);
    let mut balance: BTreeMap<[[u64; 3]; 2], (i32, DVec3)> = BTreeMap::new();
    for triangle in 0..mesh.triangles.len() {
        let corners = mesh.corners(triangle);
        for side in 0..3 {
            let (start, end) = (corners[side], corners[(side + 1) % 3]);
            let (from, to) = (key(start), key(end));
            let forward = from < to;
            let edge = if forward { [from, to] } else { [to, from] };
            let known = balance.entry(edge).or_insert((0, 0.5 * (start + end)));
            known.0 += if forward { 1 } else { -1 };
        }
    }
    balance.values().find(|(sum, _)| *sum != 0).map(|&(_, middle)| middle)
}
