//! Manifolds of many pairs, in lists filled in parallel.

use crate::manifold::{Manifold, ManifoldPoint};
use frangible_bodies::Pair;

/// Manifolds in increasing order of their pairs.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Manifolds {
    /// One chunk per task, in order.
    pub(crate) parts: Vec<Found>,
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
        self.parts.iter().flat_map(Found::iter)
    }

    /// Iterates over pairs and their points.
    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (Pair, &mut [ManifoldPoint])> {
        self.parts.iter_mut().flat_map(Found::iter_mut)
    }

    /// Iterates over pairs and their approach speeds [m/s].
    pub fn approaches(&self) -> impl Iterator<Item = (Pair, f64)> {
        self.parts.iter().flat_map(|part| &part.pairs).map(|found| (found.pair, found.approach))
    }

    /// Replaces or inserts the points of pairs in increasing order.
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

    /// Number of manifolds.
    pub fn len(&self) -> usize {
        self.parts.iter().map(|part| part.pairs.len()).sum()
    }

    /// True without manifolds.
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
