//! Which surfaces of clean solids meet.

use crate::bvh::Bvh;
use crate::cleaning::clean_mesh::CleanMesh;
use crate::winding_number::{INSIDE, WindingNumber};
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicBool, Ordering};

/// Surfaces closer than this part of the bounding box's diagonal meet, and do not cross: rounding.
const NEAR: f64 = 1e-9;
/// Probe distance from a triangle, relative to the diagonal.
const PROBE: f64 = 1e-6;
/// Probe spacing, relative to the diagonal.
const SAMPLED: f64 = 1.0 / 24.0;
/// Maximum number of probed triangles.
const MOST_SAMPLED: usize = 20_000;

/// Contacts between the surfaces of solids.
#[derive(Clone, Debug, PartialEq)]
pub struct Meeting {
    /// Per solid: true if another may cross or touch it.
    pub others: Vec<bool>,
    /// For each solid the part of its surface that lies in it and so bounds nothing, by area; zero
    /// if its surface does not cross itself.
    pub buried: Vec<f64>,
}

impl CleanMesh {
    /// Finds contacts between solids, and self-intersections.
    pub fn meeting(&self) -> Meeting {
        let (low, high) = self.mesh.bounds();
        let diagonal = (high - low).length();
        let near = NEAR * diagonal;
        let surfaces = self.surfaces();
        let mut others = met(&surfaces, near);
        for (solid, outer) in self.nested.iter().enumerate().filter_map(|(n, o)| Some((n, (*o)?))) {
            others[solid] = true;
            others[outer as usize] = true;
        }
        let buried = surfaces.iter().map(|surface| {
            if surface.crosses_itself(near) { buried_part(&surface.corners, diagonal) } else { 0.0 }
        });
        Meeting { others, buried: buried.collect() }
    }

    /// The surface of each solid.
    fn surfaces(&self) -> Vec<Surface> {
        let count = self.solid.iter().max().map_or(0, |last| *last as usize + 1);
        let mut triangles: Vec<Vec<u32>> = vec![Vec::new(); count];
        for (&solid, triangle) in self.solid.iter().zip(0..) {
            triangles[solid as usize].push(triangle);
        }
        triangles.into_par_iter().map(|triangles| Surface::new(self, &triangles)).collect()
    }
}

/// Per surface: true if another comes near.
fn met(surfaces: &[Surface], near: f64) -> Vec<bool> {
    let boxes: Vec<(DVec3, DVec3)> = surfaces.iter().map(|surface| surface.bounds).collect();
    let tree = Bvh::of_boxes(&boxes);
    let met: Vec<AtomicBool> = surfaces.iter().map(|_| AtomicBool::new(false)).collect();
    let is_met = |surface: usize| met[surface].load(Ordering::Relaxed);
    (0..surfaces.len()).into_par_iter().for_each(|one| {
        let (low, high) = (boxes[one].0 - near, boxes[one].1 + near);
        tree.visit(
            |other_low, other_high| !apart(low, high, other_low, other_high),
            |other| {
                // A pair that is met already needs no look.
                let is_pair = other < one && !apart(low, high, boxes[other].0, boxes[other].1);
                if is_pair
                    && !(is_met(one) && is_met(other))
                    && surfaces[one].is_near(&surfaces[other], near)
                {
                    met[one].store(true, Ordering::Relaxed);
                    met[other].store(true, Ordering::Relaxed);
                }
            },
        );
    });
    met.into_iter().map(AtomicBool::into_inner).collect()
}

/// A closed surface with all that is asked of its triangles.
struct Surface {
    /// Of the triangles [m].
    corners: Vec<[DVec3; 3]>,
    /// Unit normals, zero for triangles without one.
    normals: Vec<DVec3>,
    tree: Bvh,
    /// Lowest and highest corner [m].
    bounds: (DVec3, DVec3),
}

