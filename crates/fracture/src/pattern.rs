//! Fracture patterns: all of space, broken in advance [Su09 sec. 4.1].

use crate::polygon;
use frangible_geometry::HalfSpace;
use glam::DVec3;
use thiserror::Error;

/// A box broken into convex regions around one point.
///
/// The *pattern frame* has its origin in the middle of the box; +z is the direction of the collision normal, out of the
/// broken body and towards the striker; x and y lie across. A break moves, turns and uniformly scales the pattern onto
/// the body. Lengths are in the pattern's own unit.
#[derive(Clone, Debug)]
pub struct Pattern {
    /// Half of the box's edge lengths.
    pub half_extent: DVec3,
    /// The fracture centre, strictly inside of the box: what is laid on the impact point.
    pub center: DVec3,
    /// They tile the box.
    pub regions: Vec<Region>,
}

/// A convex polytope: the points inside of all its cuts. The box's own faces are no cuts, because the pattern encloses
/// what it breaks.
#[derive(Clone, Debug)]
pub struct Region {
    /// The cracks around it.
    pub cuts: Vec<Cut>,
}

/// A plane that bounds a region, and the face that it contributes.
#[derive(Clone, Debug)]
pub struct Cut {
    /// The region lies inside.
    pub half_space: HalfSpace,
    /// Corners of the face within the pattern's box, counter-clockwise seen from outside of the region.
    pub face: Vec<DVec3>,
}

/// Why a pattern cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PatternError {
    /// A parameter is out of its range.
    #[error("{parameter}: {value}, must be {rule}")]
    Parameter {
        /// Its name.
        parameter: &'static str,
        /// As given.
        value: f64,
        /// What it must fulfil.
        rule: &'static str,
    },
}

/// Faces smaller than this part of the box's surface are no faces: four planes that meet in a point leave slivers of
/// round-off size.
const SMALLEST_FACE: f64 = 1e-14;

impl Region {
    /// The intersection of half-spaces, without those that do not bound it within the box.
    pub fn from_half_spaces(half_spaces: &[HalfSpace], half_extent: DVec3) -> Self {
        let smallest = SMALLEST_FACE * half_extent.length_squared();
        let mut cuts = Vec::new();
        for (at, &half_space) in half_spaces.iter().enumerate() {
            let mut face = polygon::box_section(&half_space, half_extent);
            for (other, cutter) in half_spaces.iter().enumerate() {
                if face.is_empty() {
                    break;
                }
                if other != at {
                    face = polygon::clip(&face, cutter);
                }
            }
            if polygon::area(&face) > smallest {
                cuts.push(Cut { half_space, face });
            }
        }
        Self { cuts }
    }

    /// Largest signed distance to any of the cuts, negative inside; the distance to the region in the sense of
    /// [Su09 sec. 4.2]: right inside, a lower bound outside. Minus infinity for a region without cuts.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.cuts.iter().map(|cut| cut.half_space.distance(point)).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// The region with the least distance, the first of equals.
pub(crate) fn nearest_region(regions: &[Region], point: DVec3) -> Option<usize> {
    let mut nearest = None;
    let mut least = f64::INFINITY;
    for (at, region) in regions.iter().enumerate() {
        let distance = region.distance(point);
        if distance < least {
            (nearest, least) = (Some(at), distance);
        }
    }
    nearest
}

impl Pattern {
    /// The region that holds a point: the one with the least distance, the first of equals.
    pub fn region_at(&self, point: DVec3) -> Option<usize> {
        nearest_region(&self.regions, point)
    }

    /// Volume of a region within the box, by the divergence theorem.
    pub fn region_volume(&self, region: &Region) -> f64 {
        let walls = polygon::box_half_spaces(-self.half_extent, self.half_extent);
        let cuts: Vec<HalfSpace> = region.cuts.iter().map(|cut| cut.half_space).collect();
        let faces: f64 = region.cuts.iter().map(|cut| cut.half_space.offset * polygon::area(&cut.face)).sum();
        let outer: f64 = walls
            .iter()
            .map(|wall| {
                let section = polygon::box_section(wall, self.half_extent);
                let face = cuts.iter().fold(section, |face, cut| polygon::clip(&face, cut));
                wall.offset * polygon::area(&face)
            })
            .sum();
        (faces + outer) / 3.0
    }

    /// How far the regions' volumes are from adding up to the box's, relative to it: zero for a tiling.
    pub fn tiling_defect(&self) -> f64 {
        let e = self.half_extent;
        let whole = 8.0 * e.x * e.y * e.z;
        let parts: f64 = self.regions.iter().map(|region| self.region_volume(region)).sum();
        (parts - whole).abs() / whole
    }
}
