//! Sequential impulses in substeps, with soft contact and relaxation: one detection, several small steps [Cat24] [Mac19].

mod funds;
mod passes;
mod ranks;
mod rebound;

use crate::clusters::{Cluster, NOWHERE, SETTLED_AFTER, plan};
use crate::contact_batch::{Batch, Touching};
use crate::contact_rows::{Beat, Stage};
use crate::contact_sweep::Given;
use crate::effort::Effort;
use crate::evolve::evolve;
#[cfg(test)]
use crate::instructions::Scalar;
#[cfg(not(test))]
use crate::instructions::with_widest;
use crate::lanes::Instructions;
use crate::ledger::Ledger;
use crate::manifold::{Manifold, ManifoldFinder};
use crate::moving::{Movers, can_rest};
use crate::tally::Cause;
use crate::threads;
use crate::warm_start::{Part, WarmStart};
use crate::{Bodies, BodyId, Frame, Motion, Tally};
use funds::Funds;
use glam::DVec3;
use ranks::{Block, Ranks};

/// Steps in which kinematic bodies turn through a frame.
const TURNS: u32 = 8;

/// Approach speeds below this bounce no more, in units of what gravity gives in a frame: what rests approaches so fast.
const BOUNCE: f64 = 1.0;

/// What the books of contacts may lose to single precision in a frame, of the energy of all motion in a cluster [1]: in 200 random scenes it was 1.1e-4 at most, where two
/// bodies are jammed between two that do not move, and more than 1e-6 in one of two hundred frames. What was lost otherwise shows up as what flight gave, which is none.
const ROUNDING: f64 = 3e-4;

/// What the substeps did besides moving the bodies.
pub struct Solved {
    /// What static and kinematic bodies contributed, and where energy went.
    pub tally: Tally,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub gravity: (DVec3, DVec3),
}

/// Moves all bodies through one frame: cluster by cluster, as none feels another. What `warm` keeps from the last frame is replaced by
/// what acted in this one. Overlaps close as far as what the `ledger` holds pays for it.
pub fn solve(
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    warm: &mut WarmStart,
    ledger: &Ledger,
    frame: &Frame,
) -> Solved {
    #[cfg(not(test))]
    {
        with_widest!(frame.settings.width, solve_with(bodies, manifolds, warm, ledger, frame))
    }
    // Unit tests have one width, whatever is asked for, as each takes as long to compile as the rest of them: tests of whole scenes say that all of them give the same bits.
    #[cfg(test)]
    {
        solve_with::<Scalar>(bodies, manifolds, warm, ledger, frame)
    }
}

