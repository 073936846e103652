//! Contact graph: support relations between bodies [GBF03 sec. 5, 6].

use frangible_bodies::{Bodies, Frame, Pair, Pose, accelerate, evolve_all};
use frangible_collision::{overlap, placed};

/// Pairs in contact, by the level of their upper body: lower levels first.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ContactGraph {
    /// Bodies in a ring of mutual support share a level.
    pub levels: Vec<Level>,
}

/// One level of the graph.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Level {
    /// Bodies on this level, by dense index.
    pub bodies: Vec<usize>,
    /// Pairs with their upper body on this level, in increasing order.
    pub pairs: Vec<Pair>,
}

/// Builds the graph from the velocities after collisions: each body in turn falls through one frame
/// while all others move without gravity; bodies hit by the fall lie below.
pub fn contact_graph(bodies: &Bodies, candidates: &[Pair], frame: &Frame) -> ContactGraph {
    let others = evolve_all(bodies, &bodies.poses, &bodies.velocities, frame);
    let falling = accelerate(bodies, &bodies.velocities, 0.5 * frame.dt, frame);
    let fallen = evolve_all(bodies, &bodies.poses, &falling, frame);

    // An edge goes from the lower to the upper body.
    let mut edges = Vec::new();
    for &pair in candidates {
        for (upper, lower) in [(pair.first, pair.second), (pair.second, pair.first)] {
            if !bodies.inertias[upper].is_infinite()
                && falls_into(bodies, pair, upper, &fallen, &others)
            {
                edges.push((lower, upper));
            }
        }
    }
    levels_of(bodies.len(), &edges)
}

/// True if the fallen `upper` overlaps the other body of the pair, not fallen.
fn falls_into(bodies: &Bodies, pair: Pair, upper: usize, fallen: &[Pose], others: &[Pose]) -> bool {
    let (mut first, mut second) = placed(bodies, pair, others);
    if upper == pair.first {
        first.pose = &fallen[upper];
    } else {
        second.pose = &fallen[upper];
    }
    overlap(first, second)
}

/// Levels of the graph with `count` nodes and edges `(lower, upper)`: one per strongly connected
/// component, in topological order.
fn levels_of(count: usize, edges: &[(usize, usize)]) -> ContactGraph {
    let components = strongly_connected_components(count, edges);
    let mut level_of = vec![0; count];
    let mut levels = vec![Level::default(); components.len()];
    for (level, component) in components.into_iter().enumerate() {
        for &body in &component {
            level_of[body] = level;
        }
        levels[level].bodies = component;
    }
    for &(lower, upper) in edges {
        levels[level_of[upper]]
            .pairs
            .push(Pair { first: lower.min(upper), second: lower.max(upper) });
    }
    for level in &mut levels {
        level.pairs.sort_unstable();
        level.pairs.dedup();
    }
    levels.retain(|level| !level.pairs.is_empty());
    ContactGraph { levels }
}

/// Tarjan's algorithm [Tar72] with an explicit stack; components in topological order of `from ->
/// to`, each sorted.
fn strongly_connected_components(count: usize, edges: &[(usize, usize)]) -> Vec<Vec<usize>> {
    const UNSEEN: usize = usize::MAX;
    let mut next = vec![Vec::new(); count];
    for &(from, to) in edges {
        next[from].push(to);
    }
    let (mut order, mut low) = (vec![UNSEEN; count], vec![0; count]);
    let mut open = Vec::new();
    let mut is_open = vec![false; count];
    let mut clock = 0;
    let mut components = Vec::new();

    for root in 0..count {
        if order[root] != UNSEEN {
            continue;
        }
        // Depth-first search; each entry is a node and its number of followed edges.
        let mut path = vec![(root, 0)];
        while let Some(&mut (node, ref mut followed)) = path.last_mut() {
            if *followed == 0 {
                order[node] = clock;
                low[node] = clock;
                clock += 1;
                open.push(node);
                is_open[node] = true;
            }
            if let Some(&to) = next[node].get(*followed) {
                *followed += 1;
                if order[to] == UNSEEN {
                    path.push((to, 0));
                } else if is_open[to] {
                    low[node] = low[node].min(order[to]);
                }
                continue;
            }
            // All edges are done: close the component if this node is its root.
            if low[node] == order[node] {
                let start = open.iter().rposition(|&other| other == node).unwrap_or(0);
                let mut component = open.split_off(start);
                component.iter().for_each(|&member| is_open[member] = false);
                component.sort_unstable();
                components.push(component);
            }
            path.pop();
            if let Some(&(parent, _)) = path.last() {
                low[parent] = low[parent].min(low[node]);
            }
        }
    }
    components.reverse();
    components
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stack_has_one_level_for_each_body_from_the_ground_up() {
        let graph = levels_of(4, &[(3, 1), (0, 3), (1, 2)]);
        let bodies: Vec<_> = graph.levels.iter().map(|level| level.bodies.clone()).collect();
        assert_eq!(bodies, [[3], [1], [2]], "the ground, 0, rests on nothing");
        assert_eq!(graph.levels[0].pairs, [Pair { first: 0, second: 3 }]);
    }

    #[test]
    fn bodies_that_rest_on_each_other_share_a_level() {
        let ring = [(0, 1), (1, 2), (2, 3), (3, 1), (3, 4)];
        let graph = levels_of(5, &ring);
        assert_eq!(graph.levels[0].bodies, [1, 2, 3]);
        assert_eq!(graph.levels[0].pairs.len(), 4);
        assert_eq!(graph.levels[1].bodies, [4]);
    }

    #[test]
    fn every_node_is_in_one_component_and_edges_go_up() {
        // A small linear congruential generator: enough for graphs of every kind.
        let mut seed = 1_u64;
        let mut random = |bound: usize| {
            seed = seed
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            (seed >> 33) as usize % bound
        };
        for _ in 0..200 {
            let edges: Vec<_> = (0..random(30)).map(|_| (random(12), random(12))).collect();
            let components = strongly_connected_components(12, &edges);
            let mut place = [usize::MAX; 12];
            for (rank, component) in components.iter().enumerate() {
                for &node in component {
                    assert_eq!(place[node], usize::MAX, "in one component only");
                    place[node] = rank;
                }
            }
            assert!(edges.iter().all(|&(from, to)| place[from] <= place[to]));
        }
    }
}
