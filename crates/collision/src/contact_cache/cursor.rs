//! Cursor over the cached manifolds of the last frame, advanced in the order of this frame's pairs.

use crate::contact_cache::cached_manifold::{CacheChunk, CachedManifold, CachedPoint};
use frangible_bodies::Pair;

/// Marks removed bodies.
pub(super) const REMOVED: u32 = u32::MAX;

/// Cursor over the cached manifolds of the last frame.
#[derive(Clone, Copy)]
pub(super) struct CacheCursor<'a> {
    chunks: &'a [CacheChunk],
    /// Present index of each cached body.
    indices: &'a [u32],
    /// First pair of each chunk.
    first_pairs: &'a [Pair],
    chunk: usize,
    at: usize,
    /// Begin of the next pair's points.
    begin: usize,
}

impl<'a> CacheCursor<'a> {
    /// A cursor over `chunks`, with present body indices `indices`, and the first pairs
    /// `first_pairs`.
    pub(super) fn new(
        chunks: &'a [CacheChunk],
        indices: &'a [u32],
        first_pairs: &'a [Pair],
    ) -> Self {
        Self { chunks, indices, first_pairs, chunk: 0, at: 0, begin: 0 }
    }

    /// Skips chunks before a pair.
    pub(super) fn skip_to(&mut self, pair: Pair) {
        let chunk = self.first_pairs.partition_point(|&first| first <= pair).saturating_sub(1);
        (self.chunk, self.at, self.begin) = (chunk, 0, 0);
    }

    /// Cached manifold and points of a pair, if any; skips earlier pairs.
    #[inline]
    pub(super) fn find(&mut self, pair: Pair) -> Option<(&'a CachedManifold, &'a [CachedPoint])> {
        loop {
            let chunk = self.chunks.get(self.chunk)?;
            let Some(cached) = chunk.pairs.get(self.at) else {
                (self.chunk, self.at, self.begin) = (self.chunk + 1, 0, 0);
                continue;
            };
            let end = cached.end as usize;
            if let Some(pair_now) = now(cached, self.indices) {
                if pair_now > pair {
                    return None;
                }
                if pair_now == pair {
                    return Some((cached, &chunk.points[self.begin..end]));
                }
            }
            (self.at, self.begin) = (self.at + 1, end);
        }
    }
}

/// First pair with two living bodies of each chunk, or of a later chunk.
pub(super) fn first_pairs(chunks: &[CacheChunk], indices: &[u32]) -> Vec<Pair> {
    const LAST: Pair = Pair { first: usize::MAX, second: usize::MAX };
    let mut first_pairs = vec![LAST; chunks.len()];
    let mut next = LAST;
    for (chunk, first) in chunks.iter().zip(&mut first_pairs).rev() {
        next = chunk.pairs.iter().find_map(|cached| now(cached, indices)).unwrap_or(next);
        *first = next;
    }
    first_pairs
}

/// Present indices of a cached pair, if both bodies live.
#[inline]
fn now(cached: &CachedManifold, indices: &[u32]) -> Option<Pair> {
    let [first, second] = cached.bodies.map(|place| indices[place as usize]);
    let pair = Pair { first: first as usize, second: second as usize };
    (first != REMOVED && second != REMOVED).then_some(pair)
}
