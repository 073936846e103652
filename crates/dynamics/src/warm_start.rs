//! What contact points carry from one substep, and from one frame, to the next.

use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::{Bodies, BodyId};
use glam::Vec3;
use std::ops::Range;

/// What acted in a frame's last substep at each contact point, before and after its drift.
#[derive(Clone, Debug, Default)]
pub struct WarmStart {
    points: Vec<Carried>,
    /// The points of each pair, in the order of ids.
    pairs: Vec<([BodyId; 2], Range<usize>)>,
}

/// What some pairs carried.
#[derive(Default)]
pub(crate) struct Part {
    points: Vec<Carried>,
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
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointImpulse {
    /// Along the normal, not negative [N s].
    pub normal: f32,
    /// Across it, world frame [N s].
    pub tangent: Vec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: Vec3,
}

impl PointImpulse {
    /// So many times as much.
    pub(crate) fn scaled(&self, by: f64) -> Self {
        let by = by as f32;
        Self { normal: by * self.normal, tangent: by * self.tangent, twist: by * self.twist }
    }
}

impl WarmStart {
    /// The points of a pair that carried.
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[Carried] {
        let found = self.pairs.binary_search_by_key(&ids(bodies, pair), |kept| kept.0);
        found.map_or(&[], |at| &self.points[self.pairs[at].1.clone()])
    }

    /// Those of many pairs: most of them come in the order of ids.
    pub(crate) fn of_manifolds(&self, bodies: &Bodies, manifolds: &[Manifold]) -> Vec<&[Carried]> {
        let mut next = 0;
        let of = |manifold: &Manifold| {
            let wanted = ids(bodies, manifold.pair);
            if self.pairs.get(next).is_none_or(|kept| kept.0 != wanted) {
                next = self.pairs.partition_point(|kept| kept.0 < wanted);
            }
            match self.pairs.get(next) {
                Some(kept) if kept.0 == wanted => {
                    next += 1;
                    &self.points[kept.1.clone()]
                }
                _ => &[],
            }
        };
        manifolds.iter().map(of).collect()
    }

    /// What a point carried.
    pub fn get(&self, bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> Option<&Carried> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.sample == sample)
    }

    /// Of so many pairs, some of them in each part.
    pub(crate) fn of_parts(pairs: usize, parts: impl IntoIterator<Item = Part>) -> Self {
        let nobody = BodyId { index: 0, generation: 0 };
        let mut all = Self { points: Vec::new(), pairs: vec![([nobody; 2], 0..0); pairs] };
        for part in parts {
            let before = all.points.len();
            let mut begin = before;
            all.points.extend(part.points);
            for (place, ids, end) in part.pairs {
                all.pairs[place] = (ids, begin..before + end);
                begin = before + end;
            }
        }
        all.put_in_order();
        all
    }

    fn put_in_order(&mut self) {
        self.pairs.retain(|kept| !kept.1.is_empty());
        if !self.pairs.is_sorted_by_key(|kept| kept.0) {
            self.pairs.sort_unstable_by_key(|kept| kept.0);
        }
    }
}

impl Part {
    /// Keeps the points of the pair that has some place among all.
    pub(crate) fn keep(
        &mut self,
        place: usize,
        bodies: &Bodies,
        pair: Pair,
        carried: impl Iterator<Item = Carried>,
    ) {
        self.points.extend(carried);
        self.pairs.push((place, ids(bodies, pair), self.points.len()));
    }
}

fn ids(bodies: &Bodies, pair: Pair) -> [BodyId; 2] {
    [pair.first, pair.second].map(|i| bodies.ids[i])
}
