//! The batches of a cluster, rank by rank, as threads take them.

use crate::clusters::Member;
use crate::contact_batch::{Batch, Touching};
use crate::contact_rows::Beat;
use crate::contact_sweep::Given;
use crate::lanes::{Instructions, LANES};
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
        let batch = |(group, next): (&[Member], &[Member])| {
            touching.prefetch::<I>(movers, next);
            Batch::new((bodies, movers), group, touching, dt)
        };
        let block = |groups: Vec<&[Member]>| {
            // Each group with the one after it, whose memory is asked for meanwhile.
            let next = groups.iter().copied().skip(1).chain([&[][..]]);
            Block {
                batches: groups.iter().copied().zip(next).map(batch).collect(),
                given: Given::ZERO,
                bounces: false,
                impacts: false,
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
        visit: impl Fn(&mut Block<I>) + Send + Sync,
    ) {
        let Self { blocks, rank_ends, region_ends, pairs } = self;
        let way = Way { ends: region_ends, begin: 0, pairs: *pairs, is_fro, wanted };
        if region_ends.len() > 1 {
            return way.visit(blocks, &visit);
        }
        if !threads::is_shared(*pairs) {
            return way.one_by_one(blocks, &visit);
        }

        // The blocks of a rank side by side.
        for step in 0..rank_ends.len() {
            let at = if is_fro { rank_ends.len() - 1 - step } else { step };
            let begin = if at == 0 { 0 } else { rank_ends[at - 1] };
            let rank = &mut blocks[begin..rank_ends[at]];
            match wanted {
                None => threads::for_each(rank, *pairs, &visit),
                Some(is_wanted) => {
                    let mut some: Vec<&mut Block<I>> =
                        rank.iter_mut().filter(|block| is_wanted(block)).collect();
                    threads::for_each(&mut some, *pairs, |block| visit(block));
                }
            }
        }
    }

    /// Visits all blocks in any order, to `look` at their bodies, and then in turn, to `act` on them: both in one region before the next one, while
    /// what they need is at hand. Only what is between regions has bodies of others: it looks first, and acts last. What
    /// `look` writes no other block reads.
    pub(super) fn look_then_act(
        &mut self,
        look: impl Fn(&mut Block<I>) + Send + Sync,
        act: impl Fn(&mut Block<I>) + Send + Sync,
    ) {
        let Self { blocks, region_ends, pairs, .. } = self;
        if region_ends.len() > 1 {
            let way = Way { ends: region_ends, begin: 0, pairs: *pairs, is_fro: false, wanted: None };
            return way.look_then_act(blocks, &look, &act);
        }
        threads::for_each(blocks, *pairs, look);
        self.for_each_in_turn(false, None, act);
    }

    /// The batches in which something has met fast in this substep.
    pub(super) fn met(&mut self) -> impl Iterator<Item = &mut Batch<I>> {
        let blocks = self.blocks.iter_mut().filter(|block| block.bounces);
        blocks.flat_map(|block| &mut block.batches).filter(|batch| batch.bounces)
    }
}

/// A way through regions that follow each other, each after its two halves.
#[derive(Clone, Copy)]
struct Way<'a, I> {
    /// Where each of them ends among all blocks, and the first one begins.
    ends: &'a [usize],
    begin: usize,
    /// Of the whole cluster.
    pairs: usize,
    is_fro: bool,
    wanted: Option<fn(&Block<I>) -> bool>,
}

