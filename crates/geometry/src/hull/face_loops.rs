//! Faces as loops of vertices, in one list.

use crate::half_space::HalfSpace;
use crate::hull::edges::{HullEdge, sides};
use glam::DVec3;
use std::ops::Range;

/// The polygons of a hull, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct FaceLoops {
    /// Vertex indices, loop after loop.
    corners: Vec<u32>,
    /// Where each loop ends in `corners`.
    ends: Vec<u32>,
    /// True for cut faces.
    inner: Vec<bool>,
}

/// Nothing, in lists of indices.
const NONE: u32 = u32::MAX;

/// From a corner of a loop to the next.
#[derive(Clone, Copy)]
struct Side {
    to: u32,
    face: u32,
    /// Another side from the same vertex.
    next: u32,
    /// The opposite side, once known.
    opposite: u32,
}

impl FaceLoops {
    pub(super) fn push(&mut self, inner: bool, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u32);
        self.inner.push(inner);
    }

    /// Adds corners to a loop that is not finished.
    pub(super) fn add(&mut self, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
    }

    /// Makes a face of the corners that were added, if they are three at least.
    pub(super) fn finish(&mut self, inner: bool) -> bool {
        let start = self.ends.last().map_or(0, |&end| end as usize);
        let is_face = self.corners.len() > start + 2;
        if is_face {
            self.ends.push(self.corners.len() as u32);
            self.inner.push(inner);
        } else {
            self.corners.truncate(start);
        }
        is_face
    }

    pub(super) fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
        self.inner.clear();
    }

    pub(super) fn len(&self) -> usize {
        self.ends.len()
    }

    /// Where a face's loop is among all corners.
    pub(super) fn range(&self, face: usize) -> Range<usize> {
        let start = if face == 0 { 0 } else { self.ends[face - 1] as usize };
        start..self.ends[face] as usize
    }

    /// The loop of a face.
    pub(super) fn of(&self, face: usize) -> &[u32] {
        &self.corners[self.range(face)]
    }

    /// One of all corners.
    pub(super) fn corner(&self, at: usize) -> u32 {
        self.corners[at]
    }

    pub(super) fn is_inner(&self, face: usize) -> bool {
        self.inner[face]
    }

    /// Number of faces at each of `count` vertices.
    fn faces_at(&self, count: usize) -> Vec<u32> {
        let mut faces_at = vec![0_u32; count];
        for &vertex in &self.corners {
            faces_at[vertex as usize] += 1;
        }
        faces_at
    }

    /// Leaves out vertices with less than three faces and faces with less than three vertices until
    /// there are none.
    pub(super) fn straighten(&mut self, count: usize, planes: &mut Vec<HalfSpace>) {
        loop {
            let faces_at = self.faces_at(count);
            let is_straight = faces_at.iter().all(|&faces| faces == 0 || faces > 2)
                && (0..self.len()).all(|face| self.range(face).len() > 2);
            if is_straight {
                return;
            }
            let old = std::mem::take(self);
            let mut kept = Vec::with_capacity(planes.len());
            for (face, plane) in planes.iter().enumerate() {
                let corners =
                    || old.of(face).iter().copied().filter(|&vertex| faces_at[vertex as usize] > 2);
                if corners().count() > 2 {
                    self.push(old.inner[face], corners());
                    kept.push(*plane);
                }
            }
            *planes = kept;
        }
    }

    /// With one vertex for both ends of each side that is shorter than `shortest` [m]; `None` if
    /// there is none.
    pub(super) fn collapsed(&self, vertices: &[DVec3], shortest: f64) -> Option<Self> {
        let is_short = |[a, b]: [u32; 2]| {
            vertices[a as usize].distance_squared(vertices[b as usize]) < shortest * shortest
        };
        if !(0..self.len()).any(|face| sides(self.of(face)).any(is_short)) {
            return None;
        }
        let mut stands_for: Vec<u32> = (0..vertices.len() as u32).collect();
        for side in
            (0..self.len()).flat_map(|face| sides(self.of(face))).filter(|&side| is_short(side))
        {
            let [a, b] = side.map(|vertex| stands_for[vertex as usize]);
            stands_for
                .iter_mut()
                .filter(|vertex| **vertex == a.max(b))
                .for_each(|vertex| *vertex = a.min(b));
        }
        let mut collapsed = Self::default();
        for face in 0..self.len() {
            let mut corners: Vec<u32> =
                self.of(face).iter().map(|&vertex| stands_for[vertex as usize]).collect();
            corners.dedup();
            while corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            collapsed.push(self.inner[face], corners);
        }
        Some(collapsed)
    }

    /// Copies used vertices to `used` in order, and renumbers them.
    pub(super) fn renumber(&mut self, vertices: &[DVec3], used: &mut Vec<DVec3>) {
        let mut number = self.faces_at(vertices.len());
        used.clear();
        for (number, &vertex) in number.iter_mut().zip(vertices).filter(|(faces, _)| **faces > 0) {
            *number = used.len() as u32;
            used.push(vertex);
        }
        for corner in &mut self.corners {
            *corner = number[*corner as usize];
        }
    }

    /// The edge along each side of the loops and all edges, in the order of the faces; `None` if a
    /// side does not have one that runs along it in the opposite direction.
    pub(super) fn connected(&self) -> Option<(Vec<u32>, Vec<HullEdge>)> {
        // Lists of sides by start vertex, with their ends and faces.
        let count = self.corners.iter().fold(0, |most, &vertex| most.max(vertex as usize + 1));
        let mut first_from = vec![NONE; count];
        let mut sides_of: Vec<Side> = Vec::with_capacity(self.corners.len());
        for face in 0..self.len() {
            for [a, to] in sides(self.of(face)) {
                let next = std::mem::replace(&mut first_from[a as usize], sides_of.len() as u32);
                sides_of.push(Side { to, face: face as u32, next, opposite: NONE });
            }
        }

        // Number the edges where they are met first.
        let mut edges = Vec::with_capacity(self.corners.len() / 2);
        let mut edges_along = vec![0_u32; self.corners.len()];
        for at in 0..sides_of.len() {
            let (from, Side { to, face, opposite: known, .. }) = (self.corners[at], sides_of[at]);
            let mut opposite = first_from[to as usize];
            while opposite != NONE && sides_of[opposite as usize].to != from {
                opposite = sides_of[opposite as usize].next;
            }
            if opposite == NONE || known != NONE && known != opposite {
                return None;
            }
            let beside = &mut sides_of[opposite as usize];
            if beside.opposite != NONE && beside.opposite != at as u32 {
                return None;
            }
            beside.opposite = at as u32;
            edges_along[at] = if (opposite as usize) < at {
                edges_along[opposite as usize]
            } else {
                edges.push(HullEdge { vertices: [from, to], faces: [face, beside.face] });
                edges.len() as u32 - 1
            };
        }
        Some((edges_along, edges))
    }
}
