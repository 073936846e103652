//! The surface of polyhedra that touch: without the faces, and the parts of faces, that they turn
//! to each other.

use crate::bvh::Bvh;
use crate::face_polygon::{corners_of, polygon_area};
use crate::hull::Hull;
use crate::mesh::{Surface, TriMesh};
use glam::DVec3;
use std::collections::BTreeMap;

/// A convex polygon of the surface.
struct Patch {
    /// Counter-clockwise seen from outside [m].
    corners: Vec<DVec3>,
    /// Unit, outward.
    normal: DVec3,
    inner: bool,
}

/// Opposite normals differ by at most this: the square root of twice it is an angle of 0.08
/// degrees.
const OPPOSITE: f64 = 1e-6;

/// The outer surface of some polyhedra; points closer than `close` [m] are one. `beside` finds
/// those that may touch one of them. `None` if it is not closed, as where they overlap.
pub(crate) fn outer_surface(
    hulls: &[&Hull],
    beside: impl Fn(usize) -> Vec<usize>,
    close: f64,
) -> Option<Surface> {
    let mut patches = Vec::new();
    for (index, hull) in hulls.iter().enumerate() {
        let near = beside(index).into_iter().filter(|&other| other != index);
        let others: Vec<&Hull> = near.map(|other| hulls[other]).collect();
        for face in 0..hull.planes().len() {
            patches.extend(uncovered((hull, face), &others, close));
        }
    }
    let (positions, loops) = joined(&patches, close);

    let mut mesh = TriMesh { positions, triangles: Vec::new() };
    let (mut interior, mut normals) = (Vec::new(), Vec::new());
    for (patch, corners) in patches.iter().zip(loops) {
        let first = mesh.triangles.len();
        fill(&mut mesh, &corners, patch.normal, close);
        let count = mesh.triangles.len() - first;
        interior.extend(std::iter::repeat_n(patch.inner, count));
        normals.extend(std::iter::repeat_n(patch.normal, count));
    }
    mesh.is_watertight().then(|| Surface::with_coordinates(mesh, interior, &normals))
}

/// Adds the triangles of a convex loop: a fan around its first corner, or, where that would be flat
/// as corners lie on a side, around its middle.
fn fill(mesh: &mut TriMesh, corners: &[u32], normal: DVec3, close: f64) {
    if corners.len() < 3 {
        return;
    }
    let at = |corner: u32| mesh.positions[corner as usize];
    let fan = |n: usize| [corners[0], corners[n], corners[n + 1]];
    let is_flat = |n: usize| is_narrow(&fan(n).map(at), normal, close);
    if !(1..corners.len() - 1).any(is_flat) {
        mesh.triangles.extend((1..corners.len() - 1).map(fan));
        return;
    }
    let middle = corners.iter().map(|&corner| at(corner)).sum::<DVec3>() / corners.len() as f64;
    let apex = mesh.positions.len() as u32;
    mesh.positions.push(middle);
    let sides = corners.iter().zip(corners.iter().cycle().skip(1));
    mesh.triangles.extend(sides.map(|(&from, &to)| [apex, from, to]));
}

/// The parts of a face that no other polyhedron covers with an opposite face.
fn uncovered((hull, face): (&Hull, usize), others: &[&Hull], close: f64) -> Vec<Patch> {
    let plane = hull.planes()[face];
    let mut left = vec![corners_of(hull, face)];
    for other in others {
        for (at, opposite) in other.planes().iter().enumerate() {
            let covers = opposite.normal.dot(plane.normal) < OPPOSITE - 1.0
                && (opposite.offset + plane.offset).abs() <= close;
            if covers {
                let cover = corners_of(other, at);
                let without = |polygon| outside(polygon, &cover, plane.normal, close);
                left = left.into_iter().flat_map(without).collect();
            }
        }
    }
    let inner = hull.face(face).inner;
    let patch = |corners| Patch { corners, normal: plane.normal, inner };
    left.into_iter().map(patch).collect()
}

/// A convex polygon, counter-clockwise about `normal`, without another one in its plane that runs
/// the other way, in convex polygons. Strips narrower than `close` [m] are left out.
fn outside(polygon: Vec<DVec3>, cover: &[DVec3], normal: DVec3, close: f64) -> Vec<Vec<DVec3>> {
    let mut cut_off = Vec::new();
    let mut inside = polygon.clone();
    for (from, &start) in cover.iter().enumerate() {
        let way = cover[(from + 1) % cover.len()] - start;
        let outward = way.cross(-normal).normalize_or_zero();
        let [left, beyond] = divided(&inside, start, outward, close);
        inside = left;
        cut_off.extend((!is_narrow(&beyond, normal, close)).then_some(beyond));
        if is_narrow(&inside, normal, close) {
            // The cover lies beside the polygon.
            return vec![polygon];
        }
    }
    cut_off
}

