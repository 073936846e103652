//! Fixed bodies that the same body may meet.

use frangible_bodies::{Bodies, Pair};

/// Fixed bodies near each body that is near two of them or more.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FixedNeighbours {
    /// In ascending order, one entry per fixed body.
    of: Vec<u32>,
    fixed: Vec<u32>,
}

impl FixedNeighbours {
    /// The same as [`Self::of_pairs`] for the pairs of a whole world: most have one fixed body, the
    /// ground, and there is nothing to sort.
    pub fn of_world(bodies: &Bodies, pairs: impl Iterator<Item = Pair>) -> Self {
        let mut fixed = bodies.inertias.iter().filter(|inertia| inertia.is_infinite());
        if fixed.nth(1).is_none() { Self::default() } else { Self::of_pairs(bodies, pairs) }
    }

    /// From all pairs that may touch, some of them more than once.
    pub fn of_pairs(bodies: &Bodies, pairs: impl Iterator<Item = Pair>) -> Self {
        let is_fixed = |i: usize| bodies.inertias[i].is_infinite();
        let with_fixed = |Pair { first, second }: Pair| match (is_fixed(first), is_fixed(second)) {
            (true, false) => Some((second as u32, first as u32)),
            (false, true) => Some((first as u32, second as u32)),
            _ => None,
        };
        let mut all: Vec<(u32, u32)> = pairs.filter_map(with_fixed).collect();
        all.sort_unstable();
        all.dedup();
        let several = all.chunk_by(|a, b| a.0 == b.0).filter(|of_one| of_one.len() > 1);
        let (of, fixed) = several.flatten().copied().unzip();
        Self { of, fixed }
    }

    /// Dense indices of the fixed bodies near the body of a pair that moves, itself included.
    pub fn of_pair(&self, Pair { first, second }: Pair) -> &[u32] {
        if self.of.is_empty() {
            return &[];
        }
        let of = |i: usize| {
            let range = [i, i + 1].map(|i| self.of.partition_point(|&other| (other as usize) < i));
            &self.fixed[range[0]..range[1]]
        };
        // Fixed bodies have no entries of their own.
        let of_first = of(first);
        if of_first.is_empty() { of(second) } else { of_first }
    }
}
