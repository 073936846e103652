//! A hull cut by planes.

use super::Hull;
use super::face_loops::FaceLoops;
use crate::half_space::HalfSpace;
use glam::DVec3;

/// A vertex this close to a cut, relative to the hull's longest side, lies on it: nothing shorter
/// than what rounding moves is cut off. Should what lies that close leave no polyhedron, the next
/// one is tried.
pub(super) const ON_THE_CUT: [f64; 3] = [1e-10, 1e-8, 1e-6];

/// Vertices closer than this, relative to the hull's longest side, are one: an edge must have a
/// direction.
pub(super) const SAME: f64 = 1e-13;

/// Nothing, in lists of indices.
const NONE: u32 = u32::MAX;

// Where a vertex is, seen from a cut.
const BELOW: u8 = 1;
const ON: u8 = 2;
const ABOVE: u8 = 4;

fn side(height: f64) -> u8 {
    if height < 0.0 {
        BELOW
    } else if height > 0.0 {
        ABOVE
    } else {
        ON
    }
}

/// Cuts hulls with reused memory.
#[derive(Debug, Default)]
pub struct PlaneClipper {
    /// The longest side of the hull before any cut [m].
    size: f64,
    /// True until a cut goes through.
    is_whole: bool,
    vertices: Vec<DVec3>,
    planes: Vec<HalfSpace>,
    loops: FaceLoops,
    // New versions of the three lists above.
    next_vertices: Vec<DVec3>,
    next_planes: Vec<HalfSpace>,
    next_loops: FaceLoops,
    /// Of the vertices over the cut [m].
    heights: Vec<f64>,
    /// Side of each vertex: [`BELOW`], [`ON`] or [`ABOVE`].
    sides: Vec<u8>,
    /// New index of each kept vertex.
    number: Vec<u32>,
    /// New vertices on sides that cross the cut, in lists that begin at the lower ends.
    first_crossing: Vec<u32>,
    crossings: Vec<Crossing>,
    /// Next vertex around the cut's own face, for each vertex.
    rim: Vec<u32>,
    /// Number of vertices on the rim.
    on_rim: usize,
    /// The loop under construction.
    kept: Vec<u32>,
}

/// A new vertex on a side from below the cut to above it.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    upper: u32,
    vertex: u32,
    /// From the same lower end.
    next: u32,
}

impl Hull {
    /// The part inside a half-space; `None` if empty. Remaining faces keep their planes, and the
    /// new face is an inner face. Both sides of a cut (`cut` and its reverse) have bit-identical
    /// vertices.
    pub fn clipped(&self, cut: &HalfSpace) -> Option<Self> {
        PlaneClipper::default().clipped(self, std::slice::from_ref(cut))
    }
}

impl PlaneClipper {
    /// The part of a hull inside of all half-spaces, cut by one after the other; `None` if there is
    /// none.
    pub fn clipped(&mut self, hull: &Hull, cuts: &[HalfSpace]) -> Option<Hull> {
        self.begin(hull);
        let is_left = cuts.iter().all(|cut| self.keep_inside(cut) != Kept::Nothing);
        if is_left { self.part(hull) } else { None }
    }

    /// Begins a part of a hull.
    pub(super) fn begin(&mut self, hull: &Hull) {
        self.vertices.clone_from(&hull.vertices);
        self.planes.clone_from(&hull.planes);
        self.loops.copy_from(&hull.net);
        let (low, high) = hull.bounds();
        self.size = (high - low).max_element();
        self.is_whole = true;
    }

    /// Vertices of the part [m].
    pub(super) fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The part of the hull that it was begun with.
    pub(super) fn part(&self, hull: &Hull) -> Option<Hull> {
        if self.is_whole {
            return Some(hull.clone());
        }
        if let Some(collapsed) = self.loops.collapsed(&self.vertices, SAME * self.size)
            && let Some(hull) = Hull::from_loops(&self.vertices, self.planes.clone(), collapsed)
        {
            return Some(hull);
        }
        Hull::from_loops(&self.vertices, self.planes.clone(), self.loops.clone())
    }

    /// Cuts off the outside of a half-space.
    pub(super) fn keep_inside(&mut self, cut: &HalfSpace) -> Kept {
        // Most cuts of a cell pass by what the others have left.
        self.heights.clear();
        self.heights.extend(self.vertices.iter().map(|&vertex| cut.distance(vertex)));
        if self.heights.iter().all(|&height| height <= 0.0) {
            return Kept::Whole;
        }
        for part in ON_THE_CUT {
            // Sort the vertices into inside, on the cut (0), and outside.
            let close = part * self.size;
            let (mut inside, mut outside, mut on_cut) = (false, false, false);
            for height in &mut self.heights {
                if height.abs() <= close {
                    *height = 0.0;
                }
                inside |= *height < 0.0;
                outside |= *height > 0.0;
                on_cut |= *height == 0.0;
            }
            if !outside {
                return Kept::Whole;
            }
            if !inside {
                return Kept::Nothing;
            }
            self.clip_faces();
            if self.close(cut) {
                if on_cut {
                    // Only vertices that were there may have come to lie on a straight edge.
                    self.next_loops.straighten(self.next_vertices.len(), &mut self.next_planes);
                }
                std::mem::swap(&mut self.vertices, &mut self.next_vertices);
                std::mem::swap(&mut self.loops, &mut self.next_loops);
                std::mem::swap(&mut self.planes, &mut self.next_planes);
                self.is_whole = false;
                return Kept::Part;
            }
        }
        // A polyhedron's section is always a single loop.
        Kept::Whole
    }