/// [`solve`] with some instructions.
fn solve_with<I: Instructions>(
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    warm: &mut WarmStart,
    ledger: &Ledger,
    frame: &Frame,
) -> Solved {
    let carried = warm.of_manifolds(bodies, manifolds);
    let touching = Touching { manifolds, carried: &carried, near: frame.sag() };
    let bodies_now = &*bodies;
    let plan = plan(bodies, touching, warm, frame);
    let numbers: Vec<usize> = (0..plan.clusters.len()).collect();
    let room = || vec![NOWHERE; bodies_now.len()];
    let solve_cluster = |local: &mut Vec<u32>, number| {
        let cluster = Cluster::new(bodies_now, touching, &plan, number, local);
        let substeps = cluster.effort.substeps;
        let step = Frame { dt: frame.dt / f64::from(substeps), ..*frame };
        let mut solver = Solver::<I>::new(bodies_now, cluster, touching, step.dt);
        solver.open(ledger, frame);
        for done in 0..substeps {
            let rest = Frame { dt: f64::from(substeps - done) * step.dt, ..step };
            solver.substep(&rest, &step, frame);
            if done == 0 {
                solver.lie_down(&step);
                if solver.all_rests() {
                    solver.go_on_at_rest(&Frame { dt: rest.dt - step.dt, ..step });
                    break;
                }
            }
        }
        solver.close(frame)
    };
    // Beside them, who sleeps keeps what it carries, and so does who is in balance, which goes on.
    let stay = || plan.sleep.manifolds.iter().chain(&plan.balance.manifolds);
    let keep = || {
        let points = stay().map(|&at| carried[at].len()).sum();
        let mut kept = Part::with_room(stay().count(), points);
        stay().for_each(|&at| kept.keep(at, manifolds[at].pair, carried[at]));
        (kept, plan.balance.onward(bodies_now, (manifolds, &carried), frame))
    };
    let (closed, (kept, onward)) = threads::join(
        manifolds.len(),
        || threads::map_with(numbers, manifolds.len(), room, solve_cluster),
        keep,
    );

    // One after the other, so that sums are the same whoever came first.
    let mut solved = Solved { tally: Tally::default(), gravity: (DVec3::ZERO, DVec3::ZERO) };
    let mut parts = Vec::new();
    let (mut settled, mut is_in_one, mut is_in_heap) =
        (vec![0; bodies.len()], vec![false; bodies.len()], vec![false; bodies.len()]);
    for Closed { movers, kept, tally, is_heap } in closed {
        movers.hand_back(bodies);
        for &i in &movers.who {
            is_in_one[i] = true;
            is_in_heap[i] |= is_heap;
        }
        movers.who_may_rest().for_each(|i| settled[i] = settles(warm, bodies.ids[i]));
        parts.extend(kept);
        solved.tally.add(tally);
        solved.gravity.0 += movers.gravity.0;
        solved.gravity.1 += movers.gravity.1;
    }

    // What sleeps stays, with what it carries.
    let are_asleep = plan.sleep.hold(bodies, manifolds, &mut solved.tally);
    for (i, _) in are_asleep.iter().enumerate().filter(|&(_, &is)| is) {
        is_in_one[i] = true;
        is_in_heap[i] = warm.is_in_heap(bodies.ids[i]);
    }
    // What is in balance goes on.
    let Solved { tally, gravity } = &mut solved;
    onward.go(bodies, (tally, gravity), frame);
    for &i in &onward.who {
        let id = bodies.ids[i];
        (is_in_one[i], is_in_heap[i], settled[i]) = (true, warm.is_in_heap(id), settles(warm, id));
    }
    parts.push(kept);

    fly(bodies, &is_in_one, frame, &mut solved);
    let drowsiness = plan.sleep.drowsiness(bodies, (warm, frame), &are_asleep);
    (*warm, ()) = threads::join(
        manifolds.len(),
        || WarmStart::of_parts(bodies, (manifolds.len(), parts), &settled, &is_in_heap, &drowsiness),
        || solved.tally.find_nets(bodies),
    );
    solved
}

/// In how many frames a body could come to rest that can in this one, too.
fn settles(warm: &WarmStart, id: BodyId) -> u8 {
    warm.settled_for(id).checked_add(1).unwrap_or(SETTLED_AFTER)
}

/// Bodies that may touch nothing, and kinematic ones, for which nothing is in the way.
fn fly(bodies: &mut Bodies, is_in_one: &[bool], frame: &Frame, solved: &mut Solved) {
    let step = Frame { dt: frame.dt / f64::from(TURNS), ..*frame };
    for i in 0..bodies.len() {
        match bodies.motions[i] {
            Motion::Static => {}
            Motion::Kinematic { .. } => {
                let velocity = bodies.velocities[i];
                let end =
                    (0..TURNS).fold(bodies.poses[i], |pose, _| evolve(bodies, i, &pose, &velocity, &step));
                bodies.poses[i] = end;
            }
            Motion::Dynamic if is_in_one[i] => {}
            Motion::Dynamic => {
                let half = 0.5 * frame.dt * frame.gravity;
                let weight = bodies.masses[i] * half;
                bodies.velocities[i].linear += half;
                solved.gravity.1 += bodies.poses[i].position.cross(weight);
                bodies.poses[i] = evolve(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame);
                bodies.velocities[i].linear += half;
                solved.gravity.1 += bodies.poses[i].position.cross(weight);
                solved.gravity.0 += 2.0 * weight;
            }
        }
    }
}

/// A cluster on its way through a frame.
struct Solver<'a, I> {
    bodies: &'a Bodies,
    movers: Movers,
    ranks: Ranks<I>,
    effort: Effort,
    funds: Funds,
}

/// A cluster at the frame's end.
struct Closed {
    movers: Movers,
    kept: Vec<Part>,
    tally: Tally,
    is_heap: bool,
}

