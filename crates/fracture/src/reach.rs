//! How far a break reaches from its blow, and the crater that it cuts.

use crate::pattern::Pattern;
use crate::placement::Placement;
use frangible_geometry::{HalfSpace, Hull};
use glam::DVec3;
use std::f64::consts::TAU;

/// How far a break reaches: what lies beyond stays whole.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reach {
    /// From the blow [m].
    pub distance: f64,
    /// Which way the pattern is laid, and where the crater ends.
    pub rim: Rim,
}

/// Where a crater ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
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

/// Nearest facet of the bowl, and how much further others are, relative to one another: so that it
/// looks broken, not turned.
const NEAREST: f64 = 1.0;
const RAGGED: f64 = 0.25;

/// Turn from facet to facet: the golden angle spreads them evenly.
const GOLDEN_ANGLE: f64 = TAU * 0.381_966_011_250_105;
/// Fractional parts of its multiples vary the facets' distances evenly.
const GOLDEN_PART: f64 = 0.618_033_988_749_895;

impl Reach {
    /// The facets of the bowl around the blow, on which a pattern lies: all of its corners are in
    /// reach, the farthest just so.
    pub(crate) fn bowl(&self, placement: &Placement) -> Vec<HalfSpace> {
        let facets: Vec<HalfSpace> = (0..FACETS).map(facet).collect();
        let around = Hull::cuboid(DVec3::splat(2.0 * (NEAREST + RAGGED)));
        let bowl = facets.iter().try_fold(around, |hull, facet| hull.clipped(facet));
        let corners = bowl.iter().flat_map(|hull| hull.vertices());
        let farthest = corners.map(|corner| corner.length()).fold(NEAREST, f64::max);
        let scale = self.distance / farthest;
        let place = |facet: &HalfSpace| {
            let normal = (placement.grid_from_pattern * facet.normal).normalize();
            let offset = normal.dot(placement.point_grid) + scale * facet.offset;
            HalfSpace { normal, offset }
        };
        facets.iter().map(place).collect()
    }

    /// The scale at which the pattern's box holds all that is in reach, if that decides it.
    pub(crate) fn scale(&self, pattern: &Pattern) -> Option<f64> {
        let to_walls =
            (pattern.half_extent - pattern.center).min(pattern.half_extent + pattern.center);
        (self.rim == Rim::Bowl).then(|| self.distance / to_walls.min_element())
    }
}

/// A facet of the bowl around the origin.
fn facet(number: usize) -> HalfSpace {
    let height = 1.0 - (2 * number + 1) as f64 / FACETS as f64;
    let (across, angle) = ((1.0 - height * height).sqrt(), GOLDEN_ANGLE * number as f64);
    let normal = DVec3::new(across * libm::cos(angle), across * libm::sin(angle), height);
    let part = (GOLDEN_PART * (number + 1) as f64).fract();
    HalfSpace { normal, offset: NEAREST + RAGGED * part }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DMat3;

    /// The bowl holds a ball of most of the reach, and none of it is out of reach.
    #[test]
    fn all_of_the_bowl_is_in_reach() {
        let reach = Reach { distance: 0.3, rim: Rim::Bowl };
        let placement = Placement {
            grid_from_pattern: DMat3::from_rotation_y(0.7),
            scale: 5.0,
            center_pattern: DVec3::X,
            point_grid: DVec3::new(1.0, 2.0, 3.0),
        };
        let bowl = reach.bowl(&placement);
        let nearest = bowl.iter().map(|facet| -facet.distance(placement.point_grid));
        assert!(nearest.fold(f64::INFINITY, f64::min) > 0.6 * reach.distance);
        let around = Hull::cuboid(DVec3::splat(4.0));
        let hull = bowl.iter().try_fold(around, |hull, facet| hull.clipped(facet)).unwrap();
        let far = |corner: &DVec3| corner.distance(placement.point_grid);
        let farthest = hull.vertices().iter().map(far).fold(0.0, f64::max);
        assert!((farthest / reach.distance - 1.0).abs() < 1e-12, "{farthest}");
    }
}