impl Surface {
    fn new(clean: &CleanMesh, triangles: &[u32]) -> Self {
        let corners: Vec<[DVec3; 3]> =
            triangles.iter().map(|&triangle| clean.mesh.corners(triangle as usize)).collect();
        let normal = |&[a, b, c]: &[DVec3; 3]| (b - a).cross(c - a).normalize_or_zero();
        let bounds =
            corners.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), corners| {
                let (own_low, own_high) = box_of(corners);
                (low.min(own_low), high.max(own_high))
            });
        Self {
            normals: corners.iter().map(normal).collect(),
            tree: Bvh::new(&corners),
            corners,
            bounds,
        }
    }

    /// True if a triangle of another surface comes near one of these.
    fn is_near(&self, other: &Self, near: f64) -> bool {
        let (few, many) =
            if self.corners.len() < other.corners.len() { (self, other) } else { (other, self) };
        (0..few.corners.len()).into_par_iter().any(|triangle| {
            let (corners, normal) = (&few.corners[triangle], few.normals[triangle]);
            let (low, high) = box_of(corners);
            let (low, high) = (low - near, high + near);
            let mut found = false;
            // A plane with all of one triangle in front of it keeps both apart.
            let enters = |other_low: DVec3, other_high: DVec3| {
                let (least, most) = box_heights(other_low, other_high, corners[0], normal);
                !apart(low, high, other_low, other_high) && least <= near && most >= -near
            };
            many.tree.visit(enters, |other| {
                if !found {
                    let theirs = &many.corners[other];
                    let (other_low, other_high) = box_of(theirs);
                    let between = |of: &[DVec3; 3], at: DVec3, normal: DVec3| {
                        let (least, most) = heights(of, at, normal);
                        least > near || most < -near
                    };
                    found = !apart(low, high, other_low, other_high)
                        && !between(theirs, corners[0], normal)
                        && !between(corners, theirs[0], many.normals[other]);
                }
            });
            found
        })
    }

    /// True if two of the triangles cross by more than `near` [m].
    fn crosses_itself(&self, near: f64) -> bool {
        (0..self.corners.len()).into_par_iter().any(|triangle| {
            let (corners, normal) = (&self.corners[triangle], self.normals[triangle]);
            let (low, high) = box_of(corners);
            let (low, high) = (low - near, high + near);
            let one_sided =
                |least: f64, most: f64| normal != DVec3::ZERO && (least > -near || most < near);
            let enters = |other_low: DVec3, other_high: DVec3| {
                let (least, most) = box_heights(other_low, other_high, corners[0], normal);
                !apart(low, high, other_low, other_high) && !one_sided(least, most)
            };
            let mut found = false;
            self.tree.visit(enters, |other| {
                if found || other <= triangle {
                    return;
                }
                let (least, most) = heights(&self.corners[other], corners[0], normal);
                found = !one_sided(least, most) && self.cross(triangle, other, near);
            });
            found
        })
    }

    /// True if two triangles have more than `near` [m] of a line in common, and each has corners
    /// farther than that on both sides of the other's plane.
    fn cross(&self, one: usize, other: usize, near: f64) -> bool {
        let along = self.normals[one].cross(self.normals[other]).normalize_or_zero();
        let [a, b] = [(one, other), (other, one)].map(|(triangle, plane)| {
            let (corners, at) = (&self.corners[triangle], self.corners[plane][0]);
            let heights = corners.map(|corner| (corner - at).dot(self.normals[plane]));
            let both = heights.iter().any(|height| *height > near)
                && heights.iter().any(|height| *height < -near);
            both.then(|| common_line(corners, heights, self.corners[one][0], along))
        });
        match (a, b) {
            (Some((a, b)), Some((c, d))) => b.min(d) - a.max(c) > near,
            _ => false,
        }
    }
}

/// From where to where a triangle with corners at such `heights` is in the plane of height zero,
/// along a line in it from a point of that plane [m].
fn common_line(corners: &[DVec3; 3], heights: [f64; 3], from: DVec3, along: DVec3) -> (f64, f64) {
    let (mut first, mut last) = (f64::INFINITY, f64::NEG_INFINITY);
    for corner in 0..3 {
        let next = (corner + 1) % 3;
        let (here, there) = (heights[corner], heights[next]);
        if (here <= 0.0) != (there <= 0.0) {
            let point = corners[corner].lerp(corners[next], here / (here - there));
            let place = (point - from).dot(along);
            (first, last) = (first.min(place), last.max(place));
        }
    }
    (first, last)
}

fn box_of(&[a, b, c]: &[DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(b).min(c), a.max(b).max(c))
}

/// True if two boxes have no common point.
fn apart(low: DVec3, high: DVec3, other_low: DVec3, other_high: DVec3) -> bool {
    other_low.cmpgt(high).any() || other_high.cmplt(low).any()
}

/// The least and the largest height of corners above a plane [m].
fn heights(corners: &[DVec3; 3], at: DVec3, normal: DVec3) -> (f64, f64) {
    let [a, b, c] = corners.map(|corner| (corner - at).dot(normal));
    (a.min(b).min(c), a.max(b).max(c))
}

/// The same of a box.
fn box_heights(low: DVec3, high: DVec3, at: DVec3, normal: DVec3) -> (f64, f64) {
    let middle = (0.5 * (low + high) - at).dot(normal);
    let reach = (0.5 * (high - low)).dot(normal.abs());
    (middle - reach, middle + reach)
}

/// The part of a surface's area with no outside in front of it or no inside behind it, by samples
/// all over it; zero of none. `diagonal` is the mesh's [m].
fn buried_part(surface: &[[DVec3; 3]], diagonal: f64) -> f64 {
    let winding = WindingNumber::new(Bvh::new(surface));
    let areas: Vec<[f64; 2]> = surface
        .par_iter()
        .step_by(surface.len().div_ceil(MOST_SAMPLED).max(1))
        .map(|&[a, b, c]| {
            let across = (b - a).cross(c - a);
            let offset = PROBE * diagonal * across.normalize_or_zero();
            let parts = (across.length().sqrt() / (SAMPLED * diagonal)).round().max(1.0);
            let mut buried = 0;
            for [u, v] in middles(parts as u32) {
                let front = winding.at(a + u * (b - a) + v * (c - a) + offset);
                buried += u32::from(!(front <= INSIDE && front + 1.0 > INSIDE));
            }
            let area = 0.5 * across.length();
            [area * f64::from(buried) / (parts * parts), area]
        })
        .collect();
    let sum = |which: usize| areas.iter().map(|area| area[which]).sum::<f64>();
    if surface.is_empty() { 0.0 } else { sum(0) / sum(1) }
}

/// Middles of the triangles that a triangle with its sides in so many parts is made of, along its
/// first and its last side.
fn middles(parts: u32) -> impl Iterator<Item = [f64; 2]> {
    let place = move |n: u32, third: f64| (f64::from(n) + third) / f64::from(parts);
    (0..parts).flat_map(move |i| {
        (0..parts - i).flat_map(move |j| {
            let other = (i + j + 1 < parts).then(|| [place(i, 2.0 / 3.0), place(j, 2.0 / 3.0)]);
            std::iter::once([place(i, 1.0 / 3.0), place(j, 1.0 / 3.0)]).chain(other)
        })
    })
}
