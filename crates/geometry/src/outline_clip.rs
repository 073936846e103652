//! Intersections of half-spaces, asked for distances many times.

use crate::grid::Grid;
use crate::half_space::HalfSpace;
use frangible_math::check::{Check, Checked, finite_singles, require};
use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

/// An intersection of half-spaces on a grid.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Clip {
    /// In the grid frame.
    half_spaces: Vec<HalfSpace>,
    /// The same as functions of a point in lattice units: slope and value at node (0, 0, 0) [m].
    planes: Vec<(Vec3, f32)>,
}

/// The larger of two numbers that are not NaN: one instruction, unlike [`f32::max`].
#[inline]
pub(crate) fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Least and largest signed distance [m] of a half-space over a box.
pub(crate) fn distances_over(half_space: &HalfSpace, (low, high): (DVec3, DVec3)) -> (f64, f64) {
    let middle = half_space.distance(0.5 * (low + high));
    let reach = half_space.normal.abs().dot(0.5 * (high - low));
    (middle - reach, middle + reach)
}

impl Check for Clip {
    fn check(&self) -> Checked {
        require(self.half_spaces.len() == self.planes.len(), "a plane for each half-space")?;
        self.half_spaces.iter().try_for_each(Check::check)?;
        self.planes.iter().try_for_each(|(slope, value)| {
            finite_singles(*slope)?;
            require(value.is_finite(), "planes of finite numbers")
        })
    }
}

impl Clip {
    /// Those of the half-spaces whose planes meet a grid's box: the others hold all of it. None if
    /// one holds nothing of the box from `low` to `high`.
    pub(crate) fn new<'a>(
        grid: &Grid,
        half_spaces: impl Iterator<Item = &'a HalfSpace>,
        (low, high): (DVec3, DVec3),
    ) -> Option<Self> {
        let mut clip = Self { half_spaces: Vec::new(), planes: Vec::new() };
        for half_space in half_spaces {
            if distances_over(half_space, (low, high)).0 > 0.0 {
                return None;
            }
            if distances_over(half_space, grid.bounds()).1 > 0.0 {
                let slope = (half_space.normal * grid.spacing).as_vec3();
                clip.planes.push((slope, half_space.distance(grid.origin) as f32));
                clip.half_spaces.push(*half_space);
            }
        }
        Some(clip)
    }

    /// In the grid frame.
    pub fn half_spaces(&self) -> &[HalfSpace] {
        &self.half_spaces
    }

    /// Largest signed distance [m] to any plane at a point in lattice units; minus infinity without
    /// planes. Values above `most` [m] are only lower bounds.
    #[inline]
    pub(crate) fn value(&self, lattice: Vec3, most: f32) -> f32 {
        let mut largest = f32::NEG_INFINITY;
        for &(slope, at_origin) in &self.planes {
            largest = larger(slope.dot(lattice) + at_origin, largest);
            if largest > most {
                break;
            }
        }
        largest
    }

    /// The exact largest distance, and its unit gradient.
    pub(crate) fn value_and_gradient(&self, lattice: Vec3) -> (f32, Vec3) {
        let mut farthest = (f32::NEG_INFINITY, Vec3::Y);
        for (&(slope, at_origin), half_space) in self.planes.iter().zip(&self.half_spaces) {
            let distance = slope.dot(lattice) + at_origin;
            if distance > farthest.0 {
                farthest = (distance, half_space.normal.as_vec3());
            }
        }
        farthest
    }

    /// Lowers each distance to the one to this intersection [m], at nodes that follow `start` along
    /// x in steps of `spacing`.
    pub(crate) fn lower_row(
        &self,
        start: DVec3,
        spacing: f64,
        scratch: &mut RowScratch,
        row: &mut [f32],
    ) {
        // Planes below `least` at both ends are never the farthest.
        scratch.ends.clear();
        let last = (row.len() - 1) as f64;
        let mut least = f64::NEG_INFINITY;
        for half_space in &self.half_spaces {
            let at_start = half_space.distance(start);
            let at_end = at_start + half_space.normal.x * spacing * last;
            least = least.max(at_start.min(at_end));
            scratch.ends.push((at_start, at_end));
        }
        scratch.farthest.clear();
        scratch.farthest.resize(row.len(), least as f32);
        for (half_space, &(at_start, at_end)) in self.half_spaces.iter().zip(&scratch.ends) {
            if at_start.max(at_end) > least {
                let (at_start, step) = (at_start as f32, (half_space.normal.x * spacing) as f32);
                for (i, distance) in scratch.farthest.iter_mut().enumerate() {
                    *distance = larger(at_start + step * i as f32, *distance);
                }
            }
        }
        for (nearest, &distance) in row.iter_mut().zip(&scratch.farthest) {
            *nearest = if distance < *nearest { distance } else { *nearest };
        }
    }
}

/// Scratch memory of [`Clip::lower_row`].
#[derive(Default)]
pub(crate) struct RowScratch {
    /// Distances to each plane at both ends of the row [m].
    ends: Vec<(f64, f64)>,
    /// To the plane that is farthest, at each node [m].
    farthest: Vec<f32>,
}