impl<'a, I: Instructions> Solver<'a, I> {
    /// Substeps take `dt` [s].
    fn new(bodies: &'a Bodies, cluster: Cluster, touching: Touching, dt: f64) -> Self {
        let Cluster { bodies: who, members, rank_ends, effort } = cluster;
        let movers = Movers::new::<I>(bodies, who);
        let ranks = Ranks::new((bodies, &movers), (&members, &rank_ends), touching, dt);
        let mut solver = Self { bodies, movers, ranks, effort, funds: Funds::UNLIMITED };
        solver.follow(None);
        solver
    }

    /// Finds what there is to close overlaps with, where that matters.
    fn open(&mut self, ledger: &Ledger, frame: &Frame) {
        let Self { bodies, movers, funds, effort, .. } = self;
        if !effort.carries_much && frame.settings.ledger {
            let most = frame.settings.bank_cap * movers.mass();
            *funds = Funds::new(ledger.bank_of(bodies, &movers.who), most);
        }
    }

    /// Visits all batches, in blocks, in any order.
    fn each(&mut self, visit: impl Fn(&Movers, &mut Block<I>) + Send + Sync) {
        let Self { movers, ranks, .. } = self;
        threads::for_each(&mut ranks.blocks, ranks.pairs, |block| visit(movers, block));
    }

    /// Visits all batches in the order of their ranks, or backwards.
    fn each_in_turn(
        &mut self,
        is_fro: bool,
        visit: impl Fn(&Movers, &mut Block<I>, &[Batch<I>]) + Send + Sync,
    ) {
        let Self { movers, ranks, .. } = self;
        ranks.for_each_in_turn(is_fro, None, &|block, next| visit(movers, block, next));
    }

    /// Half kick, impulses, drift, half kick, bounce, relax, of all that does not rest. `rest` is what is left of the frame.
    fn substep(&mut self, rest: &Frame, step: &Frame, frame: &Frame) {
        self.refresh(rest);
        self.movers.kick(step, Stage::BeforeDrift);
        let threshold = BOUNCE * frame.gravity.length() * frame.dt;
        let before = Beat { parting: self.funds.parting, ..Beat::new(Stage::BeforeDrift, step) };
        self.meet_and_go_on((&before, step), threshold);
        let rebounds = self.rebounds();
        if rebounds {
            self.expect_rebounds();
        }
        self.contact(&before, threshold);
        self.movers.drift::<I>(self.bodies, step);
        self.movers.kick(step, Stage::AfterDrift);
        let after = Beat::new(Stage::AfterDrift, step);
        if rebounds && self.effort.impacts > 1 {
            self.follow(Some(step.dt));
            self.rebound(step, threshold);
            self.go_on(&after);
        } else {
            self.follow_and_go_on(&after);
            if rebounds {
                self.rebound(step, threshold);
            }
        }
        self.contact(&after, threshold);
        self.end_meeting();
        self.spend();
    }

    /// What it gave, and what closing all overlaps would have taken.
    fn spend(&mut self) {
        let Self { movers, ranks, funds, .. } = self;
        let sum = |of: fn(&Given<I>) -> f64| ranks.blocks.iter().map(|block| of(&block.given)).sum::<f64>();
        funds.spend(sum(Given::energy) + movers.held().energy, sum(|given| given.wanted.sum()));
    }

    /// What is calm comes to rest.
    fn lie_down(&mut self, step: &Frame) {
        if !self.effort.rests() || !can_rest(step) {
            return;
        }
        self.movers.find_who_may_rest(step.dt);
        self.each_in_turn(false, |movers, block, _| {
            I::run(
                #[inline(always)]
                || block.batches.iter_mut().for_each(|batch| batch.lie_down(movers)),
            );
            block.rests = block.batches.iter().any(|batch| batch.rests);
        });
        self.each_in_turn(false, |movers, block, next| {
            block.visit(
                next,
                #[inline(always)]
                |next| next.prefetch(movers, next.near_rows),
                #[inline(always)]
                |batch, _| batch.lean(movers),
            );
        });
    }

    /// Whether everything has come to rest, and nothing that is driven is near.
    fn all_rests(&self) -> bool {
        self.movers.all_rest() && !self.ranks.blocks.iter().any(|block| block.is_driven)
    }

