//! Contact cache: manifolds of polyhedron pairs, and of polyhedra on the ground, persist across
//! frames while relative motion is small. Separated pairs are skipped until their accumulated
//! motion may have closed the separation.

pub(crate) mod cached_manifold;
pub(crate) mod cursor;
pub(crate) mod prefetch;

use crate::contact_cache::cached_manifold::CacheChunk;
use crate::contact_cache::cached_manifold::CachedManifold;
use crate::contact_cache::cached_manifold::CachedPoint;
use crate::contact_cache::cursor::{CacheCursor, REMOVED, first_pairs};
use crate::contact_cache::prefetch::{Prefetcher, is_cacheable};
use crate::impulse_cache::ImpulseCache;
use crate::manifold::list::{Found, Manifolds};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::core::core_points;
use crate::narrow_phase::finder::ManifoldFinder;
use crate::narrow_phase::fixed_neighbours::FixedNeighbours;
use crate::narrow_phase::hull_hull::approach::hull_points;
use crate::narrow_phase::hull_hull::hull_point::HullPoint;
use crate::narrow_phase::hull_plane::plane_points;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seam_contacts::mend_seams;
use crate::relative_motion::{moved, moved_between, placed, second_from_first};
use frangible_bodies::{BallisticPath, Bodies, BodyId, Frame, Pair, Pose};
use frangible_math::check::{Check, Checked, require};
use frangible_math::threads;
use serde::{Deserialize, Serialize};

/// Maximum relative motion of a cached manifold, in units of the smaller body's radius: a body on
/// an edge overhangs it by as much before tipping.
const MAX_MOTION: f64 = 0.03;

/// Extra search distance relative to the reach, for the cache to survive a varying reach [1].
/// Without it falling heaps overlap by a tenth more.
const MARGIN: f64 = 0.2;

/// Manifolds of the last frame, in birth order of their bodies.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactCache {
    /// One entry per body of the last frame.
    paths: Vec<PathLength>,
    /// One chunk per task.
    chunks: Vec<CacheChunk>,
    /// Chunks of the previous frame.
    #[serde(skip)]
    last: Vec<CacheChunk>,
    #[serde(skip)]
    finders: Vec<ManifoldFinder>,
    #[serde(skip)]
    found: Manifolds,
}

/// Pairs per task: a tenth of a millisecond of work.
const SHARE: usize = 1024;

/// Accumulated motion of a body.
#[derive(Clone, Copy, Debug, Serialize, Deserialize)]
struct PathLength {
    id: BodyId,
    pose: Pose,
    /// Upper bound of the path length of any point since the first frame, over all frames [m].
    length: f64,
}

impl Check for ContactCache {
    fn check(&self) -> Checked {
        for PathLength { pose, length, .. } in &self.paths {
            pose.check()?;
            require(*length >= 0.0 && length.is_finite(), "paths with a length")?;
        }
        self.chunks.iter().try_for_each(|chunk| chunk.check(self.paths.len()))
    }
}

impl ContactCache {
    /// Finds the manifolds of all pairs that may touch within the frame. `pairs` must be in
    /// increasing order. Points in `warm` had an impulse in the last frame.
    pub fn find_manifolds(
        &mut self,
        bodies: &Bodies,
        pairs: &[Pair],
        warm: &ImpulseCache,
        frame: &Frame,
    ) -> &mut Manifolds {
        let flights = threads::list(bodies.len(), |i| BallisticPath::of(bodies, i, frame));
        let shapes = threads::list(bodies.len(), |i| ConvexShape::of(&bodies.shapes[i]));
        let indices = self.begin_frame(bodies, &flights);
        let count = pairs.len().div_ceil(SHARE);
        std::mem::swap(&mut self.last, &mut self.chunks);
        self.chunks.resize_with(count, CacheChunk::default);
        self.finders.resize_with(count, ManifoldFinder::default);
        self.found.parts.resize_with(count, Found::default);
        self.found.replaced.clear();
        self.found.neighbours = FixedNeighbours::of_world(bodies, pairs.iter().copied());

        // Each task takes a run of consecutive pairs.
        let Self { paths, chunks, last, finders, found } = self;
        let first_pairs = first_pairs(last, &indices);
        let cursor = CacheCursor::new(last, &indices, &first_pairs);
        let Manifolds { parts, neighbours, .. } = found;
        let buffers = chunks.iter_mut().zip(finders).zip(parts);
        let mut shares: Vec<(Share, &[Pair])> = buffers
            .zip(pairs.chunks(SHARE))
            .map(|(((chunk, finder), found), pairs)| {
                (Share { paths, shapes: &shapes, neighbours, chunk, finder, found }, pairs)
            })
            .collect();
        let find = |(share, pairs): &mut (Share, &[Pair])| {
            share.find_manifolds(pairs, cursor, (bodies, &flights), warm, frame);
        };
        threads::for_each(&mut shares, pairs.len(), find);
        &mut self.found
    }

