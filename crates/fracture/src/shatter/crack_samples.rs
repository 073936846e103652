//! Points on the faces that a break uncovers, and on their rims.

use crate::{pattern::Region, polygon};
use frangible_geometry::{ClosedForm, GridSolid, HalfSpace, Root};
use glam::DVec3;

/// Points of all cracks around a region within the parent [m], about `spacing` apart: corners, edges, rims, and the
/// faces between them.
pub(crate) fn crack_samples(parent: &GridSolid, region: &Region, spacing: f64) -> Vec<DVec3> {
    let walls = flat_walls(parent);
    // Points of edges that lie in the parent's surface are off it by round-off, or by a sampled root's interpolation.
    let tolerance = 0.05 * parent.level_set.grid().spacing;
    let mut sampler = Sampler { root: &parent.outline.root, spacing, tolerance, points: Vec::new() };
    for cut in &region.cuts {
        // What is flat cuts the face exactly, so that its corners are the fragment's corners.
        let mut face = cut.face.clone();
        for wall in &walls {
            if face.is_empty() {
                break;
            }
            face = polygon::clip(&face, wall);
        }
        if face.len() >= 3 {
            sampler.sample_face(&face, cut.half_space.normal);
        }
    }
    sampler.points
}

/// The flat pieces of the parent's surface, and the box of its grid.
fn flat_walls(parent: &GridSolid) -> Vec<HalfSpace> {
    let mut walls = parent.outline.cuts.clone();
    match &parent.outline.root {
        Root::ClosedForm(ClosedForm::Box { half }) => walls.extend(polygon::box_half_spaces(-half, *half)),
        Root::ClosedForm(ClosedForm::Cylinder { half_height, .. }) => {
            walls.extend([DVec3::Y, DVec3::NEG_Y].map(|normal| HalfSpace { normal, offset: *half_height }))
        }
        Root::ClosedForm(ClosedForm::HalfSpace(half_space)) => walls.push(*half_space),
        Root::Hull(hull) => walls.extend(hull.planes()),
        Root::ClosedForm(ClosedForm::Sphere { .. }) | Root::Sampled(_) => {}
    }
    let (low, high) = parent.level_set.grid().bounds();
    walls.extend(polygon::box_half_spaces(low, high));
    walls
}

/// Collects points of convex polygons that lie inside of the parent.
struct Sampler<'a> {
    root: &'a Root,
    spacing: f64,
    tolerance: f64,
    points: Vec<DVec3>,
}

impl Sampler<'_> {
    /// Signed distance to the parent [m]; its flat walls have cut the face already.
    fn distance(&self, point: DVec3) -> f64 {
        match self.root {
            Root::ClosedForm(form) => form.distance(point),
            Root::Hull(hull) => hull.distance_and_gradient(point).0,
            Root::Sampled(level_set) => f64::from(level_set.value(point)),
        }
    }

    fn sample_face(&mut self, face: &[DVec3], normal: DVec3) {
        // Corners and edges, and where the edges leave the parent.
        let edges: Vec<(DVec3, DVec3)> =
            (0..face.len()).map(|at| (face[at], face[(at + 1) % face.len()])).collect();
        for &(start, end) in &edges {
            if self.distance(start) <= self.tolerance {
                self.points.push(start);
            }
            self.walk(start, end, true);
        }

        // Lines along the longest edge; lines across it find the rims that the first ones run along.
        let by_length = |a: &&(DVec3, DVec3), b: &&(DVec3, DVec3)| {
            a.0.distance_squared(a.1).total_cmp(&b.0.distance_squared(b.1))
        };
        let Some(&(start, end)) = edges.iter().max_by(by_length) else { return };
        let along = (end - start).normalize_or_zero();
        let across = normal.cross(along);
        self.walk_lines(&edges, across, true);
        self.walk_lines(&edges, along, false);
    }

    /// Walks the lines of the face that are evenly spaced along `level`.
    fn walk_lines(&mut self, edges: &[(DVec3, DVec3)], level: DVec3, keep_inside: bool) {
        let levels = edges.iter().map(|(start, _)| start.dot(level));
        let (low, high) =
            levels.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), at| (low.min(at), high.max(at)));
        let count = ((high - low) / self.spacing).ceil() as usize;
        for line in 1..count {
            let at = low + (high - low) * line as f64 / count as f64;
            let mut ends = edges.iter().filter_map(|&(start, end)| {
                let (from, to) = (start.dot(level) - at, end.dot(level) - at);
                ((from <= 0.0) != (to <= 0.0)).then(|| start + (end - start) * (from / (from - to)))
            });
            if let (Some(start), Some(end)) = (ends.next(), ends.next()) {
                self.walk(start, end, keep_inside);
            }
        }
    }

    /// Takes points between two points of the face: evenly spaced ones that lie inside of the parent if asked to, and
    /// where the way leaves or enters it. The two ends are not taken.
    fn walk(&mut self, start: DVec3, end: DVec3, keep_inside: bool) {
        let count = ((end - start).length() / self.spacing).ceil().max(1.0) as usize;
        let mut last = (start, self.distance(start));
        for step in 1..=count {
            let point = start + (end - start) * (step as f64 / count as f64);
            let here = (point, self.distance(point));
            let (inner, outer) = if last.1 <= here.1 { (last, here) } else { (here, last) };
            if inner.1 <= 0.0 && outer.1 > self.tolerance {
                let rim = self.bisect(inner.0, outer.0);
                self.points.push(rim);
            }
            if keep_inside && step < count && here.1 <= self.tolerance {
                self.points.push(point);
            }
            last = here;
        }
    }

    /// A point of the parent's surface between a point inside and one outside.
    fn bisect(&self, mut inside: DVec3, mut outside: DVec3) -> DVec3 {
        // From the distance between samples to less than the precision of f32.
        const HALVINGS: usize = 20;
        for _ in 0..HALVINGS {
            let middle = 0.5 * (inside + outside);
            if self.distance(middle) <= 0.0 {
                inside = middle;
            } else {
                outside = middle;
            }
        }
        inside
    }
}
