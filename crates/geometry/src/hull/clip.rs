//! A hull cut by planes.

use super::loops::Loops;
use super::{Hull, sides};
use crate::HalfSpace;
use glam::DVec3;

/// A vertex this close to a cut, relative to the hull's longest side, lies on it: nothing shorter than what rounding moves is
/// cut off. Should what lies that close leave no polyhedron, the next one is tried.
const ON_THE_CUT: [f64; 3] = [1e-10, 1e-8, 1e-6];

/// Vertices closer than this, relative to the hull's longest side, are one: an edge must have a direction.
const SAME: f64 = 1e-13;

/// Cuts hulls, in memory that it keeps from one to the next.
#[derive(Debug, Default)]
pub struct Clipper {
    vertices: Vec<DVec3>,
    planes: Vec<HalfSpace>,
    loops: Loops,
    /// Of the vertices over the cut [m].
    heights: Vec<f64>,
    /// New vertices on sides that cross the cut: the side, lower end first, and the vertex.
    crossings: Vec<([u32; 2], u32)>,
    /// Sides of the cut's own face.
    rim: Vec<[u32; 2]>,
    /// What is left of one face.
    kept: Vec<u32>,
    // What becomes of the three above.
    next_vertices: Vec<DVec3>,
    next_planes: Vec<HalfSpace>,
    next_loops: Loops,
}

impl Hull {
    /// The part inside a half-space; `None` if there is none. What is left of the faces keeps their planes, the new face is an
    /// inner one, and the two sides of a cut, `cut` and `cut` turned round, share its vertices bit for bit.
    pub fn clipped(&self, cut: &HalfSpace) -> Option<Self> {
        Clipper::default().clipped(self, std::slice::from_ref(cut))
    }
}

impl Clipper {
    /// The part of a hull inside of all half-spaces, cut by one after the other; `None` if there is none.
    pub fn clipped(&mut self, hull: &Hull, cuts: &[HalfSpace]) -> Option<Hull> {
        self.vertices.clone_from(&hull.vertices);
        self.planes.clone_from(&hull.planes);
        self.loops.copy_from(&hull.net.loops);
        let mut is_whole = true;
        for cut in cuts {
            match self.cut(cut) {
                Side::Inside => {}
                Side::Outside => return None,
                Side::Cut => is_whole = false,
            }
        }
        if is_whole {
            return Some(hull.clone());
        }
        let (planes, loops) = (self.planes.clone(), self.loops.clone());
        let mut collapsed = loops.clone();
        if collapsed.collapse(&self.vertices, SAME * self.size())
            && let Some(hull) = Hull::from_loops(&self.vertices, planes.clone(), collapsed)
        {
            return Some(hull);
        }
        Hull::from_loops(&self.vertices, planes, loops)
    }

    /// The longest side of what is left [m].
    fn size(&self) -> f64 {
        let low = self.vertices.iter().fold(DVec3::INFINITY, |low, &vertex| low.min(vertex));
        let high = self.vertices.iter().fold(DVec3::NEG_INFINITY, |high, &vertex| high.max(vertex));
        (high - low).max_element()
    }

    fn cut(&mut self, cut: &HalfSpace) -> Side {
        // Most cuts of a cell pass by what the others have left.
        self.heights.clear();
        self.heights.extend(self.vertices.iter().map(|&vertex| cut.distance(vertex)));
        if self.heights.iter().all(|&height| height <= 0.0) {
            return Side::Inside;
        }
        let size = self.size();
        for part in ON_THE_CUT {
            // Sort the vertices into inside, on the cut (0), and outside.
            for height in &mut self.heights {
                *height = if height.abs() <= part * size { 0.0 } else { *height };
            }
            if self.heights.iter().all(|&height| height <= 0.0) {
                return Side::Inside;
            }
            if self.heights.iter().all(|&height| height >= 0.0) {
                return Side::Outside;
            }
            self.clip_faces();
            if self.close(cut) {
                return Side::Cut;
            }
        }
        // No polyhedron has a section that is not one loop.
        Side::Inside
    }

    /// What is left of each face, and the rim that they leave open.
    fn clip_faces(&mut self) {
        self.next_vertices.clone_from(&self.vertices);
        self.next_loops.clear();
        self.next_planes.clear();
        self.crossings.clear();
        self.rim.clear();
        for face in 0..self.loops.len() {
            // What only touches the cut vanishes, or is the rim's.
            let height = |vertex: u32| self.heights[vertex as usize];
            let corners = self.loops.of(face);
            if !corners.iter().any(|&vertex| height(vertex) < 0.0) {
                continue;
            }
            if corners.iter().all(|&vertex| height(vertex) < 0.0) {
                self.next_loops.push(self.loops.is_inner(face), corners.iter().copied());
                self.next_planes.push(self.planes[face]);
                continue;
            }
            self.kept.clear();
            for [a, b] in sides(corners) {
                let (from, to) = (height(a), height(b));
                if from <= 0.0 {
                    self.kept.push(a);
                }
                if from * to < 0.0 {
                    self.kept.push(crossing(
                        &mut self.next_vertices,
                        &mut self.crossings,
                        ([a, b], from / (from - to)),
                    ));
                }
            }
            // Where two corners in a row lie on the cut, its own face is beside.
            if self.kept.len() > 2 {
                let is_on =
                    |&vertex: &u32| self.heights.get(vertex as usize).is_none_or(|&height| height == 0.0);
                for [a, b] in sides(&self.kept).filter(|side| side.iter().all(is_on)) {
                    match self.rim.iter().position(|side| *side == [a, b]) {
                        Some(opposite) => _ = self.rim.swap_remove(opposite),
                        None => self.rim.push([b, a]),
                    }
                }
                self.next_loops.push(self.loops.is_inner(face), self.kept.iter().copied());
                self.next_planes.push(self.planes[face]);
            }
        }
    }

    /// Puts the cut's face in, and takes over what has become of the hull. False if the rim is not one loop.
    fn close(&mut self, cut: &HalfSpace) -> bool {
        let Some(start) = self.rim.iter().map(|side| side[0]).min() else { return false };
        self.kept.clear();
        let mut at = start;
        while let Some(side) = self.rim.iter().position(|side| side[0] == at) {
            self.kept.push(at);
            at = self.rim.swap_remove(side)[1];
        }
        if at != start || !self.rim.is_empty() || self.kept.len() < 3 {
            return false;
        }
        self.next_loops.push(true, self.kept.iter().copied());
        self.next_planes.push(*cut);
        self.next_loops.straighten(self.next_vertices.len(), &mut self.next_planes);
        self.next_loops.renumber(&self.next_vertices, &mut self.vertices);
        std::mem::swap(&mut self.loops, &mut self.next_loops);
        std::mem::swap(&mut self.planes, &mut self.next_planes);
        true
    }
}

/// Where a hull is, seen from a cut.
enum Side {
    Inside,
    Outside,
    Cut,
}

/// The vertex where a side crosses the cut at a part of its length; the same for the side's two faces.
fn crossing(
    vertices: &mut Vec<DVec3>,
    crossings: &mut Vec<([u32; 2], u32)>,
    ([a, b], part): ([u32; 2], f64),
) -> u32 {
    let ends = [a.min(b), a.max(b)];
    if let Some(&(_, vertex)) = crossings.iter().find(|(side, _)| *side == ends) {
        return vertex;
    }
    let (start, end) = (vertices[a as usize], vertices[b as usize]);
    let vertex = vertices.len() as u32;
    vertices.push(start + (end - start) * part);
    crossings.push((ends, vertex));
    vertex
}
