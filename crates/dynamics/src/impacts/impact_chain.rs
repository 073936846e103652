//! Impact chains within a frame: billiard balls, skittles, dominoes. Swept bounds of ballistic
//! motion miss bodies reached after an impact. Bodies in impact get a predicted deviation from
//! their ballistic path, and all pairs within reach of deviating bodies get contact points.

mod deviation;
mod swept_spheres;

use crate::impacts::impact_chain::swept_spheres::SweptSpheres;
use deviation::Deviation;
use frangible_bodies::{BallisticPath, Bodies, Frame, Pair, Pose};
use frangible_collision::{
    FixedNeighbours, ImpulseCache, ManifoldFinder, Manifolds, PairMotion, Swept,
};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};

/// Minimum growth factor of a deviation to visit its body again [1]; mutual impacts would repeat
/// forever. Without it the second ball of a row deviates backward by 0.4 m, as if the third ball
/// had hit it.
const MIN_GROWTH: f64 = 2.0;

/// Maximum number of impacts in a frame [1]. With more, as in a falling heap, impact chains are
/// left out: without a bound a wall of 1,000 bricks takes 16 times as long after an impact, and a
/// falling heap of 800 pieces 2.3 times, with equal overlaps.
const MAX_IMPACTS: usize = 1024;

/// Maximum number of body visits [1], in order of decreasing deviation.
const MAX_VISITS: usize = MAX_IMPACTS / 2;

/// Maximum number of movable neighbours per visited body, nearest first [1]: as for a brick in a
/// wall. With twelve an impact on a wall takes twice as long.
const MAX_NEIGHBOURS: usize = 8;

/// Number of points of a face contact [1].
const FACE_POINTS: usize = 4;

/// Adds manifolds for pairs that may approach faster than on their ballistic paths to `ends`
/// because of an impact, including pairs beyond the reach of ballistic motion.
pub fn find_impact_chain(
    bodies: &Bodies,
    ends: &[Pose],
    swept: &Swept,
    (manifolds, warm): (&mut Manifolds, &ImpulseCache),
    frame: &Frame,
) {
    let Some(Deviations { deviations, more }) =
        predict_deviations(bodies, ends, swept, manifolds, frame)
    else {
        return;
    };
    let mut finder = ManifoldFinder::default();
    let further = |pair: &Pair| {
        deviations[pair.first].against(pair.second) + deviations[pair.second].against(pair.first)
    };
    let all = swept.pairs.iter().chain(&more).copied();
    let neighbours = FixedNeighbours::of_world(bodies, all.clone());
    let mut pairs: Vec<(Pair, f64)> =
        all.map(|pair| (pair, further(&pair))).filter(|&(_, further)| further > 0.0).collect();
    pairs.sort_unstable_by_key(|&(pair, _)| pair);
    let mut found = Vec::new();
    let mut known = manifolds.iter().peekable();
    for (pair, further) in pairs {
        while known.next_if(|manifold| manifold.pair < pair).is_some() {}
        // Face contacts already have all their points.
        let touches = known.peek().is_some_and(|manifold| {
            let all_near =
                manifold.points.iter().all(|point| point.gap <= frame.speculative_margin());
            manifold.pair == pair && manifold.points.len() >= FACE_POINTS && all_near
        });
        if !touches {
            let [first, second] = BallisticPath::of_pair(bodies, pair, frame);
            let pair_motion =
                PairMotion::new(bodies, pair, [&first, &second], frame).among(&neighbours);
            let has_carried = |feature| warm.get(bodies, pair, feature).is_some();
            let pair_motion = pair_motion.with_speed_gain(further / frame.dt);
            if let Some(manifold) = finder.of_motion(&pair_motion, has_carried) {
                found.push((pair, manifold.points.to_vec()));
            }
        }
    }
    drop(known);
    manifolds.neighbours = neighbours;
    manifolds.replace(&found);
}

/// Deviations of a frame.
struct Deviations {
    /// One entry per body.
    deviations: Vec<Deviation>,
    /// Pairs in reach only because of a deviation.
    more: BTreeSet<Pair>,
}