    /// What all rests goes on as it moves, in one go.
    fn go_on_at_rest(&mut self, rest: &Frame) {
        self.movers.kick(rest, Stage::BeforeDrift);
        self.movers.drift::<I>(self.bodies, rest);
        self.movers.kick(rest, Stage::AfterDrift);
    }

    /// Points that have moved too far are found anew.
    fn refresh(&mut self, rest: &Frame) {
        let Self { bodies, movers, ranks, .. } = self;
        threads::for_each_with(&mut ranks.blocks, ranks.pairs, ManifoldFinder::default, |finder, block| {
            block.refresh((bodies, movers), finder, rest);
        });
    }

    /// Who meets in this substep, as fast as gravity's kick left them; then what acted in the last one acts again: block by block, as the rows of heaps come from
    /// memory each time.
    fn meet_and_go_on(&mut self, (beat, step): (&Beat, &Frame), threshold: f64) {
        let bodies = self.bodies;
        self.each_in_turn(false, |movers, block, next| {
            block.meet((bodies, movers), step, threshold);
            block.go_on(movers, beat, next);
        });
    }

    /// All points go with their bodies.
    fn follow(&mut self, drifted: Option<f64>) {
        let bodies = self.bodies;
        self.each(|movers, block| {
            block.follow((bodies, movers), drifted);
            block.find_stale();
        });
    }

    /// What acted in the last substep acts again, unless it has come apart.
    fn go_on(&mut self, beat: &Beat) {
        self.each_in_turn(false, |movers, block, next| block.go_on(movers, beat, next));
    }

    /// All points go with their bodies after a drift; then what acted in the last substep acts again, unless it has come apart: block by block, as above.
    fn follow_and_go_on(&mut self, beat: &Beat) {
        let bodies = self.bodies;
        self.each_in_turn(false, |movers, block, next| {
            block.follow((bodies, movers), Some(beat.dt));
            block.go_on(movers, beat, next);
            block.find_stale();
        });
    }

