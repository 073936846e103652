//! Prefetching of shapes for recomputed pairs: a heap's shapes exceed the near caches.

use crate::narrow_phase::convex_shape::{ConvexShape, MOST_EDGE_PAIRS};
use frangible_bodies::Pair;
use frangible_geometry::{Columns, Hull, Shape};
use frangible_math::prefetch;
use std::slice::from_ref;

/// Collision shape of a body.
pub(super) struct CollisionShape<'a> {
    convex_shape: ConvexShape<'a>,
    /// Number of edges; 0 except for polyhedra.
    edges: usize,
}

impl<'a> CollisionShape<'a> {
    pub(super) fn of(shape: &'a Shape) -> Self {
        let convex_shape = ConvexShape::of(shape);
        let edges = if let ConvexShape::Hull(hull) = convex_shape { hull.edges().len() } else { 0 };
        Self { convex_shape, edges }
    }

    /// Shapes of a cacheable pair: two polyhedra, or a polyhedron on the ground.
    pub(super) fn cacheable([first, second]: [&Self; 2]) -> Option<[ConvexShape<'a>; 2]> {
        let is_cacheable = match (first.convex_shape, second.convex_shape) {
            (ConvexShape::Hull(_), ConvexShape::Hull(_)) => {
                first.edges * second.edges <= MOST_EDGE_PAIRS
            }
            (ConvexShape::Ground(_), ConvexShape::Hull(_)) => true,
            _ => false,
        };
        is_cacheable.then_some([first.convex_shape, second.convex_shape])
    }
}

/// Pairs between two stages of prefetching: processing them takes about as long as a memory access.
const STEP: usize = 2;

/// Prefetcher over a list of pairs.
pub(super) struct Prefetcher<'a> {
    shapes: &'a [CollisionShape<'a>],
    pairs: &'a [Pair],
    /// Next pair to prefetch.
    next: usize,
}

impl<'a> Prefetcher<'a> {
    pub(super) fn new(shapes: &'a [CollisionShape<'a>], pairs: &'a [Pair]) -> Self {
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
                if let ConvexShape::Hull(hull) = shapes[i].convex_shape { Some(hull) } else { None }
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
