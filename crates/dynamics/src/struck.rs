//! What is struck strikes others in the same frame: billiard balls, skittles, dominoes. Ballistic ways do not tell, so bodies that may be struck are taken
//! to stray from theirs, and whatever they could reach is looked at, too.

use crate::broad_phase::{Bounds, is_above, swept_bounds};
use crate::detection::radius;
use crate::pair::Pair;
use crate::threads;
use crate::{Bodies, Frame, Inertia, Pose};
use frangible_geometry::{ClosedForm, Geometry, HalfSpace};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Tests of two bounds in a frame [1]: a millisecond.
const MOST_TESTS: usize = 1 << 19;

/// Strikes in a frame, and pairs that meet by them alone [1]. Where there are more, as in a heap that falls, nobody sees who strikes whom next.
const MOST_MORE: usize = 1024;

/// How much further a body must stray than was known, to be looked at again [1]: what strikes each other by turns goes on for ever.
const CLEARLY: f64 = 2.0;

/// How far a body may stray from its ballistic way because it is struck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stray {
    /// Because of the body that may push it furthest, by its dense index, and because of all others [m].
    most: (f64, usize),
    otherwise: f64,
}

/// Pairs that may meet within the frame, and how far each of their bodies may stray from its way.
pub struct Straying {
    /// In increasing order.
    pub pairs: Vec<Pair>,
    /// Of each body; none if nothing is struck.
    pub strays: Vec<Stray>,
}

impl Stray {
    pub(crate) const NONE: Self = Self { most: (0.0, usize::MAX), otherwise: 0.0 };

    /// As far as it matters to another body, which meets it on their ways if they meet by each other alone [m].
    pub(crate) fn against(&self, other: usize) -> f64 {
        if self.most.1 == other { self.otherwise } else { self.most.0 }
    }

    /// Another body may push it so far [m].
    fn add(&mut self, stray: f64, by: usize) {
        if by == self.most.1 {
            self.most.0 = self.most.0.max(stray);
        } else if stray > self.most.0 {
            (self.most, self.otherwise) = ((stray, by), self.most.0);
        } else {
            self.otherwise = self.otherwise.max(stray);
        }
    }
}

/// Adds to `pairs`, those whose bounds along their ballistic ways to `ends` overlap, those that may meet because one of them is struck, as far as
/// [`MOST_MORE`] and [`MOST_TESTS`] go.
pub fn find_struck_pairs(bodies: &Bodies, ends: &[Pose], mut pairs: Vec<Pair>, frame: &Frame) -> Straying {
    let mut struck = Struck::new(bodies, ends, frame);
    let mut next = struck.by_first_strikes(&pairs);
    let mut tests = next.len() * bodies.len();
    if next.is_empty() || tests > MOST_TESTS {
        return Straying { pairs, strays: Vec::new() };
    }

    // Whatever those can reach that were struck last may be struck by them.
    let ballistic = swept_bounds(bodies, ends, frame.dt, frame.sag());
    let (mut bounds, mut strays) = (ballistic.clone(), vec![Stray::NONE; bodies.len()]);
    let mut more = BTreeSet::<Pair>::new();
    while !next.is_empty() {
        next.iter().for_each(|(&i, stray)| bounds[i] = ballistic[i].grown(stray.most.0));
        let (mut reached, mut met) = (Vec::new(), more.clone());
        for &i in next.keys() {
            let begin = reached.len();
            reached.extend(struck.reached(i, &bounds));
            met.extend(reached[begin..].iter().filter(|pair| pairs.binary_search(pair).is_err()));
            if met.len() > MOST_MORE {
                break;
            }
        }
        if met.len() > MOST_MORE {
            break;
        }
        more = met;
        next.into_iter().for_each(|(i, stray)| strays[i] = stray);
        next = struck.by_next_strikes(&reached, &strays);
        tests += next.len() * bodies.len();
        if tests > MOST_TESTS {
            break;
        }
    }
    pairs.extend(more);
    pairs.sort();
    Straying { pairs, strays }
}

