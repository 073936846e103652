//! Pairs of polyhedra over the frames: what has hardly moved against each other since its points were found keeps them, and what was
//! further apart than it can have come since is still apart.

use crate::detection::{moved_between, second_from_first};
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::hull_contact::hull_points;
use crate::manifold::{Manifold, ManifoldFinder, ManifoldPoint, hulls_of};
use crate::pair::{Pair, placed};
use crate::warm_start::WarmStart;
use crate::{Bodies, BodyId, Frame};
use frangible_geometry::RigidTransform;
use glam::DVec3;

/// Relative motion up to which a pair keeps its points, relative to the size of the smaller body.
const STEADY: f64 = 5e-3;

/// How much further than the reach points are looked for, relative to it, so that they can be kept while it varies.
const MARGIN: f64 = 0.2;

/// Overlap, relative to the size of the smaller body, from which on a pair is looked at anew in each frame: what jams goes on to part
/// only along an axis that is the best one now.
const DEEP: f64 = 1e-2;

/// The pairs of the last frame, in the order of their bodies' births.
#[derive(Clone, Debug, Default)]
pub struct KeptPairs {
    pairs: Vec<KeptPair>,
    /// Of all pairs, one after the other.
    points: Vec<KeptPoint>,
    finder: ManifoldFinder,
}

#[derive(Clone, Copy, Debug)]
struct KeptPair {
    ids: [BodyId; 2],
    /// `second_from_first` when it was looked at.
    found_at: RigidTransform,
    /// Nothing but its points was nearer then [m].
    beyond: f64,
    /// Its last point, among those of all pairs.
    end: usize,
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
    ) -> Vec<Manifold> {
        let flights: Vec<Flight> = (0..bodies.len()).map(|i| Flight::of(bodies, i, frame)).collect();
        let (last_pairs, last_points) = (std::mem::take(&mut self.pairs), std::mem::take(&mut self.points));
        let mut last = Last { pairs: &last_pairs, points: &last_points, at: 0 };
        let mut manifolds = Vec::new();
        for &pair in pairs {
            let flights = [flights[pair.first], flights[pair.second]];
            let encounter = Encounter::new(bodies, pair, flights, frame);
            manifolds.extend(if hulls_of(bodies, pair).is_none() {
                self.finder.of_encounter(&encounter, warm)
            } else if encounter.is_out_of_reach() {
                None
            } else {
                self.of_hulls(&mut last, encounter)
            });
        }
        manifolds
    }

    /// The manifold of two polyhedra as it was, or anew.
    fn of_hulls(&mut self, last: &mut Last, mut encounter: Encounter) -> Option<Manifold> {
        let Encounter { bodies, pair, .. } = encounter;
        let (first, second) = placed(bodies, pair, &bodies.poses);
        let (now, begin) = (second_from_first(first, second), self.points.len());
        if let Some((kept, points)) = last.find(bodies, pair)
            && kept.holds(points, &encounter, &now)
        {
            self.points.extend_from_slice(points);
            self.pairs.push(KeptPair { end: self.points.len(), ..*kept });
        } else {
            encounter.search = (1.0 + MARGIN) * encounter.reach + STEADY * encounter.size;
            let ManifoldFinder { room, points } = &mut self.finder;
            points.clear();
            let beyond = hull_points(&encounter, hulls_of(bodies, pair)?, room, points);
            let is_deep = room.points.iter().any(|point| point.gap < -DEEP * encounter.size);
            let Some(beyond) = beyond.filter(|_| !is_deep) else {
                // What will meet later will do so elsewhere; what jams is looked at again.
                return (!points.is_empty()).then(|| Manifold { pair, points: points.clone() });
            };
            let kept = room.points.iter().zip(points.iter()).map(|(seen, point)| KeptPoint {
                anchors: [point.anchor_first, point.anchor_second],
                normal: seen.normal,
                sample: point.sample,
            });
            self.points.extend(kept);
            let ids = [bodies.ids[pair.first], bodies.ids[pair.second]];
            self.pairs.push(KeptPair { ids, found_at: now, beyond, end: self.points.len() });
        }
        let points: Vec<ManifoldPoint> =
            self.points[begin..].iter().filter_map(|point| point.within_reach(&encounter)).collect();
        (!points.is_empty()).then_some(Manifold { pair, points })
    }
}

/// The pairs of the last frame, while those of this one go by in the same order.
struct Last<'a> {
    pairs: &'a [KeptPair],
    points: &'a [KeptPoint],
    at: usize,
}

impl<'a> Last<'a> {
    /// A pair and its points, if it was kept; those before it are passed over.
    fn find(&mut self, bodies: &Bodies, pair: Pair) -> Option<(&'a KeptPair, &'a [KeptPoint])> {
        loop {
            let kept = self.pairs.get(self.at)?;
            let [first, second] = [bodies.index_of(kept.ids[0]), bodies.index_of(kept.ids[1])];
            if let (Some(first), Some(second)) = (first, second) {
                let kept_pair = Pair { first, second };
                if kept_pair > pair {
                    return None;
                }
                if kept_pair == pair {
                    let begin = if self.at == 0 { 0 } else { self.pairs[self.at - 1].end };
                    return Some((kept, &self.points[begin..kept.end]));
                }
            }
            self.at += 1;
        }
    }
}

impl KeptPair {
    /// Whether its points are still those of the pair, and nothing else has come within reach.
    fn holds(&self, points: &[KeptPoint], encounter: &Encounter, now: &RigidTransform) -> bool {
        let radii = [encounter.flights[0].radius, encounter.flights[1].radius];
        let moved = moved_between(&self.found_at, now, radii, 0.0);
        let is_steady = points.is_empty() || moved <= STEADY * encounter.size;
        is_steady && encounter.reach + moved <= self.beyond
    }
}

impl KeptPoint {
    /// The point where its bodies are now; `None` if it is too far to touch within the frame.
    fn within_reach(&self, encounter: &Encounter) -> Option<ManifoldPoint> {
        let [first, second] = &encounter.flights;
        let normal = first.start.orientation * self.normal;
        let on_first = first.start.world_from_body().point(self.anchors[0]);
        let on_second = second.start.world_from_body().point(self.anchors[1]);
        let gap = (on_first - on_second).dot(normal);
        if gap > encounter.reach {
            return None;
        }
        let velocity = first.velocity(on_first, 0.0) - second.velocity(on_second, 0.0);
        Some(ManifoldPoint {
            anchor_first: self.anchors[0],
            anchor_second: self.anchors[1],
            rounding: [0.0; 2],
            normal,
            sample: self.sample,
            approach: encounter.surface_speed(normal, -velocity.dot(normal), gap),
        })
    }
}

#[cfg(test)]
mod tests;