    /// At the frame's end.
    fn close(self, frame: &Frame) -> Closed {
        let Self { bodies, movers, ranks, effort, .. } = self;
        let (mut kept, mut all) = (Vec::new(), Tally::default());
        all.links.reserve(ranks.pairs);
        all.given.reserve(ranks.pairs);
        for (part, tally) in threads::map(ranks.blocks, ranks.pairs, |block| block.close(bodies, &movers)) {
            kept.push(part);
            all.add(tally);
        }
        let held = movers.held();
        all.outside_impulse += held.impulse;
        all.outside_angular_impulse += held.moment;
        all.causes.add(Cause::Contact, held.energy);

        // Contacts have told what they gave in single precision: what its rounding has lost is told here, and no more than that.
        let [gained, motion] = movers.gained(bodies, frame);
        let most = ROUNDING * motion;
        all.causes.add(Cause::Contact, (gained - all.causes.sum()).max(-most).min(most));
        Closed { movers, kept, tally: all, is_heap: effort.is_for_heap() }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::broad_phase::find_swept_pairs;
    use crate::clusters::Member;
    use crate::collisions::predict;
    use crate::manifold::find_manifolds;
    use crate::pair::Pair;
    use crate::{Contactant, NewBody, Pose, StepSettings, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// What all rests ends its frame where it would in substeps, with the same books: a ball on another one, in a first frame in which it has come to rest.
    #[test]
    fn what_all_rests_goes_on_in_one_step() {
        let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
        let mut bodies = Bodies::default();
        let creeping = Velocity { linear: 5e-5 * DVec3::X, angular_momentum: 1e-6 * DVec3::Y };
        for (motion, height, velocity) in
            [(Motion::Static, 0.0, Velocity::default()), (Motion::Dynamic, 1.0, creeping)]
        {
            bodies.spawn(NewBody {
                shape: shape.clone(),
                density: 1.0,
                motion,
                pose: Pose { position: height * DVec3::Y, orientation: DQuat::IDENTITY },
                velocity,
                contactant: Contactant::new(0.0, 0.5),
            });
        }
        let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let effort = Effort::of_size(1);
        let substeps = effort.substeps;
        let step = Frame { dt: frame.dt / f64::from(substeps), ..frame };
        let found = find_manifolds(&bodies, &[Pair { first: 0, second: 1 }], &WarmStart::default(), &frame);
        let manifolds: Vec<Manifold> = found.iter().collect();
        let touching = Touching { manifolds: &manifolds, carried: &[&[]], near: frame.sag() };
        let at_rest = || {
            let member = Member { manifold: 0, locals: [0, 1], stiffness: 1.0, is_in_heap: false };
            let (members, rank_ends) = (vec![member], vec![vec![1]]);
            let cluster = Cluster { bodies: vec![0, 1], members, rank_ends, effort };
            let mut solver = Solver::<Scalar>::new(&bodies, cluster, touching, step.dt);
            // Nothing has moved it yet, so that it is seen to be calm.
            solver.lie_down(&step);
            assert!(solver.all_rests());
            solver
        };
        let (mut in_one, mut in_steps) = (at_rest(), at_rest());
        in_one.go_on_at_rest(&frame);
        for done in 0..substeps {
            let rest = Frame { dt: f64::from(substeps - done) * step.dt, ..frame };
            in_steps.substep(&rest, &step, &frame);
        }
        let [(one, one_velocity), (steps, steps_velocity)] =
            [&in_one, &in_steps].map(|solver| solver.movers.state(&bodies, 1));
        assert!(
            (one.position - steps.position).length() < 1e-15 && one.position.x > 1.6e-6,
            "{one:?} {steps:?}"
        );
        assert!(one.orientation.dot(steps.orientation) > 1.0 - 1e-15);
        assert_eq!((one_velocity, steps_velocity), (creeping, creeping));
        let [a, b] = [&in_one, &in_steps].map(|solver| (solver.movers.gravity, solver.movers.held()));
        let weight = bodies.masses[1] * frame.dt * frame.gravity;
        assert!((a.0.0 - weight).length() < 1e-12 && (a.1.impulse + weight).length() < 1e-12);
        assert!((a.0.1 - b.0.1).length() < 1e-12 && (a.1.moment - b.1.moment).length() < 1e-12);
        assert!((a.1.energy - b.1.energy).abs() < 1e-12);
    }

    /// Frame by frame it is counted for how long a ball could rest that lies on another one, until it is pushed; one that falls could not.
    #[test]
    fn who_could_rest_is_counted() {
        let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1));
        let mut bodies = Bodies::default();
        for (motion, position) in
            [(Motion::Static, DVec3::ZERO), (Motion::Dynamic, DVec3::Y), (Motion::Dynamic, 1e3 * DVec3::Y)]
        {
            bodies.spawn(NewBody {
                shape: shape.clone(),
                density: 1.0,
                motion,
                pose: Pose { position, orientation: DQuat::IDENTITY },
                velocity: Velocity::default(),
                contactant: Contactant::new(0.0, 0.5),
            });
        }
        // Without a ledger there is enough to close its overlap with, from a frame's first substep on.
        let settings = StepSettings { ledger: false, ..StepSettings::default() };
        let frame = Frame { dt: 1.0 / 30.0, gravity: -9.81 * DVec3::Y, settings };
        let mut warm = WarmStart::default();
        let mut go_on = |bodies: &mut Bodies| {
            let ends = predict(bodies, &frame);
            let pairs = find_swept_pairs(bodies, &ends, frame.sag(), &frame);
            let found = find_manifolds(bodies, &pairs, &warm, &frame);
            let manifolds: Vec<Manifold> = found.iter().collect();
            solve(bodies, &manifolds, &mut warm, &Ledger::default(), &frame);
            [1, 2].map(|i| warm.settled_for(bodies.ids[i]))
        };
        // Its overlap has to come to what carries it first.
        (0..30).for_each(|_| _ = go_on(&mut bodies));
        let [begin, falls] = go_on(&mut bodies);
        assert!(begin > 0 && falls == 0, "{begin} {falls}");
        for more in 1..4 {
            assert_eq!(go_on(&mut bodies), [begin + more, 0]);
        }
        bodies.velocities[1].linear.y = 1.0;
        assert_eq!(go_on(&mut bodies), [0, 0]);
    }
}
