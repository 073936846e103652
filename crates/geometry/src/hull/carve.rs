//! Many parts cut out of one hull, in place.

use super::clip::{Clipper, ON_THE_CUT, SAME};
use super::loops::Loops;
use super::{Hull, HullEdge, Net};
use crate::HalfSpace;
use glam::DVec3;
use std::sync::Arc;

/// Nothing, in lists of indices.
const NONE: u32 = u32::MAX;

/// Cuts parts out of a hull by planes. A cut that has no vertex on it changes only what it goes through and what lies outside of
/// it: it is walked around from side to side. The first cut that has one sends the part to a [`Clipper`], which takes care of what
/// only touches.
#[derive(Debug)]
pub struct Carver<'a> {
    hull: &'a Hull,
    whole: Part,
    /// What is left of it.
    part: Part,
    /// Of the part's vertices over the cut [m]. New ones have none.
    heights: Vec<f64>,
    /// The vertices of what was cut out, and its edges, for each of the part's vertices and sides.
    numbers: Vec<u32>,
    edge_of: Vec<u32>,
    /// A vertex this close to a cut lies on it [m].
    close: f64,
    /// Edges have to be longer [m].
    shortest: f64,
    clipper: Clipper,
}

/// A polyhedron as sides that know their neighbours. What was cut off stays in the lists.
#[derive(Clone, Debug, Default)]
struct Part {
    vertices: Vec<DVec3>,
    /// A side that leaves each vertex.
    leaving: Vec<u32>,
    /// The vertices that are not cut off.
    kept: Vec<u32>,
    sides: Vec<Side>,
    /// Of the faces, a side of each, and whether a cut made it.
    planes: Vec<HalfSpace>,
    first: Vec<u32>,
    inner: Vec<bool>,
}

/// From a vertex to the next around a face, counter-clockwise seen from outside.
#[derive(Clone, Copy, Debug)]
struct Side {
    /// Where it begins.
    origin: u32,
    /// After it in its face.
    next: u32,
    /// The same edge in the other direction, in the face beyond.
    twin: u32,
    face: u32,
}

/// Where a part is, seen from a cut.
enum Cut {
    Inside,
    Outside,
    Through,
    /// With a vertex on it.
    Touching,
}

impl<'a> Carver<'a> {
    /// For parts of a hull.
    pub fn new(hull: &'a Hull) -> Self {
        let (low, high) = hull.bounds();
        let size = (high - low).max_element();
        let whole = Part::of(hull);
        Self {
            hull,
            part: whole.clone(),
            whole,
            heights: Vec::new(),
            numbers: Vec::new(),
            edge_of: Vec::new(),
            close: ON_THE_CUT[0] * size,
            shortest: SAME * size,
            clipper: Clipper::default(),
        }
    }

    /// The part inside of all half-spaces, cut by one after the other; `None` if there is none. See [`Clipper::clipped`], which
    /// cuts out the same.
    pub fn part(&mut self, cuts: &[HalfSpace]) -> Option<Hull> {
        self.part.copy_from(&self.whole);
        let mut is_whole = true;
        for cut in cuts {
            match self.cut(cut) {
                Cut::Inside => {}
                Cut::Outside => return None,
                Cut::Through => is_whole = false,
                Cut::Touching => return self.clipper.clipped(self.hull, cuts),
            }
        }
        if is_whole {
            return Some(self.hull.clone());
        }
        match self.finished() {
            Some(hull) => Some(hull),
            None => self.clipper.clipped(self.hull, cuts),
        }
    }

