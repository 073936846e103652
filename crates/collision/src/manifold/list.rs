//! Manifolds of many pairs, in lists filled in parallel.

use crate::manifold::{Manifold, ManifoldPoint};
use crate::narrow_phase::fixed_neighbours::FixedNeighbours;
use frangible_bodies::Pair;

/// Manifolds in increasing order of their pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifolds {
    /// One chunk per task, in order.
    pub(crate) parts: Vec<Found>,
    /// Stand in the place of the same pairs of `parts`, or beside them.
    pub(crate) replaced: Found,
    /// Of all pairs that were looked at, also those without points.
    pub neighbours: FixedNeighbours,
}

/// Manifolds of consecutive pairs, with a common list of points.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Found {
    pairs: Vec<FoundPair>,
    points: Vec<ManifoldPoint>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct FoundPair {
    pair: Pair,
    /// End of its points in the list.
    end: usize,
    /// Fastest approach of its points; see [`ManifoldPoint::approach`].
    approach: f64,
}

impl Manifolds {
    /// Iterates over all manifolds.
    pub fn iter(&self) -> impl Iterator<Item = Manifold<'_>> {
        let mut kept = self.parts.iter().flat_map(Found::iter).peekable();
        let mut replaced = self.replaced.iter().peekable();
        std::iter::from_fn(move || {
            let Some(next) = replaced.peek() else { return kept.next() };
            if let Some(before) = kept.next_if(|manifold| manifold.pair < next.pair) {
                return Some(before);
            }
            kept.next_if(|manifold| manifold.pair == next.pair);
            replaced.next()
        })
    }

    /// Iterates over pairs and their points, replaced ones last.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (Pair, &mut [ManifoldPoint])> {
        let Self { parts, replaced, .. } = self;
        let pairs: Vec<Pair> = replaced.pairs.iter().map(|found| found.pair).collect();
        let is_kept = move |pair: &Pair| pairs.binary_search(pair).is_err();
        let kept = parts.iter_mut().flat_map(Found::iter_mut);
        kept.filter(move |(pair, _)| is_kept(pair)).chain(replaced.iter_mut())
    }

    /// Iterates over pairs and their approach speeds [m/s], before any are replaced.
    pub fn approaches(&self) -> impl Iterator<Item = (Pair, f64)> {
        debug_assert!(self.replaced.pairs.is_empty());
        self.parts.iter().flat_map(|part| &part.pairs).map(|found| (found.pair, found.approach))
    }

    /// Replaces or inserts the points of pairs in increasing order, once.
    pub fn replace(&mut self, pairs: &[(Pair, Vec<ManifoldPoint>)]) {
        debug_assert!(self.replaced.pairs.is_empty() && pairs.is_sorted_by_key(|&(pair, _)| pair));
        for (pair, points) in pairs {
            self.replaced.add(*pair, points.iter().copied());
        }
    }
}

impl Found {
    fn iter(&self) -> impl Iterator<Item = Manifold<'_>> {
        let mut begin = 0;
        self.pairs.iter().map(move |&FoundPair { pair, end, .. }| {
            let points = &self.points[begin..end];
            begin = end;
            Manifold { pair, points }
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

    /// Appends the points of a pair, if any.
    pub(crate) fn add(&mut self, pair: Pair, points: impl IntoIterator<Item = ManifoldPoint>) {
        let begin = self.points.len();
        self.points.extend(points);
        if self.points.len() > begin {
            let approaches = self.points[begin..].iter().map(|point| point.approach);
            let approach = approaches.fold(0.0, f64::max);
            self.pairs.push(FoundPair { pair, end: self.points.len(), approach });
        }
    }

    pub(crate) fn clear(&mut self) {
        self.pairs.clear();
        self.points.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn point(gap: f64) -> ManifoldPoint {
        ManifoldPoint {
            anchor_first: DVec3::ZERO,
            anchor_second: DVec3::ZERO,
            rounding: [0.0; 2],
            normal: DVec3::Y,
            feature: crate::manifold::FeatureId { is_of_first: true, index: 0 },
            approach: 0.0,
            gap,
        }
    }

    /// Replaced points stand where those of the same pair were, new pairs in their order, and a
    /// change of all points reaches them and not those that they replaced.
    #[test]
    fn replaced_manifolds_stand_in_the_order_of_their_pairs() {
        let pair = |second: usize| Pair { first: 0, second };
        let mut found = Found::default();
        [2, 4, 6].into_iter().for_each(|second| found.add(pair(second), [point(1.0)]));
        let mut manifolds = Manifolds { parts: vec![found], ..Manifolds::default() };
        let new = |second: usize| (pair(second), vec![point(2.0); 2]);
        manifolds.replace(&[new(1), new(4), new(7)]);
        let seen = |manifolds: &Manifolds| -> Vec<(usize, usize, f64)> {
            let of = |all: Manifold| (all.pair.second, all.points.len(), all.points[0].gap);
            manifolds.iter().map(of).collect()
        };
        let wanted = [(1, 2, 2.0), (2, 1, 1.0), (4, 2, 2.0), (6, 1, 1.0), (7, 2, 2.0)];
        assert_eq!(seen(&manifolds), wanted);

        let mut pairs: Vec<usize> = Vec::new();
        for (pair, points) in manifolds.iter_mut() {
            pairs.push(pair.second);
            points.iter_mut().for_each(|point| point.gap += 1.0);
        }
        assert_eq!(pairs, [2, 6, 1, 4, 7]);
        assert_eq!(seen(&manifolds), wanted.map(|(second, count, gap)| (second, count, gap + 1.0)));
    }
}
