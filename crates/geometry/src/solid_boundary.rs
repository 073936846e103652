//! The part of closed surfaces that separates inside from outside.
//!
//! Where parts of a mesh overlap, pieces of its surface have the inside on both sides: they bound
//! nothing, and a distance to them would put false surfaces into a solid.

use crate::grid::Grid;
use crate::line_crossings::LineCrossings;
use glam::DVec3;
use rayon::prelude::*;

/// Probe distance in front of a triangle, in cells: less than any resolved thickness.
const PROBE: f64 = 1e-4;
/// Length in cells from which on a part of a triangle that another surface crosses is divided: the
/// error at the crease.
const CREASE: f64 = 0.125;
/// Lines closer to the border of a triangle's part than this many cells, or than this part of the
/// triangle's height, do not divide it.
const BORDER: f64 = 1e-3;

/// A straight line from point to point.
type Line = [DVec3; 2];

/// The triangles of `asked`, or parts of them, with outside in front and inside behind; none of
/// those that lie `deep` in the solid.
pub(crate) fn boundary_triangles(
    surfaces: &LineCrossings,
    asked: &[usize],
    deep: &Deep,
) -> Vec<[DVec3; 3]> {
    let spacing = deep.grid.spacing;
    let divided = |&triangle: &usize| {
        let corners = surfaces.triangles()[triangle];
        let mut pieces = Vec::new();
        if deep.holds(&corners) {
            return pieces;
        }
        if let Some(normal) = normal(&corners).try_normalize() {
            let lines = if longest_edge(&corners) > CREASE * spacing {
                meeting_lines(surfaces, triangle, normal, PROBE * spacing)
            } else {
                Vec::new()
            };
            let height = self::normal(&corners).length() / longest_edge(&corners);
            let border = BORDER * spacing.min(height);
            let probe = Probe { surfaces, deep, normal, spacing, border };
            // Keep triangles whole if they separate as a whole.
            if probe.gather(&corners, &lines, &mut pieces) {
                pieces = vec![corners];
            }
        }
        pieces
    };
    asked.par_iter().flat_map_iter(divided).collect()
}

/// Tells where a grid has inner nodes only.
pub(crate) struct Deep<'a> {
    grid: &'a Grid,
    /// Number of outer nodes below each node in all three coordinates, one row more along each.
    outer: Vec<u32>,
}

impl<'a> Deep<'a> {
    /// `winding` numbers of the nodes, above zero inside.
    pub(crate) fn new(grid: &'a Grid, winding: &[i32]) -> Self {
        let [nx, ny, nz] = grid.dims;
        let mut outer = vec![0_u32; (nx + 1) * (ny + 1) * (nz + 1)];
        let at = |i: usize, j: usize, k: usize| (k * (ny + 1) + j) * (nx + 1) + i;
        for k in 0..nz {
            for j in 0..ny {
                let mut row = 0;
                for i in 0..nx {
                    row += u32::from(winding[(k * ny + j) * nx + i] <= 0);
                    let [below, beside, both] =
                        [(j + 1, k), (j, k + 1), (j, k)].map(|(j, k)| outer[at(i + 1, j, k)]);
                    outer[at(i + 1, j + 1, k + 1)] = row + below + beside - both;
                }
            }
        }
        Self { grid, outer }
    }

    /// True if all nodes within a cell of a polygon's box are inside: nothing of it bounds what the
    /// grid can tell.
    fn holds(&self, corners: &[DVec3]) -> bool {
        let place = |point: DVec3| (point - self.grid.origin) / self.grid.spacing;
        let first = (place(lowest(corners)) - 1.0).floor().to_array();
        let last = (place(highest(corners)) + 1.0).ceil().to_array();
        let dims = self.grid.dims;
        let fits = |axis: usize| first[axis] >= 0.0 && last[axis] < dims[axis] as f64;
        if !(0..3).all(fits) {
            return false;
        }
        let (low, high) = (first.map(|n| n as usize), last.map(|n| n as usize + 1));
        let at = |i: usize, j: usize, k: usize| {
            i64::from(self.outer[(k * (dims[1] + 1) + j) * (dims[0] + 1) + i])
        };
        let slice = |k: usize| {
            at(high[0], high[1], k) - at(low[0], high[1], k) - at(high[0], low[1], k)
                + at(low[0], low[1], k)
        };
        slice(high[2]) == slice(low[2])
    }
}

