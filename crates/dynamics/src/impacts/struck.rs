//! Impact chains within a frame: billiard balls, skittles, dominoes. Swept bounds of ballistic
//! motion miss bodies reached after an impact. Bodies in impact get a predicted deviation from
//! their ballistic path, and all pairs within reach of deviating bodies get contact points.

mod stray;
mod ways;

use crate::impacts::struck::ways::Ways;
use frangible_bodies::{Bodies, Flight, Frame, Pair, Pose};
use frangible_collision::{Encounter, ManifoldFinder, Manifolds, Swept, WarmStart};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use stray::Stray;

/// Minimum growth factor of a deviation to visit its body again [1]; mutual impacts would repeat
/// forever. Without it the second ball of a row deviates backward by 0.4 m, as if the third ball
/// had hit it.
const CLEARLY: f64 = 2.0;

/// Maximum number of impacts in a frame [1]. With more, as in a falling heap, impact chains are
/// left out: without a bound a wall of 1,000 bricks takes 16 times as long after an impact, and a
/// falling heap of 800 pieces 2.3 times, with equal overlaps.
const MOST_STRIKES: usize = 1024;

/// Maximum number of body visits [1], in order of decreasing deviation.
const MOST_LOOKS: usize = MOST_STRIKES / 2;

/// Maximum number of movable neighbours per visited body, nearest first [1]: as for a brick in a
/// wall. With twelve an impact on a wall takes twice as long.
const MOST_REACHED: usize = 8;

/// Number of points of a face contact [1].
const FACE: usize = 4;

/// Adds manifolds for pairs that may approach faster than on their ballistic paths to `ends`
/// because of an impact, including pairs beyond the reach of ballistic motion.
pub fn note_struck(
    bodies: &Bodies,
    ends: &[Pose],
    swept: &Swept,
    (manifolds, warm): (&mut Manifolds, &WarmStart),
    frame: &Frame,
) {
    let Some(Straying { strays, more }) = straying(bodies, ends, swept, manifolds, frame) else {
        return;
    };
    let mut finder = ManifoldFinder::default();
    let mut pairs: Vec<Pair> = swept.pairs.iter().chain(&more).copied().collect();
    pairs.sort_unstable();
    let mut found = Vec::new();
    let mut known = manifolds.iter().peekable();
    for pair in pairs {
        let further =
            strays[pair.first].against(pair.second) + strays[pair.second].against(pair.first);
        if further <= 0.0 {
            continue;
        }
        while known.next_if(|manifold| manifold.pair < pair).is_some() {}
        // Face contacts already have all their points.
        let touches = known.peek().is_some_and(|manifold| {
            let all_near = manifold.points.iter().all(|point| point.gap <= frame.sag());
            manifold.pair == pair && manifold.points.len() >= FACE && all_near
        });
        if !touches {
            let [first, second] = Flight::of_pair(bodies, pair, frame);
            let encounter = Encounter::new(bodies, pair, [&first, &second], frame);
            let has_carried = |sample| warm.get(bodies, pair, sample).is_some();
            let encounter = encounter.struck(further / frame.dt);
            if let Some(manifold) = finder.of_encounter(&encounter, has_carried) {
                found.push((pair, manifold.points.to_vec()));
            }
        }
    }
    drop(known);
    manifolds.replace(&found);
}

/// Deviations of a frame.
struct Straying {
    /// One entry per body.
    strays: Vec<Stray>,
    /// Pairs in reach only because of a deviation.
    more: BTreeSet<Pair>,
}

