//! Which surfaces of clean solids meet.

use super::CleanMesh;
use crate::WindingNumber;
use crate::bvh::Bvh;
use crate::winding_number::INSIDE;
use glam::DVec3;
use rayon::prelude::*;

/// Surfaces closer than this part of the bounding box's diagonal meet, and do not cross: rounding.
const NEAR: f64 = 1e-9;
/// How far from a triangle it is asked what lies there, relative to the diagonal.
const PROBE: f64 = 1e-6;

/// How the surfaces of solids meet.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// For each solid whether another one may cross or touch it.
    pub others: Vec<bool>,
    /// For each solid the part of its surface that lies in it and so bounds nothing, by area; zero
    /// if its surface does not cross itself.
    pub buried: Vec<f64>,
}

impl CleanMesh {
    /// Finds where solids meet one another, and where one crosses itself.
    pub fn meeting(&self) -> Meeting {
        // Everything that comes near a triangle.
        let mesh = &self.mesh;
        let corners: Vec<[DVec3; 3]> =
            (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect();
        let (low, high) = mesh.bounds();
        let diagonal = (high - low).length();
        let near = NEAR * diagonal;
        let tree = Bvh::new(&corners);
        let found: Vec<(bool, bool)> = (0..corners.len())
            .into_par_iter()
            .map(|triangle| self.meets(&tree, &corners, triangle, near))
            .collect();

        // By solids.
        let count = self.solid.iter().max().map_or(0, |last| *last as usize + 1);
        let mut meeting = Meeting { others: vec![false; count], buried: vec![0.0; count] };
        let mut itself = vec![false; count];
        for (&solid, (other, own)) in self.solid.iter().zip(&found) {
            meeting.others[solid as usize] |= other;
            itself[solid as usize] |= own;
        }
        for (solid, outer) in self.nested.iter().enumerate().filter_map(|(n, o)| Some((n, (*o)?))) {
            meeting.others[solid] = true;
            meeting.others[outer as usize] = true;
        }
        let mut crossing: Vec<Vec<[DVec3; 3]>> = vec![Vec::new(); count];
        for (&solid, &corners) in self.solid.iter().zip(&corners) {
            if itself[solid as usize] {
                crossing[solid as usize].push(corners);
            }
        }
        for (buried, corners) in meeting.buried.iter_mut().zip(&crossing) {
            *buried = buried_part(corners, PROBE * diagonal);
        }
        meeting
    }

    /// True if another solid is near a triangle, and true if one of its own edges crosses a
    /// triangle of its solid.
    fn meets(&self, tree: &Bvh, corners: &[[DVec3; 3]], triangle: usize, near: f64) -> (bool, bool) {
        let own = &corners[triangle];
        let low = own[0].min(own[1]).min(own[2]) - near;
        let high = own[0].max(own[1]).max(own[2]) + near;
        let apart =
            |other_low: DVec3, other_high: DVec3| other_low.cmpgt(high).any() || other_high.cmplt(low).any();
        let (mut others, mut itself) = (false, false);
        tree.visit(
            |node_low, node_high| !apart(node_low, node_high),
            |other| {
                let [a, b, c] = corners[other];
                if other == triangle || apart(a.min(b).min(c), a.max(b).max(c)) {
                    return;
                }
                if self.solid[other] != self.solid[triangle] {
                    others = true;
                } else if !itself {
                    itself = self.crosses(corners, triangle, other, near);
                }
            },
        );
        (others, itself)
    }

    /// True if an edge of a triangle passes through another one that does not have its ends.
    fn crosses(&self, corners: &[[DVec3; 3]], triangle: usize, other: usize, near: f64) -> bool {
        let [a, b, c] = corners[other];
        let Some(normal) = (b - a).cross(c - a).try_normalize() else { return false };
        let heights = corners[triangle].map(|corner| (corner - a).dot(normal));
        if heights.iter().all(|height| *height > -near) || heights.iter().all(|height| *height < near) {
            return false;
        }
        (0..3).any(|from| {
            let to = (from + 1) % 3;
            let ends = [from, to].map(|corner| self.mesh.triangles[triangle][corner]);
            if ends.iter().any(|end| self.mesh.triangles[other].contains(end))
                || heights[from].min(heights[to]) > -near
                || heights[from].max(heights[to]) < near
            {
                return false;
            }
            let along = heights[from] / (heights[from] - heights[to]);
            let point = corners[triangle][from].lerp(corners[triangle][to], along);
            [(a, b), (b, c), (c, a)].iter().all(|&(from, to)| {
                let inward = normal.cross(to - from).normalize_or_zero();
                inward.dot(point - from) > near
            })
        })
    }
}

/// The part of a surface's area with no outside in front of it or no inside behind it; zero of
/// none.
fn buried_part(surface: &[[DVec3; 3]], offset: f64) -> f64 {
    let winding = WindingNumber::new(Bvh::new(surface));
    let areas: Vec<[f64; 2]> = surface
        .par_iter()
        .map(|&[a, b, c]| {
            let across = (b - a).cross(c - a);
            let area = 0.5 * across.length();
            let front = winding.at((a + b + c) / 3.0 + offset * across.normalize_or_zero());
            let separates = front <= INSIDE && front + 1.0 > INSIDE;
            [if separates { 0.0 } else { area }, area]
        })
        .collect();
    let sum = |which: usize| areas.iter().map(|area| area[which]).sum::<f64>();
    if surface.is_empty() { 0.0 } else { sum(0) / sum(1) }
}
