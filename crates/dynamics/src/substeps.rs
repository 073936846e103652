//! Sequential impulses in substeps, with soft contact and relaxation: one detection, several small steps [Cat24] [Mac19].

use crate::clusters::{Cluster, Member, clusters};
use crate::contact_batch::Batch;
use crate::contact_rows::{Beat, Stage};
use crate::contact_sweep::{Given, Pass};
use crate::evolve::evolve;
#[cfg(target_arch = "x86_64")]
use crate::instructions::{Avx2, Avx512, Sse2};
use crate::instructions::{Scalar, available};
use crate::lanes::{Instructions, Mask};
use crate::manifold::{Manifold, ManifoldFinder};
use crate::moving::Movers;
use crate::rebounds::Reached;
use crate::warm_start::{Carried, WarmStart};
use crate::{Bodies, Frame, Motion, Pose, Tally, Width};
use glam::DVec3;

/// Steps in which kinematic bodies turn through a frame.
const TURNS: u32 = 8;

/// Approach speeds below this bounce no more, in units of what gravity gives in a frame: what rests approaches so fast.
const BOUNCE: f64 = 1.0;

/// Passes over the points that meet fast in a substep, to stop them and to let them bounce.
const MEETING_PASSES: u32 = 4;

/// The most impacts that follow each other in a substep; others follow in the next one.
const IMPACTS: u32 = 32;

/// What the substeps did besides moving the bodies.
pub struct Solved {
    /// What static and kinematic bodies contributed, and where energy went.
    pub tally: Tally,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub gravity: (DVec3, DVec3),
}

/// Moves all bodies through one frame: cluster by cluster, as none feels another. What `warm` keeps from the last frame is replaced by
/// what acted in this one.
pub fn solve(bodies: &mut Bodies, manifolds: &[Manifold], warm: &mut WarmStart, frame: &Frame) -> Solved {
    let mut solved = Solved { tally: Tally::default(), gravity: (DVec3::ZERO, DVec3::ZERO) };
    match available(frame.settings.width) {
        Width::Scalar => solve_with::<Scalar>(bodies, manifolds, warm, frame, &mut solved),
        #[cfg(target_arch = "x86_64")]
        Width::Sse2 => solve_with::<Sse2>(bodies, manifolds, warm, frame, &mut solved),
        #[cfg(target_arch = "x86_64")]
        Width::Avx2 => solve_with::<Avx2>(bodies, manifolds, warm, frame, &mut solved),
        #[cfg(target_arch = "x86_64")]
        Width::Avx512 => solve_with::<Avx512>(bodies, manifolds, warm, frame, &mut solved),
        #[cfg(not(target_arch = "x86_64"))]
        Width::Sse2 | Width::Avx2 | Width::Avx512 => {
            solve_with::<Scalar>(bodies, manifolds, warm, frame, &mut solved)
        }
    }
    solved
}

/// [`solve`] with some instructions.
fn solve_with<I: Instructions>(
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    warm: &mut WarmStart,
    frame: &Frame,
    solved: &mut Solved,
) {
    let (clusters, is_in_one) = clusters(bodies, manifolds, frame);
    let starts = bodies.poses.clone();
    let mut kept = WarmStart::with_room(manifolds.len());
    let carried = warm.of_manifolds(bodies, manifolds);
    for cluster in &clusters {
        // Kinematic bodies go the same way in each.
        let kinematic = |&i: &usize| matches!(bodies.motions[i], Motion::Kinematic { .. });
        let driven: Vec<usize> = cluster.bodies.iter().copied().filter(kinematic).collect();
        driven.into_iter().for_each(|i| bodies.poses[i] = starts[i]);
        let substeps = cluster.effort.substeps;
        let step = Frame { dt: frame.dt / f64::from(substeps), ..*frame };
        let mut solver = Solver::<I>::new(bodies, cluster, manifolds, (&carried, &step));
        for done in 0..substeps {
            let rest = Frame { dt: f64::from(substeps - done) * step.dt, ..step };
            solver.substep(&rest, &step, frame);
        }
        solver.close(&mut kept, solved);
    }
    fly(bodies, &is_in_one, &starts, frame, solved);
    kept.put_in_order();
    *warm = kept;
}

