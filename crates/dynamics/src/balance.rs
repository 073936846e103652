//! Islands in balance: what their contacts gave in the last frame is what holds them in this one. So it solves this frame as well, and nothing is left to
//! be done but to let them go on.

use crate::contact_batch::Touching;
use crate::evolve::evolve_these;
use crate::instructions::prefetch;
use crate::manifold::{Manifold, ManifoldPoint};
use crate::moving::{can_rest, is_calm};
use crate::pair::Pair;
use crate::tally::{Cause, Tally};
use crate::threads;
use crate::warm_start::{Carried, WarmStart};
use crate::{Bodies, BodyId, Frame, Motion, Pose, Velocity};
use glam::DVec3;

/// An island is solved in one of so many frames even if it is in balance: what creeps is stopped, and what overlaps parts.
const SOLVED_EVERY: u64 = 8;

/// Pairs of whose memory one is asked for before it is looked at.
const AHEAD: usize = 3;

/// The islands whose forces are in balance; the ledger balances books.
#[derive(Default)]
pub(crate) struct Balance {
    /// Their manifolds.
    pub(crate) manifolds: Vec<usize>,
}

/// What acts on a body: forces [N], and their torque about its centre of mass [N m].
#[derive(Clone, Copy, Default)]
struct Load {
    force: DVec3,
    torque: DVec3,
    /// Whether it has yet to be looked at.
    is_open: bool,
}

impl Balance {
    /// Takes those islands out that are in balance in this frame: all of their bodies have `settled`, the contacts that carried in the last frame are still there, and
    /// what they gave holds each body against gravity.
    pub(crate) fn take_out(
        bodies: &Bodies,
        touching: Touching,
        islands: &mut Vec<Vec<usize>>,
        (settled, warm, frame): (&[bool], &WarmStart, &Frame),
    ) -> Self {
        if !can_rest(frame) {
            return Self::default();
        }
        let island = Island { bodies, touching, frame };
        let may_be = |at: &usize| {
            let Manifold { pair: Pair { first, second }, struck, .. } = touching.manifolds[*at];
            settled[first] && settled[second] && struck == 0.0
        };
        let is_solved = |i: usize| {
            let turn = u64::from(warm.settled_for(bodies.ids[i])) + u64::from(bodies.ids[i].index);
            turn % SOLVED_EVERY == 0
        };
        let first_mobile = |island: &[usize]| {
            let Pair { first, second } = touching.manifolds[island[0]].pair;
            if bodies.motions[first] == Motion::Dynamic { first } else { second }
        };
        let may_balance = |island: &Vec<usize>| island.iter().all(may_be) && !is_solved(first_mobile(island));
        let (candidates, mut others): (Vec<_>, Vec<_>) =
            std::mem::take(islands).into_iter().partition(may_balance);
        let pairs = candidates.iter().map(Vec::len).sum();
        let room = || vec![Load::default(); bodies.len()];
        let balances =
            |loads: &mut Vec<Load>, pairs: Vec<usize>| (island.is_in_balance(&pairs, loads), pairs);
        let mut balance = Self::default();
        for (is_in_balance, pairs) in threads::map_with(candidates, pairs, room, balances) {
            if is_in_balance {
                balance.manifolds.extend(pairs);
            } else {
                others.push(pairs);
            }
        }
        *islands = others;
        balance
    }

    /// Their bodies go on as they move: who they are, and where they get to.
    pub(crate) fn onward(
        &self,
        bodies: &Bodies,
        (manifolds, carried): (&[Manifold], &[&[Carried]]),
        frame: &Frame,
    ) -> Onward {
        let (mut who, mut links) = (Vec::new(), Vec::with_capacity(self.manifolds.len()));
        let mut are_balanced = vec![false; bodies.len()];
        for (pair, carried) in self.manifolds.iter().map(|&at| (manifolds[at].pair, carried[at])) {
            if !carried.is_empty() {
                links.push((bodies.ids[pair.first], bodies.ids[pair.second]));
            }
            for i in [pair.first, pair.second] {
                if bodies.motions[i] == Motion::Dynamic && !std::mem::replace(&mut are_balanced[i], true) {
                    who.push(i);
                }
            }
        }
        let ends = evolve_these(bodies, &who, (&bodies.poses, &bodies.velocities), frame);
        Onward { who, ends, links }
    }
}

