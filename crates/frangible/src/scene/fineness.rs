//! Patterns for a wanted number of pieces.
//!
//! A pattern that is made for a body has about as many cells there as it makes pieces: a short
//! search takes care of slivers, and of cells that hold several parts. A pattern in a box of its
//! own is searched among more, and where the cells are given, it is magnified.

use crate::scene::desc::breaking::PatternDesc;
use frangible_fracture::{Filling, MOST_CELLS, Pattern};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Patterns that are tried for each of the two searches.
const MOST_TRIES: usize = 10;

/// Patterns that are made for a solid and tried.
const MOST_MADE: usize = 6;

/// Most cells of a pattern that is made for a solid, for each piece.
const MOST_OF_A_PIECE: usize = 4;

/// Number of patterns to magnify: the coarsest with too many pieces.
const MOST_MAGNIFIED: usize = 3;

/// Cell counts above this are rounded to about this many values per doubling: bodies then share
/// patterns.
const STEPS: usize = 64;

/// A pattern magnified by more has hardly a crack left in the body.
const MOST_MAGNIFICATION: f64 = 16.0;

/// A description of a pattern, and the finer and coarser patterns that have been made of it.
#[derive(Debug)]
pub struct Fineness {
    desc: PatternDesc,
    /// The pattern as described.
    plain: Arc<Pattern>,
    /// By number of cells.
    made: Mutex<BTreeMap<usize, Option<Arc<Pattern>>>>,
}

/// The pattern that came nearest to the number of pieces asked for.
#[derive(Clone, Debug)]
pub struct Found<T> {
    /// The pattern that made them.
    pub pattern: Arc<Pattern>,
    /// Number of pieces.
    pub count: usize,
    /// Result of the attempt with the pattern.
    pub made: T,
}

impl Fineness {
    /// Of a description and its pattern.
    pub fn new(desc: PatternDesc, plain: Arc<Pattern>) -> Self {
        Self { desc, plain, made: Mutex::default() }
    }

    /// Searches the pattern with `wanted` pieces, within the fraction `within`; otherwise returns
    /// the nearest attempt. `attempt` breaks the body and returns the number of pieces. Equal
    /// descriptions and attempts give equal results.
    pub fn search<T>(
        &self,
        wanted: usize,
        within: f64,
        mut attempt: impl FnMut(&Pattern) -> (usize, T),
    ) -> Option<Found<T>> {
        let mut best: Option<Found<T>> = None;
        let off = |count: usize| count.abs_diff(wanted);
        let good = |best: &Option<Found<T>>| {
            best.as_ref().is_some_and(|best| off(best.count) as f64 <= within * wanted as f64)
        };
        let mut try_one = |pattern: Arc<Pattern>, best: &mut Option<Found<T>>| {
            let (count, made) = attempt(&pattern);
            if best.as_ref().is_none_or(|best| off(count) < off(best.count)) {
                *best = Some(Found { pattern, count, made });
            }
            count.max(1)
        };

        // The number of cells; the fewest that make more pieces than are wanted can be magnified.
        let mut above: Vec<(usize, Arc<Pattern>)> = Vec::new();
        if self.desc.with_cells(1).is_some() {
            let mut bracket = Bracket::new(wanted, (1.0, MOST_CELLS as f64));
            let mut next = Some(wanted as f64);
            let mut tried: Vec<usize> = Vec::new();
            while let Some(cells) = next.map(rounded_cells).filter(|cells| !tried.contains(cells)) {
                tried.push(cells);
                let Some(pattern) = self.with_cells(cells) else { break };
                let count = try_one(pattern.clone(), &mut best);
                if good(&best) {
                    return best;
                }
                if count > wanted {
                    above.push((cells, pattern));
                }
                bracket.add(cells as f64, count);
                next = (tried.len() < MOST_TRIES).then(|| bracket.next()).flatten();
            }
        } else {
            let count = try_one(self.plain.clone(), &mut best);
            above.extend((count > wanted).then(|| (0, self.plain.clone())));
        }

        // Sort by cell count.
        above.sort_by_key(|&(cells, _)| cells);
        for (_, pattern) in above.iter().take(MOST_MAGNIFIED) {
            let mut bracket = Bracket::new(wanted, (1.0 / MOST_MAGNIFICATION, 1.0));
            let mut next = Some(0.9);
            for _ in 0..MOST_TRIES {
                let Some(size) = next.filter(|_| !good(&best)) else { break };
                let magnified = Pattern {
                    magnification: pattern.magnification / size,
                    ..Pattern::clone(pattern)
                };
                bracket.add(size, try_one(Arc::new(magnified), &mut best));
                next = bracket.next();
            }
        }
        best
    }

