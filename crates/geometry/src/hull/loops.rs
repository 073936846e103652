//! Faces as loops of vertices, in one list.

use super::{HullEdge, sides};
use crate::HalfSpace;
use glam::DVec3;
use std::ops::Range;

/// The polygons of a hull, counter-clockwise seen from outside.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Loops {
    /// Vertex indices, loop after loop.
    corners: Vec<u32>,
    /// Where each loop ends in `corners`.
    ends: Vec<u32>,
    /// Whether a cut made the face.
    inner: Vec<bool>,
}

impl Loops {
    pub(super) fn push(&mut self, inner: bool, corners: impl IntoIterator<Item = u32>) {
        self.corners.extend(corners);
        self.ends.push(self.corners.len() as u32);
        self.inner.push(inner);
    }

    pub(super) fn clear(&mut self) {
        self.corners.clear();
        self.ends.clear();
        self.inner.clear();
    }

    /// Becomes a copy of another, in the memory it has.
    pub(super) fn copy_from(&mut self, other: &Self) {
        self.corners.clone_from(&other.corners);
        self.ends.clone_from(&other.ends);
        self.inner.clone_from(&other.inner);
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

    pub(super) fn is_inner(&self, face: usize) -> bool {
        self.inner[face]
    }

    /// The same faces, none of them made by a cut.
    pub(super) fn all_outer(mut self) -> Self {
        self.inner.fill(false);
        self
    }

    /// How many faces each of `count` vertices has.
    fn faces_at(&self, count: usize) -> Vec<u32> {
        let mut faces_at = vec![0_u32; count];
        for &vertex in &self.corners {
            faces_at[vertex as usize] += 1;
        }
        faces_at
    }

    /// Leaves out vertices with less than three faces and faces with less than three vertices until there are none.
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
                let corners = || old.of(face).iter().copied().filter(|&vertex| faces_at[vertex as usize] > 2);
                if corners().count() > 2 {
                    self.push(old.inner[face], corners());
                    kept.push(*plane);
                }
            }
            *planes = kept;
        }
    }

    /// Makes one vertex of both ends of each side that is shorter than `shortest` [m]. False if there is none.
    pub(super) fn collapse(&mut self, vertices: &[DVec3], shortest: f64) -> bool {
        let is_short = |[a, b]: [u32; 2]| {
            vertices[a as usize].distance_squared(vertices[b as usize]) < shortest * shortest
        };
        if !(0..self.len()).any(|face| sides(self.of(face)).any(is_short)) {
            return false;
        }
        let mut stands_for: Vec<u32> = (0..vertices.len() as u32).collect();
        for side in (0..self.len()).flat_map(|face| sides(self.of(face))).filter(|&side| is_short(side)) {
            let [a, b] = side.map(|vertex| stands_for[vertex as usize]);
            stands_for.iter_mut().filter(|vertex| **vertex == a.max(b)).for_each(|vertex| *vertex = a.min(b));
        }
        let old = std::mem::take(self);
        for face in 0..old.len() {
            let mut corners: Vec<u32> =
                old.of(face).iter().map(|&vertex| stands_for[vertex as usize]).collect();
            corners.dedup();
            while corners.len() > 1 && corners.first() == corners.last() {
                corners.pop();
            }
            self.push(old.inner[face], corners);
        }
        true
    }

    /// Copies the vertices that are used to `used`, in their order, and numbers them anew.
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

    /// The edge along each side of the loops and all edges, in the order of the faces; `None` if a side does not have one that
    /// runs along it in the opposite direction.
    pub(super) fn connected(&self) -> Option<(Vec<u32>, Vec<HullEdge>)> {
        // A side and its opposite have the same two ends: side by side when sorted by them.
        let mut by_ends: Vec<(u64, u32, u32)> = Vec::with_capacity(self.corners.len());
        for face in 0..self.len() {
            let first = self.range(face).start;
            for (at, [a, b]) in sides(self.of(face)).enumerate() {
                let ends = u64::from(a.min(b)) << 32 | u64::from(a.max(b));
                by_ends.push((ends, (first + at) as u32, face as u32));
            }
        }
        by_ends.sort_unstable();
        let mut beside = vec![(0_u32, 0_u32); self.corners.len()];
        for pair in by_ends.chunks(2) {
            let &[(ends, first, face), (ends_too, second, other)] = pair else { return None };
            if ends != ends_too || self.corners[first as usize] == self.corners[second as usize] {
                return None;
            }
            beside[first as usize] = (second, other);
            beside[second as usize] = (first, face);
        }
        if by_ends.windows(3).any(|three| three[0].0 == three[2].0) {
            return None;
        }

        // Number the edges where they are met first.
        let mut edges = Vec::with_capacity(self.corners.len() / 2);
        let mut edges_along = vec![0_u32; self.corners.len()];
        for face in 0..self.len() {
            let first = self.range(face).start;
            for (at, vertices) in sides(self.of(face)).enumerate() {
                let side = first + at;
                let (opposite, other) = beside[side];
                edges_along[side] = if (opposite as usize) < side {
                    edges_along[opposite as usize]
                } else {
                    edges.push(HullEdge { vertices, faces: [face as u32, other] });
                    edges.len() as u32 - 1
                };
            }
        }
        Some((edges_along, edges))
    }
}
