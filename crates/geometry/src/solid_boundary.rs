//! The part of closed surfaces that separates inside from outside.
//!
//! Where parts of a mesh overlap, pieces of its surface have the inside on both sides: they bound
//! nothing, and a distance to them would put false surfaces into a solid.

use crate::line_crossings::LineCrossings;
use glam::DVec3;
use rayon::prelude::*;

/// How far in front of a triangle its front side is probed, in cells: less than any thickness that
/// a grid resolves.
const PROBE: f64 = 1e-4;
/// Length in cells up to which a triangle that another surface meets is probed in a few places,
/// before it is divided.
const COARSE: f64 = 1.0;
/// Length in cells down to which a triangle that another surface crosses is divided: the error at
/// the crease.
const CREASE: f64 = 0.125;
/// Lines closer to the border of a triangle than this many cells, or than this part of its height,
/// do not divide it.
const BORDER: f64 = 1e-3;

/// A straight line from point to point.
type Line = [DVec3; 2];

/// The triangles of `asked`, or parts of them, with outside in front and inside behind. `spacing`
/// is a cell's edge [m].
pub(crate) fn boundary_triangles(surfaces: &LineCrossings, asked: &[usize], spacing: f64) -> Vec<[DVec3; 3]> {
    let divided = |&triangle: &usize| {
        let corners = surfaces.triangles()[triangle];
        let mut pieces = Vec::new();
        if let Some(normal) = normal(&corners).try_normalize() {
            let lines = if longest_edge(&corners) > CREASE * spacing {
                meeting_lines(surfaces, triangle, normal, PROBE * spacing)
            } else {
                Vec::new()
            };
            Probe { surfaces, normal, spacing }.gather(&corners, &lines, &mut pieces);
        }
        pieces
    };
    asked.par_iter().flat_map_iter(divided).collect()
}

/// The lines in a triangle's plane along which others meet it, or end on it.
fn meeting_lines(surfaces: &LineCrossings, triangle: usize, normal: DVec3, near: f64) -> Vec<Line> {
    let own = surfaces.triangles()[triangle];
    let (low, high) = (lowest(&own) - near, highest(&own) + near);
    let apart =
        |other_low: DVec3, other_high: DVec3| other_low.cmpgt(high).any() || other_high.cmplt(low).any();
    let mut lines = Vec::new();
    surfaces.tree().visit(
        |node_low, node_high| !apart(node_low, node_high),
        |other| {
            let corners = &surfaces.triangles()[other];
            if other == triangle || apart(lowest(corners), highest(corners)) {
                return;
            }
            let heights = corners.map(|corner| {
                let height = (corner - own[0]).dot(normal);
                if height.abs() > near { height } else { 0.0 }
            });
            if heights == [0.0; 3] {
                lines.extend((0..3).map(|k| [corners[k], corners[(k + 1) % 3]]));
                return;
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
        },
    );
    lines.retain(|line| divides(line, &own, normal, near / PROBE));
    lines
}

/// True if a line passes through the inside of a triangle in the same plane.
fn divides(line: &Line, corners: &[DVec3; 3], normal: DVec3, spacing: f64) -> bool {
    let height = self::normal(corners).length() / longest_edge(corners);
    let border = BORDER * spacing.min(height);
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    for from in 0..3 {
        let edge = corners[(from + 1) % 3] - corners[from];
        let inward = normal.cross(edge).normalize_or_zero();
        let [first, last] = line.map(|point| inward.dot(point - corners[from]) - border);
        if first <= 0.0 && last <= 0.0 {
            return false;
        }
        if first < 0.0 {
            begin = begin.max(first / (first - last));
        } else if last < 0.0 {
            end = end.min(first / (first - last));
        }
    }
    begin < end
}

fn lowest(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    a.min(b).min(c)
}

fn highest(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    a.max(b).max(c)
}

fn center(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
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
    /// Unit.
    normal: DVec3,
    /// [m]
    spacing: f64,
}

impl Probe<'_> {
    /// True if the outside begins in front of a point of the triangle and the inside behind it, one
    /// winding more.
    fn separates(&self, point: DVec3) -> bool {
        self.surfaces.winding(point + self.normal * (PROBE * self.spacing)) == 0
    }

    /// Collects the parts of a triangle that separate, whole where it does as a whole; returns
    /// whether it does. `lines` may divide it.
    fn gather(&self, corners: &[DVec3; 3], lines: &[Line], pieces: &mut Vec<[DVec3; 3]>) -> bool {
        let longest = longest_edge(corners);
        let center = center(corners);
        let mut unanimous = None;
        if lines.is_empty() || longest <= CREASE * self.spacing {
            unanimous = Some(self.separates(center));
        } else if longest <= COARSE * self.spacing {
            let answer = self.separates(center);
            let agrees = |corner: &DVec3| self.separates(corner.lerp(center, 0.1)) == answer;
            unanimous = corners.iter().all(agrees).then_some(answer);
        }

        // Divide it where the answers may differ.
        let start = pieces.len();
        let whole = unanimous.unwrap_or_else(|| {
            let [first, second] = halves(corners).map(|half| {
                let passes = |line: &&Line| divides(line, &half, self.normal, self.spacing);
                let own: Vec<Line> = lines.iter().filter(passes).copied().collect();
                self.gather(&half, &own, pieces)
            });
            first && second
        });
        if whole {
            pieces.truncate(start);
            pieces.push(*corners);
        }
        whole
    }
}

/// A triangle cut at the middle of its longest edge.
fn halves(corners: &[DVec3; 3]) -> [[DVec3; 3]; 2] {
    let [a, b, c] = *corners;
    let longest = longest_edge(corners);
    if (b - a).length() == longest {
        let middle = a.midpoint(b);
        [[a, middle, c], [middle, b, c]]
    } else if (c - b).length() == longest {
        let middle = b.midpoint(c);
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = c.midpoint(a);
        [[a, b, middle], [middle, b, c]]
    }
}
