//! The batches of a cluster, rank by rank, as threads take them.

use crate::clusters::Member;
use crate::contact_batch::{Batch, Touching};
use crate::contact_rows::Beat;
use crate::contact_sweep::{Given, Pass};
use crate::lanes::{Instructions, LANES};
use crate::manifold::ManifoldFinder;
use crate::moving::Movers;
use crate::regions::halves;
use crate::threads;
use crate::warm_start::Part;
use crate::{Bodies, Frame, Tally};

/// Batches of which fewer than this are all in the core's own cache.
const FAR: usize = 256;

/// The most batches of one rank that go to a thread together: ten microseconds of work.
const BLOCK: usize = 16;

/// Batches of pairs that share no body that can move, and what they gave.
pub(super) struct Block<I> {
    pub(super) batches: Vec<Batch<I>>,
    pub(super) given: Given<I>,
    /// Whether anything in it has met fast in this substep.
    pub(super) bounces: bool,
    /// Whether anything takes part in the impact that acts now.
    pub(super) impacts: bool,
    /// Batches of which pairs may have moved too far since their points were found, by their places.
    stale: Vec<u32>,
    /// Whether anything in it has come to rest in this frame, and whether anything is driven.
    pub(super) rests: bool,
    pub(super) is_driven: bool,
    /// Whether the memory of the next batches has to be asked for.
    is_far: bool,
}

/// All batches. In one region one rank acts after the other, the blocks of a rank side by side: their pairs share no body that can move. Where there are
/// more regions, those that share none act side by side, each block by block.
pub(super) struct Ranks<I> {
    pub(super) blocks: Vec<Block<I>>,
    /// Where each rank ends among them, and each region.
    rank_ends: Vec<usize>,
    region_ends: Vec<usize>,
    /// How many there are.
    pub(super) pairs: usize,
}

impl<I: Instructions> Ranks<I> {
    /// Of some pairs, with the ends of their ranks. Substeps take `dt` [s].
    pub(super) fn new(
        (bodies, movers): (&Bodies, &Movers),
        (members, rank_ends): (&[Member], &[Vec<usize>]),
        touching: Touching,
        dt: f64,
    ) -> Self {
        let is_far = members.len() > FAR * LANES;
        // Blocks of a rank are of about one size; no rank is empty.
        let (mut shares, mut ends, mut region_ends, mut begin) = (Vec::new(), Vec::new(), Vec::new(), 0);
        for of_region in rank_ends {
            for &end in of_region {
                let groups: Vec<&[Member]> = members[begin..end].chunks(LANES).collect();
                let size = groups.len().div_ceil(groups.len().div_ceil(BLOCK).max(1)).max(1);
                shares.extend(groups.chunks(size).map(<[_]>::to_vec));
                ends.push(shares.len());
                begin = end;
            }
            region_ends.push(shares.len());
        }
        let block = |groups: Vec<&[Member]>| {
            // The memory of the next groups is asked for meanwhile: what they are, then what that leads to.
            let group = |at: usize| groups.get(at).copied().unwrap_or(&[]);
            let batch = |at: usize| {
                touching.prefetch::<I>(group(at + 2));
                touching.prefetch_points::<I>((bodies, movers), group(at + 1));
                Batch::new((bodies, movers), group(at), touching, dt)
            };
            let batches: Vec<Batch<I>> = (0..groups.len()).map(batch).collect();
            Block {
                is_driven: batches.iter().any(|batch| batch.is_driven),
                batches,
                given: Given::ZERO,
                bounces: false,
                impacts: false,
                stale: Vec::new(),
                rests: false,
                is_far,
            }
        };
        Self {
            blocks: threads::map(shares, members.len(), block),
            rank_ends: ends,
            region_ends,
            pairs: members.len(),
        }
    }