    fn cut(&mut self, cut: &HalfSpace) -> Cut {
        // Where all vertices are, and the lowest of those outside.
        let (mut lowest, mut highest, mut touching) = (f64::INFINITY, f64::NEG_INFINITY, false);
        let (mut least_above, mut start) = (f64::INFINITY, NONE);
        self.heights.resize(self.part.vertices.len(), 0.0);
        for &vertex in &self.part.kept {
            let height = cut.distance(self.part.vertices[vertex as usize]);
            self.heights[vertex as usize] = height;
            lowest = if height < lowest { height } else { lowest };
            highest = if height > highest { height } else { highest };
            touching |= height.abs() <= self.close;
            if height > 0.0 && height < least_above {
                (least_above, start) = (height, vertex);
            }
        }
        if highest <= self.close {
            return Cut::Inside;
        }
        if lowest >= -self.close {
            return Cut::Outside;
        }
        if touching {
            return Cut::Touching;
        }

        // Walk around the section, then forget what is outside.
        let before = self.part.vertices.len() as u32;
        let is_closed =
            self.part.crossing(&self.heights, start).is_some_and(|start| self.walk_around(start, cut));
        if !is_closed {
            return Cut::Touching;
        }
        let heights = &self.heights;
        self.part.kept.retain(|&vertex| heights[vertex as usize] < 0.0);
        self.part.kept.extend(before..self.part.vertices.len() as u32);
        Cut::Through
    }

    /// Cuts the faces that the cut goes through, from a side that leaves the inside, and puts the cut's own face in. False if the
    /// section is not one loop.
    fn walk_around(&mut self, start: u32, cut: &HalfSpace) -> bool {
        let Self { part, heights, .. } = self;
        let (face, first_rim) = (part.planes.len() as u32, part.sides.len() as u32);
        let first_vertex = part.vertices.len() as u32;
        part.add_crossing(heights, start);
        let (mut side, mut from, mut last) = (start, first_vertex, NONE);
        for _ in 0..part.planes.len() {
            // Along the face to the side that comes back in.
            let mut back = part.sides[side as usize].next;
            loop {
                let next = part.sides[back as usize].next;
                if heights[part.sides[next as usize].origin as usize] < 0.0 {
                    break;
                }
                back = next;
            }

            // Close the face there, and add a side of the cut's.
            let of = part.sides[side as usize].face;
            let twin = part.sides[back as usize].twin;
            let to = if twin == start { first_vertex } else { part.add_crossing(heights, twin) };
            let rim = part.sides.len() as u32;
            part.sides.push(Side { origin: from, next: back, twin: rim + 1, face: of });
            part.sides.push(Side { origin: to, next: last, twin: rim, face });
            part.sides[side as usize].next = rim;
            part.sides[back as usize].origin = to;
            part.leaving[to as usize] = back;
            part.first[of as usize] = side;
            (side, from, last) = (twin, to, rim + 1);
            if side == start {
                break;
            }
        }
        if side != start || last < first_rim + 5 {
            return false;
        }
        part.sides[first_rim as usize + 1].next = last;
        part.planes.push(*cut);
        part.first.push(last);
        part.inner.push(true);
        true
    }

    /// What is left, as a hull of its own. `None` if it has an edge without a length or is not closed.
    fn finished(&mut self) -> Option<Hull> {
        let Self { part, numbers, edge_of, .. } = self;
        numbers.clear();
        numbers.resize(part.vertices.len(), NONE);
        for (&vertex, number) in part.kept.iter().zip(0..) {
            numbers[vertex as usize] = number;
        }
        edge_of.clear();
        edge_of.resize(part.sides.len(), NONE);
        let vertices: Vec<DVec3> = part.kept.iter().map(|&vertex| part.vertices[vertex as usize]).collect();

        // Faces that have kept a vertex. Euler's formula tells a sphere from anything else.
        let is_left = |face: &usize| {
            let first = part.sides[part.first[*face] as usize];
            numbers[first.origin as usize] != NONE
        };
        let faces = (0..part.planes.len()).filter(is_left).count();
        let count = vertices.len() + faces - 2;
        let mut planes = Vec::with_capacity(faces);
        let mut loops = Loops::with_capacity(2 * count, faces);
        let mut edges_along: Vec<u32> = Vec::with_capacity(2 * count);
        let mut edges: Vec<HullEdge> = Vec::with_capacity(count);
        for face in (0..part.planes.len()).filter(is_left) {
            let first = part.first[face];
            let mut at = first;
            loop {
                let Side { origin, next, twin, .. } = part.sides[at as usize];
                let known = edge_of[twin as usize];
                if known == NONE {
                    let vertices = [origin, part.sides[next as usize].origin];
                    edge_of[at as usize] = edges.len() as u32;
                    edges_along.push(edges.len() as u32);
                    let vertices = vertices.map(|vertex| numbers[vertex as usize]);
                    edges.push(HullEdge { vertices, faces: [planes.len() as u32; 2] });
                } else {
                    edges_along.push(known);
                    edges[known as usize].faces[1] = planes.len() as u32;
                }
                loops.add_one(numbers[origin as usize]);
                at = next;
                if at == first {
                    break;
                }
                if edges_along.len() >= 2 * count {
                    return None;
                }
            }
            loops.finish(part.inner[face]);
            planes.push(part.planes[face]);
        }
        let is_sphere = faces >= 4 && edges.len() == count && edges_along.len() == 2 * count;
        let least = self.shortest * self.shortest;
        let is_long = |edge: &HullEdge| {
            let [a, b] = edge.vertices.map(|vertex| vertices[vertex as usize]);
            a.distance_squared(b) >= least
        };
        (is_sphere && edges.iter().all(is_long)).then(|| Hull {
            vertices,
            planes,
            net: Arc::new(Net { loops, edges_along, edges }),
        })
    }
}

