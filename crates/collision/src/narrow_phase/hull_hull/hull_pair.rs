//! Two hulls and where they are.

use crate::narrow_phase::hull_hull::placement::{Placement, View};
use frangible_geometry::Hull;
use frangible_math::{RigidTransform, Width};

/// How much better an axis must be than the one before it in the order of preference, relative to
/// the size of the smaller hull: what rests does not change its features for less. Without it a
/// heap of 800 pieces that falls has overlaps of 6.8 instead of 1.3 mm at the 99th percentile.
pub(crate) const PREFERENCE: f64 = 5e-4;

/// Two hulls where they are.
#[derive(Clone, Copy)]
pub(crate) struct HullPair<'a> {
    pub(crate) hulls: [&'a Hull; 2],
    pub(crate) first_from_second: Placement,
    pub(crate) second_from_first: Placement,
    /// Lengths that differ by less are equal [m].
    pub(crate) close: f64,
    pub(crate) width: Width,
}

impl<'a> HullPair<'a> {
    /// The smaller one is of `size` [m]; their faces and vertices are looked at with instructions
    /// of this width.
    pub(crate) fn new(
        hulls: [&'a Hull; 2],
        first_from_second: &RigidTransform,
        size: f64,
        width: Width,
    ) -> Self {
        let first_from_second = Placement::new(first_from_second);
        let second_from_first = first_from_second.inverse();
        Self { hulls, first_from_second, second_from_first, close: PREFERENCE * size, width }
    }

    /// The frame of one, by its number, from that of the other.
    pub(crate) fn own_from_other(&self, side: usize) -> &Placement {
        if side == 0 { &self.first_from_second } else { &self.second_from_first }
    }

    /// In the first one's frame.
    pub(crate) fn views(&self) -> [View<'_>; 2] {
        let [first, second] = self.hulls;
        [
            View { hull: first, here_from_hull: None },
            View { hull: second, here_from_hull: Some(&self.first_from_second) },
        ]
    }
}
