//! A solid on one side of a plane.

use super::elements::{Edge, NONE};
use crate::half_space::HalfSpace;
use glam::DVec3;

/// A solid on its way through many cuts: its faces are known by their numbers alone.
#[derive(Clone, Debug, Default)]
pub(crate) struct Loose {
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) edges: Vec<Edge>,
}

/// The remainder of a solid after a cut.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Left {
    /// All of it: nothing was written.
    All,
    Nothing,
    Some,
}

/// An end of a face's part under the plane.
#[derive(Clone, Copy, Debug)]
struct End {
    face: u32,
    vertex: u32,
    /// Edges of the face that arrive there, less those that leave.
    arriving: i32,
}

/// Cuts solids by planes, with room for what that needs.
#[derive(Debug, Default)]
pub(crate) struct Clipper {
    heights: Vec<f64>,
    number: Vec<u32>,
    ends: Vec<End>,
    /// Of one face: along the line where it meets the plane, an end and its vertex.
    on_line: Vec<(f64, End)>,
    leaving: Vec<(f64, u32)>,
    entering: Vec<(f64, u32)>,
    /// Vertices where the face touches the plane.
    touching: Vec<(f64, u32)>,
}

/// A face with an edge on the plane lies in it if it leans less than this (sine of the angle).
const IN_PLANE: f64 = 1e-9;

impl Clipper {
    /// Writes the part inside of a plane. Vertices within `close` [m] of it count as on it, and
    /// stay where they are. The cut's own face is `cap`; `normal_of` gives the normals of all
    /// others.
    ///
    /// Each face is clipped by itself: the edges that stay, and along the plane one from each place
    /// where they leave the part below to the next where they come back. The same edges, the other
    /// way round, and those of faces that stay beside faces that do not, bound the cap.
    pub(crate) fn clip(
        &mut self,
        from: &Loose,
        plane: &HalfSpace,
        (cap, close): (u32, f64),
        normal_of: impl Fn(u32) -> DVec3,
        into: &mut Loose,
    ) -> Left {
        let (mut lowest, mut highest) = (f64::INFINITY, f64::NEG_INFINITY);
        self.heights.clear();
        self.heights.extend(from.vertices.iter().map(|&vertex| {
            let height = plane.distance(vertex);
            lowest = lowest.min(height);
            highest = highest.max(height);
            if height.abs() <= close { 0.0 } else { height }
        }));
        if highest <= close {
            return Left::All;
        }
        into.vertices.clear();
        into.edges.clear();
        if lowest >= -close {
            return Left::Nothing;
        }
        self.number.clear();
        self.number.resize(from.vertices.len(), NONE);
        self.ends.clear();
        for edge in &from.edges {
            self.clip_edge(from, edge, (plane, cap), &normal_of, into);
        }
        self.close_faces((plane, cap), normal_of, into);
        if into.edges.is_empty() { Left::Nothing } else { Left::Some }
    }

    fn clip_edge(
        &mut self,
        from: &Loose,
        edge: &Edge,
        (plane, cap): (&HalfSpace, u32),
        normal_of: &impl Fn(u32) -> DVec3,
        into: &mut Loose,
    ) {
        let Edge { ends: [a, b], faces: [left, right] } = *edge;
        let [height_a, height_b] = [a, b].map(|end| self.heights[end as usize]);
        if height_a.max(height_b) <= 0.0 && height_a.min(height_b) < 0.0 {
            let ends = [a, b].map(|end| self.kept(from, end, into));
            into.edges.push(Edge { ends, faces: [left, right] });
            for (vertex, height, arriving) in [(ends[0], height_a, -1), (ends[1], height_b, 1)] {
                if height == 0.0 {
                    self.end(left, vertex, arriving);
                    self.end(right, vertex, -arriving);
                }
            }
        } else if height_a * height_b < 0.0 {
            // From below to above, so that an edge is cut at the same place from both faces.
            let (low, high) = if height_a < 0.0 { (a, b) } else { (b, a) };
            let [from_low, from_high] = [low, high].map(|end| self.heights[end as usize]);
            let [start, end] = [low, high].map(|end| from.vertices[end as usize]);
            let crossing = into.vertices.len() as u32;
            into.vertices.push(start + (end - start) * (from_low / (from_low - from_high)));
            let low = self.kept(from, low, into);
            let (ends, arriving) =
                if height_a < 0.0 { ([low, crossing], 1) } else { ([crossing, low], -1) };
            into.edges.push(Edge { ends, faces: [left, right] });
            self.end(left, crossing, arriving);
            self.end(right, crossing, -arriving);
        } else if height_a == 0.0 && height_b == 0.0 {
            let along = from.vertices[b as usize] - from.vertices[a as usize];
            let stays = [(left, along), (right, -along)]
                .map(|(face, along)| is_below(normal_of(face), along, plane.normal));
            if stays == [false; 2] {
                return;
            }
            let ends = [a, b].map(|end| self.kept(from, end, into));
            let faces = [(left, stays[0]), (right, stays[1])]
                .map(|(face, stays)| if stays { face } else { cap });
            into.edges.push(Edge { ends, faces });
            for (face, [start, end]) in faces.into_iter().zip([ends, [ends[1], ends[0]]]) {
                if face != cap {
                    self.end(face, start, -1);
                    self.end(face, end, 1);
                }
            }
        }
    }

