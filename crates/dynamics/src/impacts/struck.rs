//! Struck bodies strike others in the same frame: billiard balls, skittles, dominoes. Ballistic
//! ways do not tell, so bodies that are struck are taken to stray from theirs, and whatever they
//! could reach is watched.

mod stray;
mod ways;

use crate::impacts::struck::ways::Ways;
use frangible_bodies::{Bodies, Flight, Frame, Pair, Pose};
use frangible_collision::{Encounter, ManifoldFinder, Manifolds, Swept, WarmStart};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use stray::Stray;

/// How much further a body must stray than was known, to be looked at again [1]: what strikes each
/// other by turns goes on for ever. Without it the second ball of a row strays back by 0.4 m, as if
/// the third one, which it strikes, had come at it.
const CLEARLY: f64 = 2.0;

/// Strikes in a frame [1]. Where there are more, as in a heap that falls, nobody sees who strikes
/// whom next: without a bound a wall of 1,000 bricks that is struck takes 16 times as long, a heap
/// of 800 pieces that falls 2.3 times, with overlaps no smaller.
const MOST_STRIKES: usize = 1024;

/// Times that it is asked whom a body may strike [1]: what strays furthest comes first.
const MOST_LOOKS: usize = MOST_STRIKES / 2;

/// Of the movable ones that a body may strike so many are watched, the nearest [1]: as many bricks
/// as lie about one in a wall. With twelve a wall that is struck takes twice as long.
const MOST_REACHED: usize = 8;

/// Points of a face [1].
const FACE: usize = 4;

/// Finds the manifolds of pairs that may come faster against each other than on their ballistic
/// ways to `ends`, because one of them is struck; pairs that meet by that alone are added.
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
        // Pairs that touch by a face have all of their points.
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

/// Who may stray, and who may meet by it.
struct Straying {
    /// Of each body.
    strays: Vec<Stray>,
    /// Pairs that meet by it alone.
    more: BTreeSet<Pair>,
}

/// How far bodies may stray, if anything is struck.
fn straying(
    bodies: &Bodies,
    ends: &[Pose],
    swept: &Swept,
    manifolds: &Manifolds,
    frame: &Frame,
) -> Option<Straying> {
    // What gravity makes of rest is no strike, and pushes nothing further than is looked at anyway.
    let struck = Struck { bodies, ends, frame, least: 2.0 * frame.sag() };
    let comes = manifolds.approaches().map(|(pair, approach)| (pair, approach * frame.dt));
    let strikes: Vec<(Pair, f64)> = comes.filter(|&(_, comes)| comes > struck.least).collect();
    let furthest = strikes.iter().map(|&(_, comes)| comes).reduce(f64::max)?;
    if strikes.len() > MOST_STRIKES {
        return None;
    }
    // None strays further than what something heavy strikes without loss.
    let longest = 2.0 * furthest;
    let mut found = Straying { strays: vec![Stray::NONE; bodies.len()], more: BTreeSet::new() };
    let mut next = Next::default();
    for (Pair { first, second }, comes) in strikes {
        for (i, by) in [(first, second), (second, first)] {
            next.add(i, struck.stray(i, by, comes, struck.turning(i)), by, Stray::NONE);
        }
    }

    // Whatever those can reach that stray furthest may be struck by them, the nearest first.
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

/// Bodies on their ballistic ways through a frame.
struct Struck<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    frame: &'a Frame,
    /// What comes less far rests, or falls from rest [m].
    least: f64,
}

impl Struck<'_> {
    /// How far a body may stray that is struck, if the other one of the pair comes so far against
    /// it [m]: an impulse at its middle gives no more, or one anywhere to any of its points, with
    /// what `turning` adds to its answer [1/kg].
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

    /// See [`Self::stray`].
    fn turning(&self, i: usize) -> f64 {
        let inertia = &self.bodies.inertias[i];
        let size = self.bodies.radii[i];
        if inertia.is_infinite() {
            0.0
        } else {
            inertia.inverse_moments.max_element() * size * size
        }
    }

    /// How far any points of a pair move against each other on their ways; none if they rest [m].
    fn comes(&self, pair: Pair) -> f64 {
        let way = |i: usize| self.ends[i].position - self.bodies.poses[i].position;
        let turns = |i: usize| {
            let spin =
                self.bodies.spin(i, &self.bodies.poses[i], &self.bodies.velocities[i]).length();
            // What has no bounds does not turn.
            if spin > 0.0 { self.bodies.radii[i] * (spin * self.frame.dt).min(2.0) } else { 0.0 }
        };
        let comes =
            (way(pair.first) - way(pair.second)).length() + turns(pair.first) + turns(pair.second);
        if comes > self.least { comes } else { 0.0 }
    }
}

/// Bodies that may stray further than is known, the furthest first.
#[derive(Default)]
struct Next {
    strays: BTreeMap<usize, Stray>,
    /// How far each may stray, as bits, whose order is that of positive numbers, or might when it
    /// was not known better.
    order: BinaryHeap<(u64, Reverse<usize>)>,
}

impl Next {
    /// Another body may push it so far [m], if at all.
    fn add(&mut self, i: usize, stray: f64, by: usize, known: Stray) {
        if stray > 0.0 {
            let all = self.strays.entry(i).or_insert(known);
            all.add(stray, by);
            self.order.push((all.most.0.to_bits(), Reverse(i)));
        }
    }

    /// How far a body may stray, if that is not to be looked at yet [m].
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

    /// Balls of 0.2 m along the x axis, at rest but for the first one, which has a speed [m/s].
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

    /// At 6 m/s the first ball comes 0.2 m far. So far it may push the second one, of the same
    /// mass, whose points may come further as it may turn; the third one is looked for as far as
    /// that, and so on. What meets by itself is no further apart for the two that do.
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

    /// What is slower than gravity would make it strikes nobody.
    #[test]
    fn slow_blows_are_none() {
        assert_eq!(straying(&[0.0, 0.2, 0.41], 0.02), (vec![[0, 1]], vec![]));
    }

    /// Of more strikes than there is time for nothing is known, and of a body only whom it reaches
    /// first: as many balls as told lie where the first one comes by, and some where the second one
    /// might be pushed.
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

    /// The body that may push it furthest does not count for the pair of the two.
    #[test]
    fn others_make_a_body_stray() {
        let mut stray = Stray::NONE;
        for (by, far) in [(7, 0.1), (8, 0.3), (7, 0.2), (8, 0.25)] {
            stray.add(far, by);
        }
        assert_eq!([7, 8, 9].map(|other| stray.against(other)), [0.3, 0.2, 0.3]);
    }
}