/// Predicts deviations of all bodies; `None` without impacts.
fn straying(
    bodies: &Bodies,
    ends: &[Pose],
    swept: &Swept,
    manifolds: &Manifolds,
    frame: &Frame,
) -> Option<Straying> {
    // Skip resting contacts: gravity's approach over a frame stays within the speculative margin.
    let struck = Struck { bodies, ends, frame, least: 2.0 * frame.sag() };
    let comes = manifolds.approaches().map(|(pair, approach)| (pair, approach * frame.dt));
    let strikes: Vec<(Pair, f64)> = comes.filter(|&(_, comes)| comes > struck.least).collect();
    let furthest = strikes.iter().map(|&(_, comes)| comes).reduce(f64::max)?;
    if strikes.len() > MOST_STRIKES {
        return None;
    }
    // Upper bound of all deviations: an elastic impact of an infinitely heavy body doubles the
    // speed.
    let longest = 2.0 * furthest;
    let mut found = Straying { strays: vec![Stray::NONE; bodies.len()], more: BTreeSet::new() };
    let mut next = Next::default();
    for (Pair { first, second }, comes) in strikes {
        for (i, by) in [(first, second), (second, first)] {
            next.add(i, struck.stray(i, by, comes, struck.turning(i)), by, Stray::NONE);
        }
    }

    // Best-first search: visit the body with the largest deviation, then its neighbours, nearest
    // first.
    let mut ways = Ways::new(bodies, ends, &swept.bounds, frame);
    let mut looks = 0;
    while let Some((i, stray)) = next.pop() {
        found.strays[i] = stray;
        if looks == MOST_LOOKS {
            continue;
        }
        looks += 1;
        let mut room = MOST_REACHED;
        for other in ways.reached(i, &found.strays) {
            let is_fixed = bodies.inertias[other].is_infinite();
            if !is_fixed && room == 0 {
                continue;
            }
            room -= usize::from(!is_fixed);
            let pair = Pair { first: i.min(other), second: i.max(other) };
            if swept.pairs.binary_search(&pair).is_err() {
                found.more.insert(pair);
            }
            let known = *next.of(other).unwrap_or(&found.strays[other]);
            let comes = stray.against(other);
            let pushed = struck.stray(other, i, comes + struck.comes(pair), 0.0).min(longest);
            if comes > 0.0 && pushed > CLEARLY * known.most.0 + struck.least {
                next.add(other, pushed, i, known);
            }
        }
    }
    Some(found)
}

/// Ballistic motion of all bodies through a frame.
struct Struck<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    frame: &'a Frame,
    /// Smaller relative displacements count as rest or free fall [m].
    least: f64,
}

impl Struck<'_> {
    /// Upper bound of a body's deviation after an impact, for a relative displacement `come` [m] of
    /// the pair. `turning` adds the rotational part of the inverse effective mass [1/kg] for
    /// off-centre impacts.
    fn stray(&self, i: usize, by: usize, come: f64, turning: f64) -> f64 {
        let inverse_mass = |i: usize| self.bodies.inertias[i].inverse_mass;
        let answer = inverse_mass(i) + turning;
        let restitution = self.bodies.pair_contactant(i, by).restitution;
        if answer > 0.0 {
            (1.0 + restitution) * answer / (answer + inverse_mass(by)) * come
        } else {
            0.0
        }
    }

    /// Upper bound of the rotational part of the inverse effective mass [1/kg]; see
    /// [`Self::stray`].
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
    fn comes(&self, pair: Pair) -> f64 {
        let way = |i: usize| self.ends[i].position - self.bodies.poses[i].position;
        let turns = |i: usize| {
            let spin =
                self.bodies.spin(i, &self.bodies.poses[i], &self.bodies.velocities[i]).length();
            // Unbounded bodies have no spin.
            if spin > 0.0 { self.bodies.radii[i] * (spin * self.frame.dt).min(2.0) } else { 0.0 }
        };
        let comes =
            (way(pair.first) - way(pair.second)).length() + turns(pair.first) + turns(pair.second);
        if comes > self.least { comes } else { 0.0 }
    }
}

/// Priority queue of bodies by deviation, largest first.
#[derive(Default)]
struct Next {
    strays: BTreeMap<usize, Stray>,
    /// Deviation as bits (positive floats sort like their bits), and body; may hold outdated
    /// entries.
    order: BinaryHeap<(u64, Reverse<usize>)>,
}

impl Next {
    /// Registers a deviation [m] caused by the body `by`.
    fn add(&mut self, i: usize, stray: f64, by: usize, known: Stray) {
        if stray > 0.0 {
            let all = self.strays.entry(i).or_insert(known);
            all.add(stray, by);
            self.order.push((all.most.0.to_bits(), Reverse(i)));
        }
    }

