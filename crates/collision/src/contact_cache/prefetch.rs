//! Prefetching of shapes for recomputed pairs: a heap's shapes exceed the near caches.

use crate::narrow_phase::convex_shape::ConvexShape;
use frangible_bodies::Pair;
use frangible_geometry::{Columns, Hull};
use frangible_math::prefetch;
use std::slice::from_ref;

/// True for a pair whose manifold is cached: two polyhedra, or a polyhedron on the ground.
pub(super) fn is_cacheable(shapes: [&ConvexShape; 2]) -> bool {
    matches!(shapes, [ConvexShape::Hull(_) | ConvexShape::Ground(_), ConvexShape::Hull(_)])
}

/// Pairs between two stages of prefetching: processing them takes about as long as a memory access.
const STEP: usize = 2;

/// Prefetcher over a list of pairs.
pub(super) struct Prefetcher<'a> {
    shapes: &'a [ConvexShape<'a>],
    pairs: &'a [Pair],
    /// Next pair to prefetch.
    next: usize,
}

impl<'a> Prefetcher<'a> {
    pub(super) fn new(shapes: &'a [ConvexShape<'a>], pairs: &'a [Pair]) -> Self {
        let mut prefetcher = Self { shapes, pairs, next: 0 };
        (0..3 * STEP).for_each(|_| prefetcher.prefetch_next());
        prefetcher
    }

    /// Prefetches one more pair in three stages: hulls, their arrays, and edges.
    #[inline]
    pub(super) fn prefetch_next(&mut self) {
        let Self { shapes, pairs, next } = *self;
        let hulls = |back: usize| -> [Option<&Hull>; 2] {
            let pair = next.checked_sub(back).and_then(|at| pairs.get(at));
            let hull = |i: usize| {
                if let ConvexShape::Hull(hull) = shapes[i] { Some(hull) } else { None }
            };
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
