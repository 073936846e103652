//! Search for the least overlap of two cores among normals that are offered.

use crate::narrow_phase::revolved::partner::{Partner, furthest_vertex};
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use glam::DVec3;

/// Golden-section steps of a search along an arc: to 1e-9 of it.
const NARROWINGS: usize = 44;

/// Search for the least overlap.
pub(crate) struct Search<'a> {
    pub(crate) round: &'a PlacedRevolved,
    pub(crate) partner: &'a Partner<'a>,
    /// A later normal must be better by this [m]: resting contacts keep theirs.
    pub(crate) margin: f64,
    /// Least overlap [m] so far, and its normal.
    pub(crate) depth: f64,
    pub(crate) normal: DVec3,
    /// Vertices of a hull that were furthest along normals that were offered [m].
    known: Vec<DVec3>,
}

impl<'a> Search<'a> {
    pub(crate) fn new(round: &'a PlacedRevolved, partner: &'a Partner<'a>, margin: f64) -> Self {
        let known = Vec::new();
        Self { round, partner, margin, depth: f64::INFINITY, normal: DVec3::Y, known }
    }

    /// Overlap along a unit normal from the partner to the round body [m].
    #[inline]
    pub(crate) fn overlap(&self, normal: DVec3) -> f64 {
        self.round.reach(-normal) + self.partner.reach(normal)
    }

    #[inline]
    pub(crate) fn offer(&mut self, normal: DVec3) {
        let Partner::Hull(hull) = self.partner else {
            return self.take(self.overlap(normal), normal);
        };
        // One known vertex is enough to show that a normal is no better: few are looked at with all
        // vertices.
        let (own, enough) = (self.round.reach(-normal), self.depth - self.margin);
        if self.known.iter().rev().any(|vertex| own + vertex.dot(normal) >= enough) {
            return;
        }
        let vertex = hull.vertices()[furthest_vertex(hull, normal)];
        self.known.push(vertex);
        self.take(own + vertex.dot(normal), normal);
    }

    #[inline]
    pub(crate) fn take(&mut self, depth: f64, normal: DVec3) {
        if depth < self.depth - self.margin {
            (self.depth, self.normal) = (depth, normal);
        }
    }
}

/// Where a function of one variable is least, between two values of it: the best of the
/// neighbourhoods of all of `tries` that are better than both of their neighbours.
pub(crate) fn least_along([low, high]: [f64; 2], tries: usize, value: impl Fn(f64) -> f64) -> f64 {
    let step = (high - low) / tries as f64;
    let at = |number: usize| low + step * number as f64;
    let mut best = (f64::INFINITY, low);
    let (mut before, mut here) = (f64::INFINITY, value(low));
    for number in 0..=tries {
        let after = if number < tries { value(at(number + 1)) } else { f64::INFINITY };
        if here <= before && here <= after {
            let range = [(at(number) - step).max(low), (at(number) + step).min(high)];
            for found in [(here, at(number)), narrowed(range, &value)] {
                if found.0 < best.0 {
                    best = found;
                }
            }
        }
        (before, here) = (here, after);
    }
    best.1
}

/// The least value of a function with one valley, and where it is, by golden sections.
fn narrowed([mut from, mut to]: [f64; 2], value: &impl Fn(f64) -> f64) -> (f64, f64) {
    const GOLDEN: f64 = 0.618_033_988_749_894_9;
    let mut inner = [to - GOLDEN * (to - from), from + GOLDEN * (to - from)];
    let mut values = inner.map(value);
    for _ in 0..NARROWINGS {
        if values[0] <= values[1] {
            to = inner[1];
            inner = [to - GOLDEN * (to - from), inner[0]];
            values = [value(inner[0]), values[0]];
        } else {
            from = inner[0];
            inner = [inner[1], from + GOLDEN * (to - from)];
            values = [values[1], value(inner[1])];
        }
    }
    if values[0] <= values[1] { (values[0], inner[0]) } else { (values[1], inner[1]) }
}
