//! Sites in the order of their distance from a point, one after the other: a k-d tree of which
//! nodes and sites wait in one queue by distance [HS99].
//!
//! A tree halves sites, wherever they lie. Buckets of a grid would hold most sites in a few of them
//! where sites cluster.

use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Most sites of a leaf.
const LEAF: usize = 8;

/// Marks sites among the queue's numbers: behind the nodes that are as near.
const SITE: u32 = 1 << 31;

/// A k-d tree of sites.
#[derive(Debug)]
pub(super) struct SiteTree {
    /// Leaf after leaf, with their numbers.
    sites: Vec<(DVec3, u32)>,
    /// The root is first, and the lower half of each inner node follows it.
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    /// Box around its sites.
    low: DVec3,
    high: DVec3,
    /// Range of its sites.
    first: u32,
    end: u32,
    /// The node of its upper half; 0 for a leaf.
    upper: u32,
}

/// Reused from point to point.
#[derive(Debug)]
pub(super) struct NearestSites<'a> {
    tree: &'a SiteTree,
    point: DVec3,
    /// Bits of squared distances, which have the order of these, and numbers of nodes and sites.
    queue: BinaryHeap<Reverse<(u64, u32)>>,
}

impl SiteTree {
    /// Of finite sites, of which there are fewer than 2^31.
    pub(super) fn new(sites: &[DVec3]) -> Self {
        let mut sites: Vec<(DVec3, u32)> = sites.iter().copied().zip(0..).collect();
        let mut nodes = Vec::with_capacity(4 * sites.len() / LEAF + 1);
        add_nodes(&mut sites, 0, &mut nodes);
        Self { sites, nodes }
    }
}

/// Adds the node of some sites and those below it. `first` is the place of these sites among all.
fn add_nodes(sites: &mut [(DVec3, u32)], first: u32, nodes: &mut Vec<Node>) {
    let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) =
        sites.iter().fold(none, |(low, high), (site, _)| (low.min(*site), high.max(*site)));
    let node = nodes.len();
    nodes.push(Node { low, high, first, end: first + sites.len() as u32, upper: 0 });
    if sites.len() <= LEAF {
        return;
    }
    let axis = (high - low).max_position();
    let half = sites.len() / 2;
    sites.select_nth_unstable_by(half, |a, b| a.0[axis].total_cmp(&b.0[axis]));
    let (lower, upper) = sites.split_at_mut(half);
    add_nodes(lower, first, nodes);
    nodes[node].upper = nodes.len() as u32;
    add_nodes(upper, first + half as u32, nodes);
}

impl<'a> NearestSites<'a> {
    pub(super) fn new(tree: &'a SiteTree) -> Self {
        Self { tree, point: DVec3::ZERO, queue: BinaryHeap::new() }
    }

    /// Begins anew at a point.
    pub(super) fn begin(&mut self, point: DVec3) {
        self.point = point;
        self.queue.clear();
        self.add_node(0);
    }

    /// The next site: farther than those before, or as far with a higher number. Boxes of sites that
    /// are of no use are left out.
    pub(super) fn next(&mut self, is_of_use: impl Fn(DVec3, DVec3) -> bool) -> Option<usize> {
        loop {
            let Reverse((_, number)) = self.queue.pop()?;
            if number & SITE != 0 {
                return Some((number & !SITE) as usize);
            }
            let node = self.tree.nodes[number as usize];
            if !is_of_use(node.low, node.high) {
                continue;
            }
            if node.upper == 0 {
                for &(site, of_site) in &self.tree.sites[node.first as usize..node.end as usize] {
                    let squared = (site - self.point).length_squared();
                    self.queue.push(Reverse((squared.to_bits(), of_site | SITE)));
                }
            } else {
                self.add_node(number + 1);
                self.add_node(node.upper);
            }
        }
    }

    /// No site of the node is nearer than its box, rounding included: subtraction, squares and sums
    /// never turn an order round.
    fn add_node(&mut self, number: u32) {
        let Node { low, high, .. } = self.tree.nodes[number as usize];
        let away = (low - self.point).max(self.point - high).max(DVec3::ZERO);
        self.queue.push(Reverse((away.length_squared().to_bits(), number)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(200))]

        /// All sites come once, by distance and then by number, however many are equally far.
        #[test]
        fn sites_come_by_distance_and_number(
            places in prop::collection::vec((-4..5_i32, -4..5_i32, -4..5_i32), 1..120),
            scale in prop::sample::select(vec![1.0, 0.1, 1e-9]),
        ) {
            let sites: Vec<DVec3> = places
                .iter()
                .map(|&(x, y, z)| scale * DVec3::new(f64::from(x), f64::from(y), f64::from(z)))
                .collect();
            let tree = SiteTree::new(&sites);
            let mut nearest = NearestSites::new(&tree);
            for &point in &sites {
                let mut expected: Vec<usize> = (0..sites.len()).collect();
                let squared = |site: usize| (sites[site] - point).length_squared();
                expected.sort_by(|&a, &b| squared(a).total_cmp(&squared(b)));
                nearest.begin(point);
                let found: Vec<usize> = std::iter::from_fn(|| nearest.next(|_, _| true)).collect();
                prop_assert_eq!(found, expected);
            }
        }
    }

    /// The first hundred sites cost a few hundred entries of the queue, wherever sites lie: evenly,
    /// in one plane, on a line, or most of them in a millionth of the space.
    #[test]
    fn the_work_does_not_grow_with_crowds() {
        const COUNT: usize = 5000;
        const FIRST: usize = 100;
        // Weyl's sequences are spread evenly.
        let even = |n: usize| {
            let along = |step: f64| (n as f64 * step).fract();
            DVec3::new(along(0.819_172_513), along(0.671_043_607), along(0.549_700_478))
        };
        let crowd = |n: usize| if n.is_multiple_of(50) { even(n) } else { 1e-6 * even(n) };
        let layouts: [&dyn Fn(usize) -> DVec3; 4] =
            [&even, &|n| even(n) * DVec3::new(1.0, 1.0, 0.0), &|n| even(n) * DVec3::X, &crowd];
        for (layout, place) in layouts.into_iter().enumerate() {
            let sites: Vec<DVec3> = (0..COUNT).map(place).collect();
            let tree = SiteTree::new(&sites);
            let mut nearest = NearestSites::new(&tree);
            let mut most = 0;
            for &site in &sites {
                nearest.begin(site);
                (0..FIRST).for_each(|_| assert!(nearest.next(|_, _| true).is_some()));
                most = most.max(FIRST + nearest.queue.len());
            }
            assert!(most < 800, "{layout}: {most}");
        }
    }
}