/// Bodies in balance in a frame.
pub(crate) struct Onward {
    pub(crate) who: Vec<usize>,
    /// Where each of them gets to.
    ends: Vec<Pose>,
    /// Pairs that carried.
    links: Vec<(BodyId, BodyId)>,
}

impl Onward {
    /// The bodies go where they get to. What gravity gives them is taken by what they stand on.
    pub(crate) fn go(
        &self,
        bodies: &mut Bodies,
        (tally, gravity): (&mut Tally, &mut (DVec3, DVec3)),
        frame: &Frame,
    ) {
        let gain = frame.dt * frame.gravity;
        tally.links.extend(&self.links);
        for (&i, &end) in self.who.iter().zip(&self.ends) {
            let start = std::mem::replace(&mut bodies.poses[i], end);
            let weight = bodies.masses[i] * gain;
            let moment = (0.5 * (start.position + end.position)).cross(weight);
            gravity.0 += weight;
            gravity.1 += moment;
            tally.outside_impulse -= weight;
            tally.outside_angular_impulse -= moment;
            tally.causes.add(Cause::Contact, -bodies.velocities[i].linear.dot(weight));
        }
    }
}

/// What an island is looked at with.
#[derive(Clone, Copy)]
struct Island<'a> {
    bodies: &'a Bodies,
    touching: Touching<'a>,
    frame: &'a Frame,
}

impl Island<'_> {
    /// Whether what acted in the last frame holds all bodies of some pairs. `loads` are nothing, and are so again at the end.
    fn is_in_balance(self, pairs: &[usize], loads: &mut [Load]) -> bool {
        let mut holds = true;
        for (turn, &at) in pairs.iter().enumerate() {
            if let Some(&next) = pairs.get(turn + AHEAD) {
                prefetch(self.touching.manifolds[next].points);
                prefetch(self.touching.carried[next]);
            }
            holds &= self.add_loads(at, loads);
        }
        for &at in pairs {
            let Pair { first, second } = self.touching.manifolds[at].pair;
            for i in [first, second] {
                let load = std::mem::take(&mut loads[i]);
                holds &= !load.is_open || self.is_held(i, load);
            }
        }
        holds
    }

    /// What the points of a pair gave acts on its bodies. Whether all of them are still there, and would press.
    fn add_loads(self, at: usize, loads: &mut [Load]) -> bool {
        let Manifold { pair, points, .. } = self.touching.manifolds[at];
        let Pair { first, second } = pair;
        let poses = [first, second].map(|i| &self.bodies.poses[i]);
        loads[first].is_open = true;
        loads[second].is_open = true;
        for Carried { sample, forces: [before, after] } in self.touching.carried[at] {
            let Some(point) = points.iter().find(|point| point.sample == *sample) else { return false };
            let force = (before.force + after.force).as_dvec3();
            if force.dot(point.normal) < 0.0 {
                return false;
            }
            let twist = (before.twist + after.twist).as_dvec3();
            let [lever, other_lever] = levers(point, poses);
            loads[first].add(force, lever.cross(force) + twist);
            loads[second].add(-force, -(other_lever.cross(force) + twist));
        }
        true
    }

    /// Whether what its load and gravity leave of each other keeps a body calm.
    fn is_held(self, i: usize, Load { force, torque, .. }: Load) -> bool {
        let Self { bodies, frame, .. } = self;
        if bodies.motions[i] != Motion::Dynamic {
            return true;
        }
        let gained = Velocity {
            linear: frame.dt * (bodies.inertias[i].inverse_mass * force + frame.gravity),
            angular_momentum: frame.dt * torque,
        };
        let spin = bodies.spin(i, &bodies.poses[i], &gained);
        is_calm(gained.linear.length() + bodies.radii[i] * spin.length())
    }
}