    /// Adds this frame's motion of all bodies. Returns the new index of each body of the last
    /// frame.
    fn begin_frame(&mut self, bodies: &Bodies, flights: &[BallisticPath]) -> Vec<u32> {
        let at_rest =
            |i: usize| PathLength { id: bodies.ids[i], pose: bodies.poses[i], length: 0.0 };
        let mut paths: Vec<PathLength> = (0..bodies.len()).map(at_rest).collect();
        let index = |last: &PathLength| {
            let Some(i) = bodies.index_of(last.id) else { return REMOVED };
            paths[i].length = last.length + moved(&last.pose, &bodies.poses[i], flights[i].radius);
            i as u32
        };
        let indices = self.paths.iter().map(index).collect();
        self.paths = paths;
        indices
    }
}

/// Cached manifold of a pair, and its reference path length if still valid.
struct Look<'a> {
    pair: Pair,
    known: Option<(&'a CachedManifold, &'a [CachedPoint])>,
    path_at_capture: Option<f64>,
}

/// A run of consecutive pairs, with output buffers.
struct Share<'a> {
    paths: &'a [PathLength],
    shapes: &'a [ConvexShape<'a>],
    neighbours: &'a FixedNeighbours,
    chunk: &'a mut CacheChunk,
    finder: &'a mut ManifoldFinder,
    found: &'a mut Found,
}