/// Bodies on their ballistic ways through a frame.
struct Struck<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    frame: &'a Frame,
    /// How far the points of each of them turn [m].
    turns: Vec<f64>,
    /// None strays further: twice as far as what comes fastest, as what something heavy strikes without loss does [m].
    longest: f64,
}

impl<'a> Struck<'a> {
    fn new(bodies: &'a Bodies, ends: &'a [Pose], frame: &'a Frame) -> Self {
        let turns = |i: usize| {
            let spin = bodies.spin(i, &bodies.poses[i], &bodies.velocities[i]).length();
            // What has no bounds does not turn.
            if spin > 0.0 { radius(&bodies.shapes[i]) * (spin * frame.dt).min(2.0) } else { 0.0 }
        };
        Self { bodies, ends, frame, turns: threads::list(bodies.len(), turns), longest: 0.0 }
    }

    /// How far any point of a body may stray that is struck, if the other one of the pair comes so far against it: an impulse gives no more, wherever it
    /// acts [m].
    fn stray(&self, i: usize, by: usize, come: f64) -> f64 {
        let inertia = |i: usize| &self.bodies.inertias[i];
        let Inertia { inverse_mass, inverse_moments } = *inertia(i);
        if inertia(i).is_infinite() {
            return 0.0;
        }
        let size = radius(&self.bodies.shapes[i]);
        let answer = inverse_mass + inverse_moments.max_element() * size * size;
        let restitution = self.bodies.pair_contactant(i, by).restitution;
        (1.0 + restitution) * answer / (answer + inertia(by).inverse_mass) * come
    }

    /// How far the bodies of a pair move against each other on their ways, or towards the ground if one of them is that [m].
    fn comes(&self, pair: Pair) -> f64 {
        let way = |i: usize| self.ends[i].position - self.bodies.poses[i].position;
        let of_first = way(pair.first) - way(pair.second);
        let towards = |ground: usize, way: DVec3| {
            // Shapes lie all over the memory.
            if !self.bodies.inertias[ground].is_infinite() {
                return None;
            }
            match &self.bodies.shapes[ground].geometry {
                Geometry::ClosedForm(ClosedForm::HalfSpace(HalfSpace { normal, .. })) => {
                    Some((-way.dot(self.bodies.poses[ground].orientation * *normal)).max(0.0))
                }
                _ => None,
            }
        };
        let comes = towards(pair.second, of_first).or_else(|| towards(pair.first, -of_first));
        comes.unwrap_or(of_first.length()) + self.turns[pair.first] + self.turns[pair.second]
    }

    /// How far bodies may stray because others come against them on their ways faster than gravity moves what rests, if these are not too many.
    fn by_first_strikes(&mut self, pairs: &[Pair]) -> BTreeMap<usize, Stray> {
        let fast = 2.0 * self.frame.sag();
        let strikes: Vec<(Pair, f64)> =
            pairs.iter().map(|&pair| (pair, self.comes(pair))).filter(|&(_, comes)| comes > fast).collect();
        let mut first = BTreeMap::new();
        if strikes.len() > MOST_MORE {
            return first;
        }
        self.longest = 2.0 * strikes.iter().map(|&(_, comes)| comes).fold(0.0, f64::max);
        for (Pair { first: a, second: b }, comes) in strikes {
            for (i, by) in [(a, b), (b, a)] {
                let stray = self.stray(i, by, comes);
                if stray > 0.0 {
                    first.entry(i).or_insert(Stray::NONE).add(stray, by);
                }
            }
        }
        first
    }

    /// How far those may stray that are struck by bodies that stray themselves, if that is clearly further than is known.
    fn by_next_strikes(&self, reached: &[Pair], strays: &[Stray]) -> BTreeMap<usize, Stray> {
        let mut next = BTreeMap::new();
        for &pair in reached {
            for (i, by) in [(pair.first, pair.second), (pair.second, pair.first)] {
                let by_strays = strays[by].against(i);
                let stray = self.stray(i, by, by_strays + self.comes(pair)).min(self.longest);
                if by_strays > 0.0 && stray > CLEARLY * strays[i].most.0 + self.frame.sag() {
                    next.entry(i).or_insert(strays[i]).add(stray, by);
                }
            }
        }
        next
    }

