//! Pairs of polyhedra, and polyhedra on the ground, over the frames: what has hardly moved against each other since its points were found
//! keeps them, and what was further apart than it can have come since is still apart.

mod ahead;
mod passing;

use crate::clusters::has_settled;
use crate::detection::{moved, moved_between, second_from_first};
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::hull_contact::{HullPoint, hull_points};
use crate::manifold::{Found, ManifoldFinder, ManifoldPoint, Manifolds, Solid};
use crate::moving::fastest;
use crate::pair::{Pair, placed};
use crate::plane_contact::plane_points;
use crate::threads;
use crate::warm_start::WarmStart;
use crate::{Bodies, BodyId, Frame, Motion, Pose};
use ahead::{Ahead, Seen};
use frangible_geometry::RigidTransform;
use glam::DVec3;
use passing::{NOWHERE, Passing, firsts};

/// For how long a pair keeps its points, relative to the size of the smaller body.
#[derive(Clone, Copy)]
struct Lasting {
    /// Relative motion up to which it does.
    steady: f64,
    /// Overlap with which it is looked at anew in the next frame: what jams goes on to part only along an axis that is the best one now.
    deep: f64,
}

/// What lies on an edge sticks out over it by as much before it tips.
const USUALLY: Lasting = Lasting { steady: 5e-3, deep: 1e-2 };

/// Heaps rock where their points are found anew, and have them found anew where they rock. With a fifth instead of a tenth deep overlaps grow by a third.
const IN_HEAPS: Lasting = Lasting { steady: 0.1, deep: 0.1 };

/// What creeps there is left alone: most of its motion is what points give that are found anew because of it. A calm heap moves at a fifth of the speed then; before jams stayed on a face its deepest overlaps (99th percentile) were 6.5 instead of 4.9 mm.
const CREEPING: Lasting = Lasting { steady: 0.5, deep: 0.2 };

/// Speed of the fastest point up to which a body creeps, in units of what gravity gives in a frame [1]. At 30 Hz that is 0.1 m/s. With a tenth instead, and points kept for 0.3 of a size, half as much is gained.
const CREEPS: f64 = 0.3;

/// See [`CREEPS`] [m/s].
pub(crate) fn creeping_below(frame: &Frame) -> f64 {
    CREEPS * frame.gravity.length() * frame.dt
}

/// How much further than the reach points are looked for, relative to it, so that they can be kept while it varies.
const MARGIN: f64 = 0.2;

/// The pairs of the last frame, in the order of their bodies' births.
#[derive(Clone, Debug, Default)]
pub struct KeptPairs {
    /// Of all bodies of the last frame.
    ways: Vec<Way>,
    /// One after the other.
    kept: Vec<Kept>,
    /// Room.
    last: Vec<Kept>,
    finders: Vec<ManifoldFinder>,
    found: Manifolds,
}

/// Of how near two bodies may be that meet although they rest, so much counts where both have settled or are in a heap [1]: what lies there does not fall unless something else moves it,
/// and what does may get as much deeper into the other one until the next frame, 4 mm at 30 Hz. Without it a third of a heap's pairs do not touch, and it rocks more.
pub(crate) const CLOSE: f64 = 0.25;

/// Pairs that go to a thread together: a tenth of a millisecond of work.
const SHARE: usize = 1024;

/// How far a body has come.
#[derive(Clone, Copy, Debug)]
struct Way {
    id: BodyId,
    pose: Pose,
    /// No point of it has moved further since it was first seen, all frames together [m].
    length: f64,
    /// Whether it was part of a heap in the last frame, or does not take part in what a heap does.
    is_in_heap: bool,
    /// See [`has_settled`].
    has_settled: bool,
    /// Whether it is slower than [`CREEPS`].
    creeps: bool,
}

#[derive(Clone, Debug, Default)]
struct Kept {
    pairs: Vec<KeptPair>,
    /// Of all pairs, one after the other.
    points: Vec<KeptPoint>,
}

#[derive(Clone, Copy, Debug)]
struct KeptPair {
    /// Their places among the ways of the frame.
    bodies: [u32; 2],
    /// Its last point, among those of all pairs.
    end: u32,
    /// `second_from_first` when it was looked at.
    found_at: RigidTransform,
    /// Nothing but its points was nearer then [m]; minus infinity if they do not last.
    beyond: f64,
    /// The two have moved against each other by no more than their ways are longer than this [m].
    since: f64,
}

