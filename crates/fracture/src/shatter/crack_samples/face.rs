//! A face in its plane, and the lines that its points lie on.

use glam::{DVec2, DVec3};

/// Points on neighbouring lines.
#[derive(Default)]
pub(super) struct Lines {
    pub(super) points: Vec<DVec3>,
    /// Where the points of each line end.
    pub(super) ends: Vec<usize>,
}

impl Lines {
    /// The points of one line.
    fn line(&self, line: usize) -> &[DVec3] {
        let start = if line == 0 { 0 } else { self.ends[line - 1] };
        &self.points[start..self.ends[line]]
    }

    /// All points, a tile of neighbouring lines after the other.
    pub(super) fn in_tiles(&self, mut take: impl FnMut(&[DVec3])) {
        // Samples per tile side, to fill a cluster.
        const TILE: usize = 4;
        for first_line in (0..self.ends.len()).step_by(TILE) {
            let band = first_line..(first_line + TILE).min(self.ends.len());
            let longest = band.clone().map(|line| self.line(line).len()).max().unwrap_or(0);
            for first in (0..longest).step_by(TILE) {
                for line in band.clone() {
                    let points = self.line(line);
                    let tile = first.min(points.len())..(first + TILE).min(points.len());
                    take(&points[tile]);
                }
            }
        }
    }
}

/// A face in its plane.
pub(super) struct Face {
    /// Its sides.
    pub(super) flat: Vec<[DVec2; 2]>,
    origin: DVec3,
    pub(super) along: DVec3,
    pub(super) across: DVec3,
}

impl Face {
    /// The plane's axes are along the longest edge, and across.
    pub(super) fn new(corners: &[DVec3], normal: DVec3) -> Self {
        let mut longest = DVec3::ZERO;
        for [start, end] in sides(corners) {
            if (end - start).length_squared() > longest.length_squared() {
                longest = end - start;
            }
        }
        let (origin, along) = (corners[0], longest.normalize_or_zero());
        let across = normal.cross(along);
        let flat =
            |corner: DVec3| DVec2::new((corner - origin).dot(along), (corner - origin).dot(across));
        let flat = sides(corners).map(|side| side.map(flat)).collect();
        Self { flat, origin, along, across }
    }

    pub(super) fn point(&self, flat: DVec2) -> DVec3 {
        self.origin + self.along * flat.x + self.across * flat.y
    }
}

/// The lines along x that divide a convex polygon into strips at most `spacing` wide: both ends of
/// each. Its sides go from each corner to the next.
pub(super) fn face_lines(sides: &[[DVec2; 2]], spacing: f64) -> impl Iterator<Item = [DVec2; 2]> {
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
pub(super) fn sides<T: Copy>(corners: &[T]) -> impl Iterator<Item = [T; 2]> {
    (0..corners.len())
        .map(|at| [corners[at], corners[if at + 1 < corners.len() { at + 1 } else { 0 }]])
}
