//! The polygons of faces.

use super::elements::{Edge, NONE};
use crate::polygon::triangulate;
use glam::{DVec2, DVec3};

/// A directed edge of a face, by its vertices.
pub(crate) type Side = [u32; 2];

/// The loops of all faces, in their directions.
pub(crate) fn loops_of_faces(edges: &[Edge], faces: usize) -> Vec<Vec<Vec<u32>>> {
    let mut sides = sides_of_faces(edges, faces);
    sides.iter_mut().map(|sides| linked(sides)).collect()
}

/// The directed edges of each face, in the order of the edges.
pub(crate) fn sides_of_faces(edges: &[Edge], faces: usize) -> Vec<Vec<Side>> {
    let mut sides = vec![Vec::with_capacity(4); faces];
    for &Edge { ends: [a, b], faces: [left, right] } in edges {
        sides[left as usize].push([a, b]);
        sides[right as usize].push([b, a]);
    }
    sides
}

/// Loops of directed edges, which end as soon as they come to a vertex again. As many edges must
/// begin at each vertex as end there.
pub(crate) fn linked(sides: &mut [Side]) -> Vec<Vec<u32>> {
    sides.sort_unstable();
    let mut is_used = vec![false; sides.len()];
    let mut loops = Vec::new();
    let mut path: Vec<u32> = Vec::new();
    for first in 0..sides.len() {
        let mut next = Some(first).filter(|&first| !is_used[first]);
        while let Some(at) = next {
            is_used[at] = true;
            let [from, to] = sides[at];
            path.push(from);
            if let Some(start) = path.iter().position(|&vertex| vertex == to) {
                loops.push(path.split_off(start));
            }
            let begins = sides.partition_point(|side| side[0] < to);
            let leaving = (begins..sides.len()).take_while(|&side| sides[side][0] == to);
            next = leaving.into_iter().find(|&side| !is_used[side]);
            if path.is_empty() {
                break;
            }
        }
        path.clear();
    }
    loops
}

/// A polygon with its holes.
pub(crate) struct Region {
    pub(crate) outer: Vec<u32>,
    pub(crate) holes: Vec<Vec<u32>>,
}

/// The regions of a face: its loops around the normal, each with those the other way round that lie
/// in it. What lies in none is a region by itself. Loops of two edges are left out: what lies
/// beside them closes without them.
pub(crate) fn regions(vertices: &[DVec3], normal: DVec3, loops: Vec<Vec<u32>>) -> Vec<Region> {
    let flat = Flat::new(normal);
    let (mut outer, mut holes) = (Vec::new(), Vec::new());
    for corners in loops.into_iter().filter(|corners| corners.len() > 2) {
        let area = flat.area(vertices, &corners);
        let list = if area > 0.0 { &mut outer } else { &mut holes };
        list.push((area.abs(), corners));
    }
    if outer.is_empty() {
        std::mem::swap(&mut outer, &mut holes);
    }
    // The smallest first: it is the innermost.
    outer.sort_by(|a, b| a.0.total_cmp(&b.0));
    let area_of: Vec<f64> = outer.iter().map(|region| region.0).collect();
    let mut regions: Vec<Region> =
        outer.into_iter().map(|(_, outer)| Region { outer, holes: Vec::new() }).collect();
    for (area, hole) in holes {
        let own = (0..area_of.len())
            .find(|&at| area < area_of[at] && flat.holds(vertices, &regions[at].outer, &hole));
        match own {
            Some(own) => regions[own].holes.push(hole),
            None => regions.push(Region { outer: hole, holes: Vec::new() }),
        }
    }
    regions
}

/// Triangles that fill a face, with each of its edges in one of them.
pub(crate) fn triangulate_face(
    vertices: &[DVec3],
    normal: DVec3,
    loops: Vec<Vec<u32>>,
) -> Vec<[u32; 3]> {
    let at = |corner: u32| vertices[corner as usize];
    if let [corners] = &loops[..] {
        return triangulate(corners, &at);
    }
    let mut triangles = Vec::new();
    for Region { mut outer, holes } in regions(vertices, normal, loops) {
        let flat = Flat::new(normal);
        let mut holes = holes;
        // From one side to the other, so that each is bridged to what is before it.
        let lowest = |hole: &[u32]| {
            hole.iter().map(|&at| flat.of(vertices[at as usize]).x).fold(f64::INFINITY, f64::min)
        };
        holes.sort_by(|a, b| lowest(a).total_cmp(&lowest(b)));
        for index in 0..holes.len() {
            let (hole, left) = (&holes[index], &holes[index + 1..]);
            outer = flat.bridged(vertices, outer, hole, left);
        }
        triangles.extend(triangulate(&outer, &at));
    }
    triangles
}

/// The plane of a face.
struct Flat {
    u: DVec3,
    v: DVec3,
}

impl Flat {
    fn new(normal: DVec3) -> Self {
        let (u, v) = normal.any_orthonormal_pair();
        Self { u, v }
    }

    fn of(&self, point: DVec3) -> DVec2 {
        DVec2::new(self.u.dot(point), self.v.dot(point))
    }