    /// Clips each face, and collects the open rim.
    fn clip_faces(&mut self) {
        self.number_kept();
        self.next_loops.clear();
        self.next_planes.clear();
        self.rim.clear();
        self.rim.resize(self.next_vertices.len(), NONE);
        self.on_rim = 0;
        for face in 0..self.loops.len() {
            // A face that only touches the cut vanishes, or is the rim.
            let corners = self.loops.of(face);
            let sides =
                corners.iter().fold(0, |sides, &vertex| sides | self.sides[vertex as usize]);
            if sides == BELOW {
                self.next_loops.add(corners.iter().map(|&vertex| self.number[vertex as usize]));
            } else if sides & BELOW != 0 {
                self.clip_face(face);
            } else {
                continue;
            }
            if self.next_loops.finish(self.loops.is_inner(face)) {
                self.next_planes.push(self.planes[face]);
            }
        }
    }

    /// Copies the vertices that are not above the cut.
    fn number_kept(&mut self) {
        self.next_vertices.clear();
        self.number.clear();
        self.sides.clear();
        self.sides.extend(self.heights.iter().map(|&height| side(height)));
        for (&vertex, &side) in self.vertices.iter().zip(&self.sides) {
            self.number.push(self.next_vertices.len() as u32);
            if side != ABOVE {
                self.next_vertices.push(vertex);
            }
        }
        self.first_crossing.clear();
        self.first_crossing.resize(self.vertices.len(), NONE);
        self.crossings.clear();
    }

    /// The part of a face that is not above the cut, and its sides along the cut.
    fn clip_face(&mut self, face: usize) {
        let range = self.loops.range(face);
        let count = range.len();
        // The last corner that was kept, if it lies on the cut; the first, to close the loop.
        let (mut last_on, mut first_on, mut is_first) = (NONE, NONE, true);
        for at in 0..count {
            let (a, b) = (
                self.loops.corner(range.start + at),
                self.loops.corner(range.start + (at + 1) % count),
            );
            let side = self.sides[a as usize];
            if side != ABOVE {
                let vertex = self.number[a as usize];
                let on = if side == ON { vertex } else { NONE };
                self.add_to_rim(last_on, on);
                (last_on, first_on, is_first) = (on, if is_first { on } else { first_on }, false);
                self.next_loops.add([vertex]);
            }
            if self.sides[a as usize] | self.sides[b as usize] == BELOW | ABOVE {
                let vertex = self.crossing(a, b);
                self.add_to_rim(last_on, vertex);
                (last_on, first_on, is_first) =
                    (vertex, if is_first { vertex } else { first_on }, false);
                self.next_loops.add([vertex]);
            }
        }
        self.add_to_rim(last_on, first_on);
    }

    /// Where two corners in a row lie on the cut, its own face runs the other way; where two faces
    /// have the same, there is none.
    fn add_to_rim(&mut self, from: u32, to: u32) {
        if from == NONE || to == NONE || from == to {
            return;
        }
        if self.rim[from as usize] == to {
            self.rim[from as usize] = NONE;
            self.on_rim -= 1;
        } else {
            self.rim[to as usize] = from;
            self.on_rim += 1;
        }
    }

    /// The vertex where a side crosses the cut; the same for the side's two faces.
    fn crossing(&mut self, a: u32, b: u32) -> u32 {
        let (from, to) = (self.heights[a as usize], self.heights[b as usize]);
        let (lower, upper) = if from < 0.0 { (a, b) } else { (b, a) };
        let mut known = self.first_crossing[lower as usize];
        while known != NONE {
            let crossing = self.crossings[known as usize];
            if crossing.upper == upper {
                return crossing.vertex;
            }
            known = crossing.next;
        }
        let (start, end) = (self.vertices[a as usize], self.vertices[b as usize]);
        let vertex = self.next_vertices.len() as u32;
        self.next_vertices.push(start + (end - start) * (from / (from - to)));
        self.rim.push(NONE);
        let next = self.first_crossing[lower as usize];
        self.first_crossing[lower as usize] = self.crossings.len() as u32;
        self.crossings.push(Crossing { upper, vertex, next });
        vertex
    }

    /// Puts the cut's face in. False if the rim is not one loop.
    fn close(&mut self, cut: &HalfSpace) -> bool {
        let Some(start) = self.rim.iter().position(|&next| next != NONE) else { return false };
        self.kept.clear();
        let mut at = start as u32;
        while at != NONE && self.kept.len() <= self.on_rim {
            self.kept.push(at);
            at = self.rim[at as usize];
            if at == start as u32 {
                break;
            }
        }
        if at != start as u32 || self.kept.len() != self.on_rim || self.on_rim < 3 {
            return false;
        }
        self.next_loops.push(true, self.kept.iter().copied());
        self.next_planes.push(*cut);
        true
    }
}

/// The remainder of a part after a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kept {
    /// All of it lies inside.
    Whole,
    /// The cut goes through.
    Part,
    /// All of it lies outside.
    Nothing,
}
