//! Sequential impulses in substeps, with soft contact and relaxation: one detection, several small steps [Cat24] [Mac19].

use crate::clusters::{Cluster, Member, clusters};
use crate::contact_batch::Batch;
use crate::contact_rows::{Beat, Stage};
use crate::contact_sweep::{Given, Pass};
use crate::evolve::evolve;
#[cfg(target_arch = "x86_64")]
use crate::instructions::{Avx2, Avx512, Sse2};
use crate::instructions::{Scalar, available};
use crate::lanes::{Instructions, LANES, Mask};
use crate::manifold::{Manifold, ManifoldFinder};
use crate::moving::Movers;
use crate::rebounds::Reached;
use crate::threads;
use crate::warm_start::{Carried, Part, WarmStart};
use crate::{Bodies, Frame, Motion, Tally, Width};
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
    let solve_with = match available(frame.settings.width) {
        Width::Scalar => solve_with::<Scalar>,
        #[cfg(target_arch = "x86_64")]
        Width::Sse2 => solve_with::<Sse2>,
        #[cfg(target_arch = "x86_64")]
        Width::Avx2 => solve_with::<Avx2>,
        #[cfg(target_arch = "x86_64")]
        Width::Avx512 => solve_with::<Avx512>,
        #[cfg(not(target_arch = "x86_64"))]
        Width::Sse2 | Width::Avx2 | Width::Avx512 => solve_with::<Scalar>,
    };
    solve_with(bodies, manifolds, warm, frame)
}

/// [`solve`] with some instructions.
fn solve_with<I: Instructions>(
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    warm: &mut WarmStart,
    frame: &Frame,
) -> Solved {
    let (clusters, is_in_one) = clusters(bodies, manifolds, frame);
    let carried = warm.of_manifolds(bodies, manifolds);
    let bodies_now = &*bodies;
    let closed = threads::map(clusters, |cluster| {
        let substeps = cluster.effort.substeps;
        let step = Frame { dt: frame.dt / f64::from(substeps), ..*frame };
        let mut solver = Solver::<I>::new(bodies_now, cluster, manifolds, (&carried, &step));
        for done in 0..substeps {
            let rest = Frame { dt: f64::from(substeps - done) * step.dt, ..step };
            solver.substep(&rest, &step, frame);
        }
        solver.close()
    });

    // One after the other, so that sums are the same whoever came first.
    let mut solved = Solved { tally: Tally::default(), gravity: (DVec3::ZERO, DVec3::ZERO) };
    let mut parts = Vec::new();
    for Closed { movers, kept, tally } in closed {
        movers.hand_back(bodies);
        parts.extend(kept);
        solved.tally.add(tally);
        solved.gravity.0 += movers.gravity.0;
        solved.gravity.1 += movers.gravity.1;
    }
    fly(bodies, &is_in_one, frame, &mut solved);
    *warm = WarmStart::of_parts(manifolds.len(), parts);
    solved
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

/// Batches of which fewer than this are all in the core's own cache.
const FAR: usize = 256;

/// The most batches that go to a thread together: ten microseconds of work.
const BLOCK: usize = 16;

/// Batches of pairs that share no body that can move, and what they gave.
struct Block<I> {
    batches: Vec<Batch<I>>,
    given: Given<I>,
    /// Whether anything in it has met fast in this substep.
    bounces: bool,
    /// Whether anything takes part in the impact that acts now.
    impacts: bool,
    /// Whether the memory of the next batches has to be asked for.
    is_far: bool,
}

impl<I: Instructions> Block<I> {
    /// Visits all batches.
    #[inline(always)]
    fn visit(&mut self, movers: &Movers, visit: impl Fn(&mut Batch<I>, &mut Given<I>)) {
        let Self { batches, given, is_far, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let last = batches.len() - 1;
                for at in 0..batches.len() {
                    if *is_far {
                        I::prefetch(&batches[(at + 2).min(last)..][..1]);
                        batches[(at + 1).min(last)].prefetch(movers);
                    }
                    visit(&mut batches[at], given);
                }
            },
        );
    }

    /// What its pairs carried, and their books.
    fn close(self, bodies: &Bodies, movers: &Movers) -> (Part, Tally) {
        let (mut kept, mut tally) = (Part::default(), Tally::default());
        self.given.book(&mut tally);
        let mut lines = Vec::new();
        for batch in &self.batches {
            I::run(
                #[inline(always)]
                || batch.all_lines(&mut lines),
            );
            batch.book_work(bodies, &mut tally);
            for (lane, patch) in batch.rest.patches.iter().enumerate() {
                kept.keep(patch.manifold, bodies, patch.pair, batch.carried(lane, &lines));
                let debt = batch.debt(bodies, movers, lane);
                if batch.touched(lane) || debt.is_some() {
                    tally.link(bodies, patch.pair);
                }
                tally.debts.extend(debt);
            }
        }
        (kept, tally)
    }
}