    /// The pairs of a body with all that it may reach.
    fn reached(&self, i: usize, bounds: &[Bounds]) -> Vec<Pair> {
        let of_body = &bounds[i];
        let poses: &[&[Pose]] = &[&self.bodies.poses, self.ends];
        let is_reached = |&other: &usize| {
            let of_other = &bounds[other];
            other != i
                && !of_other.is_nan()
                && of_body.overlaps(of_other)
                && !(of_other.is_boundless() && is_above(self.bodies, other, of_body, poses))
        };
        let pair = |other: usize| Pair { first: i.min(other), second: i.max(other) };
        (0..bounds.len()).filter(is_reached).map(pair).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::broad_phase::find_swept_pairs;
    use crate::collisions::predict;
    use crate::{Contactant, Motion, NewBody, StepSettings, Velocity};
    use frangible_geometry::Shape;
    use glam::DQuat;
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
        let pairs = find_swept_pairs(&bodies, &ends, frame.dt, frame.sag());
        let Straying { pairs, strays } = find_struck_pairs(&bodies, &ends, pairs, &frame);
        (pairs.iter().map(|pair| [pair.first, pair.second]).collect(), strays)
    }

    /// At 6 m/s the first ball comes 0.2 m far. So far it may push the second one, of the same mass, whose points may come further as it may turn; the
    /// third one is looked for as far as that, and so on. What meets by itself is no further apart for the two that do.
    #[test]
    fn what_is_struck_may_strike_what_it_could_reach() {
        let (pairs, strays) = straying(&[0.0, 0.25, 0.65, 1.1, 5.0], 6.0);
        for wanted in [[0, 1], [1, 2], [2, 3]] {
            assert!(pairs.contains(&wanted), "{pairs:?}");
        }
        assert!(pairs.iter().all(|pair| pair[1] < 4) && pairs.is_sorted_by(|a, b| a < b), "{pairs:?}");
        assert_eq!(strays[1].against(0), 0.0);
        assert!((0.2..=0.4).contains(&strays[1].against(2)), "{strays:?}");
        assert!(strays[3].against(4) > 0.2 && strays[4] == Stray::NONE, "{strays:?}");
    }

    /// What is slower than gravity would make it strikes nobody.
    #[test]
    fn slow_blows_are_none() {
        assert_eq!(straying(&[0.0, 0.2, 0.41], 0.02), (vec![[0, 1]], vec![]));
    }

    /// Of more strikes, pairs or tests than there is time for nothing is known: as many balls as told lie where the first one comes by, some where the
    /// second one might be pushed, and some far away.
    #[test]
    fn crowds_are_left_alone() {
        let known = |on_way: usize, beside: usize, away: usize| {
            let balls = |count: usize, from: f64| (0..count).map(move |number| from + 1e-6 * number as f64);
            let places: Vec<f64> = [0.0]
                .into_iter()
                .chain(balls(on_way, 0.2))
                .chain(balls(beside, 0.7))
                .chain(balls(away, 1e3))
                .collect();
            let (pairs, strays) = straying(&places, 6.0);
            let by_way = pairs.iter().filter(|pair| pair[0] == 0 && pair[1] <= on_way).count();
            assert_eq!(by_way, on_way, "what meets by itself is there in any case");
            let beyond = pairs
                .iter()
                .filter(|pair| pair[0] <= on_way && (on_way + 1..=on_way + beside).contains(&pair[1]));
            (beyond.count() > 0, strays.iter().any(|stray| *stray != Stray::NONE))
        };
        assert_eq!(known(1, 10, 0), (true, true));
        assert_eq!(known(MOST_MORE + 1, 10, 0), (false, false), "strikes");
        assert_eq!(known(1, MOST_MORE + 1, 0), (false, false), "pairs");
        assert_eq!(known(1000, 10, 100), (false, false), "tests");
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
