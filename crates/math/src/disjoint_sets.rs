//! Union-find.

/// A partition of `0..n` that only grows coarser. The root of a set is its least member.
#[derive(Clone, Debug)]
pub struct DisjointSets {
    parent: Vec<u32>,
}

impl DisjointSets {
    /// `count` sets of one member each.
    pub fn new(count: usize) -> Self {
        Self { parent: (0..count as u32).collect() }
    }

    /// The root of the set that holds `member`.
    #[inline]
    pub fn root(&mut self, member: u32) -> u32 {
        let mut at = member;
        while self.parent[at as usize] != at {
            // Halve the path for the next visitor.
            let above = self.parent[self.parent[at as usize] as usize];
            self.parent[at as usize] = above;
            at = above;
        }
        at
    }

    /// Makes one set of two.
    #[inline]
    pub fn unite(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.parent[a.max(b) as usize] = a.min(b);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_united_has_its_least_member_as_root() {
        let mut sets = DisjointSets::new(6);
        for (a, b) in [(5, 3), (4, 2), (3, 4)] {
            sets.unite(a, b);
        }
        assert_eq!([0, 1, 2, 3, 4, 5].map(|member| sets.root(member)), [0, 1, 2, 2, 2, 2]);
    }
}
