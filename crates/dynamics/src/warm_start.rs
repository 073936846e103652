//! What contact points carry from one frame to the next, and who could come to rest.

use crate::bodies::PerBody;
use crate::manifold::Manifold;
use crate::pair::Pair;
use crate::sleep::Drowsiness;
use crate::threads;
use crate::{Bodies, BodyId};
use glam::Vec3;
use std::ops::Range;

/// Pairs that a thread looks up together: some ten microseconds of work.
const SHARE: usize = 1024;

/// What acted in the last substep in which a pair was solved, of the last frame or of one before it, at each contact point, before and after its drift, and for how long each body has been able to rest.
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
    /// In so many frames, one after the other until then, it could come to rest.
    settled_for: u8,
    is_in_heap: bool,
    drowsiness: Drowsiness,
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
    /// Before and after the drift: impulses per second of a substep, since the next frame may have more or fewer of them.
    pub forces: [PointImpulse; 2],
}

/// What acts at one contact point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointImpulse {
    /// The part along the normal, not negative [N s]: what presses comes first among the rows.
    pub normal: f32,
    /// In all, world frame [N s]: where a normal turns, as its points are found anew, it goes on as it is.
    pub force: Vec3,
    /// Of rolling and spinning friction, world frame [N m s].
    pub twist: Vec3,
}

impl PointImpulse {
    pub(crate) const ZERO: Self = Self { normal: 0.0, force: Vec3::ZERO, twist: Vec3::ZERO };

    /// So many times as much.
    #[inline(always)]
    pub(crate) fn scaled(&self, by: f64) -> Self {
        let by = by as f32;
        Self { normal: by * self.normal, force: by * self.force, twist: by * self.twist }
    }
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

    /// In so many frames, one after the other until the last one, a body could come to rest.
    pub(crate) fn settled_for(&self, id: BodyId) -> u8 {
        self.bodies.get(id).map_or(0, |body| body.settled_for)
    }

    /// Whether a body was in a heap in the last frame: in a cluster that gets no more than one pass.
    pub(crate) fn is_in_heap(&self, id: BodyId) -> bool {
        self.bodies.get(id).is_some_and(|body| body.is_in_heap)
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

    /// Of so many pairs, some of them in each part, and of all bodies, which could come to rest in so many frames until now, may be in heaps, and are drowsy if any may sleep.
    pub(crate) fn of_parts(
        bodies: &Bodies,
        (pairs, parts): (usize, Vec<Part>),
        settled_for: &[u8],
        are_in_heaps: &[bool],
        drowsiness: &[Drowsiness],
    ) -> Self {
        let none = CarriedPair { pair: Pair { first: 0, second: 0 }, part: 0, points: 0..0 };
        let mut all = Self {
            points: Vec::with_capacity(parts.len()),
            pairs: vec![none; pairs],
            bodies: PerBody::default(),
        };
        for (place, &id) in bodies.ids.iter().enumerate() {
            let (settled_for, is_in_heap) = (settled_for[place], are_in_heaps[place]);
            let drowsiness = drowsiness.get(place).copied().unwrap_or_default();
            all.bodies.insert(id, CarriedBody { place, settled_for, is_in_heap, drowsiness });
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Contactant, Motion, NewBody, Pose, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::{DQuat, DVec3};
    use std::sync::Arc;

    fn spawn(bodies: &mut Bodies) -> BodyId {
        bodies.spawn(NewBody {
            shape: Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1)),
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY },
            velocity: Velocity::default(),
            contactant: Contactant::new(0.0, 0.5),
        })
    }

    /// What a pair carried is its own, whatever has been taken out of the world or put into it since.
    #[test]
    fn pairs_keep_what_they_carried() {
        let mut bodies = Bodies::default();
        (0..5).for_each(|_| _ = spawn(&mut bodies));
        let mut all: Vec<Pair> =
            (0..5).flat_map(|first| (first + 1..5).map(move |second| Pair { first, second })).collect();
        all.reverse();
        let point = |sample| Carried { sample: (true, sample), forces: [PointImpulse::ZERO; 2] };
        let sample_of = |pair: Pair| 10 * pair.first as u64 + pair.second as u64;

        // Two parts that take turns, and a pair that carried nothing.
        let mut parts = vec![Part::default(), Part::default()];
        for (place, &pair) in all.iter().enumerate().rev() {
            let part = &mut parts[place % 2];
            if place != 0 {
                part.points.push(point(sample_of(pair)));
            }
            part.end_pair(place, pair);
        }
        let warm = WarmStart::of_parts(&bodies, (all.len(), parts), &[0, 1, 2, 3, 4], &[false; 5], &[]);
        let ids = bodies.ids.clone();
        bodies.remove(&[false, true, false, false, false]);
        let newborn = spawn(&mut bodies);
        assert_eq!(newborn.index, ids[1].index, "in the slot of another one");

        let expected = |pair: Pair| {
            let was = |i: usize| ids.iter().position(|&id| id == bodies.ids[i]);
            let was = Pair { first: was(pair.first)?, second: was(pair.second)? };
            (was != all[0]).then(|| sample_of(was))
        };
        let now: Vec<Pair> = all.iter().copied().filter(|pair| pair.second < bodies.len()).collect();
        let manifolds: Vec<Manifold> =
            now.iter().map(|&pair| Manifold { pair, points: &[], struck: 0.0 }).collect();
        let mut found = 0;
        for (&pair, points) in now.iter().zip(warm.of_manifolds(&bodies, &manifolds)) {
            assert_eq!(points, warm.of_pair(&bodies, pair));
            assert_eq!(points.first().map(|point| point.sample.1), expected(pair), "{pair:?}");
            found += points.len();
        }
        assert_eq!(found, 5, "six pairs of those that stay, of which one carried nothing");
        let settled: Vec<u8> = bodies.ids.iter().map(|&id| warm.settled_for(id)).collect();
        assert_eq!(settled, [0, 2, 3, 4, 0]);
    }
}
