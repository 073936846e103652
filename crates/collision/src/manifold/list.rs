//! The manifolds of many pairs, in lists that threads fill side by side.

use crate::manifold::{Manifold, ManifoldPoint};
use frangible_bodies::Pair;

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
    pub fn approaches(&self) -> impl Iterator<Item = (Pair, f64)> {
        self.parts.iter().flat_map(|part| &part.pairs).map(|found| (found.pair, found.approach))
    }

    /// Puts other points in the place of a pair's, or adds the pair, for pairs in increasing order.
    pub fn replace(&mut self, pairs: &[(Pair, Vec<ManifoldPoint>)]) {
        let mut merged = Found::default();
        let mut new = pairs.iter().peekable();
        for Manifold { pair, points } in self.iter() {
            while let Some((before, points)) = new.next_if(|(new, _)| *new < pair) {
                merged.add(*before, points.iter().copied());
            }
            match new.next_if(|(new, _)| *new == pair) {
                Some((_, points)) => merged.add(pair, points.iter().copied()),
                None => merged.add(pair, points.iter().copied()),
            }
        }
        new.for_each(|(pair, points)| merged.add(*pair, points.iter().copied()));
        self.parts = vec![merged];
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

    /// Adds the points of a pair, if there are any.
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