    /// The same among patterns that are made for a solid, where the description allows it.
    pub fn search_in<T>(
        &self,
        filling: Option<&Filling>,
        (wanted, within): (usize, f64),
        mut attempt: impl FnMut(&Pattern) -> (usize, T),
    ) -> Option<Found<T>> {
        let made = |cells: usize| self.desc.in_solid(cells, filling?).map(Arc::new);
        let mut best: Option<Found<T>> = None;
        let mut bracket = Bracket::new(wanted, (1.0, (MOST_OF_A_PIECE * wanted) as f64));
        let mut next = Some(wanted as f64);
        let mut tried: Vec<usize> = Vec::new();
        while let Some(cells) = next.map(|cells| cells.round() as usize) {
            if tried.contains(&cells) {
                break;
            }
            tried.push(cells);
            let Some(pattern) = made(cells) else { break };
            let (count, made) = attempt(&pattern);
            let off = |count: usize| count.abs_diff(wanted);
            if best.as_ref().is_none_or(|best| off(count) < off(best.count)) {
                best = Some(Found { pattern, count, made });
            }
            if off(count) as f64 <= within * wanted as f64 {
                return best;
            }
            bracket.add(cells as f64, count.max(1));
            next = (tried.len() < MOST_MADE).then(|| bracket.next()).flatten();
        }
        if best.is_some() { best } else { self.search(wanted, within, attempt) }
    }

    /// The pattern with about `cells` cells; `None` if a parameter forbids it.
    fn with_cells(&self, cells: usize) -> Option<Arc<Pattern>> {
        let mut made = self.made.lock().unwrap_or_else(PoisonError::into_inner);
        let make = || self.desc.with_cells(cells)?.pattern().ok().map(Arc::new);
        made.entry(cells).or_insert_with(make).clone()
    }
}

/// A number of cells that others ask for, too.
fn rounded_cells(cells: f64) -> usize {
    let cells = cells.round() as usize;
    let step = (cells / STEPS).max(1);
    (cells / step * step).clamp(1, MOST_CELLS)
}

/// Bracket of x for a wanted count that rises with x.
struct Bracket {
    wanted: f64,
    range: (f64, f64),
    /// The nearest x with too low a count and with too high a one, and these counts.
    low: Option<(f64, f64)>,
    high: Option<(f64, f64)>,
}

impl Bracket {
    fn new(wanted: usize, range: (f64, f64)) -> Self {
        Self { wanted: wanted as f64, range, low: None, high: None }
    }

    fn add(&mut self, x: f64, count: usize) {
        let count = count as f64;
        if count < self.wanted {
            if self.low.is_none_or(|(known, _)| x > known) {
                self.low = Some((x, count));
            }
        } else if self.high.is_none_or(|(known, _)| x < known) {
            self.high = Some((x, count));
        }
    }

    /// Where to look next: on a straight line through the logarithms, inside of what is known;
    /// `None` at the end of the range.
    fn next(&self) -> Option<f64> {
        const LONGEST_STEP: f64 = 16.0;
        // No nearer to an end of the bracket than this part of it.
        const LEAST_PART: f64 = 0.1;
        let (least, most) = self.range;
        match (self.low, self.high) {
            (Some((low, few)), Some((high, many))) => {
                // Counts that do not rise with x leave the bracket turned round.
                let (low, high) = (low.min(high), low.max(high));
                let part = libm::log(self.wanted / few) / libm::log(many / few);
                let part =
                    if part.is_finite() { part.clamp(LEAST_PART, 1.0 - LEAST_PART) } else { 0.5 };
                Some(low * libm::pow(high / low, part))
            }
            (Some((low, few)), None) => {
                let step = (self.wanted / few).clamp(1.1, LONGEST_STEP);
                (low < most).then(|| (low * step).max(low + least.min(1.0)).min(most))
            }
            (None, Some((high, many))) => {
                let step = (many / self.wanted).clamp(1.1, LONGEST_STEP);
                (high > least).then(|| (high / step).max(least))
            }
            (None, None) => None,
        }
    }
}
