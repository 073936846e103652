//! Impacts that follow each other within a substep.

use super::Solver;
use super::ranks::Block;
use crate::Frame;
use crate::contact_rows::{Beat, Stage};
use crate::contact_sweep::Pass;
use crate::effort::Meeting;
use crate::lanes::Instructions;
use crate::rebounds::{Impact, Reached, SLOWEST};
use std::sync::atomic::{AtomicBool, Ordering};

impl<I: Instructions> Solver<'_, I> {
    /// What meets fast presses what it strikes against others: all that still approach fast act, until none does.
    pub(super) fn squeeze(&mut self, beat: &Beat, threshold: f64) {
        if !self.ranks.blocks.iter().any(|block| block.bounces) {
            return;
        }
        let least = threshold.max(SLOWEST);
        for number in 0..self.effort.impacts {
            let pass = Pass::over_squeezed(number % 2 == 1);
            let any_is = AtomicBool::new(false);
            self.each_in_turn(pass.is_fro, |movers, block, next| {
                if block.squeeze(movers, (beat, pass), least, next) {
                    any_is.store(true, Ordering::Relaxed);
                }
            });
            if !any_is.into_inner() {
                return;
            }
        }
    }

    /// Whether anything that has met fast in this substep leaves again.
    pub(super) fn rebounds(&self) -> bool {
        let Self { ranks, .. } = self;
        let mut any = false;
        I::run(
            #[inline(always)]
            || {
                for block in ranks.blocks.iter().filter(|block| block.bounces) {
                    for batch in &block.batches {
                        any |= batch.rebounding().any();
                    }
                }
            },
        );
        any
    }

    /// Notes what acts before anything met, so that what stops it can be taken back: where impacts may follow each other, of all, and nothing rests
    /// there any more.
    pub(super) fn expect_rebounds(&mut self) {
        let is_only = self.effort.impacts == 1;
        self.each_in_turn(false, |movers, block, _| {
            I::run(
                #[inline(always)]
                || {
                    for batch in &mut block.batches {
                        if batch.rests && !is_only {
                            batch.get_up(movers);
                        }
                        if batch.bounces || !is_only {
                            batch.note_starts();
                        }
                    }
                },
            );
        });
    }

    /// What met fast leaves again, by impacts that follow each other if there may be more than one; if not, what carried has gone on.
    pub(super) fn rebound(&mut self, step: &Frame, threshold: f64) {
        let beat = &Beat::new(Stage::Bounce, step);
        let is_only = self.effort.impacts == 1;
        let mut reached = Reached::none(&self.movers);
        if !is_only {
            self.take_back(beat, &mut reached);
        }
        for number in 1..=self.effort.impacts {
            let impact = Impact { number, is_only, threshold };
            let Self { movers, ranks, .. } = self;
            I::run(
                #[inline(always)]
                || {
                    for block in &mut ranks.blocks {
                        block.impacts = false;
                        for batch in &mut block.batches {
                            block.impacts |= batch.find_impacts(movers, impact, &mut reached);
                        }
                    }
                },
            );
            if !self.ranks.blocks.iter().any(|block| block.impacts) {
                return;
            }
            let Meeting { passes, together } = self.effort.meeting;
            let over_meeting = Pass::over_meeting(together);
            self.meeting_pass(beat, over_meeting);
            for _ in 0..passes {
                self.meeting_pass(beat, over_meeting.sweeping());
            }
        }
        let Self { ranks, .. } = self;
        I::run(
            #[inline(always)]
            || {
                for block in ranks.blocks.iter_mut().filter(|block| block.impacts) {
                    for batch in block.batches.iter_mut().filter(|batch| batch.impacts) {
                        batch.end_impacts(is_only);
                    }
                }
            },
        );
    }

    /// Takes back what stopped all that the first impact reaches: one batch after the other, as each may reach the next.
    fn take_back(&mut self, beat: &Beat, reached: &mut Reached) {
        let Self { movers, ranks, .. } = self;
        I::run(
            #[inline(always)]
            || {
                let (mut spreads, mut is_fro) = (true, false);
                while spreads {
                    spreads = false;
                    let count = ranks.blocks.len();
                    for turn in 0..count {
                        let block = &mut ranks.blocks[if is_fro { count - 1 - turn } else { turn }];
                        for batch in &mut block.batches {
                            spreads |= batch.reach(movers, reached);
                        }
                    }
                    is_fro = !is_fro;
                }
                for Block { batches, given, .. } in &mut ranks.blocks {
                    for batch in batches {
                        batch.take_back(movers, reached, (beat, given));
                    }
                }
            },
        );
    }
}