/// Bodies that may touch nothing, and kinematic ones, for which nothing is in the way.
fn fly(bodies: &mut Bodies, is_in_one: &[bool], starts: &[Pose], frame: &Frame, solved: &mut Solved) {
    let step = Frame { dt: frame.dt / f64::from(TURNS), ..*frame };
    for i in 0..bodies.len() {
        match bodies.motions[i] {
            Motion::Static => {}
            Motion::Kinematic { .. } => {
                let velocity = bodies.velocities[i];
                let end = (0..TURNS).fold(starts[i], |pose, _| evolve(bodies, i, &pose, &velocity, &step));
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

/// Batches of which fewer than this are all in the core's own cache.
const FAR: usize = 256;

/// Visits all batches, to or fro. Of many, it asks for the memory of the next ones first.
#[inline(always)]
fn each<I: Instructions>(
    batches: &mut [Batch<I>],
    movers: &mut Movers,
    is_fro: bool,
    mut visit: impl FnMut(&mut Batch<I>, &mut Movers),
) {
    let count = batches.len();
    for step in 0..count {
        let at = if is_fro { count - 1 - step } else { step };
        if count > FAR {
            let ahead = |by: usize| if is_fro { at.saturating_sub(by) } else { (at + by).min(count - 1) };
            I::prefetch(&batches[ahead(2)..][..1]);
            batches[ahead(1)].prefetch(movers);
        }
        visit(&mut batches[at], movers);
    }
}

/// A cluster on its way through a frame.
struct Solver<'a, I> {
    bodies: &'a mut Bodies,
    movers: Movers,
    batches: Vec<Batch<I>>,
    finder: ManifoldFinder,
    given: Given<I>,
    tally: Tally,
    passes: u32,
}

impl<'a, I: Instructions> Solver<'a, I> {
    fn new(
        bodies: &'a mut Bodies,
        cluster: &Cluster,
        manifolds: &[Manifold],
        with: (&[&[Carried]], &Frame),
    ) -> Self {
        let movers = Movers::new::<I>(bodies, cluster.bodies.clone());
        let batch = |group: &Vec<Member>| Batch::new(bodies, &movers, group, manifolds, with);
        let batches = cluster.groups.iter().map(batch).collect();
        let mut solver = Self {
            bodies,
            movers,
            batches,
            finder: ManifoldFinder::default(),
            given: Given::ZERO,
            tally: Tally::default(),
            passes: cluster.effort.passes,
        };
        solver.follow(None);
        solver
    }

    /// Half kick, impulses, drift, half kick, bounce, relax. `rest` is what is left of the frame.
    fn substep(&mut self, rest: &Frame, step: &Frame, frame: &Frame) {
        self.refresh(rest);
        self.movers.kick(step);
        let threshold = BOUNCE * frame.gravity.length() * frame.dt;
        self.meet(step, threshold);
        let rebounds = self.batches.iter().any(|batch| batch.rebounding().any());
        if rebounds {
            self.batches.iter_mut().for_each(Batch::note_starts);
        }
        self.contact(&Beat::new(Stage::BeforeDrift, step));
        self.movers.drift::<I>(self.bodies, step);
        self.movers.kick(step);
        self.follow(Some(step.dt));
        if rebounds {
            self.rebound(step, threshold);
        }
        self.contact(&Beat::new(Stage::AfterDrift, step));
        self.end_meeting();
    }

    /// Points that have moved too far are found anew.
    fn refresh(&mut self, rest: &Frame) {
        let Self { bodies, movers, batches, finder, .. } = self;
        for batch in batches {
            if batch.refresh(bodies, movers, finder, rest) {
                I::run(
                    #[inline(always)]
                    || batch.follow(movers, None),
                );
            }
        }
    }

    /// Who meets in this substep.
    fn meet(&mut self, step: &Frame, threshold: f64) {
        let Self { bodies, movers, batches, .. } = self;
        batches.iter_mut().for_each(|batch| batch.be_driven(bodies, Some(step.dt)));
        I::run(
            #[inline(always)]
            || {
                each(
                    batches,
                    movers,
                    false,
                    #[inline(always)]
                    |batch, movers| batch.meet(movers, threshold, step),
                );
            },
        );
    }

    /// All points go with their bodies.
    fn follow(&mut self, drifted: Option<f64>) {
        let Self { bodies, movers, batches, .. } = self;
        I::run(
            #[inline(always)]
            || {
                each(
                    batches,
                    movers,
                    false,
                    #[inline(always)]
                    |batch, movers| batch.follow(movers, drifted),
                );
            },
        );
        for batch in batches.iter_mut() {
            batch.be_driven(bodies, None);
            if let Some(dt) = drifted {
                batch.forget_driven(movers, dt);
            }
        }
    }

    /// Contact at one stage of a substep: what acted at this stage of the last one, then passes over all rows, to and fro, so that none
    /// always has the last word and stacks do not lean. What meets now has no impulses to start from, and takes more passes, its normals
    /// first.
    fn contact(&mut self, beat: &Beat) {
        self.go_on(beat);
        self.pass(beat, Pass::TOGETHER);
        let begins_fro = self.passes % 2 == 1 && beat.stage == Stage::AfterDrift;
        for number in 0..self.passes {
            let is_fro = (number % 2 == 1) != begins_fro;
            self.pass(beat, Pass::over_all(is_fro, number + 1 == self.passes));
        }
        for _ in 2..MEETING_PASSES {
            self.pass(beat, Pass::MEETING);
        }
        self.pass(beat, Pass::LAST_MEETING);
    }

    /// What acted in the last substep acts again, unless it has come apart.
    fn go_on(&mut self, beat: &Beat) {
        let Self { movers, batches, given, .. } = self;
        I::run(
            #[inline(always)]
            || {
                each(
                    batches,
                    movers,
                    false,
                    #[inline(always)]
                    |batch, movers| batch.go_on(movers, beat, given),
                );
            },
        );
    }

    /// One pass over all rows.
    fn pass(&mut self, beat: &Beat, pass: Pass) {
        let Self { movers, batches, given, .. } = self;
        I::run(
            #[inline(always)]
            || {
                if pass.only_meeting {
                    for batch in batches.iter_mut().filter(|batch| batch.meets(beat)) {
                        batch.act(movers, beat, pass, given);
                    }
                    return;
                }
                each(
                    batches,
                    movers,
                    pass.is_fro,
                    #[inline(always)]
                    |batch, movers| batch.act(movers, beat, pass, given),
                );
            },
        );
    }

    /// What met fast leaves again, by impacts that follow each other.
    fn rebound(&mut self, step: &Frame, threshold: f64) {
        let beat = &Beat::new(Stage::Bounce, step);
        let Self { movers, batches, given, .. } = self;
        let mut reached = Reached::none(movers);
        I::run(
            #[inline(always)]
            || {
                let (mut spreads, mut is_fro) = (true, false);
                while spreads {
                    spreads = false;
                    each(
                        batches,
                        movers,
                        is_fro,
                        #[inline(always)]
                        |batch, movers| spreads |= batch.reach(movers, &mut reached),
                    );
                    is_fro = !is_fro;
                }
                batches.iter_mut().for_each(|batch| batch.take_back(movers, &reached, (beat, given)));
            },
        );
        for impact in 1..=IMPACTS {
            let Self { movers, batches, .. } = self;
            let mut any = false;
            I::run(
                #[inline(always)]
                || {
                    for batch in batches.iter_mut() {
                        any |= batch.find_impacts(movers, (threshold, impact), &mut reached);
                    }
                },
            );
            if !any {
                return;
            }
            self.pass(beat, Pass::TOGETHER);
            for _ in 0..MEETING_PASSES {
                self.pass(beat, Pass::MEETING);
            }
        }
        self.batches.iter_mut().filter(|batch| batch.impacts).for_each(Batch::end_impacts);
    }

    /// What stopped what met fast is no guide to the next substep.
    fn end_meeting(&mut self) {
        for batch in self.batches.iter_mut().filter(|batch| batch.bounces) {
            batch.clear_bouncing();
            batch.rows.iter_mut().for_each(|row| row.bounces = Mask::NONE);
            batch.bounces = false;
        }
    }

    /// Hands the bodies back, keeps the impulses for the next frame, notes who touched and who owes energy.
    fn close(self, kept: &mut WarmStart, solved: &mut Solved) {
        let Self { bodies, movers, batches, given, mut tally, .. } = self;
        movers.hand_back(bodies);
        given.book(&mut tally);
        for batch in &batches {
            batch.book_work(bodies, &mut tally);
            for (lane, patch) in batch.rest.patches.iter().enumerate() {
                kept.keep(patch.manifold, bodies, patch.pair, batch.carried(lane));
                let debt = batch.debt(bodies, lane);
                if batch.touched(lane) || debt.is_some() {
                    tally.link(bodies, patch.pair);
                }
                tally.debts.extend(debt);
            }
        }
        solved.tally.add(tally);
        solved.gravity.0 += movers.gravity.0;
        solved.gravity.1 += movers.gravity.1;
    }
}