    /// Twice the area of a loop [m^2], positive around the normal.
    fn area(&self, vertices: &[DVec3], corners: &[u32]) -> f64 {
        let place = |at: u32| self.of(vertices[at as usize]);
        let origin = place(corners[0]);
        let pairs = corners.windows(2);
        pairs.map(|pair| (place(pair[0]) - origin).perp_dot(place(pair[1]) - origin)).sum()
    }

    /// True if a loop runs around most of another one's sides, by their middles: vertices of both
    /// may be the same.
    fn holds(&self, vertices: &[DVec3], corners: &[u32], others: &[u32]) -> bool {
        let places = |corners: &[u32]| -> Vec<DVec2> {
            corners.iter().map(|&at| self.of(vertices[at as usize])).collect()
        };
        let (outer, inner) = (places(corners), places(others));
        let next = |at: usize, of: &[DVec2]| of[(at + 1) % of.len()];
        let around = |point: DVec2| {
            let crosses = |&at: &usize| {
                let (a, b) = (outer[at], next(at, &outer));
                (a.y > point.y) != (b.y > point.y)
                    && (point.x - a.x) < (b.x - a.x) * (point.y - a.y) / (b.y - a.y)
            };
            (0..outer.len()).filter(crosses).count() % 2 == 1
        };
        let middle = |at: usize| 0.5 * (inner[at] + next(at, &inner));
        let inside = (0..inner.len()).filter(|&at| around(middle(at))).count();
        2 * inside > inner.len()
    }

    /// A loop and a hole as one, by the shortest bridge that crosses neither them nor other holes.
    fn bridged(
        &self,
        vertices: &[DVec3],
        outer: Vec<u32>,
        hole: &[u32],
        others: &[Vec<u32>],
    ) -> Vec<u32> {
        let place = |at: u32| self.of(vertices[at as usize]);
        let lowest = (0..hole.len())
            .min_by(|&a, &b| place(hole[a]).x.total_cmp(&place(hole[b]).x))
            .unwrap_or(0);
        // Where they touch, they are one already.
        let touching = hole.iter().position(|at| outer.contains(at));
        let lowest = touching.unwrap_or(lowest);
        let from = place(hole[lowest]);
        let mut order: Vec<usize> = (0..outer.len()).collect();
        let away = |at: usize| place(outer[at]).distance_squared(from);
        order.sort_by(|&a, &b| away(a).total_cmp(&away(b)).then(a.cmp(&b)));
        let is_free = |&to: &usize| {
            let bridge = [hole[lowest], outer[to]];
            let loops = [&outer[..], hole].into_iter().chain(others.iter().map(|one| &one[..]));
            let mut sides = loops.flat_map(|corners| {
                corners.iter().copied().zip(corners.iter().copied().cycle().skip(1))
            });
            !sides.any(|(a, b)| {
                let is_apart = bridge.iter().all(|&end| end != a && end != b);
                is_apart && cross(bridge.map(place), [place(a), place(b)])
            })
        };
        let to = order.iter().copied().find(is_free).or(order.first().copied()).unwrap_or(0);
        let mut joined = outer[..=to].to_vec();
        if hole[lowest] == outer[to] {
            joined.extend(hole[lowest + 1..].iter().chain(&hole[..lowest]));
            joined.extend(&outer[to..]);
            return joined;
        }
        joined.extend(hole[lowest..].iter().chain(&hole[..=lowest]));
        joined.extend(&outer[to..]);
        joined
    }
}

/// True if two segments have a point in common.
fn cross([a, b]: [DVec2; 2], [c, d]: [DVec2; 2]) -> bool {
    let side = |from: DVec2, to: DVec2, point: DVec2| (to - from).perp_dot(point - from);
    side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

/// Gives each region of a face but the first a number of its own: the edges' faces are renumbered.
/// `sides` holds the face's edges with their places: the edge's index, and which of its faces.
pub(crate) fn part_face(
    vertices: &[DVec3],
    normal: DVec3,
    sides: &[(Side, usize, usize)],
    mut renumber: impl FnMut(usize, usize, usize),
) -> usize {
    let mut own: Vec<Side> = sides.iter().map(|side| side.0).collect();
    let loops = linked(&mut own);
    if loops.len() < 2 {
        return 1;
    }
    let regions = regions(vertices, normal, loops);
    if regions.len() < 2 {
        return 1;
    }
    // Of each directed edge the region; equal ones go one to each.
    let mut of_side: Vec<(Side, u32)> = Vec::with_capacity(sides.len());
    for (number, region) in regions.iter().enumerate() {
        for corners in std::iter::once(&region.outer).chain(&region.holes) {
            let next = corners.iter().copied().cycle().skip(1);
            of_side.extend(corners.iter().copied().zip(next).map(|(a, b)| ([a, b], number as u32)));
        }
    }
    of_side.sort_unstable();
    for &(side, edge, slot) in sides {
        let at = of_side.partition_point(|(other, number)| (*other, *number) < (side, 0));
        let taken = (at..of_side.len())
            .take_while(|&at| of_side[at].0 == side)
            .find(|&at| of_side[at].1 != NONE);
        if let Some(taken) = taken {
            renumber(edge, slot, of_side[taken].1 as usize);
            of_side[taken].1 = NONE;
        }
    }
    regions.len()
}
