//! Points on the faces that a break uncovers, and on their rims.

mod parent;

use crate::{
    Placement,
    pattern::{Cut, Region},
    polygon,
};
use glam::{DVec2, DVec3};
pub(crate) use parent::Parent;

/// Points on the cracks around a region, face after face.
#[derive(Debug, Default)]
pub(crate) struct CrackSamples {
    /// Grid frame [m].
    points: Vec<DVec3>,
    /// Of all faces [m].
    corners: Vec<DVec3>,
    /// Where each face's points and corners end, and its normal.
    faces: Vec<([usize; 2], DVec3)>,
}

/// One of a region's cracks.
#[derive(Clone, Copy, Debug)]
pub(crate) struct CrackFace<'a> {
    /// Grid frame [m].
    pub(crate) points: &'a [DVec3],
    /// Of a polygon that holds all of them [m].
    pub(crate) corners: &'a [DVec3],
    /// Out of the region.
    pub(crate) normal: DVec3,
}

impl CrackSamples {
    fn clear(&mut self) {
        self.points.clear();
        self.corners.clear();
        self.faces.clear();
    }

    /// Makes a face of the points that were added since the last one.
    fn end_face(&mut self, corners: &[DVec3], normal: DVec3) {
        self.corners.extend_from_slice(corners);
        self.faces.push(([self.points.len(), self.corners.len()], normal));
    }

    /// In order.
    pub(crate) fn faces(&self) -> impl Iterator<Item = CrackFace<'_>> {
        let starts = std::iter::once([0; 2]).chain(self.faces.iter().map(|&(ends, _)| ends));
        starts.zip(&self.faces).map(|(starts, &(ends, normal))| CrackFace {
            points: &self.points[starts[0]..ends[0]],
            corners: &self.corners[starts[1]..ends[1]],
            normal,
        })
    }
}

impl<'a> Sampler<'a> {
    /// Of cracks within the parent, by points about `spacing` [m] apart.
    pub(crate) fn new(parent: &'a Parent<'a>, spacing: f64) -> Self {
        let (samples, edges, corners) = (CrackSamples::default(), Vec::new(), Vec::new());
        Self { parent, spacing, samples, edges, corners, lines: Lines::default() }
    }

    /// Points of all cracks around a region, whose faces are still those of the pattern: corners, edges, rims, and the faces between
    /// them. Neighbours follow each other.
    pub(crate) fn sample(
        &mut self,
        planes: &Region,
        placement: &Placement,
        of_pattern: &Region,
    ) -> &CrackSamples {
        self.samples.clear();
        self.edges.clear();
        self.corners.clear();
        for (cut, Cut { face, .. }) in planes.cuts.iter().zip(&of_pattern.cuts) {
            if self.parent.misses(&cut.half_space) {
                continue;
            }
            // What is flat cuts the face exactly, so that its corners are the fragment's corners.
            let mut face: Vec<DVec3> = face.iter().map(|&corner| placement.point(corner)).collect();
            for wall in &self.parent.walls {
                if face.is_empty() {
                    break;
                }
                if face.iter().any(|&corner| wall.distance(corner) > 0.0) {
                    face = polygon::clip(&face, wall);
                }
            }
            if face.len() >= 3 {
                self.sample_face(&face, cut.half_space.normal);
            }
        }
        &self.samples
    }
}

/// Collects samples of the faces of one region, in memory that it keeps from one to the next.
pub(crate) struct Sampler<'a> {
    parent: &'a Parent<'a>,
    spacing: f64,
    samples: CrackSamples,
    /// The edges and corners that another face has brought already.
    edges: Vec<(DVec3, DVec3)>,
    corners: Vec<DVec3>,
    /// Of the face that is being sampled.
    lines: Lines,
}

/// Points on neighbouring lines.
#[derive(Default)]
struct Lines {
    points: Vec<DVec3>,
    /// Where the points of each line end.
    ends: Vec<usize>,
}

impl Lines {
    /// The points of one line.
    fn line(&self, line: usize) -> &[DVec3] {
        let start = if line == 0 { 0 } else { self.ends[line - 1] };
        &self.points[start..self.ends[line]]
    }

    /// All points, a tile of neighbouring lines after the other.
    fn in_tiles(&self, mut take: impl FnMut(DVec3)) {
        // As many as fill a cluster.
        const TILE: usize = 4;
        for first_line in (0..self.ends.len()).step_by(TILE) {
            let band = first_line..(first_line + TILE).min(self.ends.len());
            let longest = band.clone().map(|line| self.line(line).len()).max().unwrap_or(0);
            for first in (0..longest).step_by(TILE) {
                for line in band.clone() {
                    let points = self.line(line);
                    let tile = first.min(points.len())..(first + TILE).min(points.len());
                    points[tile].iter().copied().for_each(&mut take);
                }
            }
        }
    }
}

/// A face in its plane.
struct Face<'a> {
    corners: &'a [DVec3],
    /// Its sides.
    flat: Vec<[DVec2; 2]>,
    origin: DVec3,
    along: DVec3,
    across: DVec3,
}

impl Face<'_> {
    fn point(&self, flat: DVec2) -> DVec3 {
        self.origin + self.along * flat.x + self.across * flat.y
    }
}

