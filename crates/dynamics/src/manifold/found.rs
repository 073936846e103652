//! The manifolds of many pairs, in lists that threads fill side by side.

use super::{Manifold, ManifoldPoint};
use crate::pair::Pair;

/// The manifolds of some pairs, in the order of the pairs, which is increasing.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifolds {
    /// One after the other: each thread finds some.
    pub(crate) parts: Vec<Found>,
}

/// The manifolds of pairs that follow each other, their points in one list.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    pairs: Vec<FoundPair>,
    points: Vec<ManifoldPoint>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct FoundPair {
    pair: Pair,
    /// Its last point, among those of all pairs.
    end: usize,
    /// See [`ManifoldPoint::approach`]: the fastest.
    approach: f64,
    /// See [`Manifold::struck`].
    struck: f64,
}

impl Manifolds {
    /// One by one.
    pub fn iter(&self) -> impl Iterator<Item = Manifold<'_>> {
        self.parts.iter().flat_map(Found::iter)
    }

    /// Pairs and their points.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (Pair, &mut [ManifoldPoint])> {
        self.parts.iter_mut().flat_map(Found::iter_mut)
    }

    /// Pairs and how fast they approach each other [m/s].
    pub(crate) fn approaches(&self) -> impl Iterator<Item = (Pair, f64)> {
        self.parts.iter().flat_map(|part| &part.pairs).map(|found| (found.pair, found.approach))
    }

    /// Notes how much faster pairs may come against each other because they are struck [m/s]. They are in increasing order; those that have no points
    /// get places without.
    pub(crate) fn note_struck(&mut self, struck: &[(Pair, f64)]) {
        if self.parts.is_empty() {
            self.parts.push(Found::default());
        }
        // Each part takes those before the first of the next ones.
        let mut rest = struck;
        for at in 0..self.parts.len() {
            let next = self.parts[at + 1..].iter().find_map(|part| part.pairs.first());
            let count = match next {
                Some(next) => rest.partition_point(|(pair, _)| *pair < next.pair),
                None => rest.len(),
            };
            let (of_part, others) = rest.split_at(count);
            if !of_part.is_empty() {
                self.parts[at].note_struck(of_part);
            }
            rest = others;
        }
    }

    /// How many there are.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|part| part.pairs.len()).sum()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.parts.iter().all(|part| part.pairs.is_empty())
    }
}

impl Found {
    fn iter(&self) -> impl Iterator<Item = Manifold<'_>> {
        let mut begin = 0;
        self.pairs.iter().map(move |&FoundPair { pair, end, struck, .. }| {
            let points = &self.points[begin..end];
            begin = end;
            Manifold { pair, points, struck }
        })
    }

    fn iter_mut(&mut self) -> impl Iterator<Item = (Pair, &mut [ManifoldPoint])> {
        let (mut begin, mut rest) = (0, self.points.as_mut_slice());
        self.pairs.iter().map(move |&FoundPair { pair, end, .. }| {
            let (points, others) = std::mem::take(&mut rest).split_at_mut(end - begin);
            (begin, rest) = (end, others);
            (pair, points)
        })
    }

    /// See [`Manifolds::note_struck`].
    fn note_struck(&mut self, struck: &[(Pair, f64)]) {
        let mut struck = struck.iter().copied().peekable();
        let mut pairs = Vec::with_capacity(self.pairs.len() + struck.len());
        let mut end = 0;
        for mut found in self.pairs.drain(..) {
            let before = |&(pair, _): &(Pair, f64)| pair < found.pair;
            pairs.extend(
                std::iter::from_fn(|| struck.next_if(before))
                    .map(|pair| FoundPair::without_points(pair, end)),
            );
            if let Some((_, struck)) = struck.next_if(|&(pair, _)| pair == found.pair) {
                found.struck = struck;
            }
            end = found.end;
            pairs.push(found);
        }
        pairs.extend(struck.map(|pair| FoundPair::without_points(pair, end)));
        self.pairs = pairs;
    }

    /// Adds the points of a pair, if there are any.
    pub(crate) fn add(&mut self, pair: Pair, points: impl IntoIterator<Item = ManifoldPoint>) {
        self.add_near(pair, points, f64::INFINITY);
    }

    /// All of them, if any is as `near` [m]; what is not a number is.
    pub(crate) fn add_near(
        &mut self,
        pair: Pair,
        points: impl IntoIterator<Item = ManifoldPoint>,
        near: f64,
    ) {
        let begin = self.points.len();
        self.points.extend(points);
        let of_pair = &self.points[begin..];
        if of_pair.iter().any(|point| point.gap <= near || point.gap.is_nan()) {
            let approach = of_pair.iter().map(|point| point.approach).fold(0.0, f64::max);
            self.pairs.push(FoundPair { pair, end: self.points.len(), approach, struck: 0.0 });
        } else {
            self.points.truncate(begin);
        }
    }

    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.points.clear();
    }
}

impl FoundPair {
    /// A pair that may come so much faster against each other [m/s], after so many points of others.
    fn without_points((pair, struck): (Pair, f64), end: usize) -> Self {
        Self { pair, end, approach: 0.0, struck }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// What may be struck is noted where it touches, and has a place without points where it does not, in the order of the pairs, in whichever part.
    #[test]
    fn pairs_that_are_struck_have_their_places() {
        let pair = |first: usize, second: usize| Pair { first, second };
        let point = |approach: f64| ManifoldPoint {
            anchor_first: DVec3::ZERO,
            anchor_second: DVec3::ZERO,
            rounding: [0.0; 2],
            normal: DVec3::Y,
            sample: (true, 0),
            approach,
            gap: 0.0,
        };
        let mut parts = vec![Found::default(); 4];
        parts[0].add(pair(0, 3), [point(1.0), point(2.0)]);
        parts[0].add(pair(1, 2), [point(0.0)]);
        parts[2].add(pair(4, 5), [point(3.0)]);
        let mut all = Manifolds { parts };
        assert!(all.approaches().eq([(pair(0, 3), 2.0), (pair(1, 2), 0.0), (pair(4, 5), 3.0)]));

        all.note_struck(&[(pair(0, 1), 1.0), (pair(1, 2), 2.0), (pair(3, 9), 3.0), (pair(7, 8), 4.0)]);
        let seen = all.iter().map(|manifold| {
            let Manifold { pair, points, struck } = manifold;
            ([pair.first, pair.second], points.len(), struck)
        });
        let wanted = [
            ([0, 1], 0, 1.0),
            ([0, 3], 2, 0.0),
            ([1, 2], 1, 2.0),
            ([3, 9], 0, 3.0),
            ([4, 5], 1, 0.0),
            ([7, 8], 0, 4.0),
        ];
        assert!(seen.eq(wanted), "{all:?}");

        let mut none = Manifolds::default();
        none.note_struck(&[(pair(0, 1), 1.0)]);
        assert_eq!(none.len(), 1);
    }
}
