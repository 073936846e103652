//! How far a break reaches from its blow, and the crater that it cuts.

use crate::pattern::Pattern;
use crate::placement::Placement;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// How far a break reaches: what lies beyond stays whole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reach {
    /// From the blow [m].
    pub distance: f64,
    /// Which way the pattern is laid, and where the crater ends.
    pub rim: Rim,
}

/// Where a crater ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Rim {
    /// At a faceted bowl that cuts through cells. The pattern's box is laid around the bowl, so
    /// that its cells are as fine as the crater needs.
    Bowl,
    /// At cracks of the pattern, which is laid on the whole body: cells with their centre of mass
    /// in reach come loose, at least the one that is struck.
    Cells,
}

/// Facets of the bowl: as many as look round with as few convex parts around them.
const FACETS: usize = 14;

/// Radius of the ball that the bowl is a part of, at its nearest facet; the bowl is scaled to the
/// reach later.
const NEAREST: f64 = 1.0;

/// Other facets lie further out by up to this part of the nearest one's distance [1]: the bowl looks
/// broken, not turned.
const RAGGED: f64 = 0.25;

/// The ball's centre lies so far in front of the surface, in units of its radius [1]: the bowl opens
/// outward, at 37 degrees at its rim, so that pieces can leave it. Half a ball around the blow held
/// them fast. The bowl is half as deep as it is wide from the blow to its rim.
const IN_FRONT: f64 = 0.6;

/// Part of the reach up to which material in front of the blow comes loose, as where a body is
/// struck at a slant or in a hollow; there it is up to 1.4 times as far from the blow.
const STANDS_OUT: f64 = 0.25;

/// Turn from facet to facet: the golden angle spreads them evenly.
const GOLDEN_ANGLE: f64 = TAU * 0.381_966_011_250_105;
/// Fractional parts of its multiples vary the facets' distances evenly.
const GOLDEN_PART: f64 = 0.618_033_988_749_895;

impl Reach {
    /// The facets of the bowl at the blow, on which a pattern lies: behind the plane across the
    /// blow's normal all of its corners are in reach, the farthest just so.
    pub(crate) fn bowl(&self, placement: &Placement) -> Vec<HalfSpace> {
        let facets: Vec<HalfSpace> = (0..FACETS).map(facet).collect();
        let surface = HalfSpace { normal: DVec3::Z, offset: 0.0 };
        let around = Hull::cuboid(DVec3::splat(4.0 * (NEAREST + RAGGED)));
        let mut planes = facets.iter().chain([&surface]);
        let bowl = planes.try_fold(around, |hull, plane| hull.clipped(plane));
        let corners = bowl.iter().flat_map(|hull| hull.vertices());
        let farthest = corners.map(|corner| corner.length()).fold(0.5 * NEAREST, f64::max);
        let scale = self.distance / farthest;
        let place = |facet: &HalfSpace| {
            let normal = (placement.grid_from_pattern * facet.normal).normalize();
            let offset = normal.dot(placement.point_grid) + scale * facet.offset;
            HalfSpace { normal, offset }
        };
        let front = HalfSpace { normal: DVec3::Z, offset: STANDS_OUT * farthest };
        facets.iter().chain([&front]).map(place).collect()
    }

    /// The scale at which the pattern's box holds all that is in reach, if that decides it.
    pub(crate) fn scale(&self, pattern: &Pattern) -> Option<f64> {
        let to_walls =
            (pattern.half_extent - pattern.center).min(pattern.half_extent + pattern.center);
        (self.rim == Rim::Bowl).then(|| self.distance / to_walls.min_element())
    }
}

/// A facet of the bowl in the pattern frame, with the blow in the origin.
fn facet(number: usize) -> HalfSpace {
    let height = 1.0 - (2 * number + 1) as f64 / FACETS as f64;
    let (across, angle) = ((1.0 - height * height).sqrt(), GOLDEN_ANGLE * number as f64);
    let normal = DVec3::new(across * libm::cos(angle), across * libm::sin(angle), height);
    let part = (GOLDEN_PART * (number + 1) as f64).fract();
    HalfSpace { normal, offset: IN_FRONT * normal.z + NEAREST + RAGGED * part }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// Within the body none of the bowl is out of reach, and it is about half as deep as wide.
    #[test]
    fn all_of_the_bowl_is_in_reach() {
        let reach = Reach { distance: 0.3, rim: Rim::Bowl };
        let placement = Placement {
            grid_from_pattern: DMat3::from_rotation_y(0.7),
            scale: 5.0,
            center_pattern: DVec3::X,
            point_grid: DVec3::new(1.0, 2.0, 3.0),
        };
        let inward = -placement.grid_from_pattern.z_axis;
        let surface = HalfSpace { normal: -inward, offset: -inward.dot(placement.point_grid) };
        let mut planes = reach.bowl(&placement);
        planes.push(surface);
        let around = Hull::cuboid(DVec3::splat(6.0));
        let hull = planes.iter().try_fold(around, |hull, facet| hull.clipped(facet)).unwrap();
        let from_blow = |corner: &DVec3| *corner - placement.point_grid;
        let corners = || hull.vertices().iter().map(from_blow);
        let farthest = corners().map(DVec3::length).fold(0.0, f64::max);
        let depth = corners().map(|corner| corner.dot(inward)).fold(0.0, f64::max);
        assert!((farthest / reach.distance - 1.0).abs() < 1e-12, "{farthest}");
        assert!((0.35..0.65).contains(&(depth / reach.distance)), "{depth}");
    }
}
