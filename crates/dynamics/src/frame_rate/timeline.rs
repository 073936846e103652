//! Times of impact of bodies within a substep, and which batches are still to be visited.

use super::contact_batch::ContactBatch;
use super::impact_log::ImpactLog;
use super::solver_bodies::{SolverBodies, SolverBody};
use frangible_math::{LANES, Mask};

/// Impact times of bodies within a substep.
pub(super) struct Timeline {
    round: u32,
    /// Round of each body's last velocity change.
    changed: Vec<u32>,
    /// Time of each body's next impact in this round, and of its last impact in this substep [s].
    next: Vec<f32>,
    last: Vec<f32>,
    /// Lines with times to reset.
    claimed: Vec<usize>,
    bounced: Vec<usize>,
    is_movable: Vec<bool>,
    /// Batches to test for impacts, and batches with impacts; both empty between substeps.
    pub(super) asked: BatchSet,
    pub(super) coming: BatchSet,
    /// Velocity change of each lane that would cause an impact [m/s].
    pub(super) needs: Vec<[f32; LANES]>,
    pub(super) impacts: ImpactLog,
}

/// A set of batch indices with extraction in ascending order.
#[derive(Default)]
pub(super) struct BatchSet {
    /// One bit per index.
    words: Vec<u64>,
}

impl BatchSet {
    pub(super) fn below(most: usize) -> Self {
        Self { words: vec![0; most.div_ceil(64)] }
    }

    pub(super) fn insert(&mut self, number: usize) {
        self.words[number / 64] |= 1 << (number % 64);
    }

    pub(super) fn clear(&mut self) {
        self.words.fill(0);
    }

    pub(super) fn is_empty(&self) -> bool {
        self.words.iter().all(|&word| word == 0)
    }

    /// Removes and returns the smallest index not below `from`.
    pub(super) fn take_from(&mut self, from: usize) -> Option<usize> {
        let first = self.words.get(from / 64)? & (u64::MAX << (from % 64));
        let mut at = from / 64;
        let mut word = first;
        while word == 0 {
            at += 1;
            word = *self.words.get(at)?;
        }
        let bit = word.trailing_zeros();
        self.words[at] &= !(1 << bit);
        Some(64 * at + bit as usize)
    }
}

/// Solver lines of a batch.
#[derive(Clone, Copy)]
pub(super) struct BatchLines {
    lines: [[usize; LANES]; 2],
}

impl Timeline {
    pub(super) fn new(bodies: &SolverBodies, batches: usize) -> Self {
        let is_movable: Vec<bool> = bodies.lines.iter().map(SolverBody::is_movable).collect();
        let count = is_movable.len();
        Self {
            round: 1,
            changed: vec![0; count],
            next: vec![f32::INFINITY; count],
            last: vec![0.0; count],
            claimed: Vec::new(),
            bounced: Vec::new(),
            is_movable,
            asked: BatchSet::below(batches),
            coming: BatchSet::below(batches),
            needs: vec![[0.0; LANES]; batches],
            impacts: ImpactLog::default(),
        }
    }

    pub(super) fn next_round(&mut self) {
        self.round += 1;
        for line in self.claimed.drain(..) {
            self.next[line] = f32::INFINITY;
        }
    }

    /// Resets all times at the end of a substep.
    pub(super) fn end(&mut self) {
        self.next_round();
        for line in self.bounced.drain(..) {
            self.last[line] = 0.0;
        }
    }
}

impl BatchLines {
    pub(super) fn new<I>(batch: &ContactBatch<I>) -> Self {
        Self { lines: batch.lines() }
    }

    /// Time of the last impact of either body of each lane [s].
    pub(super) fn clocks(&self, timeline: &Timeline) -> [f32; LANES] {
        std::array::from_fn(|lane| {
            let [first, second] = [0, 1].map(|side| timeline.last[self.lines[side][lane]]);
            first.max(second)
        })
    }

    fn movable(self, timeline: &Timeline, lane: usize) -> impl Iterator<Item = usize> + use<> {
        let lines = [0, 1].map(|side| self.lines[side][lane]);
        let is_movable = lines.map(|line| timeline.is_movable[line]);
        (0..2).filter(move |&side| is_movable[side]).map(move |side| lines[side])
    }

    /// Bodies with a changed velocity, and an upper bound of the change [m/s].
    pub(super) fn changed(
        self,
        timeline: &Timeline,
        by: [[f32; LANES]; 2],
    ) -> impl Iterator<Item = (usize, f32)> + use<> {
        let of_line = |side: usize, lane: usize| {
            let line = self.lines[side][lane];
            (timeline.is_movable[line] && by[side][lane] > 0.0).then_some((line, by[side][lane]))
        };
        let all: [[Option<(usize, f32)>; LANES]; 2] =
            std::array::from_fn(|side| std::array::from_fn(|lane| of_line(side, lane)));
        all.into_iter().flatten().flatten()
    }

    /// Registers the times of possible impacts [s].
    pub(super) fn claim(&self, timeline: &mut Timeline, lanes: Mask, times: [f32; LANES]) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in self.movable(timeline, lane) {
                timeline.claimed.push(line);
                timeline.next[line] = timeline.next[line].min(times[lane]);
            }
        }
    }

    /// Lanes in which neither body has an earlier impact. A body may bounce several times in a
    /// round at the same time.
    pub(super) fn are_next(&self, timeline: &Timeline, lanes: Mask, times: [f32; LANES]) -> Mask {
        let mut are_next = Mask::NONE;
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            let is_next = |line: usize| {
                let is_known = timeline.changed[line] != timeline.round;
                let earliest = if is_known { timeline.next[line] } else { timeline.last[line] };
                times[lane] <= earliest
            };
            are_next.set(lane, self.movable(timeline, lane).all(is_next));
        }
        are_next
    }

    /// Registers the impacts of some lanes.
    pub(super) fn mark(&self, timeline: &mut Timeline, lanes: Mask, times: [f32; LANES]) {
        for lane in (0..LANES).filter(|&lane| lanes.get(lane)) {
            for line in self.movable(timeline, lane) {
                timeline.changed[line] = timeline.round;
                timeline.last[line] = timeline.last[line].max(times[lane]);
                timeline.bounced.push(line);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Indices come out in ascending order from the query on, including later inserts; smaller
    /// indices stay.
    #[test]
    fn batches_are_taken_in_ascending_order() {
        let mut numbers = BatchSet::below(200);
        [3, 64, 63, 199, 0, 128].into_iter().for_each(|number| numbers.insert(number));
        let (mut from, mut taken) = (1, Vec::new());
        while let Some(number) = numbers.take_from(from) {
            taken.push(number);
            from = number + 1;
            if number == 64 {
                [63, 65].into_iter().for_each(|number| numbers.insert(number));
            }
        }
        assert_eq!(taken, [3, 63, 64, 65, 128, 199]);
        assert_eq!([numbers.take_from(0), numbers.take_from(0)], [Some(0), Some(63)]);
        assert!(numbers.is_empty());
    }
}
