//! Contact cache: manifolds of polyhedron pairs, and of polyhedra on the ground, persist across
//! frames while relative motion is small. Separated pairs are skipped until their accumulated
//! motion may have closed the separation.

pub(crate) mod kept;
pub(crate) mod lookup;
pub(crate) mod prefetch;

use crate::contact_cache::kept::Kept;
use crate::contact_cache::kept::KeptPair;
use crate::contact_cache::kept::KeptPoint;
use crate::contact_cache::lookup::{NOWHERE, Passing, firsts};
use crate::contact_cache::prefetch::{Ahead, Seen};
use crate::manifold::list::{Found, Manifolds};
use crate::narrow_phase::core::core_point;
use crate::narrow_phase::encounter::Encounter;
use crate::narrow_phase::finder::ManifoldFinder;
use crate::narrow_phase::hull_hull::approach::hull_points;
use crate::narrow_phase::hull_hull::hull_point::HullPoint;
use crate::narrow_phase::hull_plane::plane_points;
use crate::narrow_phase::solid::Solid;
use crate::relative_motion::{moved, moved_between, placed, second_from_first};
use crate::warm_start::WarmStart;
use frangible_bodies::{Bodies, BodyId, Flight, Frame, Pair, Pose};
use frangible_math::threads;

/// Maximum relative motion of a cached manifold, in units of the smaller body's radius: a body on
/// an edge overhangs it by as much before tipping.
const STEADY: f64 = 0.03;

/// Extra search distance relative to the reach, for the cache to survive a varying reach [1].
/// Without it falling heaps overlap by a tenth more.
const MARGIN: f64 = 0.2;

/// Manifolds of the last frame, in birth order of their bodies.
#[derive(Clone, Debug, Default)]
pub struct KeptPairs {
    /// One entry per body of the last frame.
    ways: Vec<Way>,
    /// One chunk per task.
    kept: Vec<Kept>,
    /// Chunks of the previous frame.
    last: Vec<Kept>,
    finders: Vec<ManifoldFinder>,
    found: Manifolds,
}

/// Pairs per task: a tenth of a millisecond of work.
const SHARE: usize = 1024;

/// Accumulated motion of a body.
#[derive(Clone, Copy, Debug)]
struct Way {
    id: BodyId,
    pose: Pose,
    /// Upper bound of the path length of any point since the first frame, over all frames [m].
    length: f64,
}

impl KeptPairs {
    /// Finds the manifolds of all pairs that may touch within the frame. `pairs` must be in
    /// increasing order. Points in `warm` had an impulse in the last frame.
    pub fn find_manifolds(
        &mut self,
        bodies: &Bodies,
        pairs: &[Pair],
        warm: &WarmStart,
        frame: &Frame,
    ) -> &mut Manifolds {
        let flights = threads::list(bodies.len(), |i| Flight::of(bodies, i, frame));
        let seen = threads::list(bodies.len(), |i| Seen::of(&bodies.shapes[i]));
        let places = self.go_on(bodies, &flights);
        let count = pairs.len().div_ceil(SHARE);
        std::mem::swap(&mut self.last, &mut self.kept);
        self.kept.resize_with(count, Kept::default);
        self.finders.resize_with(count, ManifoldFinder::default);
        self.found.parts.resize_with(count, Found::default);

        // Each task takes a run of consecutive pairs.
        let Self { ways, kept, last, finders, found } = self;
        let firsts = firsts(last, &places);
        let passing = Passing::new(last, &places, &firsts);
        let rooms = kept.iter_mut().zip(finders).zip(&mut found.parts);
        let mut shares: Vec<(Share, &[Pair])> = rooms
            .zip(pairs.chunks(SHARE))
            .map(|(((kept, finder), found), pairs)| {
                (Share { ways, seen: &seen, kept, finder, found }, pairs)
            })
            .collect();
        let find = |(share, pairs): &mut (Share, &[Pair])| {
            share.find_manifolds(pairs, passing, (bodies, &flights), warm, frame);
        };
        threads::for_each(&mut shares, pairs.len(), find);
        &mut self.found
    }

    /// Adds this frame's motion of all bodies. Returns the new index of each body of the last
    /// frame.
    fn go_on(&mut self, bodies: &Bodies, flights: &[Flight]) -> Vec<u32> {
        let at_rest = |i: usize| Way { id: bodies.ids[i], pose: bodies.poses[i], length: 0.0 };
        let mut ways: Vec<Way> = (0..bodies.len()).map(at_rest).collect();
        let place = |last: &Way| {
            let Some(i) = bodies.index_of(last.id) else { return NOWHERE };
            ways[i].length = last.length + moved(&last.pose, &bodies.poses[i], flights[i].radius);
            i as u32
        };
        let places = self.ways.iter().map(place).collect();
        self.ways = ways;
        places
    }
}

/// Cached manifold of a pair, and its reference path length if still valid.
struct Look<'a> {
    pair: Pair,
    known: Option<(&'a KeptPair, &'a [KeptPoint])>,
    since: Option<f64>,
}

/// A run of consecutive pairs, with output buffers.
struct Share<'a> {
    ways: &'a [Way],
    seen: &'a [Seen<'a>],
    kept: &'a mut Kept,
    finder: &'a mut ManifoldFinder,
    found: &'a mut Found,
}