/// A cluster on its way through a frame.
struct Solver<'a, I> {
    bodies: &'a Bodies,
    movers: Movers,
    blocks: Vec<Block<I>>,
    /// Where each rank ends among the blocks: one rank acts after the other, the blocks of a rank side by side.
    rank_ends: Vec<usize>,
    passes: u32,
}

/// A cluster at the frame's end.
struct Closed {
    movers: Movers,
    kept: Vec<Part>,
    tally: Tally,
}

impl<'a, I: Instructions> Solver<'a, I> {
    fn new(
        bodies: &'a Bodies,
        cluster: Cluster,
        manifolds: &[Manifold],
        with: (&[&[Carried]], &Frame),
    ) -> Self {
        let Cluster { bodies: who, members, rank_ends, effort } = cluster;
        let movers = Movers::new::<I>(bodies, who);
        let is_far = members.len() > FAR * LANES;

        // Blocks of a rank are of one size.
        let (mut shares, mut ends, mut begin) = (Vec::new(), Vec::new(), 0);
        for end in rank_ends {
            let groups: Vec<&[Member]> = members[begin..end].chunks(LANES).collect();
            let size = groups.len().div_ceil(groups.len().div_ceil(BLOCK));
            shares.extend(groups.chunks(size).map(<[_]>::to_vec));
            ends.push(shares.len());
            begin = end;
        }
        let block = |groups: Vec<&[Member]>| {
            let batch = |group| Batch::new(bodies, &movers, group, manifolds, with);
            Block {
                batches: groups.into_iter().map(batch).collect(),
                given: Given::ZERO,
                bounces: false,
                impacts: false,
                is_far,
            }
        };
        let blocks = threads::map(shares, block);
        let mut solver = Self { bodies, movers, blocks, rank_ends: ends, passes: effort.passes };
        solver.follow(None);
        solver
    }

    /// Visits all blocks, in any order.
    fn each(&mut self, visit: impl Fn(&Movers, &mut Block<I>) + Send + Sync) {
        let Self { movers, blocks, .. } = self;
        threads::for_each(blocks, |block| visit(movers, block));
    }

    /// Visits blocks, rank by rank, to or fro: all, or those that are `wanted`.
    fn each_in_turn(
        &mut self,
        is_fro: bool,
        wanted: Option<fn(&Block<I>) -> bool>,
        visit: impl Fn(&Movers, &mut Block<I>) + Send + Sync,
    ) {
        let Self { movers, blocks, rank_ends, .. } = self;
        let count = rank_ends.len();
        for step in 0..count {
            let at = if is_fro { count - 1 - step } else { step };
            let begin = if at == 0 { 0 } else { rank_ends[at - 1] };
            let rank = &mut blocks[begin..rank_ends[at]];
            match wanted {
                None => threads::for_each(rank, |block| visit(movers, block)),
                Some(is_wanted) => {
                    let mut some: Vec<&mut Block<I>> =
                        rank.iter_mut().filter(|block| is_wanted(block)).collect();
                    threads::for_each(&mut some, |block| visit(movers, block));
                }
            }
        }
    }

