//! Points on the faces that a break uncovers, and on their rims.

pub(crate) mod face;
pub(crate) mod parent;

use crate::pattern::region::{Cut, Region};
use crate::placement::Placement;
use crate::polygon;
use face::{Face, Lines, face_lines, sides};
use frangible_geometry::HalfSpace;
use glam::{DVec2, DVec3};
pub(crate) use parent::Parent;
use std::ops::Range;

/// A crack of a region.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CrackFace<'a> {
    /// Between its edges; grid frame [m].
    inner: &'a [DVec3],
    /// Samples on edges not covered by the region's earlier faces [m].
    on_edges: &'a [DVec3],
    /// Corners of a polygon that contains all samples [m].
    pub(crate) corners: &'a [DVec3],
    /// Out of the region.
    pub(crate) normal: DVec3,
}

impl<'a> CrackFace<'a> {
    /// Grid frame [m].
    pub(crate) fn points(self) -> impl Iterator<Item = &'a DVec3> {
        self.inner.iter().chain(self.on_edges)
    }
}

/// A face of a pattern in the parent, common to two regions.
struct SharedFace {
    /// Half-space of the region with the first sample.
    half_space: HalfSpace,
    /// Where its corners are in `placed`.
    placed: Range<usize>,
    /// Where those of what is cut off by the parent's flat pieces are in `corners`.
    corners: Range<usize>,
    /// Where the points between its edges are in `points`.
    points: Range<usize>,
}

/// Collects samples of the faces of regions, one region after the other.
pub(crate) struct Sampler<'a> {
    parent: &'a Parent<'a>,
    spacing: f64,
    /// All sampled faces, and their data; grid frame [m].
    shared: Vec<SharedFace>,
    placed: Vec<DVec3>,
    corners: Vec<DVec3>,
    points: Vec<DVec3>,
    /// The faces of the last region: which they are, where their points on edges end, and the
    /// normal out of the region.
    faces: Vec<(usize, usize, DVec3)>,
    on_edges: Vec<DVec3>,
    /// Edges and corners already covered by a face.
    known_edges: Vec<[DVec3; 2]>,
    known_corners: Vec<DVec3>,
    scratch: Scratch,
}

/// Memory for the face that is being sampled.
#[derive(Default)]
struct Scratch {
    clipped: Vec<DVec3>,
    lines: Lines,
    stretches: Vec<[f64; 2]>,
}

impl<'a> Sampler<'a> {
    /// Of cracks within the parent, by points about `spacing` [m] apart.
    pub(crate) fn new(parent: &'a Parent<'a>, spacing: f64) -> Self {
        Self {
            parent,
            spacing,
            shared: Vec::new(),
            placed: Vec::new(),
            corners: Vec::new(),
            points: Vec::new(),
            faces: Vec::new(),
            on_edges: Vec::new(),
            known_edges: Vec::new(),
            known_corners: Vec::new(),
            scratch: Scratch::default(),
        }
    }

    /// Points of all cracks around a region, whose faces are still those of the pattern: corners,
    /// edges, rims, and the faces between them. Neighbours follow each other. The two regions on
    /// both sides of a face have the same points between its edges.
    pub(crate) fn sample(
        &mut self,
        planes: &Region,
        placement: &Placement,
        of_pattern: &Region,
    ) -> impl Iterator<Item = CrackFace<'_>> {
        self.faces.clear();
        self.on_edges.clear();
        self.known_edges.clear();
        self.known_corners.clear();
        for (Cut { half_space, .. }, Cut { face, .. }) in planes.cuts.iter().zip(&of_pattern.cuts) {
            if self.parent.misses(half_space) {
                continue;
            }
            let placed = self.placed.len();
            self.placed.extend(face.iter().map(|&corner| placement.point(corner)));
            let shared = match self.other_side(half_space, placed) {
                Some(shared) => {
                    self.placed.truncate(placed);
                    shared
                }
                None => {
                    if !self.sample_face(half_space, placed) {
                        continue;
                    }
                    self.shared.len() - 1
                }
            };
            self.sample_edges(shared);
            self.faces.push((shared, self.on_edges.len(), half_space.normal));
        }

        let starts = std::iter::once(0).chain(self.faces.iter().map(|&(_, end, _)| end));
        starts.zip(&self.faces).map(|(start, &(shared, end, normal))| {
            let SharedFace { points, corners, .. } = &self.shared[shared];
            CrackFace {
                inner: &self.points[points.clone()],
                on_edges: &self.on_edges[start..end],
                corners: &self.corners[corners.clone()],
                normal,
            }
        })
    }

    /// The face with the corners that are placed last, if it was sampled for the region across.
    fn other_side(&self, half_space: &HalfSpace, placed: usize) -> Option<usize> {
        let same = SAME * self.spacing;
        let corners = &self.placed[placed..];
        let is_corner = |corner: &DVec3| corners.iter().any(|&other| is_same(*corner, other, same));
        self.shared.iter().position(|SharedFace { half_space: other, placed, .. }| {
            (half_space.offset + other.offset).abs() < same
                && is_same(half_space.normal, -other.normal, SAME)
                && placed.len() == corners.len()
                && self.placed[placed.clone()].iter().all(is_corner)
        })
    }
}

