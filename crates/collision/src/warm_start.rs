//! Impulses that contact points carry from one frame to the next, and which body had which
//! place then.

use crate::manifold::Manifold;
use frangible_bodies::{Bodies, BodyId, Pair, PerBody};
use frangible_math::threads;
use glam::Vec3;
use std::ops::Range;

/// Pairs that a thread looks up together: some ten microseconds of work.
const SHARE: usize = 1024;

/// What acted in the last substep of a frame at each contact point.
#[derive(Clone, Debug, Default)]
pub struct WarmStart {
    /// Of some pairs each.
    points: Vec<Vec<Carried>>,
    /// Those that carried, in the order of [`Pair`].
    pairs: Vec<CarriedPair>,
    /// The dense index then of each body that was there.
    places: PerBody<usize>,
}

/// Where the points of a pair are.
#[derive(Clone, Debug)]
struct CarriedPair {
    /// By dense indices of that frame.
    pair: Pair,
    part: usize,
    points: Range<usize>,
}

/// What some pairs carried.
#[derive(Default)]
pub struct Part {
    /// One after the other.
    pub points: Vec<Carried>,
    /// Place of each among all pairs, its bodies, and its end among the points.
    pairs: Vec<(usize, Pair, usize)>,
}

/// A contact point and what it carried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Whether it is a sample or feature of the pair's first body, and which.
    pub sample: (bool, u64),
    /// Impulses per second, since the next frame may have more or fewer substeps.
    pub force: PointImpulse,
}

/// What acts at one contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointImpulse {
    /// The part along the normal, not negative [N s].
    pub normal: f32,
    /// In all, world frame [N s]: where a normal turns, as its points are found anew, it goes on as
    /// it is.
    pub force: Vec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: Vec3,
    /// Of the whole frame, blows included, per second: world frame [N].
    pub mean: Vec3,
}

impl WarmStart {
    /// The points of a pair that carried.
    #[inline]
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[Carried] {
        let Some(pair) = self.pair_then(bodies, pair) else { return &[] };
        let found = self.pairs.binary_search_by_key(&pair, |kept| kept.pair);
        found.map_or(&[], |at| self.points_of(&self.pairs[at]))
    }

    /// A pair by the dense indices of the last frame, if both of its bodies were there.
    fn pair_then(&self, bodies: &Bodies, pair: Pair) -> Option<Pair> {
        let [first, second] = pair.ids(bodies).map(|id| self.places.get(id));
        Some(Pair { first: first?, second: second? })
    }

    fn points_of(&self, pair: &CarriedPair) -> &[Carried] {
        &self.points[pair.part][pair.points.clone()]
    }

    /// Those of many pairs: most of them come in the order of the last frame's.
    pub fn of_manifolds(&self, bodies: &Bodies, manifolds: &[Manifold]) -> Vec<&[Carried]> {
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
            manifolds.iter().map(of).collect::<Vec<&[Carried]>>()
        };
        threads::map(manifolds.chunks(SHARE).collect(), manifolds.len(), of_share).concat()
    }

    /// What a point carried.
    #[inline]
    pub fn get(&self, bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> Option<&Carried> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.sample == sample)
    }

    /// Forgets what contacts of some bodies carried.
    pub fn forget(&mut self, who: &[BodyId]) {
        let mut places: Vec<usize> = who.iter().filter_map(|&id| self.places.get(id)).collect();
        places.sort_unstable();
        let is_forgotten = |place: usize| places.binary_search(&place).is_ok();
        self.pairs.retain(|kept| !is_forgotten(kept.pair.first) && !is_forgotten(kept.pair.second));
    }

    /// Of so many pairs of these bodies, some of them in each part.
    pub fn of_parts(bodies: &Bodies, pairs: usize, parts: Vec<Part>) -> Self {
        let none = CarriedPair { pair: Pair { first: 0, second: 0 }, part: 0, points: 0..0 };
        let mut all = Self {
            points: Vec::with_capacity(parts.len()),
            pairs: vec![none; pairs],
            places: PerBody::default(),
        };
        for (place, &id) in bodies.ids.iter().enumerate() {
            all.places.insert(id, place);
        }
        for Part { points, pairs } in parts {
            let (part, mut begin) = (all.points.len(), 0);
            for (place, pair, end) in pairs {
                all.pairs[place] = CarriedPair { pair, part, points: begin..end };
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

impl Part {
    /// For so many pairs that carried at so many points.
    pub fn with_room(pairs: usize, points: usize) -> Self {
        Self { points: Vec::with_capacity(points), pairs: Vec::with_capacity(pairs) }
    }

    /// A pair that has some place among all carries what it carried.
    #[inline]
    pub fn keep(&mut self, place: usize, pair: Pair, carried: &[Carried]) {
        self.points.extend_from_slice(carried);
        self.end_pair(place, pair);
    }

    /// The points since the last pair are those of a pair that has some place among all.
    #[inline]
    pub fn end_pair(&mut self, place: usize, pair: Pair) {
        self.pairs.push((place, pair, self.points.len()));
    }
}
