//! Islands: bodies that exchanged impulses in a frame, directly or through others.

use crate::BodyId;
use std::collections::BTreeMap;

/// Groups of ids, united link by link.
#[derive(Clone, Debug, Default)]
pub struct Islands {
    parent: BTreeMap<BodyId, BodyId>,
}

impl Islands {
    /// Unites the islands of two bodies.
    pub fn link(&mut self, a: BodyId, b: BodyId) {
        let (a, b) = (self.root(a), self.root(b));
        // The smaller id stands for the island, whatever the order of the links.
        self.parent.insert(a.max(b), a.min(b));
    }

    /// The members of each island, in order of their smallest id; bodies that were never linked are not listed.
    pub fn members(&mut self) -> Vec<Vec<BodyId>> {
        let ids: Vec<BodyId> = self.parent.keys().copied().collect();
        let mut groups: BTreeMap<BodyId, Vec<BodyId>> = BTreeMap::new();
        for id in ids {
            groups.entry(self.root(id)).or_default().push(id);
        }
        groups.into_values().collect()
    }

    fn root(&mut self, id: BodyId) -> BodyId {
        let mut root = id;
        while let Some(&up) = self.parent.get(&root).filter(|&&up| up != root) {
            root = up;
        }
        // Shorten the way for the next time.
        let mut at = id;
        while at != root {
            let up = self.parent.insert(at, root);
            at = up.unwrap_or(root);
        }
        self.parent.insert(root, root);
        root
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_make_islands_in_any_order() {
        let id = |index| BodyId { index, generation: 0 };
        let links = [(5, 3), (1, 2), (3, 9), (7, 7), (2, 4)];
        let islands = |links: &[(u32, u32)]| {
            let mut islands = Islands::default();
            links.iter().for_each(|&(a, b)| islands.link(id(a), id(b)));
            islands.members().iter().map(|m| m.iter().map(|id| id.index).collect()).collect::<Vec<Vec<u32>>>()
        };
        let expected = vec![vec![1, 2, 4], vec![3, 5, 9], vec![7]];
        assert_eq!(islands(&links), expected);
        let mut reversed = links;
        reversed.reverse();
        assert_eq!(islands(&reversed), expected);
    }
}
