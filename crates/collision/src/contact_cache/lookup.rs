//! Cursor over the cached manifolds of the last frame, advanced in the order of this frame's pairs.

use crate::contact_cache::kept::{Kept, KeptPair, KeptPoint};
use frangible_bodies::Pair;

/// Marks removed bodies.
pub(super) const NOWHERE: u32 = u32::MAX;

/// Cursor over the cached manifolds of the last frame.
#[derive(Clone, Copy)]
pub(super) struct Passing<'a> {
    parts: &'a [Kept],
    /// Present index of each cached body.
    places: &'a [u32],
    /// First pair of each chunk.
    firsts: &'a [Pair],
    part: usize,
    at: usize,
    /// Begin of the next pair's points.
    begin: usize,
}

impl<'a> Passing<'a> {
    /// A cursor over `parts`, with present body indices `places`, and the first pairs `firsts`.
    pub(super) fn new(parts: &'a [Kept], places: &'a [u32], firsts: &'a [Pair]) -> Self {
        Self { parts, places, firsts, part: 0, at: 0, begin: 0 }
    }

    /// Skips chunks before a pair.
    pub(super) fn go_to(&mut self, pair: Pair) {
        let part = self.firsts.partition_point(|&first| first <= pair).saturating_sub(1);
        (self.part, self.at, self.begin) = (part, 0, 0);
    }

    /// Cached manifold and points of a pair, if any; skips earlier pairs.
    #[inline]
    pub(super) fn find(&mut self, pair: Pair) -> Option<(&'a KeptPair, &'a [KeptPoint])> {
        loop {
            let part = self.parts.get(self.part)?;
            let Some(kept) = part.pairs.get(self.at) else {
                (self.part, self.at, self.begin) = (self.part + 1, 0, 0);
                continue;
            };
            let end = kept.end as usize;
            if let Some(kept_pair) = now(kept, self.places) {
                if kept_pair > pair {
                    return None;
                }
                if kept_pair == pair {
                    return Some((kept, &part.points[self.begin..end]));
                }
            }
            (self.at, self.begin) = (self.at + 1, end);
        }
    }
}

/// First pair with two living bodies of each chunk, or of a later chunk.
pub(super) fn firsts(parts: &[Kept], places: &[u32]) -> Vec<Pair> {
    const LAST: Pair = Pair { first: usize::MAX, second: usize::MAX };
    let mut firsts = vec![LAST; parts.len()];
    let mut next = LAST;
    for (part, first) in parts.iter().zip(&mut firsts).rev() {
        next = part.pairs.iter().find_map(|kept| now(kept, places)).unwrap_or(next);
        *first = next;
    }
    firsts
}

/// Present indices of a cached pair, if both bodies live.
#[inline]
fn now(kept: &KeptPair, places: &[u32]) -> Option<Pair> {
    let [first, second] = kept.bodies.map(|place| places[place as usize]);
    let pair = Pair { first: first as usize, second: second as usize };
    (first != NOWHERE && second != NOWHERE).then_some(pair)
}