/// Predicts deviations of all bodies; `None` without impacts.
fn predict_deviations(
    bodies: &Bodies,
    ends: &[Pose],
    swept: &Swept,
    manifolds: &Manifolds,
    frame: &Frame,
) -> Option<Deviations> {
    // Skip resting contacts: gravity's approach over a frame stays within the speculative margin.
    let motion = ChainMotion { bodies, ends, frame, least: 2.0 * frame.speculative_margin() };
    let approaches = manifolds.approaches().map(|(pair, approach)| (pair, approach * frame.dt));
    let impacts: Vec<(Pair, f64)> =
        approaches.filter(|&(_, displacement)| displacement > motion.least).collect();
    let furthest = impacts.iter().map(|&(_, displacement)| displacement).reduce(f64::max)?;
    if impacts.len() > MAX_IMPACTS {
        return None;
    }
    // Upper bound of all deviations: an elastic impact of an infinitely heavy body doubles the
    // speed.
    let longest = 2.0 * furthest;
    let mut found =
        Deviations { deviations: vec![Deviation::NONE; bodies.len()], more: BTreeSet::new() };
    let mut queue = DeviationQueue::default();
    for (Pair { first, second }, displacement) in impacts {
        for (i, by) in [(first, second), (second, first)] {
            queue.add(
                i,
                motion.deviation(i, by, displacement, motion.turning(i)),
                by,
                Deviation::NONE,
            );
        }
    }

    // Best-first search: visit the body with the largest deviation, then its neighbours, nearest
    // first.
    let mut spheres = SweptSpheres::new(bodies, ends, &swept.bounds, frame);
    let mut visits = 0;
    while let Some((i, deviation)) = queue.pop() {
        found.deviations[i] = deviation;
        if visits == MAX_VISITS {
            continue;
        }
        visits += 1;
        let mut free_places = MAX_NEIGHBOURS;
        for other in spheres.reached(i, &found.deviations) {
            if !bodies.may_collide(i, other) {
                continue;
            }
            let is_fixed = bodies.inertias[other].is_infinite();
            if !is_fixed && free_places == 0 {
                continue;
            }
            free_places -= usize::from(!is_fixed);
            let pair = Pair { first: i.min(other), second: i.max(other) };
            if swept.pairs.binary_search(&pair).is_err() {
                found.more.insert(pair);
            }
            let known = *queue.of(other).unwrap_or(&found.deviations[other]);
            let displacement = deviation.against(other);
            let pushed = motion
                .deviation(other, i, displacement + motion.relative_displacement(pair), 0.0)
                .min(longest);
            if displacement > 0.0 && pushed > MIN_GROWTH * known.most.0 + motion.least {
                queue.add(other, pushed, i, known);
            }
        }
    }
    Some(found)
}

/// Ballistic motion of all bodies through a frame.
struct ChainMotion<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    frame: &'a Frame,
    /// Smaller relative displacements count as rest or free fall [m].
    least: f64,
}

impl ChainMotion<'_> {
    /// Upper bound of a body's deviation after an impact, for a relative `displacement` [m] of the
    /// pair. `turning` adds the rotational part of the inverse effective mass [1/kg] for off-centre
    /// impacts.
    fn deviation(&self, i: usize, by: usize, displacement: f64, turning: f64) -> f64 {
        let inverse_mass = |i: usize| self.bodies.inertias[i].inverse_mass;
        let answer = inverse_mass(i) + turning;
        let restitution = self.bodies.pair_surface(i, by).restitution;
        if answer > 0.0 {
            (1.0 + restitution) * answer / (answer + inverse_mass(by)) * displacement
        } else {
            0.0
        }
    }

    /// Upper bound of the rotational part of the inverse effective mass [1/kg]; see
    /// [`Self::deviation`].
    fn turning(&self, i: usize) -> f64 {
        let inertia = &self.bodies.inertias[i];
        let size = self.bodies.radii[i];
        if inertia.is_infinite() {
            0.0
        } else {
            inertia.inverse_moments.max_element() * size * size
        }
    }

    /// Upper bound of the relative displacement of a pair's points [m]; 0 for resting pairs.
    fn relative_displacement(&self, pair: Pair) -> f64 {
        let way = |i: usize| self.ends[i].position - self.bodies.poses[i].position;
        let turns = |i: usize| {
            let spin =
                self.bodies.spin(i, &self.bodies.poses[i], &self.bodies.velocities[i]).length();
            // Unbounded bodies have no spin.
            if spin > 0.0 { self.bodies.radii[i] * (spin * self.frame.dt).min(2.0) } else { 0.0 }
        };
        let displacement =
            (way(pair.first) - way(pair.second)).length() + turns(pair.first) + turns(pair.second);
        if displacement > self.least { displacement } else { 0.0 }
    }
}

/// Priority queue of bodies by deviation, largest first.
#[derive(Default)]
struct DeviationQueue {
    deviations: BTreeMap<usize, Deviation>,
    /// Deviation as bits (positive floats sort like their bits), and body; may hold outdated
    /// entries.
    order: BinaryHeap<(u64, Reverse<usize>)>,
}

impl DeviationQueue {
    /// Registers a deviation [m] caused by the body `by`.
    fn add(&mut self, i: usize, deviation: f64, by: usize, known: Deviation) {
        if deviation > 0.0 {
            let all = self.deviations.entry(i).or_insert(known);
            all.add(deviation, by);
            self.order.push((all.most.0.to_bits(), Reverse(i)));
        }
    }

    /// Queued deviation of a body.
    fn of(&self, i: usize) -> Option<&Deviation> {
        self.deviations.get(&i)
    }