impl Part {
    fn of(hull: &Hull) -> Self {
        let Net { loops, edges_along, edges } = &*hull.net;
        let mut part = Self {
            vertices: hull.vertices.clone(),
            leaving: vec![NONE; hull.vertices.len()],
            kept: (0..hull.vertices.len() as u32).collect(),
            sides: Vec::with_capacity(edges_along.len()),
            planes: hull.planes.clone(),
            first: Vec::with_capacity(hull.planes.len()),
            inner: (0..hull.planes.len()).map(|face| loops.is_inner(face)).collect(),
        };
        let mut side_of = vec![NONE; edges.len()];
        for face in 0..hull.planes.len() {
            let range = loops.range(face);
            part.first.push(range.start as u32);
            for at in range.clone() {
                let next = if at + 1 == range.end { range.start } else { at + 1 } as u32;
                let twin = std::mem::replace(&mut side_of[edges_along[at] as usize], at as u32);
                if twin != NONE {
                    part.sides[twin as usize].twin = at as u32;
                }
                let origin = loops.corner(at);
                part.leaving[origin as usize] = at as u32;
                part.sides.push(Side { origin, next, twin, face: face as u32 });
            }
        }
        part
    }

    /// Becomes a copy of another, in the memory it has.
    fn copy_from(&mut self, other: &Self) {
        self.vertices.clone_from(&other.vertices);
        self.leaving.clone_from(&other.leaving);
        self.kept.clone_from(&other.kept);
        self.sides.clone_from(&other.sides);
        self.planes.clone_from(&other.planes);
        self.first.clone_from(&other.first);
        self.inner.clone_from(&other.inner);
    }

    /// A side that leaves the inside of a cut, found downhill from a vertex outside.
    fn crossing(&self, heights: &[f64], mut vertex: u32) -> Option<u32> {
        loop {
            let first = self.leaving[vertex as usize];
            let (mut side, mut lowest) = (first, vertex);
            loop {
                let twin = self.sides[side as usize].twin;
                let to = self.sides[self.sides[side as usize].next as usize].origin;
                if heights[to as usize] < 0.0 {
                    return Some(twin);
                }
                if heights[to as usize] < heights[lowest as usize] {
                    lowest = to;
                }
                side = self.sides[twin as usize].next;
                if side == first {
                    break;
                }
            }
            if lowest == vertex {
                return None;
            }
            vertex = lowest;
        }
    }

    /// Adds the vertex where a side that leaves the inside crosses the cut.
    fn add_crossing(&mut self, heights: &[f64], side: u32) -> u32 {
        let Side { origin, next, .. } = self.sides[side as usize];
        let outside = self.sides[next as usize].origin;
        let (from, to) = (heights[origin as usize], heights[outside as usize]);
        let (start, end) = (self.vertices[origin as usize], self.vertices[outside as usize]);
        self.vertices.push(start + (end - start) * (from / (from - to)));
        self.leaving.push(NONE);
        self.vertices.len() as u32 - 1
    }
}
