//! Overlapping boxes: strips across the axis of largest extent, and within each strip a sweep along
//! the next axis [Bar92]. Time is linear in the number of boxes plus overlaps, for flat piles,
//! towers and rows.

use crate::broad_phase::bounds::Bounds;
use crate::broad_phase::crowd::{most_pairs, thinned};
use frangible_bodies::Pair;
use frangible_math::threads;
use glam::DVec3;

/// A box in a strip, along the permuted axes [m], rounded outwards to never miss an overlap.
#[derive(Clone, Copy, Default)]
struct Entry {
    /// Lower and upper bound along the sweep axis.
    along: [f32; 2],
    /// Bounds across the strips.
    across: [f32; 2],
    /// Bounds along the third axis.
    third: [f32; 2],
    index: u32,
    /// First strip of the box.
    first_strip: u32,
    moves: bool,
}

/// Distribution of boxes into strips.
struct Layout {
    /// Axis across the strips, sweep axis, third axis.
    axes: [usize; 3],
    /// Begin of the first strip [m].
    begin: f64,
    /// Width of a strip [m].
    width: f64,
    strips: usize,
}

/// Number of pair lists, at least the number of threads.
const SHARES: usize = 16;

/// All overlapping pairs of finite boxes of which at least one moves and which may collide, unordered. Boxes within
/// single-precision rounding may count as overlapping. With `thins`, crowds keep the
/// [deepest](thinned) pairs; also returns the number of omitted pairs.
pub(crate) fn overlapping_bounded(
    bounds: &[Bounds],
    moves: &[bool],
    may_collide: &(impl Fn(usize, usize) -> bool + Sync),
    thins: bool,
) -> (Vec<Vec<Pair>>, usize) {
    let is_bounded =
        |&index: &usize| bounds[index].low.is_finite() && bounds[index].high.is_finite();
    let bounded: Vec<usize> = (0..bounds.len()).filter(is_bounded).collect();
    let layout = Layout::of(bounds, &bounded);

    // Sort by lower bound along the sweep axis, ties by index.
    let sweep = layout.axes[1];
    let key = |&index: &usize| {
        u64::from(ascending(round_down(bounds[index].low[sweep]))) << 32 | index as u64
    };
    let mut order: Vec<u64> = bounded.iter().map(key).collect();
    order.sort_unstable();

    // Copy into each overlapped strip, in this order.
    let placed = threads::list(order.len(), |at| {
        let index = order[at] as u32;
        let bounds = &bounds[index as usize];
        let [first, last] = layout.strips_of(bounds);
        (first, last, layout.entry(bounds, index, first as u32, moves[index as usize]))
    });
    let mut begin = vec![0; layout.strips + 1];
    for &(first, last, _) in &placed {
        begin[first..=last].iter_mut().for_each(|count| *count += 1);
    }
    let mut total = 0;
    for begin in &mut begin {
        total += std::mem::replace(begin, total);
    }
    let mut next = begin.clone();
    let mut entries = vec![Entry::default(); total];
    for (first, last, entry) in placed {
        for next in &mut next[first..=last] {
            entries[*next] = entry;
            *next += 1;
        }
    }

    let strips: Vec<usize> = (0..layout.strips).collect();
    let shares: Vec<&[usize]> = strips.chunks(layout.strips.div_ceil(SHARES)).collect();
    let most = if thins { most_pairs(bounded.len()) } else { usize::MAX };
    let pairs = threads::map(shares, bounded.len(), |strips| {
        let mut pairs = Vec::new();
        for &strip in strips {
            let entries = &entries[begin[strip]..begin[strip + 1]];
            sweep_strip(entries, strip as u32, may_collide, most, &mut pairs);
        }
        pairs
    });
    if pairs.iter().map(Vec::len).sum::<usize>() <= most {
        return (pairs, 0);
    }
    drop(pairs);
    let (pairs, left_out) = thinned(bounds, |take| {
        let mut of_one = Vec::new();
        for strip in 0..layout.strips {
            let entries = &entries[begin[strip]..begin[strip + 1]];
            for at in 0..entries.len() {
                of_one.clear();
                sweep_one(entries, at, strip as u32, &mut of_one);
                let meets = |pair: &&Pair| may_collide(pair.first, pair.second);
                of_one.iter().filter(meets).for_each(|&pair| take(pair));
            }
        }
    });
    (vec![pairs], left_out)
}

