//! The batches of a cluster, rank by rank, as threads take them.

use crate::clusters::Member;
use crate::contact_batch::{Batch, Touching};
use crate::contact_sweep::Given;
use crate::lanes::{Instructions, LANES};
use crate::moving::Movers;
use crate::threads;
use crate::warm_start::Part;
use crate::{Bodies, Tally};

/// Batches of which fewer than this are all in the core's own cache.
const FAR: usize = 256;

/// The most batches that go to a thread together: ten microseconds of work.
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

/// All batches. One rank acts after the other, the blocks of a rank side by side: their pairs share no body that can move.
pub(super) struct Ranks<I> {
    pub(super) blocks: Vec<Block<I>>,
    /// Where each rank ends among them.
    ends: Vec<usize>,
    /// How many there are.
    pub(super) pairs: usize,
}

impl<I: Instructions> Ranks<I> {
    /// Of some pairs, with the ends of their ranks. Substeps take `dt` [s].
    pub(super) fn new(
        (bodies, movers): (&Bodies, &Movers),
        (members, rank_ends): (&[Member], &[usize]),
        touching: Touching,
        dt: f64,
    ) -> Self {
        let is_far = members.len() > FAR * LANES;
        // Blocks of a rank are of about one size; no rank is empty.
        let (mut shares, mut ends, mut begin) = (Vec::new(), Vec::new(), 0);
        for &end in rank_ends {
            let groups: Vec<&[Member]> = members[begin..end].chunks(LANES).collect();
            let size = groups.len().div_ceil(groups.len().div_ceil(BLOCK).max(1)).max(1);
            shares.extend(groups.chunks(size).map(<[_]>::to_vec));
            ends.push(shares.len());
            begin = end;
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
        Self { blocks: threads::map(shares, members.len(), block), ends, pairs: members.len() }
    }

    /// Visits blocks, rank by rank, to or fro: all, or those that are `wanted`.
    pub(super) fn for_each_in_turn(
        &mut self,
        is_fro: bool,
        wanted: Option<fn(&Block<I>) -> bool>,
        visit: impl Fn(&mut Block<I>) + Send + Sync,
    ) {
        let Self { blocks, ends, pairs } = self;
        let count = ends.len();
        for step in 0..count {
            let at = if is_fro { count - 1 - step } else { step };
            let begin = if at == 0 { 0 } else { ends[at - 1] };
            let rank = &mut blocks[begin..ends[at]];
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

    /// The batches in which something has met fast in this substep.
    pub(super) fn met(&mut self) -> impl Iterator<Item = &mut Batch<I>> {
        let blocks = self.blocks.iter_mut().filter(|block| block.bounces);
        blocks.flat_map(|block| &mut block.batches).filter(|batch| batch.bounces)
    }
}

impl<I: Instructions> Block<I> {
    /// Visits all batches, and asks memory for the next one.
    #[inline(always)]
    pub(super) fn visit(&mut self, ask: impl Fn(&Batch<I>), visit: impl Fn(&mut Batch<I>, &mut Given<I>)) {
        let Self { batches, given, is_far, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let last = batches.len() - 1;
                for at in 0..batches.len() {
                    if *is_far {
                        I::prefetch(&batches[(at + 2).min(last)..][..1]);
                        ask(&batches[(at + 1).min(last)]);
                    }
                    visit(&mut batches[at], given);
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