    /// Visits blocks, rank by rank, to or fro: all, or those that are `wanted`.
    pub(super) fn for_each_in_turn(
        &mut self,
        is_fro: bool,
        wanted: Option<fn(&Block<I>) -> bool>,
        visit: BlockVisit<I>,
    ) {
        let Self { blocks, rank_ends, region_ends, pairs } = self;
        let way = Way { ends: region_ends, pairs: *pairs, is_fro, wanted };
        if !threads::is_shared(*pairs) {
            return way.one_by_one(blocks, visit);
        }
        if region_ends.len() > 1 {
            return way.visit(blocks, 0, visit);
        }

        // The blocks of a rank side by side.
        for step in 0..rank_ends.len() {
            let at = if is_fro { rank_ends.len() - 1 - step } else { step };
            let begin = if at == 0 { 0 } else { rank_ends[at - 1] };
            let rank = &mut blocks[begin..rank_ends[at]];
            match wanted {
                None => threads::for_each(rank, *pairs, |block| visit(block, &[])),
                Some(is_wanted) => {
                    let mut some: Vec<&mut Block<I>> =
                        rank.iter_mut().filter(|block| is_wanted(block)).collect();
                    threads::for_each(&mut some, *pairs, |block| visit(block, &[]));
                }
            }
        }
    }

    /// The batches in which something has met fast in this substep.
    pub(super) fn met(&mut self) -> impl Iterator<Item = &mut Batch<I>> {
        let blocks = self.blocks.iter_mut().filter(|block| block.bounces);
        blocks.flat_map(|block| &mut block.batches).filter(|batch| batch.bounces)
    }
}

/// What is done with each block, and the batches that this thread comes to next, if any. Known by its address only, or the ways through regions would be compiled for each of
/// them.
type BlockVisit<'a, I> = &'a (dyn Fn(&mut Block<I>, &[Batch<I>]) + Send + Sync);

/// A way through regions that follow each other, each after its two halves.
#[derive(Clone, Copy)]
struct Way<'a, I> {
    /// Where each of them ends among all blocks.
    ends: &'a [usize],
    /// See [`Ranks`].
    pairs: usize,
    is_fro: bool,
    wanted: Option<fn(&Block<I>) -> bool>,
}

impl<I: Instructions> Way<'_, I> {
    /// Visits their blocks, of which the first one is the `begin`th of all: the halves side by side, as no pair of one shares a body that can move
    /// with the other, and those between them block by block.
    fn visit(self, blocks: &mut [Block<I>], begin: usize, visit: BlockVisit<I>) {
        let Some([low, high]) = halves(self.ends.len()) else { return self.one_by_one(blocks, visit) };
        let (of_low, of_high) =
            (Self { ends: &self.ends[low], ..self }, Self { ends: &self.ends[high], ..self });
        let middle = of_low.ends[of_low.ends.len() - 1];
        let (halves, between) = blocks.split_at_mut(of_high.ends[of_high.ends.len() - 1] - begin);
        let (low, high) = halves.split_at_mut(middle - begin);
        if self.is_fro {
            self.one_by_one(between, visit);
        }
        threads::join(self.pairs, || of_low.visit(low, begin, visit), || of_high.visit(high, middle, visit));
        if !self.is_fro {
            self.one_by_one(between, visit);
        }
    }

    fn one_by_one(self, blocks: &mut [Block<I>], visit: BlockVisit<I>) {
        let count = blocks.len();
        for step in 0..count {
            let at = if self.is_fro { count - 1 - step } else { step };
            if self.wanted.is_some_and(|is_wanted| !is_wanted(&blocks[at])) {
                continue;
            }
            let (before, rest) = blocks.split_at_mut(at);
            let (here, after) = rest.split_at_mut(1);
            let next = if self.is_fro { before.last() } else { after.first() };
            visit(&mut here[0], next.map_or(&[], |block| &block.batches));
        }
    }
}

impl<I: Instructions> Block<I> {
    /// Who meets in a substep.
    pub(super) fn meet(&mut self, (bodies, movers): (&Bodies, &Movers), step: &Frame, threshold: f64) {
        if self.is_driven {
            self.batches.iter_mut().for_each(|batch| batch.be_driven(bodies, Some(step.dt)));
        }
        self.visit(
            &[],
            #[inline(always)]
            |next| next.prefetch_to_meet(movers),
            #[inline(always)]
            |batch, _| batch.meet(movers, threshold, step),
        );
        self.bounces = self.batches.iter().any(|batch| batch.bounces);
    }

    /// All points go with their bodies, after a drift if one has taken so long [s].
    pub(super) fn follow(&mut self, (bodies, movers): (&Bodies, &Movers), drifted: Option<f64>) {
        self.visit(
            &[],
            #[inline(always)]
            |next| next.prefetch_to_follow(movers),
            #[inline(always)]
            |batch, _| batch.follow((bodies, movers), drifted),
        );
    }

