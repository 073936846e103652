//! A polyhedron that is being cut.

use super::Hull;
use super::half_edges::Side;
use crate::half_space::HalfSpace;
use glam::DVec3;

/// Nothing, in lists of indices.
const NONE: u32 = u32::MAX;

/// A polyhedron with linked sides. Removed elements stay in the lists.
#[derive(Debug)]
pub(super) struct CellPart {
    pub(super) vertices: Vec<CellVertex>,
    /// Remaining vertices.
    pub(super) kept: Vec<KeptVertex>,
    pub(super) sides: Vec<Side>,
    pub(super) faces: Vec<CellFace>,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct CellVertex {
    pub(super) position: DVec3,
    /// A side that begins at the vertex.
    pub(super) leaving: u32,
}

#[derive(Clone, Copy, Debug)]
pub(super) struct CellFace {
    pub(super) plane: HalfSpace,
    /// A side of the face.
    pub(super) first: u32,
    /// True for cut faces.
    pub(super) inner: bool,
}

/// A remaining vertex.
#[derive(Clone, Copy, Debug)]
pub(super) struct KeptVertex {
    pub(super) position: DVec3,
    pub(super) number: u32,
}

impl CellPart {
    /// An empty part, with capacity for cuts.
    pub(super) fn with_room_for(vertices: usize, sides: usize, faces: usize) -> Self {
        Self {
            vertices: Vec::with_capacity(2 * vertices),
            kept: Vec::with_capacity(2 * vertices),
            sides: Vec::with_capacity(2 * sides),
            faces: Vec::with_capacity(2 * faces),
        }
    }

    /// All of a hull, without its sides.
    pub(super) fn of(hull: &Hull, leaving: &[u32]) -> Self {
        let vertex = |(&position, &leaving): (&DVec3, &u32)| CellVertex { position, leaving };
        let kept = |(&position, number): (&DVec3, u32)| KeptVertex { position, number };
        let face = |(face, &plane): (usize, &HalfSpace)| {
            let (first, inner) = (hull.net.sides(face).start as u32, hull.net.is_inner(face));
            CellFace { plane, first, inner }
        };
        Self {
            vertices: hull.vertices.iter().zip(leaving).map(vertex).collect(),
            kept: hull.vertices.iter().zip(0..).map(kept).collect(),
            sides: Vec::new(),
            faces: hull.planes.iter().enumerate().map(face).collect(),
        }
    }

    /// Copies another part with its sides, reusing memory.
    pub(super) fn copy_from(&mut self, other: &Self, sides: &[Side]) {
        self.vertices.clone_from(&other.vertices);
        self.kept.clone_from(&other.kept);
        self.sides.clear();
        self.sides.extend_from_slice(sides);
        self.faces.clone_from(&other.faces);
    }

    /// Forgets the vertices above a cut, where `levels` are the heights of those that were kept,
    /// and puts the heights in the order of the vertices' numbers. Returns the lowest above.
    pub(super) fn keep_below(&mut self, levels: &[f64], heights: &mut [f64]) -> u32 {
        let (mut least_above, mut lowest) = (f64::INFINITY, NONE);
        let mut count = 0;
        for (at, &height) in levels.iter().enumerate() {
            let kept = self.kept[at];
            heights[kept.number as usize] = height;
            self.kept[count] = kept;
            if height < 0.0 {
                count += 1;
            } else if height < least_above {
                (least_above, lowest) = (height, kept.number);
            }
        }
        self.kept.truncate(count);
        lowest
    }

    /// Keeps the vertices that were added since there were `before`.
    pub(super) fn keep_new(&mut self, before: usize) {
        let new = self.vertices[before..].iter().zip(before as u32..);
        self.kept
            .extend(new.map(|(vertex, number)| KeptVertex { position: vertex.position, number }));
    }

    /// A side that leaves the inside of a cut, found downhill from a vertex outside.
    pub(super) fn crossing(&self, heights: &[f64], mut vertex: u32) -> Option<u32> {
        loop {
            let first = self.vertices[vertex as usize].leaving;
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
    pub(super) fn add_crossing(&mut self, heights: &[f64], side: u32) -> u32 {
        let Side { origin, next, .. } = self.sides[side as usize];
        let outside = self.sides[next as usize].origin;
        let (from, to) = (heights[origin as usize], heights[outside as usize]);
        let [start, end] = [origin, outside].map(|vertex| self.vertices[vertex as usize].position);
        let position = start + (end - start) * (from / (from - to));
        self.vertices.push(CellVertex { position, leaving: NONE });
        self.vertices.len() as u32 - 1
    }
}
