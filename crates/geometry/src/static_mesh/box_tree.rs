//! A tree of boxes in single precision, over items that it sorts.

use glam::{DVec3, Vec3};

/// A subtree with at most this many items is a leaf [1]. With 8, visits test a third more items.
const LEAF: usize = 4;

/// Bins of the surface-area heuristic [Wald07].
const BINS: usize = 16;

/// Parents before children; node 0 is the root. 32 bytes each.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct BoxTree {
    nodes: Vec<Node>,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Node {
    low: [f32; 3],
    /// First child of a branch, first item of a leaf.
    first: u32,
    high: [f32; 3],
    /// Number of items of a leaf; 0 for a branch. The highest bit says that none is marked.
    count: u32,
}

const UNMARKED: u32 = 1 << 31;

/// Lowest and highest corner around a triangle [m], rounded outwards.
pub(crate) fn box_around(positions: &[DVec3], corners: &[u32; 3]) -> [Vec3; 2] {
    let [a, b, c] = corners.map(|vertex| positions[vertex as usize]);
    let down = |x: f64| {
        let single = x as f32;
        if f64::from(single) > x { single.next_down() } else { single }
    };
    let up = |x: f64| {
        let single = x as f32;
        if f64::from(single) < x { single.next_up() } else { single }
    };
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    [
        Vec3::new(down(low.x), down(low.y), down(low.z)),
        Vec3::new(up(high.x), up(high.y), up(high.z)),
    ]
}

/// Longest way from the root to a leaf; what is deeper is one leaf.
const MOST_DEPTH: usize = 48;

impl BoxTree {
    /// Sorts boxes into a tree; also the order of the items in it.
    pub(crate) fn new(boxes: &[[Vec3; 2]]) -> (Self, Vec<u32>) {
        let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
        let mut nodes = Vec::with_capacity(boxes.len());
        nodes.push(Node { low: [0.0; 3], first: 0, high: [0.0; 3], count: boxes.len() as u32 });
        let mut waiting = vec![(0, 0..boxes.len(), 0)];
        let mut spare = Vec::new();
        while let Some((node, range, depth)) = waiting.pop() {
            let items = &mut order[range.clone()];
            let (low, high) = union(boxes, items);
            let whole = Node {
                low: low.to_array(),
                first: range.start as u32,
                high: high.to_array(),
                count: items.len() as u32,
            };
            let cut = if depth < MOST_DEPTH { split(boxes, items, &mut spare) } else { None };
            nodes[node] = whole;
            if let Some(cut) = cut {
                let children = nodes.len();
                nodes[node] = Node { first: children as u32, count: 0, ..whole };
                nodes.extend([whole; 2]);
                let middle = range.start + cut;
                waiting.push((children + 1, middle..range.end, depth + 1));
                waiting.push((children, range.start..middle, depth + 1));
            }
        }
        nodes.shrink_to_fit();
        (Self { nodes }, order)
    }

    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        self.nodes.first().map_or((DVec3::ZERO, DVec3::ZERO), Node::bounds)
    }

    /// Marks some items for [`BoxTree::visit`].
    pub(crate) fn mark(&mut self, is_marked: impl Fn(usize) -> bool) {
        for at in (0..self.nodes.len()).rev() {
            let Node { first, count, .. } = self.nodes[at];
            let holds = if count > 0 {
                (first..first + count).any(|item| is_marked(item as usize))
            } else {
                let children = &self.nodes[first as usize..first as usize + 2];
                children.iter().any(|child| child.count & UNMARKED == 0)
            };
            self.nodes[at].count |= if holds { 0 } else { UNMARKED };
        }
    }

    /// Calls `visit` with the items of all leaves whose boxes, and all boxes above them, pass
    /// `enters`, in the order of the items; if asked for, without leaves that hold no marked item.
    #[inline]
    pub(crate) fn visit(
        &self,
        only_marked: bool,
        mut enters: impl FnMut(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(usize),
    ) {
        let mut stack = [0_u32; MOST_DEPTH + 2];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting] as usize];
            let (low, high) = node.bounds();
            if only_marked && node.count & UNMARKED != 0 || !enters(low, high) {
                continue;
            }
            let count = node.count & !UNMARKED;
            if count > 0 {
                (node.first..node.first + count).for_each(|item| visit(item as usize));
            } else {
                (stack[waiting], stack[waiting + 1]) = (node.first + 1, node.first);
                waiting += 2;
            }
        }
    }

    /// Calls `visit(item, bound)` with items in leaves nearer to a point than a bound [m^2], nearer
    /// boxes first; `visit` gives the next bound.
    pub(crate) fn visit_nearest(
        &self,
        point: DVec3,
        mut bound_squared: f64,
        mut visit: impl FnMut(usize, f64) -> f64,
    ) {
        let mut stack = [(0_u32, 0.0); MOST_DEPTH + 2];
        let mut waiting = 1;
        while waiting > 0 {
            waiting -= 1;
            let (index, squared) = stack[waiting];
            if squared >= bound_squared {
                continue;
            }
            let node = &self.nodes[index as usize];
            let count = node.count & !UNMARKED;
            if count > 0 {
                for item in node.first..node.first + count {
                    bound_squared = visit(item as usize, bound_squared);
                }
            } else {
                let [left, right] = [node.first, node.first + 1]
                    .map(|child| (child, self.nodes[child as usize].distance_squared(point)));
                let (near, far) = if left.1 <= right.1 { (left, right) } else { (right, left) };
                (stack[waiting], stack[waiting + 1]) = (far, near);
                waiting += 2;
            }
        }
    }
}

