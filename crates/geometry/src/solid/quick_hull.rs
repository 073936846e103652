//! Convex hulls for comparisons: their planes and volume alone.

use super::elements::NONE;
use glam::DVec3;

/// Points less than this part of the points' extent outside of a facet are on it.
const ON_THE_HULL: f64 = 1e-10;

/// The convex hull of points, rounded, with room for the next one. It is closed by construction:
/// whatever rounding lets a new corner see, a cone to the rim of that replaces it.
#[derive(Debug, Default)]
pub(crate) struct QuickHull {
    facets: Vec<Facet>,
    /// Of each point the next one outside of the same facet.
    next: Vec<u32>,
    rim: Vec<[u32; 2]>,
    orphans: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
struct Facet {
    corners: [u32; 3],
    /// Unit.
    normal: DVec3,
    /// [m]
    offset: f64,
    /// The first of the points outside of it.
    outside: u32,
}

impl QuickHull {
    /// Outward unit normals and offsets [m] of the last hull's facets.
    pub(crate) fn planes(&self) -> impl Iterator<Item = (DVec3, f64)> + Clone {
        self.facets.iter().map(|facet| (facet.normal, facet.offset))
    }

    /// The volume of the hull of points [m^3]; 0 if they are flat.
    pub(crate) fn volume(&mut self, points: &[DVec3]) -> f64 {
        self.facets.clear();
        let Some((first, extent)) = first_corners(points) else { return 0.0 };
        let close = ON_THE_HULL * extent;
        self.next.clear();
        self.next.resize(points.len(), NONE);
        let [a, b, c, d] = first;
        for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
            self.add(points, corners);
        }
        self.orphans.clear();
        self.orphans.extend((0..points.len() as u32).filter(|at| !first.contains(at)));
        self.share_out(points, 0, close);
        let mut at = 0;
        while at < self.facets.len() {
            match self.furthest(points, at) {
                Some(apex) => at = self.grow(points, at, apex, close),
                None => at += 1,
            }
        }
        let origin = points[a as usize];
        let six: f64 = self
            .facets
            .iter()
            .map(|facet| {
                let [a, b, c] = facet.corners.map(|at| points[at as usize] - origin);
                a.dot(b.cross(c))
            })
            .sum();
        six / 6.0
    }

    fn add(&mut self, points: &[DVec3], corners: [u32; 3]) {
        let [a, b, c] = corners.map(|at| points[at as usize]);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        self.facets.push(Facet { corners, normal, offset: normal.dot(a), outside: NONE });
    }

    /// Gives each orphan to one of the facets from `first` on, if it is outside of one.
    fn share_out(&mut self, points: &[DVec3], first: usize, close: f64) {
        for &orphan in &self.orphans {
            let point = points[orphan as usize];
            let sees = |facet: &&mut Facet| facet.normal.dot(point) > facet.offset + close;
            if let Some(facet) = self.facets[first..].iter_mut().find(sees) {
                self.next[orphan as usize] = facet.outside;
                facet.outside = orphan;
            }
        }
    }

    fn furthest(&self, points: &[DVec3], at: usize) -> Option<u32> {
        let Facet { normal, outside, .. } = self.facets[at];
        let (mut furthest, mut most) = (None, f64::NEG_INFINITY);
        let mut point = outside;
        while point != NONE {
            let height = normal.dot(points[point as usize]);
            if height > most {
                (furthest, most) = (Some(point), height);
            }
            point = self.next[point as usize];
        }
        furthest
    }

    /// Replaces all facets that can be seen from `apex`, of which one is `seen`. Answers with the
    /// new place of what comes after that one.
    fn grow(&mut self, points: &[DVec3], seen: usize, apex: u32, close: f64) -> usize {
        let point = points[apex as usize];
        self.rim.clear();
        self.orphans.clear();
        let (mut kept, mut before) = (0, 0);
        for at in 0..self.facets.len() {
            if at == seen {
                before = kept;
            }
            let facet = self.facets[at];
            if at != seen && facet.normal.dot(point) <= facet.offset + 0.5 * close {
                self.facets[kept] = facet;
                kept += 1;
                continue;
            }
            let [a, b, c] = facet.corners;
            for [from, to] in [[a, b], [b, c], [c, a]] {
                match self.rim.iter().position(|&side| side == [to, from]) {
                    Some(beside) => {
                        self.rim.swap_remove(beside);
                    }
                    None => self.rim.push([from, to]),
                }
            }
            let mut orphan = facet.outside;
            while orphan != NONE {
                if orphan != apex {
                    self.orphans.push(orphan);
                }
                orphan = self.next[orphan as usize];
            }
        }
        self.facets.truncate(kept);
        for at in 0..self.rim.len() {
            let [from, to] = self.rim[at];
            self.add(points, [from, to, apex]);
        }
        self.share_out(points, kept, close);
        before
    }
}

/// Four points far apart, the last below the plane of the others, and the extent of all [m].
fn first_corners(points: &[DVec3]) -> Option<([u32; 4], f64)> {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) =
        points.iter().fold(none, |(low, high), &point| (low.min(point), high.max(point)));
    let axis = (high - low).max_position();
    let extent = (high - low)[axis];
    let furthest = |from: &dyn Fn(DVec3) -> f64| {
        let pairs = points.iter().map(|&point| from(point)).zip(0..);
        pairs.max_by(|a, b| a.0.total_cmp(&b.0)).map_or((0, 0.0), |(most, at)| (at, most))
    };
    let place = |at: u32| points[at as usize];
    if points.len() < 4 {
        return None;
    }
    let (a, _) = furthest(&|point| -point[axis]);
    let (b, _) = furthest(&|point| point[axis]);
    let along = (place(b) - place(a)).normalize_or_zero();
    let (c, wide) = furthest(&|point| along.cross(point - place(a)).length_squared());
    let normal = along.cross(place(c) - place(a)).normalize_or_zero();
    let (d, thick) = furthest(&|point| normal.dot(point - place(a)).abs());
    if wide.sqrt() <= ON_THE_HULL * extent || thick <= ON_THE_HULL * extent {
        return None;
    }
    let is_above = normal.dot(place(d) - place(a)) > 0.0;
    Some((if is_above { [a, c, b, d] } else { [a, b, c, d] }, extent))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hull::Hull;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn volumes_are_those_of_hulls(
            places in prop::collection::vec(prop::array::uniform3(-4..5i32), 4..60),
            moves in prop::collection::vec(prop::array::uniform3(-1.0..1.0f64), 60),
            noise in prop_oneof![Just(0.0), Just(1e-12), Just(0.3)],
        ) {
            let points: Vec<DVec3> = places
                .iter()
                .zip(&moves)
                .map(|(place, moved)| {
                    DVec3::from_array(place.map(f64::from)) + noise * DVec3::from_array(*moved)
                })
                .collect();
            let exact = Hull::of_points(&points).map_or(0.0, |hull| hull.volume());
            let mut quick = QuickHull::default();
            prop_assert!((quick.volume(&points) - exact).abs() < 1e-3);
            for (normal, offset) in quick.planes() {
                prop_assert!(points.iter().all(|point| normal.dot(*point) < offset + 1e-6));
            }
        }
    }
}