/// Points this close to each other are the same; in units of the distance between samples.
const SAME: f64 = 1e-6;

fn is_same(a: DVec3, b: DVec3, same: f64) -> bool {
    (a - b).abs().max_element() < same
}

impl Sampler<'_> {
    /// Samples the face with the corners that are placed last, without its edges. False, and
    /// nothing done, if none of it is left within the parent's flat pieces.
    fn sample_face(&mut self, half_space: &HalfSpace, placed: usize) -> bool {
        // Flat surfaces cut the face exactly: its corners are the fragment's corners.
        let (start, clipped) = (self.corners.len(), &mut self.scratch.clipped);
        self.corners.extend_from_slice(&self.placed[placed..]);
        for wall in &self.parent.walls {
            if self.corners[start..].iter().any(|&corner| wall.distance(corner) > 0.0) {
                clipped.clear();
                polygon::clip_into(&self.corners[start..], wall, clipped);
                self.corners.truncate(start);
                self.corners.append(clipped);
            }
        }
        if self.corners.len() < start + 3 {
            self.corners.truncate(start);
            self.placed.truncate(placed);
            return false;
        }
        let first_point = self.points.len();
        self.sample_inside(start, half_space.normal);
        self.shared.push(SharedFace {
            half_space: *half_space,
            placed: placed..self.placed.len(),
            corners: start..self.corners.len(),
            points: first_point..self.points.len(),
        });
        true
    }

    /// Points of the face with the last corners on lines along its longest edge, and where these
    /// leave the parent; where the rim runs along them, lines across find it.
    fn sample_inside(&mut self, first_corner: usize, normal: DVec3) {
        let face = Face::new(&self.corners[first_corner..], normal);
        let Scratch { lines, stretches, .. } = &mut self.scratch;
        let Self { parent, spacing, .. } = *self;
        lines.points.clear();
        lines.ends.clear();
        for [from, to] in face_lines(&face.flat, spacing) {
            let (start, end) = (face.point(from), face.point(to));
            parent.inside(start, end, spacing, stretches);
            for &stretch in stretches.iter() {
                let [from, to] = stretch.map(|at| start.lerp(end, at));
                let steps = (from.distance(to) / spacing - 1e-9).ceil().max(1.0);
                if stretch[0] > 0.0 && parent.crosses_rim(from, face.along, face.across) {
                    lines.points.push(from);
                }
                let way = (to - from) / steps;
                lines.points.extend((1..steps as usize).map(|step| from + way * step as f64));
                if stretch[1] < 1.0 && parent.crosses_rim(to, face.along, face.across) {
                    lines.points.push(to);
                }
            }
            lines.ends.push(lines.points.len());
        }
        let points = &mut self.points;
        points.reserve(lines.points.len());
        lines.in_tiles(|tile| points.extend_from_slice(tile));

        if parent.is_flat() {
            return;
        }
        let turn = |side: &[DVec2; 2]| side.map(|corner| DVec2::new(-corner.y, corner.x));
        let turned: Vec<[DVec2; 2]> = face.flat.iter().map(turn).collect();
        for line in face_lines(&turned, spacing) {
            let [start, end] = line.map(|flat| face.point(DVec2::new(flat.y, -flat.x)));
            parent.inside(start, end, spacing, stretches);
            for stretch in stretches.iter() {
                for at in stretch.iter().filter(|&&at| at > 0.0 && at < 1.0) {
                    let rim = start.lerp(end, *at);
                    if !parent.crosses_rim(rim, face.along, face.across) {
                        points.push(rim);
                    }
                }
            }
        }
    }

    /// Corners and points of a face's edges, and where the edges leave the parent; those that no
    /// other face has brought.
    fn sample_edges(&mut self, face: usize) {
        let same = SAME * self.spacing;
        let tolerance = 0.1 * same.max(0.5 * self.spacing);
        let stretches = &mut self.scratch.stretches;
        for [start, end] in sides(&self.corners[self.shared[face].corners.clone()]) {
            // Points of edges that lie in the parent's surface are off it by round-off, or by a
            // sampled root's interpolation.
            let known = self.known_corners.iter().any(|&corner| is_same(corner, start, same));
            if !known && self.parent.distance(start) <= tolerance {
                self.known_corners.push(start);
                self.on_edges.push(start);
            }
            let known = self.known_edges.iter().any(|&[a, b]| {
                (is_same(a, start, same) && is_same(b, end, same))
                    || (is_same(a, end, same) && is_same(b, start, same))
            });
            if known {
                continue;
            }
            self.known_edges.push([start, end]);
            self.parent.inside(start, end, self.spacing, stretches);
            for &stretch in stretches.iter() {
                let [from, to] = stretch.map(|at| start.lerp(end, at));
                let steps = (from.distance(to) / self.spacing - 1e-9).ceil().max(1.0);
                let first = if stretch[0] > 0.0 { 0 } else { 1 };
                let last = if stretch[1] < 1.0 { steps as usize } else { steps as usize - 1 };
                let way = (to - from) / steps;
                self.on_edges.extend((first..=last).map(|step| from + way * step as f64));
            }
        }
    }
}

#[cfg(test)]
mod tests;