impl Sampler<'_> {
    fn sample_face(&mut self, corners: &[DVec3], normal: DVec3) {
        // The plane's axes: along the longest edge, and across.
        let mut longest = DVec3::ZERO;
        for [start, end] in sides(corners) {
            if (end - start).length_squared() > longest.length_squared() {
                longest = end - start;
            }
        }
        let along = longest.normalize_or_zero();
        let across = normal.cross(along);
        let flat =
            |corner: DVec3| DVec2::new((corner - corners[0]).dot(along), (corner - corners[0]).dot(across));
        let flat = sides(corners).map(|side| side.map(flat)).collect();
        let face = Face { corners, flat, origin: corners[0], along, across };

        self.sample_inside(&face);
        self.sample_edges(&face);
        self.samples.end_face(corners, normal);
    }

    /// Points on lines along the longest edge, and where these leave the parent; where the rim runs along them, lines across
    /// find it.
    fn sample_inside(&mut self, face: &Face) {
        self.lines.points.clear();
        self.lines.ends.clear();
        let mut stretches = Vec::new();
        for [from, to] in face_lines(&face.flat, self.spacing) {
            let (start, end) = (face.point(from), face.point(to));
            self.parent.inside(start, end, self.spacing, &mut stretches);
            for &stretch in &stretches {
                let [from, to] = stretch.map(|at| start.lerp(end, at));
                let steps = (from.distance(to) / self.spacing - 1e-9).ceil().max(1.0);
                if stretch[0] > 0.0 && self.crosses_rim(from, face.along, face.across) {
                    self.lines.points.push(from);
                }
                let way = (to - from) / steps;
                self.lines.points.extend((1..steps as usize).map(|step| from + way * step as f64));
                if stretch[1] < 1.0 && self.crosses_rim(to, face.along, face.across) {
                    self.lines.points.push(to);
                }
            }
            self.lines.ends.push(self.lines.points.len());
        }
        let points = &mut self.samples.points;
        points.reserve(self.lines.points.len());
        self.lines.in_tiles(|point| points.push(point));

        if self.parent.is_flat() {
            return;
        }
        let turn = |side: &[DVec2; 2]| side.map(|corner| DVec2::new(-corner.y, corner.x));
        let turned: Vec<[DVec2; 2]> = face.flat.iter().map(turn).collect();
        for line in face_lines(&turned, self.spacing) {
            let [start, end] = line.map(|flat| face.point(DVec2::new(flat.y, -flat.x)));
            self.parent.inside(start, end, self.spacing, &mut stretches);
            for stretch in &stretches {
                for at in stretch.iter().filter(|&&at| at > 0.0 && at < 1.0) {
                    let rim = start.lerp(end, *at);
                    if !self.crosses_rim(rim, face.along, face.across) {
                        self.samples.points.push(rim);
                    }
                }
            }
        }
    }

    /// Whether a line along `along` crosses the parent's surface more steeply than one along `across` would.
    fn crosses_rim(&self, point: DVec3, along: DVec3, across: DVec3) -> bool {
        let normal = self.parent.normal(point);
        normal.dot(along).abs() >= normal.dot(across).abs()
    }

    /// Corners and points of edges, and where the edges leave the parent; those that no other face has brought.
    fn sample_edges(&mut self, face: &Face) {
        let same = 1e-6 * self.spacing;
        let is_same = |a: DVec3, b: DVec3| (a - b).abs().max_element() < same;
        let tolerance = 0.1 * same.max(0.5 * self.spacing);
        let mut stretches = Vec::new();
        for [start, end] in sides(face.corners) {
            // Points of edges that lie in the parent's surface are off it by round-off, or by a sampled root's interpolation.
            let known = self.corners.iter().any(|&corner| is_same(corner, start));
            if !known && self.parent.distance(start) <= tolerance {
                self.corners.push(start);
                self.samples.points.push(start);
            }
            let known = self.edges.iter().any(|&(a, b)| {
                (is_same(a, start) && is_same(b, end)) || (is_same(a, end) && is_same(b, start))
            });
            if known {
                continue;
            }
            self.edges.push((start, end));
            self.parent.inside(start, end, self.spacing, &mut stretches);
            for &stretch in &stretches {
                let [from, to] = stretch.map(|at| start.lerp(end, at));
                let steps = (from.distance(to) / self.spacing - 1e-9).ceil().max(1.0);
                let first = if stretch[0] > 0.0 { 0 } else { 1 };
                let last = if stretch[1] < 1.0 { steps as usize } else { steps as usize - 1 };
                let way = (to - from) / steps;
                self.samples.points.extend((first..=last).map(|step| from + way * step as f64));
            }
        }
    }
}

/// The lines along x that divide a convex polygon into strips at most `spacing` wide: both ends of each. Its sides go from each corner
/// to the next.
fn face_lines(sides: &[[DVec2; 2]], spacing: f64) -> impl Iterator<Item = [DVec2; 2]> {
    let low = sides.iter().fold(f64::INFINITY, |low, [corner, _]| low.min(corner.y));
    let high = sides.iter().fold(f64::NEG_INFINITY, |high, [corner, _]| high.max(corner.y));
    let count = ((high - low) / spacing - 1e-9).ceil() as usize;
    (1..count).filter_map(move |line| {
        let y = low + (high - low) * line as f64 / count as f64;
        let mut ends = sides.iter().filter(|[start, end]| (start.y <= y) != (end.y <= y));
        let mut next = || {
            let [start, end] = ends.next()?;
            Some(DVec2::new(start.x + (end.x - start.x) * ((y - start.y) / (end.y - start.y)), y))
        };
        Some([next()?, next()?])
    })
}

/// From each corner of a polygon to the next.
fn sides<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 2]> {
    (0..corners.len()).map(|at| [corners[at], corners[if at + 1 < corners.len() { at + 1 } else { 0 }]])
}