    /// Half kick, impulses, drift, half kick, bounce, relax. `rest` is what is left of the frame.
    fn substep(&mut self, rest: &Frame, step: &Frame, frame: &Frame) {
        self.refresh(rest);
        self.movers.kick(step);
        let threshold = BOUNCE * frame.gravity.length() * frame.dt;
        self.meet(step, threshold);
        let rebounds = self.met().any(|batch| batch.rebounding().any());
        if rebounds {
            self.each(|_, block| block.batches.iter_mut().for_each(Batch::note_starts));
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
        let bodies = self.bodies;
        self.each(|movers, block| {
            let mut finder = ManifoldFinder::default();
            for batch in &mut block.batches {
                if batch.refresh((bodies, movers), &mut finder, rest) {
                    I::run(
                        #[inline(always)]
                        || batch.follow(movers, None),
                    );
                }
            }
        });
    }

    /// Who meets in this substep.
    fn meet(&mut self, step: &Frame, threshold: f64) {
        let bodies = self.bodies;
        self.each(|movers, block| {
            block.batches.iter_mut().for_each(|batch| batch.be_driven(bodies, Some(step.dt)));
            block.visit(
                movers,
                #[inline(always)]
                |batch, _| batch.meet(movers, threshold, step),
            );
            block.bounces = block.batches.iter().any(|batch| batch.bounces);
        });
    }

    /// All points go with their bodies.
    fn follow(&mut self, drifted: Option<f64>) {
        let bodies = self.bodies;
        self.each(|movers, block| {
            block.visit(
                movers,
                #[inline(always)]
                |batch, _| batch.follow(movers, drifted),
            );
            for batch in &mut block.batches {
                batch.be_driven(bodies, None);
                if let Some(dt) = drifted {
                    batch.forget_driven(movers, dt);
                }
            }
        });
    }

    /// Contact at one stage of a substep: what acted at this stage of the last one, then passes over all rows, to and fro, so that none
    /// always has the last word and stacks do not lean. What meets now has no impulses to start from, and takes more passes, its normals
    /// first.
    fn contact(&mut self, beat: &Beat) {
        self.go_on(beat);
        self.meeting_pass(beat, Pass::TOGETHER);
        let begins_fro = self.passes % 2 == 1 && beat.stage == Stage::AfterDrift;
        for number in 0..self.passes {
            let is_fro = (number % 2 == 1) != begins_fro;
            self.pass(beat, Pass::over_all(is_fro, number + 1 == self.passes));
        }
        for _ in 2..MEETING_PASSES {
            self.meeting_pass(beat, Pass::MEETING);
        }
        self.meeting_pass(beat, Pass::LAST_MEETING);
    }

    /// What acted in the last substep acts again, unless it has come apart.
    fn go_on(&mut self, beat: &Beat) {
        self.each_in_turn(false, None, |movers, block| {
            block.visit(
                movers,
                #[inline(always)]
                |batch, given| batch.go_on(movers, beat, given),
            );
        });
    }

    /// One pass over all rows.
    fn pass(&mut self, beat: &Beat, pass: Pass) {
        self.each_in_turn(pass.is_fro, None, |movers, block| {
            block.visit(
                movers,
                #[inline(always)]
                |batch, given| batch.act(movers, beat, pass, given),
            );
        });
    }

    /// One pass over what meets fast: few, as a rule.
    fn meeting_pass(&mut self, beat: &Beat, pass: Pass) {
        let is_wanted: fn(&Block<I>) -> bool =
            if beat.stage == Stage::Bounce { |block| block.impacts } else { |block| block.bounces };
        self.each_in_turn(pass.is_fro, Some(is_wanted), |movers, block| {
            let Block { batches, given, .. } = block;
            I::run(
                #[inline(always)]
                || {
                    for batch in batches.iter_mut().filter(|batch| batch.meets(beat)) {
                        batch.act(movers, beat, pass, given);
                    }
                },
            );
        });
    }

    /// The batches in which something has met fast in this substep.
    fn met(&mut self) -> impl Iterator<Item = &mut Batch<I>> {
        let blocks = self.blocks.iter_mut().filter(|block| block.bounces);
        blocks.flat_map(|block| &mut block.batches).filter(|batch| batch.bounces)
    }

    /// What met fast leaves again, by impacts that follow each other: one batch after the other, as each may reach the next.
    fn rebound(&mut self, step: &Frame, threshold: f64) {
        let beat = &Beat::new(Stage::Bounce, step);
        let mut reached = Reached::none(&self.movers);
        let Self { movers, blocks, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let (mut spreads, mut is_fro) = (true, false);
                while spreads {
                    spreads = false;
                    let count = blocks.len();
                    for step in 0..count {
                        let block = &mut blocks[if is_fro { count - 1 - step } else { step }];
                        for batch in &mut block.batches {
                            spreads |= batch.reach(movers, &mut reached);
                        }
                    }
                    is_fro = !is_fro;
                }
                for Block { batches, given, .. } in blocks {
                    for batch in batches {
                        batch.take_back(movers, &reached, (beat, given));
                    }
                }
            },
        );
        for impact in 1..=IMPACTS {
            let Self { movers, blocks, .. } = self;
            I::run(
                #[inline(always)]
                || {
                    for block in blocks {
                        block.impacts = false;
                        for batch in &mut block.batches {
                            block.impacts |= batch.find_impacts(movers, (threshold, impact), &mut reached);
                        }
                    }
                },
            );
            if !self.blocks.iter().any(|block| block.impacts) {
                return;
            }
            self.meeting_pass(beat, Pass::TOGETHER);
            for _ in 0..MEETING_PASSES {
                self.meeting_pass(beat, Pass::MEETING);
            }
        }
        let impacting = self.blocks.iter_mut().filter(|block| block.impacts);
        let batches = impacting.flat_map(|block| &mut block.batches);
        batches.filter(|batch| batch.impacts).for_each(Batch::end_impacts);
    }

    /// What stopped what met fast is no guide to the next substep.
    fn end_meeting(&mut self) {
        self.met().for_each(|batch| {
            batch.clear_bouncing();
            batch.rows.iter_mut().for_each(|row| row.bounces = Mask::NONE);
            batch.bounces = false;
        });
    }

    /// At the frame's end.
    fn close(self) -> Closed {
        let Self { bodies, movers, blocks, .. } = self;
        let (mut kept, mut all) = (Vec::new(), Tally::default());
        for (part, tally) in threads::map(blocks, |block| block.close(bodies, &movers)) {
            kept.push(part);
            all.add(tally);
        }
        Closed { movers, kept, tally: all }
    }
}