/// Overlapping pairs whose later box begins in this strip; stops once `pairs` exceeds `most`.
fn sweep_strip(
    entries: &[Entry],
    strip: u32,
    may_collide: &impl Fn(usize, usize) -> bool,
    most: usize,
    pairs: &mut Vec<Pair>,
) {
    // Overlap is unpredictable: write every candidate without a branch, and overwrite misses.
    let mut with = vec![0; entries.len()];
    for (at, a) in entries.iter().enumerate() {
        let mut count = 0;
        for b in &entries[at + 1..] {
            if b.along[0] > a.along[1] {
                break;
            }
            let overlaps = (b.across[0] <= a.across[1])
                & (a.across[0] <= b.across[1])
                & (b.third[0] <= a.third[1])
                & (a.third[0] <= b.third[1]);
            let is_here = (a.first_strip == strip) | (b.first_strip == strip);
            with[count] = b.index;
            count += usize::from(overlaps & is_here & (a.moves | b.moves));
        }
        if pairs.len() > most {
            return;
        }
        let meet = with[..count].iter().map(|&other| {
            let (first, second) = (a.index.min(other) as usize, a.index.max(other) as usize);
            Pair { first, second }
        });
        pairs.extend(meet.filter(|pair| may_collide(pair.first, pair.second)));
    }
}

/// Overlapping pairs of one box with later boxes.
fn sweep_one(entries: &[Entry], at: usize, strip: u32, pairs: &mut Vec<Pair>) {
    let a = &entries[at];
    let later = entries[at + 1..].iter().take_while(|b| b.along[0] <= a.along[1]);
    let meets = |b: &&Entry| {
        b.across[0] <= a.across[1]
            && a.across[0] <= b.across[1]
            && b.third[0] <= a.third[1]
            && a.third[0] <= b.third[1]
            && (a.first_strip == strip || b.first_strip == strip)
            && (a.moves || b.moves)
    };
    pairs.extend(later.filter(meets).map(|b| {
        let (first, second) = (a.index.min(b.index) as usize, a.index.max(b.index) as usize);
        Pair { first, second }
    }));
}

impl Layout {
    /// Strip width is the mean box width (about two strips per box), with at most one strip per
    /// box.
    fn of(bounds: &[Bounds], bounded: &[usize]) -> Self {
        let count = bounded.len().max(1) as f64;
        let boxes = || bounded.iter().map(|&index| &bounds[index]);
        let sum = |of: &dyn Fn(&Bounds) -> DVec3| boxes().map(of).sum::<DVec3>() / count;
        let middle = |bounds: &Bounds| 0.5 * (bounds.low + bounds.high);
        let mean = sum(&middle);
        let spread = sum(&|bounds| (middle(bounds) - mean).abs());
        let mut axes = [0, 1, 2];
        axes.sort_by(|&a, &b| spread[b].total_cmp(&spread[a]).then(a.cmp(&b)));

        let low = boxes().fold(DVec3::INFINITY, |low, bounds| low.min(bounds.low))[axes[0]];
        let high = boxes().fold(DVec3::NEG_INFINITY, |high, bounds| high.max(bounds.high))[axes[0]];
        let size = sum(&|bounds| bounds.high - bounds.low)[axes[0]];
        let width = size.max((high - low) / count);
        let strips = if width > 0.0 { ((high - low) / width).ceil().max(1.0) as usize } else { 1 };
        Self { axes, begin: low, width, strips }
    }

    /// First and last strip of a box.
    fn strips_of(&self, bounds: &Bounds) -> [usize; 2] {
        // NaN maps to the first strip.
        let axis = self.axes[0];
        let strip = |x: f64| (((x - self.begin) / self.width) as usize).min(self.strips - 1);
        [strip(bounds.low[axis]), strip(bounds.high[axis])]
    }

    fn entry(&self, bounds: &Bounds, index: u32, first_strip: u32, moves: bool) -> Entry {
        let range = |axis: usize| [round_down(bounds.low[axis]), -round_down(-bounds.high[axis])];
        let [across, along, third] = self.axes;
        let (along, across, third) = (range(along), range(across), range(third));
        Entry { along, across, third, index, first_strip, moves }
    }
}

/// Largest single-precision number not above `x`.
fn round_down(x: f64) -> f32 {
    let near = x as f32;
    if f64::from(near) > x { near.next_down() } else { near }
}

/// Integer with the order of floats; both zeros map to one value.
fn ascending(x: f32) -> u32 {
    let bits = (x + 0.0).to_bits();
    if bits >> 31 == 1 { !bits } else { bits | 1 << 31 }
}