impl Load {
    fn add(&mut self, force: DVec3, torque: DVec3) {
        self.force += force;
        self.torque += torque;
    }
}

/// From both centres of mass to where a point acts, which is between the surfaces, beside the corner that slides along the other body [m].
fn levers(point: &ManifoldPoint, [first, second]: [&Pose; 2]) -> [DVec3; 2] {
    let between = first.position - second.position;
    let half = 0.5 * point.gap;
    if point.sample.0 {
        let lever = first.orientation * point.anchor_first - (point.rounding[0] + half) * point.normal;
        [lever, lever + between]
    } else {
        let lever = second.orientation * point.anchor_second + (point.rounding[1] + half) * point.normal;
        [lever - between, lever]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::broad_phase::find_swept_pairs;
    use crate::clusters::has_settled;
    use crate::collisions::predict;
    use crate::ledger::{Ledger, energy};
    use crate::manifold::{Manifolds, find_manifolds};
    use crate::substeps::{Solved, solve};
    use crate::{Contactant, NewBody, StepSettings};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// Two cubes on each other on a third one that does not move, after so many frames.
    struct Stack {
        bodies: Bodies,
        warm: WarmStart,
        frame: Frame,
    }

    impl Stack {
        fn after(frames: usize) -> Self {
            // Without a ledger there is enough to close overlaps with.
            let settings = StepSettings { ledger: false, ..StepSettings::default() };
            let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings };
            let mut stack = Self { bodies: Bodies::default(), warm: WarmStart::default(), frame };
            for (motion, height) in [(Motion::Static, 0.0), (Motion::Dynamic, 1.0), (Motion::Dynamic, 2.0)] {
                stack.bodies.spawn(NewBody {
                    shape: Arc::new(Shape::closed_form(ClosedForm::Box { half: DVec3::splat(0.5) }, 0.1)),
                    density: 1.0,
                    motion,
                    pose: Pose { position: height * DVec3::Y, orientation: DQuat::IDENTITY },
                    velocity: Velocity::default(),
                    contactant: Contactant::new(0.0, 0.5),
                });
            }
            (0..frames).for_each(|_| {
                stack.step();
            });
            stack
        }

        fn manifolds(&self) -> Manifolds {
            let ends = predict(&self.bodies, &self.frame);
            let pairs = find_swept_pairs(&self.bodies, &ends, self.frame.sag(), &self.frame);
            find_manifolds(&self.bodies, &pairs, &self.warm, &self.frame)
        }

        fn step(&mut self) -> Solved {
            let found = self.manifolds();
            let manifolds: Vec<Manifold> = found.iter().collect();
            solve(&mut self.bodies, &manifolds, &mut self.warm, &Ledger::default(), &self.frame)
        }

        /// Whether it is in balance in the next frame, with another look at its manifolds.
        fn is_in_balance(&self, look: impl Fn(&mut Vec<Manifold>)) -> bool {
            let Self { bodies, warm, frame, .. } = self;
            let found = self.manifolds();
            let mut manifolds: Vec<Manifold> = found.iter().collect();
            look(&mut manifolds);
            let carried = warm.of_manifolds(bodies, &manifolds);
            let touching = Touching { manifolds: &manifolds, carried: &carried, near: frame.sag() };
            let settled: Vec<bool> = (0..bodies.len()).map(|i| has_settled(bodies, i, warm)).collect();
            let mut islands = vec![(0..manifolds.len()).collect()];
            let balance = Balance::take_out(bodies, touching, &mut islands, (&settled, warm, frame));
            assert_eq!(islands.is_empty(), !balance.manifolds.is_empty());
            islands.is_empty()
        }

        fn energy(&self) -> f64 {
            let Self { bodies, frame, .. } = self;
            let of = |i: usize| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity);
            (1..bodies.len()).map(of).sum()
        }
    }

    /// What stands is in balance in most frames, but not in all: it goes on as it moves, carries what it carried, and all is booked.
    #[test]
    fn what_is_in_balance_goes_on_as_it_moves() {
        /// The frame in which it creeps.
        const CREEPS: usize = 10;
        let mut stack = Stack::after(80);
        let mut balanced = 0;
        for _ in 0..24 {
            if !stack.is_in_balance(|_| {}) {
                stack.step();
                continue;
            }
            balanced += 1;
            if balanced == CREEPS {
                stack.bodies.velocities[2].linear.y = -5e-5;
            }
            let (bodies, energy) = (stack.bodies.clone(), stack.energy());
            let carried = |stack: &Stack| {
                [(0, 1), (1, 2)]
                    .map(|(first, second)| stack.warm.of_pair(&stack.bodies, Pair { first, second }).to_vec())
            };
            let before = carried(&stack);
            let Solved { tally, gravity } = stack.step();
            assert_eq!(carried(&stack), before);
            assert_eq!(stack.bodies.velocities, bodies.velocities);
            for i in 1..3 {
                let end = bodies.poses[i].position + stack.frame.dt * bodies.velocities[i].linear;
                assert_eq!(stack.bodies.poses[i].position, end);
            }
            let weight = 2.0 * stack.frame.dt * stack.frame.gravity;
            assert!(
                (gravity.0 - weight).length() < 1e-12 && (tally.outside_impulse + weight).length() < 1e-12
            );
            assert!((gravity.1 + tally.outside_angular_impulse).length() < 1e-12);
            assert!((tally.causes.sum() - (stack.energy() - energy)).abs() < 1e-14);
            assert!(balanced != CREEPS || tally.causes.sum() < -1e-5, "contacts take what gravity gives");
            assert_eq!(tally.links.len(), 2);
        }
        assert!((CREEPS..=21).contains(&balanced), "{balanced}");
    }

    /// What its contacts do not hold, or is about to be struck, is not in balance; nor is anything before it has settled.
    #[test]
    fn what_nothing_holds_is_not_in_balance() {
        let stack = (40..48).map(Stack::after).find(|stack| stack.is_in_balance(|_| {}));
        let mut stack = stack.expect("it is in seven of eight frames");
        assert!(!stack.is_in_balance(|manifolds| manifolds[1].struck = 1.0));
        assert!(!stack.is_in_balance(|manifolds| {
            manifolds.pop();
        }));
        assert!(!stack.is_in_balance(|manifolds| {
            let points = manifolds[0].points;
            manifolds[0].points = &points[1..];
        }));
        let found = stack.manifolds();
        let turned = |point: &ManifoldPoint| ManifoldPoint { normal: -point.normal, ..*point };
        let turned: Vec<ManifoldPoint> =
            found.iter().take(1).flat_map(|manifold| manifold.points).map(turned).collect();
        let turned: &[ManifoldPoint] = turned.leak();
        assert!(!turned.is_empty() && !stack.is_in_balance(|manifolds| manifolds[0].points = turned));
        let gravity = stack.frame.gravity;
        stack.frame.gravity = 1.001 * gravity;
        assert!(!stack.is_in_balance(|_| {}));
        stack.frame.gravity = gravity + 0.01 * DVec3::X;
        assert!(!stack.is_in_balance(|_| {}));
        stack.frame.gravity = gravity;
        assert!(stack.is_in_balance(|_| {}));
        stack.bodies.velocities[2].linear.x = 1e-3;
        assert!(!stack.is_in_balance(|_| {}));
        assert!((0..8).map(Stack::after).all(|stack| !stack.is_in_balance(|_| {})));
    }
}
