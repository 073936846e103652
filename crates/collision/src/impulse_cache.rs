//! Impulse cache for warm starting, across frames.

use crate::manifold::{FeatureId, Manifold};
use frangible_bodies::{Bodies, BodyId, Pair, PerBody};
use frangible_math::check::{Check, Checked, finite_singles, require};
use frangible_math::threads;
use glam::Vec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Pairs per lookup task: about ten microseconds of work.
const SHARE: usize = 1024;

/// Contact impulses of the last substep of a frame.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ImpulseCache {
    /// One list per chunk.
    points: Vec<Vec<CachedImpulse>>,
    /// Pairs with impulses, in the order of [`Pair`].
    pairs: Vec<CachedPair>,
    /// Dense index of each body in the cached frame.
    places: PerBody<usize>,
}

/// Location of a pair's points.
#[derive(Clone, Debug, Serialize, Deserialize)]
struct CachedPair {
    /// Dense indices in the cached frame.
    pair: Pair,
    part: usize,
    points: Range<usize>,
}

/// Cached impulses of a group of pairs.
#[derive(Default)]
pub struct ImpulseChunk {
    /// Points of all pairs, concatenated.
    pub points: Vec<CachedImpulse>,
    /// Per pair: manifold index, bodies, and end in `points`.
    pairs: Vec<(usize, Pair, usize)>,
}

/// Cached impulse of a contact point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CachedImpulse {
    /// Feature of the point.
    pub feature: FeatureId,
    /// Impulses per second: the next frame may have another substep count.
    pub force: PointImpulse,
}

/// Impulse at a contact point.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointImpulse {
    /// Normal component, not negative [N s].
    pub normal: f32,
    /// Total, world frame [N s]: keeps its direction even if a recomputed normal rotates.
    pub force: Vec3,
    /// Moment of rolling and spinning friction, world frame [N m s].
    pub twist: Vec3,
    /// Mean of the whole frame including impacts, per second: world frame [N].
    pub mean: Vec3,
}

impl Check for ImpulseCache {
    fn check(&self) -> Checked {
        let is_sorted = self.pairs.is_sorted_by_key(|kept| kept.pair);
        require(is_sorted, "pairs with impulses, in order")?;
        for CachedPair { part, points, .. } in &self.pairs {
            let in_part = self.points.get(*part).is_some_and(|part| points.end <= part.len());
            require(in_part && points.start <= points.end, "points of a pair that there are")?;
        }
        self.points.iter().flatten().try_for_each(|CachedImpulse { force, .. }| {
            require(force.normal.is_finite(), "finite impulses")?;
            [force.force, force.twist, force.mean].into_iter().try_for_each(finite_singles)
        })
    }
}

impl ImpulseCache {
    /// Cached points of a pair.
    #[inline]
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[CachedImpulse] {
        let Some(pair) = self.pair_then(bodies, pair) else { return &[] };
        let found = self.pairs.binary_search_by_key(&pair, |kept| kept.pair);
        found.map_or(&[], |at| self.points_of(&self.pairs[at]))
    }

    /// A pair in dense indices of the cached frame, if both bodies existed.
    fn pair_then(&self, bodies: &Bodies, pair: Pair) -> Option<Pair> {
        let [first, second] = pair.ids(bodies).map(|id| self.places.get(id));
        Some(Pair { first: first?, second: second? })
    }

    fn points_of(&self, pair: &CachedPair) -> &[CachedImpulse] {
        &self.points[pair.part][pair.points.clone()]
    }

    /// Cached points of all manifolds; most pairs come in the cached order.
    pub fn of_manifolds(&self, bodies: &Bodies, manifolds: &[Manifold]) -> Vec<&[CachedImpulse]> {
        let of_share = |manifolds: &[Manifold]| {
            let mut next = 0;
            let of = |manifold: &Manifold| {
                let Some(wanted) = self.pair_then(bodies, manifold.pair) else { return &[][..] };
                if self.pairs.get(next).is_none_or(|kept| kept.pair != wanted) {
                    next = self.pairs.partition_point(|kept| kept.pair < wanted);
                }
                match self.pairs.get(next) {
                    Some(kept) if kept.pair == wanted => {
                        next += 1;
                        self.points_of(kept)
                    }
                    _ => &[],
                }
            };
            manifolds.iter().map(of).collect::<Vec<&[CachedImpulse]>>()
        };
        threads::map(manifolds.chunks(SHARE).collect(), manifolds.len(), of_share).concat()
    }

    /// Cached impulse of a point.
    #[inline]
    pub fn get(&self, bodies: &Bodies, pair: Pair, feature: FeatureId) -> Option<&CachedImpulse> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.feature == feature)
    }

    /// Drops the cached impulses of contacts with the bodies `ids`.
    pub fn forget(&mut self, ids: &[BodyId]) {
        let mut places: Vec<usize> = ids.iter().filter_map(|&id| self.places.get(id)).collect();
        places.sort_unstable();
        let is_forgotten = |place: usize| places.binary_search(&place).is_ok();
        self.pairs.retain(|kept| !is_forgotten(kept.pair.first) && !is_forgotten(kept.pair.second));
    }

    /// Builds the cache from chunks that hold disjoint sets of `pairs` manifolds.
    pub fn of_parts(bodies: &Bodies, pairs: usize, parts: Vec<ImpulseChunk>) -> Self {
        let none = CachedPair { pair: Pair { first: 0, second: 0 }, part: 0, points: 0..0 };
        let mut all = Self {
            points: Vec::with_capacity(parts.len()),
            pairs: vec![none; pairs],
            places: PerBody::default(),
        };
        for (place, &id) in bodies.ids.iter().enumerate() {
            all.places.insert(id, place);
        }
        for ImpulseChunk { points, pairs } in parts {
            let (part, mut begin) = (all.points.len(), 0);
            for (place, pair, end) in pairs {
                all.pairs[place] = CachedPair { pair, part, points: begin..end };
                begin = end;
            }
            all.points.push(points);
        }
        all.pairs.retain(|kept| !kept.points.is_empty());
        if !all.pairs.is_sorted_by_key(|kept| kept.pair) {
            all.pairs.sort_unstable_by_key(|kept| kept.pair);
        }
        all
    }
}

impl ImpulseChunk {
    /// Reserves capacity.
    pub fn with_room(pairs: usize, points: usize) -> Self {
        Self { points: Vec::with_capacity(points), pairs: Vec::with_capacity(pairs) }
    }

    /// Copies the pair's cached impulses unchanged; `place` is its manifold index.
    #[inline]
    pub fn keep(&mut self, place: usize, pair: Pair, carried: &[CachedImpulse]) {
        self.points.extend_from_slice(carried);
        self.end_pair(place, pair);
    }

    /// Assigns the points since the last call to a pair; `place` is its manifold index.
    #[inline]
    pub fn end_pair(&mut self, place: usize, pair: Pair) {
        self.pairs.push((place, pair, self.points.len()));
    }
}
