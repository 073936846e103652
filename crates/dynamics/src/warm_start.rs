//! Impulses that contact points carry from one frame to the next, and each body's substeps and
//! drowsiness.

use crate::manifold::Manifold;
use crate::sleep::Drowsiness;
use frangible_bodies::{Bodies, BodyId, Pair, PerBody};
use frangible_math::threads;
use glam::Vec3;
use std::ops::Range;

/// Pairs that a thread looks up together: some ten microseconds of work.
const SHARE: usize = 1024;

/// What acted in the last substep of a frame at each contact point, and how each body's island
/// went.
#[derive(Clone, Debug, Default)]
pub struct WarmStart {
    /// Of some pairs each.
    points: Vec<Vec<Carried>>,
    /// Those that carried, in the order of [`Pair`].
    pairs: Vec<CarriedPair>,
    /// All that were there.
    bodies: PerBody<CarriedBody>,
}

/// What is known of a body from the last frame.
#[derive(Clone, Copy, Debug, PartialEq)]
struct CarriedBody {
    /// Its dense index then.
    place: usize,
    substeps: Substeps,
    drowsiness: Drowsiness,
}

/// The substeps of an island; none if it touched nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Substeps {
    pub(crate) count: u32,
    /// How many would have done.
    pub(crate) needed: f32,
}

impl Substeps {
    /// The larger of both numbers.
    pub(crate) fn max(self, other: Self) -> Self {
        Self { count: self.count.max(other.count), needed: self.needed.max(other.needed) }
    }
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
pub(crate) struct Part {
    pub(crate) points: Vec<Carried>,
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
    pub fn of_pair(&self, bodies: &Bodies, pair: Pair) -> &[Carried] {
        let Some(pair) = self.pair_then(bodies, pair) else { return &[] };
        let found = self.pairs.binary_search_by_key(&pair, |kept| kept.pair);
        found.map_or(&[], |at| self.points_of(&self.pairs[at]))
    }

    /// A pair by the dense indices of the last frame, if both of its bodies were there.
    fn pair_then(&self, bodies: &Bodies, pair: Pair) -> Option<Pair> {
        let [first, second] = pair.ids(bodies).map(|id| self.bodies.get(id));
        Some(Pair { first: first?.place, second: second?.place })
    }

    fn points_of(&self, pair: &CarriedPair) -> &[Carried] {
        &self.points[pair.part][pair.points.clone()]
    }

    /// Those of many pairs: most of them come in the order of the last frame's.
    pub(crate) fn of_manifolds(&self, bodies: &Bodies, manifolds: &[Manifold]) -> Vec<&[Carried]> {
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
    pub fn get(&self, bodies: &Bodies, pair: Pair, sample: (bool, u64)) -> Option<&Carried> {
        self.of_pair(bodies, pair).iter().find(|carried| carried.sample == sample)
    }

    /// Those of a body's island in the last frame.
    pub(crate) fn substeps(&self, id: BodyId) -> Substeps {
        self.bodies.get(id).map_or(Substeps::default(), |body| body.substeps)
    }

    /// What decides whether a body sleeps.
    pub(crate) fn drowsiness(&self, id: BodyId) -> Drowsiness {
        self.bodies.get(id).map_or(Drowsiness::default(), |body| body.drowsiness)
    }

    /// A body is as awake as if it had just moved.
    pub fn wake(&mut self, id: BodyId) {
        if let Some(body) = self.bodies.get(id) {
            self.bodies.insert(id, CarriedBody { drowsiness: Drowsiness::default(), ..body });
        }
    }

    /// Forgets what contacts of some bodies carried.
    pub fn forget(&mut self, who: &[BodyId]) {
        let mut places: Vec<usize> =
            who.iter().filter_map(|&id| self.bodies.get(id)).map(|body| body.place).collect();
        places.sort_unstable();
        let is_forgotten = |place: usize| places.binary_search(&place).is_ok();
        self.pairs.retain(|kept| !is_forgotten(kept.pair.first) && !is_forgotten(kept.pair.second));
    }

    /// Whether a body slept in the last frame.
    pub fn is_asleep(&self, id: BodyId) -> bool {
        self.drowsiness(id).is_asleep()
    }

    /// Of so many pairs, some of them in each part, and of all bodies, whose islands took so many
    /// substeps, and which are drowsy if any may sleep.
    pub(crate) fn of_parts(
        bodies: &Bodies,
        (pairs, parts): (usize, Vec<Part>),
        substeps: &[Substeps],
        drowsiness: &[Drowsiness],
    ) -> Self {
        let none = CarriedPair { pair: Pair { first: 0, second: 0 }, part: 0, points: 0..0 };
        let mut all = Self {
            points: Vec::with_capacity(parts.len()),
            pairs: vec![none; pairs],
            bodies: PerBody::default(),
        };
        for (place, &id) in bodies.ids.iter().enumerate() {
            let substeps = substeps[place];
            let drowsiness = drowsiness.get(place).copied().unwrap_or_default();
            all.bodies.insert(id, CarriedBody { place, substeps, drowsiness });
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
    pub(crate) fn with_room(pairs: usize, points: usize) -> Self {
        Self { points: Vec::with_capacity(points), pairs: Vec::with_capacity(pairs) }
    }

    /// A pair that has some place among all carries what it carried.
    pub(crate) fn keep(&mut self, place: usize, pair: Pair, carried: &[Carried]) {
        self.points.extend_from_slice(carried);
        self.end_pair(place, pair);
    }

    /// The points since the last pair are those of a pair that has some place among all.
    pub(crate) fn end_pair(&mut self, place: usize, pair: Pair) {
        self.pairs.push((place, pair, self.points.len()));
    }
}
