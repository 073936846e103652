//! An oracle for separations: brute force in double precision, by the definition of convex bodies,
//! independent of the narrow phase; and random pairs of shapes to compare both on.
//!
//! A convex body is a *core* (points, or two discs on an axis) and a rounding. Along a unit normal
//! two cores are apart by what their supports leave between them; their separation is the largest
//! of these numbers over all normals [Gregorius13]. Cores apart: nearest points of both, until
//! support points prove the distance. Cores that overlap: a polytope in their difference, until its
//! surface proves that no normal separates further. Both are good to 1e-8 of the smaller body, or
//! better.
//!
//! Where rounding leaves no proof, in one of a hundred pairs at most, all normals are tried that
//! can be best: of a face of either, and across an edge of each, where rims are edges in all
//! directions: first in steps, and then ever smaller steps around the best. The number given is
//! attained by a normal, so true overlaps are never deeper than it says; they are shallower only if
//! the steps miss a valley. Where cores have no rims all normals are tried, and the error is
//! rounding.

pub(crate) mod body;
pub(crate) mod depth;
pub(crate) mod distance;
pub(crate) mod draw;
pub(crate) mod proof;
pub(crate) mod refine;

use body::Convex;
use distance::Distance;
use glam::DVec3;

/// Answer of the oracle about two convex bodies.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Truth {
    /// Separation of the surfaces [m]; negative for overlap.
    pub(crate) gap: f64,
    /// Unit, from the second to the first.
    pub(crate) normal: DVec3,
    /// Separation of the cores [m].
    pub(crate) of_cores: f64,
}

/// Overlaps below this part of the smaller body's reach may be none: of bodies ten thousand times
/// as large rounding leaves the search for nearest points that much.
const NEARLY: f64 = 1e-3;

/// Separation of the first from the second.
pub(crate) fn truth(first: &Convex, second: &Convex) -> Truth {
    let (of_cores, normal) = match distance::distance(first, second) {
        Some(Distance { least, normal, is_proved: true }) => (least, normal),
        Some(_) | None if let Some(proved) = proof::least_overlap(first, second) => proved,
        Some(Distance { least, normal, .. }) => refine::refine(first, second, (least, normal)),
        None => {
            let found = depth::least_overlap(first, second);
            let size = first.radius().min(second.radius());
            if found.0 < -NEARLY * size { found } else { refine::refine(first, second, found) }
        }
    };
    Truth { gap: of_cores - first.rounding - second.rounding, normal, of_cores }
}

/// Separation along a unit normal from the second to the first [m].
pub(crate) fn along(first: &Convex, second: &Convex, normal: DVec3) -> f64 {
    let cores = (first.support(-normal) - second.support(normal)).dot(normal);
    cores - first.rounding - second.rounding
}

#[cfg(test)]
mod tests;