    /// What acted in the last substep acts again.
    pub(super) fn go_on(&mut self, movers: &Movers, beat: &Beat, next: &[Batch<I>]) {
        self.visit(
            next,
            #[inline(always)]
            |next| {
                let rows = next.carrying_rows[beat.stage.at()];
                if rows > 0 {
                    next.prefetch(movers, rows);
                }
            },
            #[inline(always)]
            |batch, given| batch.go_on(movers, beat, given),
        );
    }

    /// Lets those act that approach faster than `least` [m/s]. Whether any do.
    pub(super) fn squeeze(
        &mut self,
        movers: &Movers,
        (beat, pass): (&Beat, Pass),
        least: f64,
        next: &[Batch<I>],
    ) -> bool {
        self.wake(movers);
        let mut any = false;
        self.visit(
            next,
            #[inline(always)]
            |next| next.prefetch(movers, 0),
            #[inline(always)]
            |batch, given| {
                if batch.is_squeezed(movers, beat, least) {
                    any = true;
                    batch.act(movers, beat, pass, given);
                }
            },
        );
        any
    }

    /// Lets batches get up of which a body is fast.
    pub(super) fn wake(&mut self, movers: &Movers) {
        let Self { batches, stale, rests, .. } = self;
        if !*rests {
            return;
        }
        I::run(
            #[inline(always)]
            || {
                for (at, batch) in batches.iter_mut().enumerate() {
                    if batch.rests && batch.is_stirred(movers) {
                        batch.get_up(movers);
                        if batch.may_be_stale() {
                            stale.push(at as u32);
                        }
                    }
                }
            },
        );
    }

    /// Finds the batches of which pairs may have moved too far.
    pub(super) fn find_stale(&mut self) {
        let Self { batches, stale, .. } = self;
        stale.clear();
        let may_be = |(_, batch): &(usize, &Batch<I>)| !batch.rests && batch.may_be_stale();
        stale.extend(batches.iter().enumerate().filter(may_be).map(|(at, _)| at as u32));
    }

    /// Finds their points anew. `rest` is what is left of the frame.
    pub(super) fn refresh(
        &mut self,
        (bodies, movers): (&Bodies, &Movers),
        finder: &mut ManifoldFinder,
        rest: &Frame,
    ) {
        let Self { batches, stale, .. } = self;
        I::run(
            #[inline(always)]
            || {
                for (turn, &at) in stale.iter().enumerate() {
                    if let Some(&next) = stale.get(turn + 1) {
                        batches[next as usize].prefetch_to_refresh(movers);
                    }
                    let batch = &mut batches[at as usize];
                    if batch.refresh((bodies, movers), finder, rest) {
                        batch.follow_points(movers, None);
                    }
                }
            },
        );
    }

    /// Visits all batches that do not rest, and asks memory for the one after the next, which may be among those that are `next` to these: one visit is too short for it to
    /// arrive.
    #[inline(always)]
    pub(super) fn visit(
        &mut self,
        next: &[Batch<I>],
        ask: impl Fn(&Batch<I>),
        mut visit: impl FnMut(&mut Batch<I>, &mut Given<I>),
    ) {
        let Self { batches, given, is_far, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let count = batches.len();
                for at in 0..count {
                    if *is_far {
                        let ahead = |by: usize| batches.get(at + by).or_else(|| next.get(at + by - count));
                        if let Some(batch) = ahead(3) {
                            I::prefetch(std::slice::from_ref(batch));
                        }
                        if let Some(batch) = ahead(2).filter(|batch| !batch.rests) {
                            ask(batch);
                        }
                    }
                    if !batches[at].rests {
                        visit(&mut batches[at], given);
                    }
                }
            },
        );
    }

    /// What its pairs carried, and their books.
    pub(super) fn close(self, bodies: &Bodies, movers: &Movers) -> (Part, Tally) {
        let (mut tally, mut lines) = (Tally::default(), Vec::new());
        self.given.book(&mut tally);
        let (pairs, points) = self.batches.iter().fold((0, 0), |(pairs, points), batch| {
            (pairs + batch.rest.patches.len(), points + batch.carried_points())
        });
        let mut kept = Part::with_room(pairs, points);
        I::run(
            #[inline(always)]
            || {
                for (at, batch) in self.batches.iter().enumerate() {
                    if let Some(next) = self.batches.get(at + 1) {
                        next.prefetch_all();
                    }
                    batch.end_frame((bodies, movers), &mut lines, (&mut kept, &mut tally));
                }
            },
        );
        (kept, tally)
    }
}
