//! Cuts many parts out of one hull, in place.

use super::Hull;
use super::cell_part::{CellFace, CellPart};
use super::half_edges::{HalfEdgeBuilder, HalfEdges, Side};
use super::plane_clip::{Kept, ON_THE_CUT, PlaneClipper, SAME};
use crate::half_space::HalfSpace;
use crate::hull::edges::HullEdge;
use glam::DVec3;

/// Nothing, in lists of indices.
const NONE: u32 = u32::MAX;

/// Cuts parts out of a hull by planes. A cut in general position (without vertices on it) changes
/// only the crossed faces and the outside: the cutter walks around it from side to side. From the
/// first cut with a vertex on it, the part goes to a [`PlaneClipper`] for degenerate cases.
#[derive(Debug)]
pub struct CellCutter<'a> {
    hull: &'a Hull,
    whole: CellPart,
    /// Of the whole.
    sides: &'a [Side],
    /// Remaining part, unless the clipper has it.
    part: CellPart,
    /// The half-spaces that have cut the part, or have passed by it.
    cuts: Vec<HalfSpace>,
    is_whole: bool,
    /// True from the first cut with a vertex on it.
    is_clipped: bool,
    /// Of the vertices that are kept over the cut [m], in their order; and of all of the part's by
    /// their numbers, where new ones have none.
    levels: Vec<f64>,
    heights: Vec<f64>,
    /// The vertices of what was cut out, and its edges, for each of the part's vertices and sides.
    numbers: Vec<u32>,
    edge_of: Vec<u32>,
    /// Faces of the part removed.
    left: Vec<CellFace>,
    /// A vertex this close to a cut lies on it [m].
    close: f64,
    /// Edges have to be longer [m].
    shortest: f64,
    clipper: PlaneClipper,
}

/// Where a part is, seen from a cut.
enum Cut {
    Inside,
    Outside,
    Through,
    /// The cut has a vertex on it.
    Touching,
}

impl<'a> CellCutter<'a> {
    /// For parts of a hull.
    pub fn new(hull: &'a Hull) -> Self {
        let (low, high) = hull.bounds();
        let size = (high - low).max_element();
        let HalfEdges { sides, leaving } = hull.net.half_edges();
        let (vertices, faces) = (hull.vertices.len(), hull.planes.len());
        Self {
            hull,
            whole: CellPart::of(hull, leaving),
            sides,
            part: CellPart::with_room_for(vertices, sides.len(), faces),
            cuts: Vec::new(),
            is_whole: true,
            is_clipped: false,
            levels: Vec::with_capacity(2 * vertices),
            heights: Vec::with_capacity(2 * vertices),
            numbers: Vec::with_capacity(2 * vertices),
            edge_of: Vec::with_capacity(2 * sides.len()),
            left: Vec::with_capacity(faces),
            close: ON_THE_CUT[0] * size,
            shortest: SAME * size,
            clipper: PlaneClipper::default(),
        }
    }

    /// The part inside of all half-spaces, cut by one after the other; `None` if there is none. See
    /// [`PlaneClipper::clipped`], which cuts out the same.
    pub fn part(&mut self, cuts: &[HalfSpace]) -> Option<Hull> {
        self.begin();
        let is_left = cuts.iter().all(|cut| self.keep_inside(cut) != Kept::Nothing);
        if is_left { self.hull() } else { None }
    }

    /// Begins a part, with all of the hull.
    pub fn begin(&mut self) {
        self.part.copy_from(&self.whole, self.sides);
        self.cuts.clear();
        (self.is_whole, self.is_clipped) = (true, false);
    }

    /// Cuts the outside of a half-space off the part. Not to be called for a part of which nothing
    /// was left.
    pub fn keep_inside(&mut self, cut: &HalfSpace) -> Kept {
        self.cuts.push(*cut);
        if self.is_clipped {
            return self.clipper.keep_inside(cut);
        }
        match self.cut(cut) {
            Cut::Inside => Kept::Whole,
            Cut::Outside => Kept::Nothing,
            Cut::Through => {
                self.is_whole = false;
                Kept::Part
            }
            Cut::Touching => {
                self.is_clipped = true;
                self.clipper.begin(self.hull);
                let mut last = Kept::Whole;
                for cut in &self.cuts {
                    last = self.clipper.keep_inside(cut);
                    if last == Kept::Nothing {
                        break;
                    }
                }
                last
            }
        }
    }

    /// Vertices of the part [m].
    pub fn vertices(&self) -> impl Iterator<Item = DVec3> {
        let (kept, clipped): (&[_], &[_]) =
            if self.is_clipped { (&[], self.clipper.vertices()) } else { (&self.part.kept, &[]) };
        kept.iter().map(|kept| kept.position).chain(clipped.iter().copied())
    }