    /// Queued deviation of a body.
    fn of(&self, i: usize) -> Option<&Stray> {
        self.strays.get(&i)
    }

    fn pop(&mut self) -> Option<(usize, Stray)> {
        loop {
            let (_, Reverse(i)) = self.order.pop()?;
            if let Some(stray) = self.strays.remove(&i) {
                return Some((i, stray));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Contactant, Motion, NewBody, StepSettings, Velocity, predict};
    use frangible_collision::find_manifolds;
    use frangible_geometry::{ClosedForm, Shape};
    use glam::{DQuat, DVec3};
    use std::sync::Arc;

    const FRAME: f64 = 1.0 / 30.0;

    /// Spawns balls of 0.2 m diameter along the x axis, at rest except the first, which has `speed`
    /// [m/s].
    fn straying(places: &[f64], speed: f64) -> (Vec<[usize; 2]>, Vec<Stray>) {
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
                contactant: Contactant::new(1.0, 0.0),
            });
        }
        let frame = Frame { dt: FRAME, gravity: DVec3::ZERO, settings: StepSettings::default() };
        let ends = predict(&bodies, &frame);
        let swept = Swept::new(&bodies, &ends, frame.sag(), &frame);
        let manifolds = find_manifolds(&bodies, &swept.pairs, &WarmStart::default(), &frame);
        let none = Straying { strays: vec![], more: BTreeSet::new() };
        let Straying { strays, more } =
            super::straying(&bodies, &ends, &swept, &manifolds, &frame).unwrap_or(none);
        let all: BTreeSet<Pair> = more.into_iter().chain(swept.pairs).collect();
        (all.iter().map(|pair| [pair.first, pair.second]).collect(), strays)
    }

    /// At 6 m/s the first ball travels 0.2 m in a frame. It may push the second ball equally far
    /// (its points further, by rotation), the second the third, and beyond. A pair's mutual impact
    /// adds no deviation to the pair.
    #[test]
    fn what_is_struck_may_strike_what_it_could_reach() {
        let (pairs, strays) = straying(&[0.0, 0.25, 0.65, 1.1, 5.0], 6.0);
        for wanted in [[0, 1], [1, 2], [2, 3]] {
            assert!(pairs.contains(&wanted), "{pairs:?}");
        }
        assert!(
            pairs.iter().all(|pair| pair[1] < 4) && pairs.is_sorted_by(|a, b| a < b),
            "{pairs:?}"
        );
        assert_eq!(strays[1].against(0), 0.0);
        assert!((0.2..=0.4).contains(&strays[1].against(2)), "{strays:?}");
        assert!(strays[3].against(4) > 0.2 && strays[4] == Stray::NONE, "{strays:?}");
    }

    /// Approaches below gravity's speed gain are no impacts.
    #[test]
    fn slow_blows_are_none() {
        assert_eq!(straying(&[0.0, 0.2, 0.41], 0.02), (vec![[0, 1]], vec![]));
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
            let (pairs, strays) = straying(&places, 6.0);
            let beyond = pairs.iter().filter(|pair| {
                pair[0] <= on_way && (on_way + 1..=on_way + beside).contains(&pair[1])
            });
            (beyond.count(), strays.iter().any(|stray| *stray != Stray::NONE))
        };
        assert_eq!(known(1, 7), (14, true), "by either of the first two");
        assert!((MOST_REACHED..=2 * MOST_REACHED).contains(&known(1, 200).0), "pairs");
        assert_eq!(
            known(MOST_STRIKES + 1, 10),
            (0, true),
            "the pairs of a crowd are thinned before"
        );
    }

    /// The largest source of a deviation is excluded for the pair of the two bodies.
    #[test]
    fn others_make_a_body_stray() {
        let mut stray = Stray::NONE;
        for (by, far) in [(7, 0.1), (8, 0.3), (7, 0.2), (8, 0.25)] {
            stray.add(far, by);
        }
        assert_eq!([7, 8, 9].map(|other| stray.against(other)), [0.3, 0.2, 0.3]);
    }
}