impl Share<'_> {
    fn find_manifolds(
        &mut self,
        pairs: &[Pair],
        mut passing: Passing,
        (bodies, flights): (&Bodies, &[Flight]),
        warm: &WarmStart,
        frame: &Frame,
    ) {
        self.kept.pairs.clear();
        self.kept.points.clear();
        self.found.clear();
        passing.go_to(pairs[0]);

        // Split pairs into cached and recomputed manifolds.
        let (mut looks, mut anew) = (Vec::with_capacity(pairs.len()), Vec::new());
        let encounter = |pair: Pair| {
            Encounter::new(bodies, pair, [&flights[pair.first], &flights[pair.second]], frame)
        };
        for &pair in pairs {
            let encounter = encounter(pair);
            if encounter.is_out_of_reach() {
                continue;
            }
            let known = passing.find(pair);
            let since = known.and_then(|(kept, points)| self.still_holds(kept, points, &encounter));
            if since.is_none() {
                anew.push(pair);
            }
            looks.push(Look { pair, known, since });
        }

        let mut ahead = Ahead::new(self.seen, &anew);
        for Look { pair, known, since } in looks {
            if let Some((kept, points)) = known
                && let Some(since) = since
            {
                if !points.is_empty() {
                    let encounter = encounter(pair);
                    self.kept.points.extend_from_slice(points);
                    let within_reach =
                        points.iter().filter_map(|point| point.within_reach(&encounter));
                    self.found.add(pair, within_reach);
                }
                self.keep(KeptPair { since, ..*kept }, pair);
                continue;
            }
            ahead.go_on();
            let encounter = encounter(pair);
            if let Some(solids) = Seen::lasting([&self.seen[pair.first], &self.seen[pair.second]]) {
                self.find_anew(encounter, solids);
                continue;
            }
            let has_carried = |sample| warm.get(bodies, pair, sample).is_some();
            if let Some(manifold) = self.finder.of_encounter(&encounter, has_carried) {
                self.found.add(pair, manifold.points.iter().copied());
            }
        }
    }

    /// Sum of both path lengths [m].
    fn ways_of(&self, pair: Pair) -> f64 {
        self.ways[pair.first].length + self.ways[pair.second].length
    }

    /// If the cached points are still valid and no other feature is within reach: the reference
    /// path length.
    #[inline]
    fn still_holds(
        &self,
        kept: &KeptPair,
        points: &[KeptPoint],
        encounter: &Encounter,
    ) -> Option<f64> {
        let steady = STEADY * encounter.size;
        let steady = if points.is_empty() { f64::INFINITY } else { steady };
        let most = steady.min(kept.beyond - encounter.reach);
        let ways = self.ways_of(encounter.pair);
        if ways - kept.since <= most {
            return Some(kept.since);
        }
        if most < 0.0 {
            return None;
        }
        // Test the relative motion: bodies moving together have long paths but little relative
        // motion.
        let Encounter { bodies, pair, flights, .. } = *encounter;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let now = second_from_first(first, second);
        let radii = [flights[0].radius, flights[1].radius];
        let moved = moved_between(&kept.found_at, &now, radii, 0.0);
        (moved <= most).then_some(ways - moved)
    }

    /// Stores a pair with the last points of the chunk.
    fn keep(&mut self, kept: KeptPair, pair: Pair) {
        let bodies = [pair.first as u32, pair.second as u32];
        self.kept.pairs.push(KeptPair { bodies, end: self.kept.points.len() as u32, ..kept });
    }

    /// Runs the narrow phase for a pair, and caches the result.
    fn find_anew(&mut self, mut encounter: Encounter, solids: [Solid; 2]) {
        let Encounter { bodies, pair, reach, size, .. } = encounter;
        encounter.search = (1.0 + MARGIN) * reach + STEADY * size;
        let ManifoldFinder { room, points } = &mut *self.finder;
        points.clear();
        let beyond = match solids {
            [Solid::Hull(first), Solid::Hull(second)] => {
                hull_points(&encounter, [first, second], room, points)
            }
            [Solid::Ground(ground), Solid::Hull(hull)] => {
                plane_points(&encounter, hull, false, ground, room, points)
            }
            _ => None,
        };
        core_point(&encounter, solids, points);
        let begin = self.kept.points.len();
        let normal_of = |seen: &HullPoint| match solids[0] {
            Solid::Ground(ground) => -ground.normal,
            _ => seen.normal,
        };
        self.kept.points.extend(room.points.iter().zip(points.iter()).map(|(seen, point)| {
            KeptPoint {
                anchors: [point.anchor_first, point.anchor_second],
                normal: normal_of(seen),
                sample: point.sample,
            }
        }));

        // Without a bound the points belong to a later instant, and the next frame needs others.
        let beyond = if let Some(beyond) = beyond {
            let kept = &self.kept.points[begin..];
            let within_reach = kept.iter().filter_map(|point| point.within_reach(&encounter));
            self.found.add(pair, within_reach);
            beyond
        } else {
            self.found.add(pair, points.iter().copied());
            f64::NEG_INFINITY
        };
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let (found_at, since) = (second_from_first(first, second), self.ways_of(pair));
        self.keep(KeptPair { bodies: [0; 2], end: 0, found_at, beyond, since }, pair);
    }
}
