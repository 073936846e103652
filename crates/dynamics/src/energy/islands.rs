//! Energy islands: bodies that exchanged impulses in a frame, directly or through others.

use frangible_bodies::{Bodies, BodyId};
use std::collections::BTreeMap;

/// Disjoint-set forest of bodies. A living body's node is its dense index; removed bodies follow.
#[derive(Clone, Debug, Default)]
pub(crate) struct Islands {
    /// Parent of each node: a root is its own parent, [`NONE`] marks nodes without links.
    parent: Vec<u32>,
    gone: BTreeMap<BodyId, u32>,
    number: Vec<u32>,
}

/// Marks nodes without an island.
const NONE: u32 = u32::MAX;

impl Islands {
    /// A forest without links.
    pub(crate) fn new(bodies: &Bodies) -> Self {
        Self { parent: vec![NONE; bodies.len()], ..Self::default() }
    }

    /// Node of a body.
    pub(crate) fn node(&mut self, bodies: &Bodies, id: BodyId) -> u32 {
        if let Some(dense) = bodies.index_of(id) {
            return dense as u32;
        }
        let next = self.parent.len() as u32;
        let node = *self.gone.entry(id).or_insert(next);
        if node == next {
            self.parent.push(NONE);
        }
        node
    }

    /// Unites the islands of two nodes.
    pub(crate) fn link(&mut self, a: u32, b: u32) {
        self.join(a);
        self.join(b);
        let (a, b) = (root(&mut self.parent, a), root(&mut self.parent, b));
        // The smaller node becomes the root, independent of the order of links.
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// Makes an unlinked node an island of its own.
    pub(crate) fn join(&mut self, node: u32) {
        let parent = &mut self.parent[node as usize];
        *parent = if *parent == NONE { node } else { *parent };
    }

    /// Members of each island, in order of their smallest node; unlinked bodies are left out.
    pub(crate) fn members(&mut self, bodies: &Bodies) -> Vec<Vec<BodyId>> {
        let mut gone = vec![BodyId { index: 0, generation: 0 }; self.gone.len()];
        for (&id, &node) in &self.gone {
            gone[node as usize - bodies.len()] = id;
        }
        // Count first: most islands are small, and growing lists cost more.
        let mut sizes = Vec::new();
        self.number = vec![NONE; self.parent.len()];
        for node in 0..self.parent.len() {
            if self.parent[node] == NONE {
                continue;
            }
            let root = root(&mut self.parent, node as u32) as usize;
            if root == node {
                self.number[node] = sizes.len() as u32;
                sizes.push(0);
            }
            self.number[node] = self.number[root];
            sizes[self.number[node] as usize] += 1;
        }
        let mut members: Vec<Vec<BodyId>> = sizes.into_iter().map(Vec::with_capacity).collect();
        for (node, &number) in self.number.iter().enumerate().filter(|&(_, &number)| number != NONE)
        {
            let id = bodies.ids.get(node).copied().unwrap_or_else(|| gone[node - bodies.len()]);
            members[number as usize].push(id);
        }
        members
    }

    /// Index of a node's island in [`Self::members`], if any.
    pub(crate) fn number(&self, node: u32) -> Option<usize> {
        self.number
            .get(node as usize)
            .filter(|&&number| number != NONE)
            .map(|&number| number as usize)
    }
}

/// Root of a node's island, with path halving.
pub(crate) fn root(parent: &mut [u32], node: u32) -> u32 {
    let mut at = node;
    loop {
        let up = parent[at as usize];
        if up == at {
            return at;
        }
        // Path halving.
        parent[at as usize] = parent[up as usize];
        at = up;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, Pose, SurfaceProperties, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use std::sync::Arc;

    /// Independent of link order and of links to removed bodies.
    #[test]
    fn links_make_islands_in_any_order() {
        let shape = Arc::new(Shape::closed_form(ClosedForm::Sphere { radius: 0.1 }, 0.1));
        let mut bodies = Bodies::default();
        let body = || NewBody {
            shape: shape.clone(),
            density: 1.0,
            motion: Motion::Dynamic,
            pose: Pose { position: glam::DVec3::ZERO, orientation: glam::DQuat::IDENTITY },
            velocity: Velocity::default(),
            surface: SurfaceProperties::new(0.0, 0.0),
        };
        let ids: Vec<BodyId> = (0..10).map(|_| bodies.spawn(body())).collect();
        let gone: Vec<bool> = (0..10).map(|i| i == 3 || i == 8).collect();
        bodies.remove(&gone);
        let links = [(5, 3), (1, 2), (3, 9), (7, 7), (2, 4)];
        let islands = |links: &[(usize, usize)]| {
            let mut islands = Islands::new(&bodies);
            for &(a, b) in links {
                let [a, b] = [a, b].map(|i| islands.node(&bodies, ids[i]));
                islands.link(a, b);
            }
            let members = islands.members(&bodies);
            for (number, island) in members.iter().enumerate() {
                let mut numbers = island.iter().map(|&id| {
                    let node = islands.node(&bodies, id);
                    islands.number(node)
                });
                assert!(numbers.all(|found| found == Some(number)));
            }
            for unlinked in [0, 8] {
                let node = islands.node(&bodies, ids[unlinked]);
                assert_eq!(islands.number(node), None);
            }
            members.iter().map(|m| m.iter().map(|id| id.index).collect()).collect::<Vec<Vec<u32>>>()
        };
        let expected = vec![vec![1, 2, 4], vec![5, 9, 3], vec![7]];
        assert_eq!(islands(&links), expected);
        let mut reversed = links;
        reversed.reverse();
        assert_eq!(islands(&reversed), expected);
    }
}