    fn kept(&mut self, from: &Loose, vertex: u32, into: &mut Loose) -> u32 {
        let number = &mut self.number[vertex as usize];
        if *number == NONE {
            *number = into.vertices.len() as u32;
            into.vertices.push(from.vertices[vertex as usize]);
        }
        *number
    }

    fn end(&mut self, face: u32, vertex: u32, arriving: i32) {
        self.ends.push(End { face, vertex, arriving });
    }

    /// Adds the edges of the faces along the plane.
    fn close_faces(
        &mut self,
        (plane, cap): (&HalfSpace, u32),
        normal_of: impl Fn(u32) -> DVec3,
        into: &mut Loose,
    ) {
        let mut ends = std::mem::take(&mut self.ends);
        ends.sort_unstable_by_key(|end| (end.face, end.vertex));
        for of_face in ends.chunk_by(|a, b| a.face == b.face) {
            let face = of_face[0].face;
            self.on_line.clear();
            let along = normal_of(face).cross(plane.normal);
            for at_vertex in of_face.chunk_by(|a, b| a.vertex == b.vertex) {
                let arriving = at_vertex.iter().map(|end| end.arriving).sum();
                let vertex = at_vertex[0].vertex;
                let place = along.dot(into.vertices[vertex as usize]);
                self.on_line.push((place, End { face, vertex, arriving }));
            }
            self.join_ends((face, cap), into);
        }
        self.ends = ends;
    }

    /// From each end that is left to the next one that is entered, along the line, and over what
    /// touches it between them.
    fn join_ends(&mut self, faces: (u32, u32), into: &mut Loose) {
        self.on_line.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.vertex.cmp(&b.1.vertex)));
        self.leaving.clear();
        self.entering.clear();
        self.touching.clear();
        for &(place, end) in &self.on_line {
            let waiting = match end.arriving {
                0 => &mut self.touching,
                1.. => &mut self.leaving,
                _ => &mut self.entering,
            };
            let count = end.arriving.unsigned_abs().max(1) as usize;
            waiting.extend(std::iter::repeat_n((place, end.vertex), count));
        }
        // As many leave as enter: faces are closed.
        for (&(from, start), &(to, end)) in self.leaving.iter().zip(&self.entering) {
            let mut last = start;
            let mut join = |next: u32| {
                if last != next {
                    into.edges.push(Edge { ends: [last, next], faces: faces.into() });
                }
                last = next;
            };
            let between = |&&(place, _): &&(f64, u32)| from.min(to) < place && place < from.max(to);
            let touching = self.touching.iter().filter(between).map(|&(_, vertex)| vertex);
            if from < to {
                touching.for_each(&mut join);
            } else {
                touching.rev().for_each(&mut join);
            }
            join(end);
        }
    }
}

/// True if a face is below the plane on the left of one of its edges, which lies in the plane; one
/// that lies in the plane itself, if it looks up.
fn is_below(normal: DVec3, along: DVec3, up: DVec3) -> bool {
    let rise = normal.cross(along).dot(up);
    if rise.abs() <= IN_PLANE * along.length() { normal.dot(up) > 0.0 } else { rise < 0.0 }
}