impl Share<'_> {
    fn find_manifolds(
        &mut self,
        pairs: &[Pair],
        mut cursor: CacheCursor,
        (bodies, flights): (&Bodies, &[BallisticPath]),
        warm: &ImpulseCache,
        frame: &Frame,
    ) {
        self.chunk.pairs.clear();
        self.chunk.points.clear();
        self.found.clear();
        cursor.skip_to(pairs[0]);

        // Split pairs into cached and recomputed manifolds.
        let (mut looks, mut stale) = (Vec::with_capacity(pairs.len()), Vec::new());
        let pair_motion = |pair: Pair| {
            PairMotion::new(bodies, pair, [&flights[pair.first], &flights[pair.second]], frame)
        };
        let neighbours = self.neighbours;
        for &pair in pairs {
            let pair_motion = pair_motion(pair);
            if pair_motion.is_out_of_reach() {
                continue;
            }
            let known = cursor.find(pair);
            let path_at_capture =
                known.and_then(|(cached, points)| self.still_holds(cached, points, &pair_motion));
            if path_at_capture.is_none() {
                stale.push(pair);
            }
            looks.push(Look { pair, known, path_at_capture });
        }

        let mut prefetcher = Prefetcher::new(self.shapes, &stale);
        for Look { pair, known, path_at_capture } in looks {
            if let Some((cached, points)) = known
                && let Some(path_at_capture) = path_at_capture
            {
                if !points.is_empty() {
                    let pair_motion = pair_motion(pair);
                    self.chunk.points.extend_from_slice(points);
                    let within_reach =
                        points.iter().filter_map(|point| point.within_reach(&pair_motion));
                    self.found.add(pair, within_reach);
                }
                self.keep(CachedManifold { path_at_capture, ..*cached }, pair);
                continue;
            }
            prefetcher.prefetch_next();
            let pair_motion = pair_motion(pair);
            let convex_shapes = [self.shapes[pair.first], self.shapes[pair.second]];
            if is_cacheable(convex_shapes.each_ref()) {
                self.refresh(pair_motion.among(neighbours), convex_shapes);
                continue;
            }
            let pair_motion = pair_motion.among(neighbours);
            let has_carried = |feature| warm.get(bodies, pair, feature).is_some();
            if let Some(manifold) = self.finder.of_motion(&pair_motion, has_carried) {
                self.found.add(pair, manifold.points.iter().copied());
            }
        }
    }

    /// Sum of both path lengths [m].
    fn path_length_of(&self, pair: Pair) -> f64 {
        self.paths[pair.first].length + self.paths[pair.second].length
    }

    /// If the cached points are still valid and no other feature is within reach: the reference
    /// path length.
    #[inline]
    fn still_holds(
        &self,
        cached: &CachedManifold,
        points: &[CachedPoint],
        pair_motion: &PairMotion,
    ) -> Option<f64> {
        if cached.was_apart && !points.iter().all(|point| point.is_apart(pair_motion)) {
            return None;
        }
        let max_motion = MAX_MOTION * pair_motion.size;
        let max_motion = if points.is_empty() { f64::INFINITY } else { max_motion };
        let most = max_motion.min(cached.separation_bound - pair_motion.reach);
        let path_length = self.path_length_of(pair_motion.pair);
        if path_length - cached.path_at_capture <= most {
            return Some(cached.path_at_capture);
        }
        if most < 0.0 {
            return None;
        }
        // Test the relative motion: bodies moving together have long paths but little relative
        // motion.
        let PairMotion { bodies, pair, paths, .. } = *pair_motion;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let now = second_from_first(first, second);
        let radii = [paths[0].radius, paths[1].radius];
        let moved = moved_between(&cached.found_at, &now, radii, 0.0);
        (moved <= most).then_some(path_length - moved)
    }

    /// Stores a pair with the last points of the chunk.
    fn keep(&mut self, cached: CachedManifold, pair: Pair) {
        let bodies = [pair.first as u32, pair.second as u32];
        self.chunk.pairs.push(CachedManifold {
            bodies,
            end: self.chunk.points.len() as u32,
            ..cached
        });
    }

    /// Runs the narrow phase for a pair, and caches the result.
    fn refresh(&mut self, mut pair_motion: PairMotion, convex_shapes: [ConvexShape; 2]) {
        let PairMotion { bodies, pair, reach, size, .. } = pair_motion;
        pair_motion.search = (1.0 + MARGIN) * reach + MAX_MOTION * size;
        let ManifoldFinder { scratch, points } = &mut *self.finder;
        points.clear();
        let separation_bound = match convex_shapes {
            [ConvexShape::Hull(first), ConvexShape::Hull(second)] => {
                hull_points(&pair_motion, [first, second], scratch, points)
            }
            [ConvexShape::Ground(ground), ConvexShape::Hull(hull)] => {
                plane_points(&pair_motion, hull, false, ground, scratch, points)
            }
            _ => None,
        };
        // Points of a seam belong to this frame.
        let is_seam = mend_seams(&pair_motion, convex_shapes, scratch, points);
        let separation_bound = separation_bound.filter(|_| !is_seam);
        core_points(&pair_motion, convex_shapes, points);
        let begin = self.chunk.points.len();
        let normal_of = |hull_point: &HullPoint| match convex_shapes[0] {
            ConvexShape::Ground(ground) => -ground.normal,
            _ => hull_point.normal,
        };
        self.chunk.points.extend(scratch.points.iter().zip(points.iter()).map(
            |(hull_point, point)| CachedPoint {
                anchors: [point.anchor_first, point.anchor_second],
                normal: normal_of(hull_point),
                feature: point.feature,
            },
        ));

        let was_apart = self.chunk.points[begin..].iter().all(|point| point.is_apart(&pair_motion));

        // Without a bound the points belong to a later instant, and the next frame needs others.
        let separation_bound = if let Some(separation_bound) = separation_bound {
            let new = &self.chunk.points[begin..];
            let within_reach = new.iter().filter_map(|point| point.within_reach(&pair_motion));
            self.found.add(pair, within_reach);
            separation_bound
        } else {
            self.found.add(pair, points.iter().copied());
            f64::NEG_INFINITY
        };
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let (found_at, path_at_capture) =
            (second_from_first(first, second), self.path_length_of(pair));
        self.keep(
            CachedManifold {
                bodies: [0; 2],
                end: 0,
                found_at,
                separation_bound,
                was_apart,
                path_at_capture,
            },
            pair,
        );
    }
}
