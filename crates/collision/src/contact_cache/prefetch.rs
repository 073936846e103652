//! Prefetching of shapes for recomputed pairs: a heap's shapes exceed the near caches.

use crate::narrow_phase::solid::{MOST_EDGE_PAIRS, Solid};
use frangible_bodies::Pair;
use frangible_geometry::{Columns, Hull, Shape};
use frangible_math::prefetch;
use std::slice::from_ref;

/// Collision shape of a body.
pub(super) struct Seen<'a> {
    solid: Solid<'a>,
    /// Number of edges; 0 except for polyhedra.
    edges: usize,
}

impl<'a> Seen<'a> {
    pub(super) fn of(shape: &'a Shape) -> Self {
        let solid = Solid::of(shape);
        let edges = if let Solid::Hull(hull) = solid { hull.edges().len() } else { 0 };
        Self { solid, edges }
    }

    /// Shapes of a cacheable pair: two polyhedra, or a polyhedron on the ground.
    pub(super) fn lasting([first, second]: [&Self; 2]) -> Option<[Solid<'a>; 2]> {
        let lasts = match (first.solid, second.solid) {
            (Solid::Hull(_), Solid::Hull(_)) => first.edges * second.edges <= MOST_EDGE_PAIRS,
            (Solid::Ground(_), Solid::Hull(_)) => true,
            _ => false,
        };
        lasts.then_some([first.solid, second.solid])
    }
}

/// Pairs between two stages of prefetching: processing them takes about as long as a memory access.
const STEP: usize = 2;

/// Prefetcher over a list of pairs.
pub(super) struct Ahead<'a> {
    seen: &'a [Seen<'a>],
    pairs: &'a [Pair],
    /// Next pair to prefetch.
    next: usize,
}

impl<'a> Ahead<'a> {
    pub(super) fn new(seen: &'a [Seen<'a>], pairs: &'a [Pair]) -> Self {
        let mut ahead = Self { seen, pairs, next: 0 };
        (0..3 * STEP).for_each(|_| ahead.go_on());
        ahead
    }

    /// Prefetches one more pair in three stages: hulls, their arrays, and edges.
    #[inline]
    pub(super) fn go_on(&mut self) {
        let Self { seen, pairs, next } = *self;
        let hulls = |back: usize| -> [Option<&Hull>; 2] {
            let pair = next.checked_sub(back).and_then(|at| pairs.get(at));
            let hull =
                |i: usize| if let Solid::Hull(hull) = seen[i].solid { Some(hull) } else { None };
            pair.map_or([None; 2], |pair| [hull(pair.first), hull(pair.second)])
        };
        for hull in hulls(0).into_iter().flatten() {
            prefetch(from_ref(hull));
        }
        for hull in hulls(STEP).into_iter().flatten() {
            prefetch(hull.vertices());
            prefetch(hull.planes());
            prefetch(hull.net());
            prefetch(hull.known_columns().map_or(&[], Columns::all));
        }
        for hull in hulls(2 * STEP).into_iter().flatten() {
            prefetch(hull.edges());
            prefetch(hull.sides());
        }
        self.next += 1;
    }
}
