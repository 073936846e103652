//! Runs for repeated cutting.

use crate::runs::{Run, Span};

/// The longest span of a run, and what the others hold together. Most cuts go through it, and then
/// none of the others is looked at.
#[derive(Clone, Copy, Debug)]
pub struct RunCore {
    /// Of the run.
    row: [u32; 2],
    /// Of the grid, along x.
    middle: f64,
    /// First and last node of the run, and of its longest span.
    ends: [f64; 2],
    core: [f64; 2],
    /// Of the longest span.
    coverage: f64,
    is_inside: bool,
    before: Sums,
    behind: Sums,
}

/// Number of inside nodes, and moments of the spans.
#[derive(Clone, Copy, Debug)]
struct Sums {
    inside: u32,
    moments: [f64; 3],
}

/// A whole number from zero to the largest `u32`: the last bits of a sum with 2^52.
#[inline]
fn number(whole: f64) -> u32 {
    (whole + (1_u64 << (f64::MANTISSA_DIGITS - 1)) as f64).to_bits() as u32
}

impl Sums {
    fn of(spans: &[Span], start: u32, middle: f64) -> Self {
        let mut run = Run::empty([0; 2], start);
        spans.iter().for_each(|span| run.add(span, middle));
        Self { inside: run.inside, moments: run.moments }
    }

    /// Of the parts of a row's spans between two nodes, span by span.
    #[cold]
    fn within(spans: &[Span], [start, end]: [u32; 2], middle: f64) -> Self {
        let mut run = Run::empty([0; 2], start);
        for span in spans {
            if span.end <= start {
                continue;
            }
            if span.start >= end {
                break;
            }
            run.add(
                &Span { start: span.start.max(start), end: span.end.min(end), ..*span },
                middle,
            );
        }
        Self { inside: run.inside, moments: run.moments }
    }

    #[inline]
    fn plus(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.moments, other.moments);
        Self { inside: self.inside + other.inside, moments: [a + x, b + y, c + z] }
    }
}

impl RunCore {
    /// Sums of a run and its spans, in a grid with its middle `middle` nodes along x.
    pub(crate) fn of(run: &Run, spans: &[Span], middle: f64) -> Self {
        let longest =
            (0..spans.len()).rev().max_by_key(|&at| spans[at].end - spans[at].start).unwrap_or(0);
        let nothing = Span { start: run.start, end: run.start + 1, coverage: 0.0, inside: false };
        let core = spans.get(longest).copied().unwrap_or(nothing);
        let ends = |start: u32, end: u32| [f64::from(start), f64::from(end) - 1.0];
        let behind = spans.get(longest + 1..).unwrap_or_default();
        Self {
            row: run.row,
            middle,
            ends: ends(run.start, run.end),
            core: ends(core.start, core.end),
            coverage: f64::from(core.coverage),
            is_inside: core.inside,
            before: Sums::of(&spans[..longest], run.start, middle),
            behind: Sums::of(behind, core.end, middle),
        }
    }

    /// The part of the run from one node to another, whole numbers; `spans` finds those of its row.
    #[inline]
    pub fn cut<'a>(&self, [first, last]: [f64; 2], spans: impl FnOnce() -> &'a [Span]) -> Run {
        let (start, end) = (number(first), number(last) + 1);
        let [before, behind] = [first < self.core[0], last > self.core[1]];
        let from = if before { self.core[0] } else { first };
        let to = if behind { self.core[1] } else { last };
        // Numbers, not a `Run`: one that is put together in two places goes through memory.
        let (inside, [volume, along, square]) =
            if from > to || (before && first != self.ends[0]) || (behind && last != self.ends[1]) {
                let Sums { inside, moments } = Sums::within(spans(), [start, end], self.middle);
                (inside, moments)
            } else {
                let (count, place) = (to - from + 1.0, 0.5 * (from + to) - self.middle);
                let volume = count * self.coverage;
                let square = volume * (place * place + (count * count - 1.0) * (1.0 / 12.0));
                let inside = if self.is_inside { number(count) } else { 0 };
                let mut sums = Sums { inside, moments: [volume, volume * place, square] };
                if before {
                    sums = self.before.plus(sums);
                }
                if behind {
                    sums = sums.plus(self.behind);
                }
                (sums.inside, sums.moments)
            };
        Run { row: self.row, start, end, inside, moments: [volume, along, square] }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Wherever a run is cut, the part holds what its spans do.
        #[test]
        fn parts_hold_what_their_spans_do(
            lengths in prop::collection::vec((1..4_u32, 0.0..1.0_f32, any::<bool>()), 1..8),
            (low, high) in (0.0..1.0_f64, 0.0..1.0_f64),
        ) {
            let (middle, mut run) = (11.5, Run::empty([3, 4], 5));
            let mut spans = Vec::new();
            for (length, coverage, inside) in lengths {
                let span = Span { start: run.end, end: run.end + length, coverage, inside };
                run.add(&span, middle);
                spans.push(span);
            }
            let node = |part: f64| run.start + (part * f64::from(run.end - run.start)) as u32;
            let (start, end) = (node(low.min(high)), node(low.max(high)) + 1);
            let ends = [f64::from(start), f64::from(end - 1)];
            let cut = RunCore::of(&run, &spans, middle).cut(ends, || &spans);
            let mut expected = Run::empty(run.row, start);
            for span in spans.iter().filter(|span| span.start < end && span.end > start) {
                expected.add(&Span { start: span.start.max(start), end: span.end.min(end), ..*span }, middle);
            }
            prop_assert_eq!((cut.row, cut.start, cut.end), (expected.row, start, end));
            prop_assert_eq!(cut.inside, expected.inside);
            for (a, b) in cut.moments.iter().zip(expected.moments) {
                prop_assert!((a - b).abs() < 1e-12, "{} {}", a, b);
            }
        }
    }
}