/// A point of contact, in the frames of its bodies.
#[derive(Clone, Copy, Debug)]
struct KeptPoint {
    /// On the first and on the second body, each in its own frame [m].
    anchors: [DVec3; 2],
    /// Unit, from the second to the first, in the first one's frame.
    normal: DVec3,
    sample: (bool, u64),
}

impl KeptPairs {
    /// The manifolds of all pairs that may touch within the frame, in the order of the pairs, which is increasing. Points that are in
    /// `warm` carried in the last frame.
    pub fn find_manifolds(
        &mut self,
        bodies: &Bodies,
        pairs: &[Pair],
        warm: &WarmStart,
        frame: &Frame,
    ) -> &mut Manifolds {
        let flights = threads::list(bodies.len(), |i| Flight::of(bodies, i, frame));
        let seen = threads::list(bodies.len(), |i| Seen::of(&bodies.shapes[i]));
        let places = self.go_on(bodies, &flights, (warm, frame));
        let count = pairs.len().div_ceil(SHARE);
        std::mem::swap(&mut self.last, &mut self.kept);
        self.kept.resize_with(count, Kept::default);
        self.finders.resize_with(count, ManifoldFinder::default);
        self.found.parts.resize_with(count, Found::default);

        // Each thread takes some pairs that follow each other.
        let Self { ways, kept, last, finders, found } = self;
        let firsts = firsts(last, &places);
        let passing = Passing::new(last, &places, &firsts);
        let rooms = kept.iter_mut().zip(finders).zip(&mut found.parts);
        let mut shares: Vec<(Share, &[Pair])> = rooms
            .zip(pairs.chunks(SHARE))
            .map(|(((kept, finder), found), pairs)| (Share { ways, seen: &seen, kept, finder, found }, pairs))
            .collect();
        let find = |(share, pairs): &mut (Share, &[Pair])| {
            share.find_manifolds(pairs, passing, (bodies, &flights), warm, frame);
        };
        threads::for_each(&mut shares, pairs.len(), find);
        &mut self.found
    }

    /// Follows all bodies to where they are now. Returns where those of the last frame are among them.
    fn go_on(
        &mut self,
        bodies: &Bodies,
        flights: &[Flight],
        (warm, frame): (&WarmStart, &Frame),
    ) -> Vec<u32> {
        let creeps = creeping_below(frame);
        let at_rest = |i: usize| {
            let id = bodies.ids[i];
            let is_in_heap = bodies.motions[i] != Motion::Dynamic || warm.is_in_heap(id);
            Way {
                id,
                pose: bodies.poses[i],
                length: 0.0,
                is_in_heap,
                has_settled: has_settled(bodies, i, warm),
                creeps: !matches!(bodies.motions[i], Motion::Kinematic { .. }) && fastest(bodies, i) < creeps,
            }
        };
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

/// What is known of a pair from the last frame, and from when on its ways count if that still holds.
struct Look<'a> {
    pair: Pair,
    known: Option<(&'a KeptPair, &'a [KeptPoint])>,
    since: Option<f64>,
}

/// Some pairs that follow each other, and room for what is found.
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