impl Node {
    #[inline]
    fn bounds(&self) -> (DVec3, DVec3) {
        (Vec3::from_array(self.low).as_dvec3(), Vec3::from_array(self.high).as_dvec3())
    }

    #[inline]
    fn distance_squared(&self, point: DVec3) -> f64 {
        let (low, high) = self.bounds();
        (point - point.clamp(low, high)).length_squared()
    }
}

fn union(boxes: &[[Vec3; 2]], items: &[u32]) -> (Vec3, Vec3) {
    items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &item| {
        let [item_low, item_high] = boxes[item as usize];
        (low.min(item_low), high.max(item_high))
    })
}

fn half_area((low, high): (Vec3, Vec3)) -> f32 {
    let extent = high - low;
    extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
}

/// Partitions the items of a node in two and gives the size of the first part; `None` for a leaf.
/// Both parts keep the order of their items.
fn split(boxes: &[[Vec3; 2]], items: &mut [u32], spare: &mut Vec<u32>) -> Option<usize> {
    if items.len() <= LEAF {
        return None;
    }
    let middle = |item: u32| {
        let [low, high] = boxes[item as usize];
        0.5 * low + 0.5 * high
    };
    let (low, high) =
        items.iter().fold((Vec3::INFINITY, Vec3::NEG_INFINITY), |(low, high), &item| {
            (low.min(middle(item)), high.max(middle(item)))
        });
    let extent = high - low;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let scale = BINS as f32 / extent[axis];
    if !scale.is_finite() {
        // All middles coincide: any halves are as good.
        return Some(items.len() / 2);
    }
    let bin_of = |item: u32| (((middle(item)[axis] - low[axis]) * scale) as usize).min(BINS - 1);

    // Cut where items times box area on either side are least.
    const NONE: (usize, (Vec3, Vec3)) = (0, (Vec3::INFINITY, Vec3::NEG_INFINITY));
    type Bin = (usize, (Vec3, Vec3));
    let join = |a: Bin, b: Bin| -> Bin { (a.0 + b.0, (a.1.0.min(b.1.0), a.1.1.max(b.1.1))) };
    let mut bins = [NONE; BINS];
    for &item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        let [item_low, item_high] = boxes[item as usize];
        *bin = join(*bin, (1, (item_low, item_high)));
    }
    let mut above = bins;
    for bin in (0..BINS - 1).rev() {
        above[bin] = join(bins[bin], above[bin + 1]);
    }
    let cost = |side: Bin| if side.0 == 0 { 0.0 } else { side.0 as f32 * half_area(side.1) };
    let (mut below, mut best) = (bins[0], (f32::INFINITY, 1));
    for cut in 1..BINS {
        let total = cost(below) + cost(above[cut]);
        if below.0 > 0 && above[cut].0 > 0 && total < best.0 {
            best = (total, cut);
        }
        below = join(below, bins[cut]);
    }

    spare.clear();
    spare.extend(items.iter().copied().filter(|&item| bin_of(item) >= best.1));
    let mut kept = 0;
    for at in 0..items.len() {
        let item = items[at];
        if bin_of(item) < best.1 {
            items[kept] = item;
            kept += 1;
        }
    }
    items[kept..].copy_from_slice(spare);
    // Boxes that overflow single precision have no least cost.
    Some(if kept == 0 || kept == items.len() { items.len() / 2 } else { kept })
}
