//! Crowds: dense overlaps with an unmanageable number of pairs.
//!
//! Only the deepest overlaps are kept. After those bodies separate, others follow.

use crate::broad_phase::bounds::Bounds;
use frangible_bodies::Pair;

/// Pairs kept per body in a crowd. Twelve equal balls fit around a ball.
const NEAREST: usize = 24;

/// Pair count below which no thinning takes place.
const FEWEST: usize = 10_000;

/// Maximum number of pairs without thinning: twice the kept number, beyond any number of
/// neighbours.
pub(super) fn most_pairs(bodies: usize) -> usize {
    2 * NEAREST * bodies + FEWEST
}

/// Overlap of two boxes: minimum translation along an axis [m].
fn depth(a: &Bounds, b: &Bounds) -> f64 {
    (a.high.min(b.high) - a.low.max(b.low)).min_element()
}

/// Pairs among the deepest of either body, and the number of omitted pairs. `visit` must iterate
/// over all pairs in the same order each time. A body with few pairs keeps all.
pub(super) fn thinned(
    bounds: &[Bounds],
    visit: impl Fn(&mut dyn FnMut(Pair)),
) -> (Vec<Pair>, usize) {
    let mut count = vec![0_u32; bounds.len()];
    let mut all = 0;
    visit(&mut |Pair { first, second }| {
        all += 1;
        count[first] += 1;
        count[second] += 1;
    });
    let has_few = |i: usize| count[i] as usize <= NEAREST;

    // Collect each body's deepest pairs in descending order; break ties by index distance, to
    // spread the choice.
    let mut deepest: Vec<Vec<(f64, usize)>> = vec![Vec::new(); bounds.len()];
    let mut pairs = Vec::new();
    visit(&mut |pair| {
        let Pair { first, second } = pair;
        if has_few(first) || has_few(second) {
            pairs.push(pair);
            return;
        }
        let depth = depth(&bounds[first], &bounds[second]);
        for (own, other) in [(first, second), (second, first)] {
            let is_before = |&(known, by): &(f64, usize)| {
                known > depth
                    || (known == depth && (by.abs_diff(own), by) < (other.abs_diff(own), other))
            };
            let of_own = &mut deepest[own];
            if of_own.len() == NEAREST && of_own.last().is_some_and(is_before) {
                continue;
            }
            let at = of_own.partition_point(is_before);
            of_own.insert(at, (depth, other));
            of_own.truncate(NEAREST);
        }
    });
    let chosen = |(own, others): (usize, &Vec<(f64, usize)>)| -> Vec<Pair> {
        let pair =
            |&(_, other): &(f64, usize)| Pair { first: own.min(other), second: own.max(other) };
        others.iter().map(pair).collect()
    };
    pairs.extend(deepest.iter().enumerate().flat_map(chosen));
    pairs.sort_unstable();
    pairs.dedup();
    let left_out = all - pairs.len();
    (pairs, left_out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// Each body of a crowd keeps its quota including its nearest neighbours, and a body aside
    /// keeps all pairs.
    #[test]
    fn each_keeps_its_nearest() {
        let cube = |x: f64| Bounds {
            low: DVec3::new(x - 1.0, -1.0, -1.0),
            high: DVec3::new(x + 1.0, 1.0, 1.0),
        };
        let mut bounds: Vec<Bounds> = (0..200).map(|n| cube(1e-3 * f64::from(n))).collect();
        bounds.push(cube(2.1));
        let visit = |take: &mut dyn FnMut(Pair)| {
            for first in 0..bounds.len() {
                for second in first + 1..bounds.len() {
                    if bounds[first].overlaps(&bounds[second]) {
                        take(Pair { first, second });
                    }
                }
            }
        };
        let (pairs, left_out) = thinned(&bounds, visit);
        let mut all = 0;
        visit(&mut |_| all += 1);
        assert_eq!(pairs.len() + left_out, all);
        assert!(pairs.len() < 200 * NEAREST, "{}", pairs.len());
        let of = |i: usize| pairs.iter().filter(|pair| pair.first == i || pair.second == i).count();
        assert!((0..200).all(|i| of(i) >= NEAREST), "none has fewer");
        assert!(
            (0..199).all(|first| pairs.contains(&Pair { first, second: first + 1 })),
            "neighbours"
        );
        let aside = bounds[..200].iter().filter(|other| other.overlaps(&bounds[200])).count();
        assert!(of(200) >= aside.min(NEAREST), "{} of {aside}", of(200));
    }
}
