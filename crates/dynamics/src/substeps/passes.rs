//! Passes over what touches, at one stage of a substep.

use super::Solver;
use super::ranks::Block;
use crate::contact_rows::{Beat, Stage};
use crate::contact_sweep::Pass;
use crate::effort::Meeting;
use crate::lanes::{Instructions, Mask};

impl<I: Instructions> Solver<'_, I> {
    /// Contact at one stage of a substep, after what acted at this stage of the last one: what meets now, which has no impulses to start
    /// from, its normals first, and what it presses against others; then passes over all rows, to and fro, so that none always has the last
    /// word and stacks do not lean. They come last, or what is struck would be pressed through what it touches.
    pub(super) fn contact(&mut self, beat: &Beat, threshold: f64) {
        let Meeting { passes, together } = self.effort.meeting;
        let over_meeting = Pass::over_meeting(together);
        self.meeting_pass(beat, over_meeting);
        for _ in 1..passes {
            self.meeting_pass(beat, over_meeting.sweeping());
        }
        if beat.stage == Stage::BeforeDrift {
            self.squeeze(beat, threshold);
        }
        let begins_fro = self.effort.passes % 2 == 1 && beat.stage == Stage::AfterDrift;
        for number in 0..self.effort.passes {
            let is_fro = (number % 2 == 1) != begins_fro;
            self.pass(beat, Pass::over_all(is_fro, number + 1 == self.effort.passes));
        }
    }

    /// One pass over all rows.
    fn pass(&mut self, beat: &Beat, pass: Pass) {
        self.each_in_turn(pass.is_fro, |movers, block, next| {
            block.wake(movers);
            block.visit(
                next,
                #[inline(always)]
                |next| {
                    if next.has_work(beat.stage) {
                        next.prefetch(movers, next.acting_rows(beat.stage));
                        next.prefetch_motions(movers);
                    }
                },
                #[inline(always)]
                |batch, given| {
                    if batch.has_work(beat.stage) {
                        batch.act(movers, beat, pass, given);
                    }
                },
            );
        });
    }

    /// One pass over what meets fast: few, as a rule.
    pub(super) fn meeting_pass(&mut self, beat: &Beat, pass: Pass) {
        let is_wanted: fn(&Block<I>) -> bool =
            if beat.stage == Stage::Bounce { |block| block.impacts } else { |block| block.bounces };
        let Self { movers, ranks, .. } = self;
        ranks.for_each_in_turn(pass.is_fro, Some(is_wanted), &|block, _| {
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

    /// What stopped what met fast is no guide to the next substep.
    pub(super) fn end_meeting(&mut self) {
        let Self { ranks, .. } = self;
        I::run(
            #[inline(always)]
            || {
                for batch in ranks.met() {
                    batch.clear_bouncing();
                    for row in &mut batch.rows {
                        row.bounces = Mask::NONE;
                    }
                    batch.bounces = false;
                }
            },
        );
    }
}