    fn pop(&mut self) -> Option<(usize, Deviation)> {
        loop {
            let (_, Reverse(i)) = self.order.pop()?;
            if let Some(deviation) = self.deviations.remove(&i) {
                return Some((i, deviation));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, StepSettings, SurfaceProperties, Velocity, predict};
    use frangible_collision::find_manifolds;
    use frangible_geometry::{ClosedForm, Shape};
    use glam::{DQuat, DVec3};
    use std::sync::Arc;

    const FRAME: f64 = 1.0 / 30.0;

    /// Spawns balls of 0.2 m diameter along the x axis, at rest except the first, which has `speed`
    /// [m/s].
    fn predict_deviations(places: &[f64], speed: f64) -> (Vec<[usize; 2]>, Vec<Deviation>) {
        let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.1 }, 0.1));
        let mut bodies = Bodies::default();
        for (number, &x) in places.iter().enumerate() {
            let linear = DVec3::X * if number == 0 { speed } else { 0.0 };
            bodies.spawn(NewBody {
                shape: shape.clone(),
                density: 1000.0,
                motion: Motion::Dynamic,
                pose: Pose { position: DVec3::X * x, orientation: DQuat::IDENTITY },
                velocity: Velocity { linear, ..Velocity::default() },
                surface: SurfaceProperties::new(1.0, 0.0),
            });
        }
        let frame = Frame { dt: FRAME, gravity: DVec3::ZERO, settings: StepSettings::default() };
        let ends = predict(&bodies, &frame);
        let swept = Swept::new(&bodies, &ends, frame.speculative_margin(), &frame);
        let manifolds = find_manifolds(&bodies, &swept.pairs, &ImpulseCache::default(), &frame);
        let none = Deviations { deviations: vec![], more: BTreeSet::new() };
        let Deviations { deviations, more } =
            super::predict_deviations(&bodies, &ends, &swept, &manifolds, &frame).unwrap_or(none);
        let all: BTreeSet<Pair> = more.into_iter().chain(swept.pairs).collect();
        (all.iter().map(|pair| [pair.first, pair.second]).collect(), deviations)
    }

    /// At 6 m/s the first ball travels 0.2 m in a frame. It may push the second ball equally far
    /// (its points further, by rotation), the second the third, and beyond. A pair's mutual impact
    /// adds no deviation to the pair.
    #[test]
    fn what_is_struck_may_strike_what_it_could_reach() {
        let (pairs, deviations) = predict_deviations(&[0.0, 0.25, 0.65, 1.1, 5.0], 6.0);
        for wanted in [[0, 1], [1, 2], [2, 3]] {
            assert!(pairs.contains(&wanted), "{pairs:?}");
        }
        assert!(
            pairs.iter().all(|pair| pair[1] < 4) && pairs.is_sorted_by(|a, b| a < b),
            "{pairs:?}"
        );
        assert_eq!(deviations[1].against(0), 0.0);
        assert!((0.2..=0.4).contains(&deviations[1].against(2)), "{deviations:?}");
        assert!(
            deviations[3].against(4) > 0.2 && deviations[4] == Deviation::NONE,
            "{deviations:?}"
        );
    }

    /// Approaches below gravity's speed gain are no impacts.
    #[test]
    fn slow_blows_are_none() {
        assert_eq!(predict_deviations(&[0.0, 0.2, 0.41], 0.02), (vec![[0, 1]], vec![]));
    }

    /// With too many impacts no deviation is computed; a single body gets only its nearest
    /// neighbours: a given number of balls lies on the first ball's path, and more around the
    /// second ball's.
    #[test]
    fn crowds_are_left_alone() {
        let known = |on_way: usize, beside: usize| {
            let balls =
                |count: usize, from: f64| (0..count).map(move |number| from + 1e-6 * number as f64);
            let places: Vec<f64> =
                [0.0].into_iter().chain(balls(on_way, 0.2)).chain(balls(beside, 0.7)).collect();
            let (pairs, deviations) = predict_deviations(&places, 6.0);
            let beyond = pairs.iter().filter(|pair| {
                pair[0] <= on_way && (on_way + 1..=on_way + beside).contains(&pair[1])
            });
            (beyond.count(), deviations.iter().any(|deviation| *deviation != Deviation::NONE))
        };
        assert_eq!(known(1, 7), (14, true), "by either of the first two");
        assert!((MAX_NEIGHBOURS..=2 * MAX_NEIGHBOURS).contains(&known(1, 200).0), "pairs");
        assert_eq!(
            known(MAX_IMPACTS + 1, 10),
            (0, true),
            "the pairs of a crowd are thinned before"
        );
    }

    /// The largest source of a deviation is excluded for the pair of the two bodies.
    #[test]
    fn others_make_a_body_stray() {
        let mut deviation = Deviation::NONE;
        for (by, far) in [(7, 0.1), (8, 0.3), (7, 0.2), (8, 0.25)] {
            deviation.add(far, by);
        }
        assert_eq!([7, 8, 9].map(|other| deviation.against(other)), [0.3, 0.2, 0.3]);
    }
}