    /// The part; `None` if rounding leaves no polyhedron.
    pub fn hull(&mut self) -> Option<Hull> {
        if self.is_clipped {
            return self.clipper.part(self.hull);
        }
        if self.is_whole {
            return Some(self.hull.clone());
        }
        match self.finished() {
            Some(hull) => Some(hull),
            None => self.clipper.clipped(self.hull, &self.cuts),
        }
    }

    fn cut(&mut self, cut: &HalfSpace) -> Cut {
        // Where all vertices are.
        let (mut lowest, mut highest, mut nearest) =
            (f64::INFINITY, f64::NEG_INFINITY, f64::INFINITY);
        self.levels.resize(self.part.kept.len(), 0.0);
        for (kept, level) in self.part.kept.iter().zip(&mut self.levels) {
            let height = cut.distance(kept.position);
            let away = height.abs();
            lowest = if height < lowest { height } else { lowest };
            highest = if height > highest { height } else { highest };
            nearest = if away < nearest { away } else { nearest };
            *level = height;
        }
        if highest <= self.close {
            return Cut::Inside;
        }
        if lowest >= -self.close {
            return Cut::Outside;
        }
        if nearest <= self.close {
            return Cut::Touching;
        }

        // Forget what is outside, and walk around the section: downhill from the lowest vertex
        // there.
        self.heights.resize(self.part.vertices.len(), 0.0);
        let start = self.part.keep_below(&self.levels, &mut self.heights);
        let before = self.part.vertices.len();
        let is_closed = self
            .part
            .crossing(&self.heights, start)
            .is_some_and(|start| self.walk_around(start, cut));
        if !is_closed {
            return Cut::Touching;
        }
        self.part.keep_new(before);
        Cut::Through
    }

    /// Cuts the faces that the cut goes through, from a side that leaves the inside, and puts the
    /// cut's own face in. False if the section is not one loop.
    fn walk_around(&mut self, start: u32, cut: &HalfSpace) -> bool {
        let Self { part, heights, .. } = self;
        let (face, first_rim) = (part.faces.len() as u32, part.sides.len() as u32);
        let first_vertex = part.vertices.len() as u32;
        part.add_crossing(heights, start);
        let (mut side, mut from, mut last) = (start, first_vertex, NONE);
        for _ in 0..part.faces.len() {
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
            part.vertices[to as usize].leaving = back;
            part.faces[of as usize].first = side;
            (side, from, last) = (twin, to, rim + 1);
            if side == start {
                break;
            }
        }
        if side != start || last < first_rim + 5 {
            return false;
        }
        part.sides[first_rim as usize + 1].next = last;
        part.faces.push(CellFace { plane: *cut, first: last, inner: true });
        true
    }

    /// The remaining part as a hull. `None` with a zero-length edge, or if not closed.
    fn finished(&mut self) -> Option<Hull> {
        let Self { part, numbers, edge_of, left, .. } = self;
        numbers.clear();
        numbers.resize(part.vertices.len(), NONE);
        for (kept, number) in part.kept.iter().zip(0..) {
            numbers[kept.number as usize] = number;
        }
        edge_of.clear();
        edge_of.resize(part.sides.len(), NONE);
        let vertices: Vec<DVec3> = part.kept.iter().map(|kept| kept.position).collect();

        // Faces that have kept a vertex. Euler's formula tells a sphere from anything else.
        let (numbers, sides, edge_of) =
            (numbers.as_slice(), part.sides.as_slice(), edge_of.as_mut_slice());
        left.clear();
        for face in &part.faces {
            if numbers[sides[face.first as usize].origin as usize] != NONE {
                left.push(*face);
            }
        }
        let count = (vertices.len() + left.len()).checked_sub(2).filter(|_| left.len() > 3)?;
        let mut net = HalfEdgeBuilder::new(count, left.len());
        for (face, number) in left.iter().zip(0..) {
            let mut at = face.first;
            loop {
                let Side { origin, next, twin, .. } = sides[at as usize];
                let origin = numbers[origin as usize];
                let edge = match edge_of[twin as usize] {
                    NONE => {
                        let end = numbers[sides[next as usize].origin as usize];
                        let edge = net.add_edge([origin, end], number)?;
                        edge_of[at as usize] = edge;
                        edge
                    }
                    known => net.close_edge(known, number),
                };
                net.add_side(origin, edge)?;
                at = next;
                if at == face.first {
                    break;
                }
            }
            net.end_face(face.inner);
        }
        let net = net.finished()?;
        let planes = left.iter().map(|face| face.plane).collect();
        let least = self.shortest * self.shortest;
        let is_long = |edge: &HullEdge| {
            let [a, b] = edge.vertices.map(|vertex| vertices[vertex as usize]);
            a.distance_squared(b) >= least
        };
        net.edges().iter().all(is_long).then(|| Hull::new(vertices, planes, net))
    }
}