impl<I: Instructions> Way<'_, I> {
    /// Visits their blocks: the halves side by side, as no pair of one shares a body that can move with the other, and those between them block by
    /// block.
    fn visit(self, blocks: &mut [Block<I>], visit: &(impl Fn(&mut Block<I>) + Send + Sync)) {
        let Some([low, high]) = self.halves() else { return self.one_by_one(blocks, visit) };
        let [of_low, of_high, between] = self.split([low, high], blocks);
        if self.is_fro {
            self.one_by_one(between, visit);
        }
        threads::join(self.pairs, || low.visit(of_low, visit), || high.visit(of_high, visit));
        if !self.is_fro {
            self.one_by_one(between, visit);
        }
    }

    /// See [`Ranks::look_then_act`].
    fn look_then_act(
        self,
        blocks: &mut [Block<I>],
        look: &(impl Fn(&mut Block<I>) + Send + Sync),
        act: &(impl Fn(&mut Block<I>) + Send + Sync),
    ) {
        let Some([low, high]) = self.halves() else {
            self.one_by_one(blocks, look);
            return self.one_by_one(blocks, act);
        };
        let [of_low, of_high, between] = self.split([low, high], blocks);
        self.one_by_one(between, look);
        threads::join(
            self.pairs,
            || low.look_then_act(of_low, look, act),
            || high.look_then_act(of_high, look, act),
        );
        self.one_by_one(between, act);
    }

    /// The two halves, if they are not all in one region.
    fn halves(self) -> Option<[Self; 2]> {
        let [low, high] = halves(self.ends.len())?;
        let low = Self { ends: &self.ends[low], ..self };
        let high = Self { ends: &self.ends[high], begin: low.end(), ..self };
        Some([low, high])
    }

    /// Their blocks, and those between them.
    fn split(self, [low, high]: [Self; 2], blocks: &mut [Block<I>]) -> [&mut [Block<I>]; 3] {
        let (of_halves, between) = blocks.split_at_mut(high.end() - self.begin);
        let (of_low, of_high) = of_halves.split_at_mut(low.end() - self.begin);
        [of_low, of_high, between]
    }

    /// Where the last region ends among all blocks.
    fn end(self) -> usize {
        self.ends[self.ends.len() - 1]
    }

    fn one_by_one(self, blocks: &mut [Block<I>], visit: &(impl Fn(&mut Block<I>) + Send + Sync)) {
        let is_wanted = |block: &&mut Block<I>| self.wanted.is_none_or(|is_wanted| is_wanted(block));
        if self.is_fro {
            blocks.iter_mut().rev().filter(is_wanted).for_each(visit);
        } else {
            blocks.iter_mut().filter(is_wanted).for_each(visit);
        }
    }
}

impl<I: Instructions> Block<I> {
    /// Lets batches get up of which a body is fast.
    pub(super) fn wake(&mut self, movers: &Movers) {
        let Self { batches, .. } = self;
        I::run(
            #[inline(always)]
            || {
                for batch in batches.iter_mut().filter(|batch| batch.rests && batch.is_stirred(movers)) {
                    batch.get_up(movers);
                }
            },
        );
    }

    /// Visits all batches that do not rest, and asks memory for the one after the next: one visit is too short for it to arrive.
    #[inline(always)]
    pub(super) fn visit(&mut self, ask: impl Fn(&Batch<I>), visit: impl Fn(&mut Batch<I>, &mut Given<I>)) {
        let Self { batches, given, is_far, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let last = batches.len() - 1;
                for at in 0..batches.len() {
                    if *is_far {
                        I::prefetch(&batches[(at + 3).min(last)..][..1]);
                        let next = &batches[(at + 2).min(last)];
                        if !next.rests {
                            ask(next);
                        }
                    }
                    if !batches[at].rests {
                        visit(&mut batches[at], given);
                    }
                }
            },
        );
    }

    /// Who meets in a substep: see [`Batch::meet`].
    pub(super) fn meet(&mut self, (bodies, movers): (&Bodies, &Movers), threshold: f64, step: &Frame) {
        self.batches.iter_mut().for_each(|batch| batch.be_driven(bodies, Some(step.dt)));
        self.visit(
            #[inline(always)]
            |next| next.prefetch(movers, next.near_rows),
            #[inline(always)]
            |batch, _| batch.meet(movers, threshold, step),
        );
        self.bounces = self.batches.iter().any(|batch| batch.bounces);
    }

    /// All points go with their bodies: see [`Batch::follow`].
    pub(super) fn follow(&mut self, (bodies, movers): (&Bodies, &Movers), drifted: Option<f64>) {
        self.visit(
            #[inline(always)]
            |next| next.prefetch_to_follow(movers),
            #[inline(always)]
            |batch, _| batch.follow(movers, drifted),
        );
        for batch in &mut self.batches {
            batch.be_driven(bodies, None);
            if let Some(dt) = drifted {
                batch.forget_driven(movers, dt);
            }
        }
    }

    /// What acted in the last substep acts again, unless it has come apart.
    pub(super) fn go_on(&mut self, movers: &Movers, beat: &Beat) {
        self.visit(
            #[inline(always)]
            |next| {
                let rows = next.carrying_rows[beat.stage.at()];
                if rows > 0 {
                    next.prefetch(movers, rows);
                }
            },
            #[inline(always)]
            |batch, given| {
                if batch.carrying_rows[beat.stage.at()] > 0 {
                    batch.go_on(movers, beat, given);
                }
            },
        );
    }

    /// What its pairs carried, and their books.
    pub(super) fn close(self, bodies: &Bodies, movers: &Movers) -> (Part, Tally) {
        let (mut kept, mut tally, mut lines) = (Part::default(), Tally::default(), Vec::new());
        self.given.book(&mut tally);
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
