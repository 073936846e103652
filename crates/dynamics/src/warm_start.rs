//! What contact points carry from one substep, and from one frame, to the next.

use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::threads;
use crate::{Bodies, BodyId};
use glam::Vec3;
use std::ops::Range;

/// Pairs that a thread looks up together: some ten microseconds of work.
const SHARE: usize = 1024;

/// What acted in a frame's last substep at each contact point, before and after its drift.
#[derive(Clone, Debug, Default)]
pub struct WarmStart {
    /// Of some pairs each.
    points: Vec<Vec<Carried>>,
    /// In the order of ids.
    pairs: Vec<CarriedPair>,
}

/// Where the points of a pair are.
#[derive(Clone, Debug)]
struct CarriedPair {
    ids: [BodyId; 2],
    part: usize,
    points: Range<usize>,
}

/// What some pairs carried.
#[derive(Default)]
pub(crate) struct Part {
    pub(crate) points: Vec<Carried>,
    /// Place of each among all pairs, its bodies, and its end among the points.
    pairs: Vec<(usize, [BodyId; 2], usize)>,
}

/// A contact point and what it carried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Carried {
    /// Whether it is a sample or feature of the pair's first body, and which.
    pub sample: (bool, u64),
    /// Before and after the drift: impulses per second of a substep, since the next frame may have more or fewer of them.
    pub forces: [PointImpulse; 2],
}

/// What acts at one contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointImpulse {
    /// Along the normal, not negative [N s].
    pub normal: f32,
    /// Across it, world frame [N s].
    pub tangent: Vec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: Vec3,
}

impl PointImpulse {
    pub(crate) const ZERO: Self = Self { normal: 0.0, tangent: Vec3::ZERO, twist: Vec3::ZERO };

    /// So many times as much.
    #[inline(always)]
    pub(crate) fn scaled(&self, by: f64) -> Self {
        let by = by as f32;
        Self { normal: by * self.normal, tangent: by * self.tangent, twist: by * self.twist }
    }
}

impl WarmStart {
    /// The points of a pair that carried.
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[Carried] {
        let found = self.pairs.binary_search_by_key(&pair.ids(bodies), |kept| kept.ids);
        found.map_or(&[], |at| self.points_of(&self.pairs[at]))
    }

    fn points_of(&self, pair: &CarriedPair) -> &[Carried] {
        &self.points[pair.part][pair.points.clone()]
    }

    /// Those of many pairs: most of them come in the order of ids.
    pub(crate) fn of_manifolds(&self, bodies: &Bodies, manifolds: &[Manifold]) -> Vec<&[Carried]> {
        let of_share = |manifolds: &[Manifold]| {
            let mut next = 0;
            let of = |manifold: &Manifold| {
                let wanted = manifold.pair.ids(bodies);
                if self.pairs.get(next).is_none_or(|kept| kept.ids != wanted) {
                    next = self.pairs.partition_point(|kept| kept.ids < wanted);
                }
                match self.pairs.get(next) {
                    Some(kept) if kept.ids == wanted => {
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
    pub fn get(&self, bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> Option<&Carried> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.sample == sample)
    }

    /// Of so many pairs, some of them in each part.
    pub(crate) fn of_parts(pairs: usize, parts: Vec<Part>) -> Self {
        let nobody = BodyId { index: 0, generation: 0 };
        let none = CarriedPair { ids: [nobody; 2], part: 0, points: 0..0 };
        let mut all = Self { points: Vec::with_capacity(parts.len()), pairs: vec![none; pairs] };
        for Part { points, pairs } in parts {
            let (part, mut begin) = (all.points.len(), 0);
            for (place, ids, end) in pairs {
                all.pairs[place] = CarriedPair { ids, part, points: begin..end };
                begin = end;
            }
            all.points.push(points);
        }
        all.pairs.retain(|kept| !kept.points.is_empty());
        if !all.pairs.is_sorted_by_key(|kept| kept.ids) {
            all.pairs.sort_unstable_by_key(|kept| kept.ids);
        }
        all
    }
}

impl Part {
    /// The points since the last pair are those of a pair that has some place among all.
    pub(crate) fn end_pair(&mut self, place: usize, ids: [BodyId; 2]) {
        self.pairs.push((place, ids, self.points.len()));
    }
}
