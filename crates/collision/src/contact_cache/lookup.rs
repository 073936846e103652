//! What is known of pairs from the last frame, while those of this one go by in the same order.

use crate::contact_cache::kept::{Kept, KeptPair, KeptPoint};
use frangible_bodies::Pair;

/// Of a body that is gone.
pub(super) const NOWHERE: u32 = u32::MAX;

/// The pairs of the last frame, while those of this one go by in the same order.
#[derive(Clone, Copy)]
pub(super) struct Passing<'a> {
    parts: &'a [Kept],
    /// Where their bodies are now.
    places: &'a [u32],
    /// Of the parts.
    firsts: &'a [Pair],
    part: usize,
    at: usize,
    /// Of the points of the pair that comes next.
    begin: usize,
}

impl<'a> Passing<'a> {
    /// Of some parts, of which bodies are now at `places`, and their `firsts`.
    pub(super) fn new(parts: &'a [Kept], places: &'a [u32], firsts: &'a [Pair]) -> Self {
        Self { parts, places, firsts, part: 0, at: 0, begin: 0 }
    }

    /// Passes over parts before a pair.
    pub(super) fn go_to(&mut self, pair: Pair) {
        let part = self.firsts.partition_point(|&first| first <= pair).saturating_sub(1);
        (self.part, self.at, self.begin) = (part, 0, 0);
    }

    /// A pair and its points, if it was kept; those before it are passed over.
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

/// The first pair of each part of which both bodies are still there, or of a later part.
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

/// What a pair of the last frame is now, if both bodies are still there.
#[inline]
fn now(kept: &KeptPair, places: &[u32]) -> Option<Pair> {
    let [first, second] = kept.bodies.map(|place| places[place as usize]);
    let pair = Pair { first: first as usize, second: second as usize };
    (first != NOWHERE && second != NOWHERE).then_some(pair)
}