/// The parts of a convex polygon before and beyond a line in its plane; what is within `close` [m]
/// lies on the line.
fn divided(polygon: &[DVec3], on_line: DVec3, outward: DVec3, close: f64) -> [Vec<DVec3>; 2] {
    let height = |point: DVec3| {
        let height = outward.dot(point - on_line);
        if height.abs() > close { height } else { 0.0 }
    };
    let mut parts = [Vec::with_capacity(polygon.len() + 1), Vec::with_capacity(polygon.len() + 1)];
    for (from, &corner) in polygon.iter().enumerate() {
        let next = polygon[(from + 1) % polygon.len()];
        let (here, there) = (height(corner), height(next));
        if here <= 0.0 {
            parts[0].push(corner);
        }
        if here >= 0.0 {
            parts[1].push(corner);
        }
        if here * there < 0.0 {
            let point = corner.lerp(next, here / (here - there));
            parts.iter_mut().for_each(|part| part.push(point));
        }
    }
    parts
}

/// True if a polygon is nowhere wider than `close` [m], about.
fn is_narrow(polygon: &[DVec3], normal: DVec3, close: f64) -> bool {
    let sides = polygon.iter().zip(polygon.iter().cycle().skip(1));
    let around: f64 = sides.map(|(a, b)| a.distance(*b)).sum();
    polygon.len() < 3 || polygon_area(polygon, normal) <= close * around
}

/// Common vertices of all patches, and each patch's loop with the vertices that lie on its sides:
/// each side is then a side of one neighbour.
fn joined(patches: &[Patch], close: f64) -> (Vec<DVec3>, Vec<Vec<u32>>) {
    let mut vertices = Vertices { positions: Vec::new(), cells: BTreeMap::new(), close };
    let loops: Vec<Vec<u32>> = patches
        .iter()
        .map(|patch| patch.corners.iter().map(|&corner| vertices.number(corner)).collect())
        .collect();
    let positions = vertices.positions;
    let points: Vec<(DVec3, DVec3)> = positions.iter().map(|&point| (point, point)).collect();
    let tree = Bvh::of_boxes(&points);
    let with_all = |corners: Vec<u32>| {
        let mut all: Vec<u32> = Vec::with_capacity(corners.len());
        for (from, &corner) in corners.iter().enumerate() {
            all.push(corner);
            let next = corners[(from + 1) % corners.len()];
            all.extend(between(&positions, &tree, [corner, next], close));
        }
        all.dedup();
        while all.len() > 1 && all.first() == all.last() {
            all.pop();
        }
        all
    };
    let loops = loops.into_iter().map(with_all).collect();
    (positions, loops)
}

/// Vertices within `close` [m] of a side, without its ends, in their order.
fn between(positions: &[DVec3], tree: &Bvh, ends: [u32; 2], close: f64) -> Vec<u32> {
    let [start, end] = ends.map(|end| positions[end as usize]);
    let (low, high) = (start.min(end) - close, start.max(end) + close);
    let length = start.distance(end);
    let along = (end - start).normalize_or_zero();
    let mut found: Vec<(f64, u32)> = Vec::new();
    tree.visit(
        |from, to| from.cmple(high).all() && low.cmple(to).all(),
        |vertex| {
            let way = positions[vertex] - start;
            let at = way.dot(along);
            let is_end = ends.contains(&(vertex as u32));
            if !is_end && at > 0.0 && at < length && (way - at * along).length() <= close {
                found.push((at, vertex as u32));
            }
        },
    );
    found.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    found.into_iter().map(|(_, vertex)| vertex).collect()
}

/// Points that are one if they are close.
struct Vertices {
    positions: Vec<DVec3>,
    /// By cube of twice the edge `close`.
    cells: BTreeMap<[i64; 3], Vec<u32>>,
    close: f64,
}

impl Vertices {
    /// The vertex at a point: the first one that is close, or a new one.
    fn number(&mut self, point: DVec3) -> u32 {
        let cell = (point / (2.0 * self.close)).floor().to_array().map(|n| n as i64);
        let beside = |n: usize| [n % 3, n / 3 % 3, n / 9].map(|n| n as i64 - 1);
        let around = (0..27).map(|n| std::array::from_fn(|axis| cell[axis] + beside(n)[axis]));
        let known = around.filter_map(|cell: [i64; 3]| self.cells.get(&cell)).flatten();
        let is_close =
            |&&vertex: &&u32| self.positions[vertex as usize].distance(point) <= self.close;
        if let Some(&vertex) = known.filter(is_close).min() {
            return vertex;
        }
        let new = self.positions.len() as u32;
        self.positions.push(point);
        self.cells.entry(cell).or_default().push(new);
        new
    }
}
