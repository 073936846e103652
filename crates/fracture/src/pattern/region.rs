//! A convex cell of a pattern, and the planes around it.

use crate::polygon;
use frangible_geometry::{HalfSpace, Hull, HullFace, PlaneClipper};
use frangible_math::cancel;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A convex polytope: the points inside of all its cuts. The box's own faces are no cuts, because
/// the pattern encloses what it breaks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// The cracks around it.
    pub cuts: Vec<Cut>,
}

/// A plane that bounds a region, and the face that it contributes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(from = "CutRecord", into = "CutRecord")]
pub struct Cut {
    /// The region lies inside.
    pub half_space: HalfSpace,
    /// Corners of the face within the pattern's box, counter-clockwise seen from outside of the
    /// region.
    pub face: Vec<DVec3>,
}

/// A cut as it stands in a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct CutRecord {
    normal: DVec3,
    offset: f64,
    face: Vec<DVec3>,
}

impl From<CutRecord> for Cut {
    fn from(CutRecord { normal, offset, face }: CutRecord) -> Self {
        Self { half_space: HalfSpace { normal, offset }, face }
    }
}

impl From<Cut> for CutRecord {
    fn from(Cut { half_space: HalfSpace { normal, offset }, face }: Cut) -> Self {
        Self { normal, offset, face }
    }
}

/// Faces smaller than this part of the box's surface are no faces: four planes that meet in a point
/// leave slivers of round-off size.
const SMALLEST_FACE: f64 = 1e-14;

impl Region {
    /// Intersection of half-spaces, without half-spaces that do not bound it within the box; `None`
    /// if it lies beyond.
    pub fn from_half_spaces(half_spaces: &[HalfSpace], half_extent: DVec3) -> Option<Self> {
        cancel::check();
        let hull = PlaneClipper::default().clipped(&Hull::cuboid(half_extent), half_spaces)?;
        Some(Self::of_hull(&hull, half_extent))
    }

    /// A part of the box, cut out of it by planes.
    pub(crate) fn of_hull(hull: &Hull, half_extent: DVec3) -> Self {
        let smallest = SMALLEST_FACE * half_extent.length_squared();
        let corner = |&vertex: &u32| hull.vertices()[vertex as usize];
        let cut = |face: HullFace<'_>| {
            let corners: Vec<DVec3> = face.vertices.iter().map(corner).collect();
            let is_face = polygon::area(&corners) > smallest;
            is_face.then_some(Cut { half_space: face.plane, face: corners })
        };
        Self { cuts: hull.faces().filter(|face| face.inner).filter_map(cut).collect() }
    }

    /// The same region in a box that is so many times as large.
    pub(crate) fn scaled(mut self, size: f64) -> Self {
        for Cut { half_space, face } in &mut self.cuts {
            half_space.offset *= size;
            face.iter_mut().for_each(|corner| *corner *= size);
        }
        self
    }

    /// The polyhedron within the box of `half_extent` around the origin; `None` if it lies beyond.
    pub fn hull(&self, half_extent: DVec3) -> Option<Hull> {
        let whole = Hull::cuboid(half_extent);
        self.cuts.iter().try_fold(whole, |hull, cut| hull.clipped(&cut.half_space))
    }

    /// Largest signed distance to any of the cuts, negative inside; the distance to the region in
    /// the sense of [Su09 sec. 4.2]: right inside, a lower bound outside. Minus infinity for a
    /// region without cuts.
    pub fn distance(&self, point: DVec3) -> f64 {
        self.cuts.iter().map(|cut| cut.half_space.distance(point)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The same; what is more than `most` may come out smaller, but not less than that.
    pub(crate) fn distance_up_to(&self, point: DVec3, most: f64) -> f64 {
        let mut largest = f64::NEG_INFINITY;
        for cut in &self.cuts {
            largest = largest.max(cut.half_space.distance(point));
            if largest > most {
                break;
            }
        }
        largest
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