        // What holds, and what is to be looked at anew.
        let (mut looks, mut anew) = (Vec::with_capacity(pairs.len()), Vec::new());
        let encounter =
            |pair: Pair| Encounter::new(bodies, pair, [&flights[pair.first], &flights[pair.second]], frame);
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
                    let within_reach = points.iter().filter_map(|point| point.within_reach(&encounter));
                    self.found.add_near(pair, within_reach, self.near(&encounter));
                }
                self.keep(KeptPair { since, ..*kept }, pair);
                continue;
            }
            ahead.go_on();
            let encounter = encounter(pair);
            if let Some(solids) = Seen::lasting([&self.seen[pair.first], &self.seen[pair.second]]) {
                let last_normal = known.and_then(|(_, points)| Some(points.first()?.normal));
                self.find_anew(Encounter { last_normal, ..encounter }, solids);
                continue;
            }
            let has_carried = |sample| warm.get(bodies, pair, sample).is_some();
            if let Some(manifold) = self.finder.of_encounter(&encounter, has_carried) {
                self.found.add(pair, manifold.points.iter().copied());
            }
        }
    }

    /// How far the ways of a pair are together [m].
    fn ways_of(&self, pair: Pair) -> f64 {
        self.ways[pair.first].length + self.ways[pair.second].length
    }

    /// How near at least one point of a pair must be for the two to meet [m].
    fn near(&self, encounter: &Encounter) -> f64 {
        let [first, second] = [encounter.pair.first, encounter.pair.second].map(|i| &self.ways[i]);
        let have_settled = first.has_settled && second.has_settled;
        let lie = have_settled || (first.is_in_heap && second.is_in_heap);
        if lie { encounter.reach - (1.0 - CLOSE) * encounter.near } else { f64::INFINITY }
    }

    /// For how long a pair keeps its points.
    fn lasting(&self, pair: Pair) -> Lasting {
        let [first, second] = [pair.first, pair.second].map(|i| &self.ways[i]);
        match (first.is_in_heap && second.is_in_heap, first.creeps && second.creeps) {
            (true, true) => CREEPING,
            (true, false) => IN_HEAPS,
            (false, _) => USUALLY,
        }
    }

    /// If the points of a pair are still its points, and nothing else has come within reach: from when on its ways count.
    #[inline]
    fn still_holds(&self, kept: &KeptPair, points: &[KeptPoint], encounter: &Encounter) -> Option<f64> {
        let steady = self.lasting(encounter.pair).steady * encounter.size;
        let steady = if points.is_empty() { f64::INFINITY } else { steady };
        let most = steady.min(kept.beyond - encounter.reach);
        let ways = self.ways_of(encounter.pair);
        if ways - kept.since <= most {
            return Some(kept.since);
        }
        if most < 0.0 {
            return None;
        }
        // What moves together hardly moves against each other.
        let Encounter { bodies, pair, flights, .. } = *encounter;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let now = second_from_first(first, second);
        let radii = [flights[0].radius, flights[1].radius];
        let moved = moved_between(&kept.found_at, &now, radii, 0.0);
        (moved <= most).then_some(ways - moved)
    }

    /// Keeps a pair, whose points are the last ones.
    fn keep(&mut self, kept: KeptPair, pair: Pair) {
        let bodies = [pair.first as u32, pair.second as u32];
        self.kept.pairs.push(KeptPair { bodies, end: self.kept.points.len() as u32, ..kept });
    }

    /// Looks where a pair touches, and keeps it for the next frame.
    fn find_anew(&mut self, mut encounter: Encounter, solids: [Solid; 2]) {
        let Encounter { bodies, pair, reach, size, .. } = encounter;
        let (lasting, near) = (self.lasting(pair), self.near(&encounter));
        encounter.search = (1.0 + MARGIN) * reach + lasting.steady * size;
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
        let begin = self.kept.points.len();
        let normal_of = |seen: &HullPoint| match solids[0] {
            Solid::Ground(ground) => -ground.normal,
            _ => seen.normal,
        };
        self.kept.points.extend(room.points.iter().zip(points.iter()).map(|(seen, point)| KeptPoint {
            anchors: [point.anchor_first, point.anchor_second],
            normal: normal_of(seen),
            sample: point.sample,
        }));

        // What will meet later will do so elsewhere; what jams is looked at again.
        let is_deep = room.points.iter().any(|point| point.gap < -lasting.deep * size);
        let beyond = if let Some(beyond) = beyond.filter(|_| !is_deep) {
            let kept = &self.kept.points[begin..];
            let within_reach = kept.iter().filter_map(|point| point.within_reach(&encounter));
            self.found.add_near(pair, within_reach, near);
            beyond
        } else {
            self.found.add_near(pair, points.iter().copied(), near);
            f64::NEG_INFINITY
        };
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let (found_at, since) = (second_from_first(first, second), self.ways_of(pair));
        self.keep(KeptPair { bodies: [0; 2], end: 0, found_at, beyond, since }, pair);
    }
}

impl KeptPoint {
    /// The point where its bodies are now; `None` if it is too far to touch within the frame.
    #[inline]
    fn within_reach(&self, encounter: &Encounter) -> Option<ManifoldPoint> {
        let [first, second] = encounter.flights;
        let normal = first.start.orientation * self.normal;
        let on_first = first.start.world_from_body().point(self.anchors[0]);
        let on_second = second.start.world_from_body().point(self.anchors[1]);
        let gap = (on_first - on_second).dot(normal);
        if gap > encounter.reach {
            return None;
        }
        let approach = if encounter.may_strike() {
            let velocity = first.velocity(on_first, 0.0) - second.velocity(on_second, 0.0);
            encounter.surface_speed(normal, -velocity.dot(normal), gap)
        } else {
            0.0
        };
        Some(ManifoldPoint {
            anchor_first: self.anchors[0],
            anchor_second: self.anchors[1],
            rounding: [0.0; 2],
            normal,
            sample: self.sample,
            approach,
            gap,
        })
    }
}

#[cfg(test)]
mod tests;