/// The lines in a triangle's plane along which others meet it, or end on it.
fn meeting_lines(surfaces: &LineCrossings, triangle: usize, normal: DVec3, near: f64) -> Vec<Line> {
    let own = surfaces.triangles()[triangle];
    let (low, high) = (lowest(&own) - near, highest(&own) + near);
    let apart = |other_low: DVec3, other_high: DVec3| {
        other_low.cmpgt(high).any() || other_high.cmplt(low).any()
    };
    // Skip boxes beside the triangle's plane.
    let enters = |other_low: DVec3, other_high: DVec3| {
        let height = (0.5 * (other_low + other_high) - own[0]).dot(normal);
        let reach = (0.5 * (other_high - other_low)).dot(normal.abs());
        !apart(other_low, other_high) && height.abs() <= reach + near
    };
    let mut lines = Vec::new();
    for other in surfaces.in_boxes(enters) {
        let corners = &surfaces.triangles()[other];
        if other == triangle || apart(lowest(corners), highest(corners)) {
            continue;
        }
        let heights = corners.map(|corner| {
            let height = (corner - own[0]).dot(normal);
            if height.abs() > near { height } else { 0.0 }
        });
        if heights == [0.0; 3] {
            lines.extend((0..3).map(|k| [corners[k], corners[(k + 1) % 3]]));
            continue;
        }
        let mut ends = [DVec3::ZERO; 2];
        let mut count = 0;
        for from in 0..3 {
            let to = (from + 1) % 3;
            let end = if heights[from] == 0.0 {
                corners[from]
            } else if heights[from] * heights[to] < 0.0 {
                let along = heights[from] / (heights[from] - heights[to]);
                corners[from].lerp(corners[to], along)
            } else {
                continue;
            };
            ends[count] = end;
            count += 1;
        }
        if count == 2 {
            lines.push(ends);
        }
    }
    lines
}

/// Length of a line inside a convex polygon in the same plane, farther than `border` [m] from its
/// edges; zero if none.
fn length_within(line: &Line, polygon: &[DVec3], normal: DVec3, border: f64) -> f64 {
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for (from, &corner) in polygon.iter().enumerate() {
        let edge = polygon[(from + 1) % polygon.len()] - corner;
        let inward = normal.cross(edge).normalize_or_zero();
        let [first, last] = line.map(|point| inward.dot(point - corner) - border);
        if first <= 0.0 && last <= 0.0 {
            return 0.0;
        }
        if first < 0.0 {
            begin = begin.max(first / (first - last));
        } else if last < 0.0 {
            end = end.min(first / (first - last));
        }
    }
    (end - begin).max(0.0) * (line[1] - line[0]).length()
}

/// The two parts of a convex polygon on the left and on the right of a line in its plane.
fn divided(polygon: &[DVec3], line: &Line, normal: DVec3) -> [Vec<DVec3>; 2] {
    let left = normal.cross(line[1] - line[0]).normalize_or_zero();
    let mut parts = [Vec::with_capacity(polygon.len() + 1), Vec::with_capacity(polygon.len() + 1)];
    for (from, &corner) in polygon.iter().enumerate() {
        let next = polygon[(from + 1) % polygon.len()];
        let [here, there] = [corner, next].map(|point| left.dot(point - line[0]));
        if here >= 0.0 {
            parts[0].push(corner);
        }
        if here <= 0.0 {
            parts[1].push(corner);
        }
        if here * there < 0.0 {
            let point = corner.lerp(next, here / (here - there));
            parts.iter_mut().for_each(|part| part.push(point));
        }
    }
    parts
}

fn lowest(corners: &[DVec3]) -> DVec3 {
    corners.iter().fold(DVec3::INFINITY, |low, corner| low.min(*corner))
}

fn highest(corners: &[DVec3]) -> DVec3 {
    corners.iter().fold(DVec3::NEG_INFINITY, |high, corner| high.max(*corner))
}

fn longest_edge(&[a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).length().max((c - b).length()).max((a - c).length())
}

fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

/// Asks on which sides of a triangle the inside is.
struct Probe<'a> {
    surfaces: &'a LineCrossings<'a>,
    deep: &'a Deep<'a>,
    /// Unit.
    normal: DVec3,
    /// Of the grid [m].
    spacing: f64,
    /// Lines that are closer to the border [m] do not divide.
    border: f64,
}

impl Probe<'_> {
    /// True if the outside begins in front of a point of the triangle and the inside behind it, one
    /// winding more.
    fn separates(&self, point: DVec3) -> bool {
        self.surfaces.winding(point + self.normal * (PROBE * self.spacing)) == 0
    }

    /// Collects the separating parts of a convex polygon, in triangles; returns true if all of it
    /// separates. `lines` may divide it.
    fn gather(&self, polygon: &[DVec3], lines: &[Line], pieces: &mut Vec<[DVec3; 3]>) -> bool {
        if polygon.len() < 3 || self.deep.holds(polygon) {
            return polygon.len() < 3;
        }

        // Divide along the line with the largest length inside: beside a line the answers may
        // differ.
        let size = (highest(polygon) - lowest(polygon)).max_element();
        let within = |line: &Line| length_within(line, polygon, self.normal, self.border);
        let own: Vec<(f64, Line)> = if size > CREASE * self.spacing {
            lines.iter().map(|line| (within(line), *line)).filter(|line| line.0 > 0.0).collect()
        } else {
            Vec::new()
        };
        let longest = (0..own.len()).max_by(|&a, &b| own[a].0.total_cmp(&own[b].0));
        if let Some(longest) = longest {
            // Use each line once, regardless of rounding in its distance from the parts' borders.
            let mut own: Vec<Line> = own.into_iter().map(|line| line.1).collect();
            let longest = own.remove(longest);
            let [left, right] = divided(polygon, &longest, self.normal);
            let whole = self.gather(&left, &own, pieces);
            return self.gather(&right, &own, pieces) && whole;
        }
        let middle = polygon.iter().sum::<DVec3>() / polygon.len() as f64;
        let separates = self.separates(middle);
        if separates {
            pieces.extend((1..polygon.len() - 1).map(|n| [polygon[0], polygon[n], polygon[n + 1]]));
        }
        separates
    }
}
