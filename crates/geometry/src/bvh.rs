//! Bounding-volume hierarchy over triangles: the exact closest point.

use glam::DVec3;

/// A subtree with at most this many triangles is a leaf: about where testing all costs as much as
/// descending.
const LEAF_TRIANGLES: usize = 4;
/// Bins of the surface-area heuristic [Wald07]; more change the trees by a per cent.
const BINS: usize = 16;

/// Triangles sorted into a binary tree of boxes.
#[derive(Clone, Debug)]
pub struct Bvh {
    /// Parents before children; node 0 is the root.
    nodes: Vec<Node>,
    /// Corners of the triangles [m], those of each leaf together.
    triangles: Vec<[DVec3; 3]>,
    /// For each of `triangles`, its position in the list that the tree was built from.
    source: Vec<u32>,
}

#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    low: DVec3,
    high: DVec3,
    /// First of the node's triangles; they lie together.
    first: u32,
    count: u32,
    /// Index of the left child, the right one follows; 0 for a leaf.
    children: u32,
}

/// A point of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Closest {
    /// Squared distance to the query [m^2].
    pub distance_squared: f64,
    /// Position of the triangle in the list that the tree was built from.
    pub triangle: usize,
    /// The closest point [m].
    pub point: DVec3,
}

impl Node {
    pub(crate) fn is_leaf(&self) -> bool {
        self.children == 0
    }

    /// Indices of the two children of an inner node.
    pub(crate) fn children(&self) -> [usize; 2] {
        [self.children as usize, self.children as usize + 1]
    }

    pub(crate) fn range(&self) -> std::ops::Range<usize> {
        self.first as usize..(self.first + self.count) as usize
    }

    /// Squared distance from a point to the box [m^2].
    #[inline]
    fn distance_squared(&self, point: DVec3) -> f64 {
        (point - point.clamp(self.low, self.high)).length_squared()
    }
}

impl Bvh {
    /// Sorts triangles, given by their corners [m], into a tree by the surface-area heuristic.
    pub fn new(triangles: &[[DVec3; 3]]) -> Self {
        let mut items: Vec<Item> = triangles
            .iter()
            .enumerate()
            .map(|(source, corners)| Item::new(source, corners))
            .collect();
        let mut nodes = Vec::with_capacity(2 * triangles.len().div_ceil(LEAF_TRIANGLES));
        if !items.is_empty() {
            nodes.push(leaf(&items, 0));
        }
        let mut next = 0;
        while next < nodes.len() {
            let range = nodes[next].range();
            if let Some(middle) = split(&mut items[range.clone()]).map(|count| range.start + count)
            {
                nodes[next].children = nodes.len() as u32;
                nodes.push(leaf(&items[range.start..middle], range.start));
                nodes.push(leaf(&items[middle..range.end], middle));
            }
            next += 1;
        }
        Self {
            nodes,
            triangles: items.iter().map(|item| triangles[item.source as usize]).collect(),
            source: items.iter().map(|item| item.source).collect(),
        }
    }

    /// Sorts axis-aligned boxes, each from its lowest to its highest corner [m], into a tree for
    /// [`Bvh::visit`]: a box is the one around its own diagonal.
    pub fn of_boxes(boxes: &[(DVec3, DVec3)]) -> Self {
        let diagonals: Vec<[DVec3; 3]> =
            boxes.iter().map(|&(low, high)| [low, high, high]).collect();
        Self::new(&diagonals)
    }

    /// Calls `visit` with the list position of every item in a leaf whose box, and all boxes above
    /// it, pass `enters` (lowest and highest corner [m]), in tree order. A visited item itself need
    /// not pass.
    pub fn visit(
        &self,
        mut enters: impl FnMut(DVec3, DVec3) -> bool,
        mut visit: impl FnMut(usize),
    ) {
        let mut stack = [0; 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let node = &self.nodes[stack[waiting]];
            if !enters(node.low, node.high) {
                continue;
            }
            if node.is_leaf() || waiting + 2 > stack.len() {
                // Of a subtree deeper than the stack all is visited.
                node.range().for_each(|slot| visit(self.source[slot] as usize));
            } else {
                [stack[waiting + 1], stack[waiting]] = node.children();
                waiting += 2;
            }
        }
    }

    pub(crate) fn nodes(&self) -> &[Node] {
        &self.nodes
    }

    /// Corners [m], in the order that the ranges of the nodes refer to.
    pub(crate) fn triangles(&self) -> &[[DVec3; 3]] {
        &self.triangles
    }

    /// The closest point of the surface nearer than `bound_squared` [m^2]; `None` if there is none.
    pub fn closest(&self, point: DVec3, bound_squared: f64) -> Option<Closest> {
        self.closest_of(point, bound_squared, |_| true)
    }

    /// Closest of the `wanted` triangles, given by their list positions.
    #[inline]
    pub fn closest_of(
        &self,
        point: DVec3,
        bound_squared: f64,
        wanted: impl Fn(usize) -> bool,
    ) -> Option<Closest> {
        let mut best_squared = bound_squared;
        let mut best = None;
        let mut stack = [(0, 0.0); 64];
        let mut waiting = usize::from(!self.nodes.is_empty());
        while waiting > 0 {
            waiting -= 1;
            let (index, box_squared) = stack[waiting];
            if box_squared >= best_squared {
                continue;
            }
            let node = &self.nodes[index];
            if node.is_leaf() || waiting + 2 > stack.len() {
                // Test the triangles of a leaf (or of a subtree deeper than the stack).
                for slot in node.range().filter(|&slot| wanted(self.source[slot] as usize)) {
                    let candidate = closest_point_on_triangle(point, &self.triangles[slot]);
                    let squared = (point - candidate).length_squared();
                    if squared < best_squared {
                        best_squared = squared;
                        best = Some((slot, candidate));
                    }
                }
            } else {
                // Visit the nearer child first.
                let [left, right] = node.children();
                let to_left = self.nodes[left].distance_squared(point);
                let to_right = self.nodes[right].distance_squared(point);
                let (near, far) = if to_left <= to_right {
                    ((left, to_left), (right, to_right))
                } else {
                    ((right, to_right), (left, to_left))
                };
                stack[waiting] = far;
                stack[waiting + 1] = near;
                waiting += 2;
            }
        }
        best.map(|(slot, point)| Closest {
            distance_squared: best_squared,
            triangle: self.source[slot] as usize,
            point,
        })
    }
}

/// A triangle on its way into the tree.
#[derive(Clone, Copy)]
struct Item {
    low: DVec3,
    high: DVec3,
    source: u32,
}

impl Item {
    fn new(source: usize, corners: &[DVec3; 3]) -> Self {
        let [a, b, c] = *corners;
        Self { low: a.min(b).min(c), high: a.max(b).max(c), source: source as u32 }
    }

    fn middle(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }
}

/// A childless node around some items.
fn leaf(items: &[Item], first: usize) -> Node {
    let (low, high) = bounds(items);
    Node { low, high, first: first as u32, count: items.len() as u32, children: 0 }
}

fn bounds(items: &[Item]) -> (DVec3, DVec3) {
    items.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), item| {
        (low.min(item.low), high.max(item.high))
    })
}

fn half_area(low: DVec3, high: DVec3) -> f64 {
    let extent = high - low;
    extent.x * extent.y + extent.y * extent.z + extent.z * extent.x
}

/// Partitions the items of a node in two and returns the size of the first part; `None` if the node
/// is better a leaf.
fn split(items: &mut [Item]) -> Option<usize> {
    if items.len() <= LEAF_TRIANGLES {
        return None;
    }

    // Sort the middles into bins along the axis of their largest extent.
    let (low, high) =
        items.iter().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), item| {
            (low.min(item.middle()), high.max(item.middle()))
        });
    let extent = high - low;
    let axis = if extent.x >= extent.y && extent.x >= extent.z {
        0
    } else if extent.y >= extent.z {
        1
    } else {
        2
    };
    let scale = BINS as f64 / extent[axis];
    if !scale.is_finite() {
        // All middles coincide: any halves are as good.
        return Some(items.len() / 2);
    }
    let bin_of = |item: &Item| (((item.middle()[axis] - low[axis]) * scale) as usize).min(BINS - 1);
    let mut bins = [(0, DVec3::INFINITY, DVec3::NEG_INFINITY); BINS];
    for item in items.iter() {
        let bin = &mut bins[bin_of(item)];
        *bin = (bin.0 + 1, bin.1.min(item.low), bin.2.max(item.high));
    }

    // Cut where the expected cost, triangles times box area on either side, is least.
    let join = |a: (usize, DVec3, DVec3), b: (usize, DVec3, DVec3)| {
        (a.0 + b.0, a.1.min(b.1), a.2.max(b.2))
    };
    let mut above = bins;
    for bin in (0..BINS - 1).rev() {
        above[bin] = join(bins[bin], above[bin + 1]);
    }
    let cost = |side: (usize, DVec3, DVec3)| {
        if side.0 == 0 { 0.0 } else { side.0 as f64 * half_area(side.1, side.2) }
    };
    let mut below = bins[0];
    let mut best = (f64::INFINITY, 1);
    for cut in 1..BINS {
        let total = cost(below) + cost(above[cut]);
        if total < best.0 {
            best = (total, cut);
        }
        below = join(below, bins[cut]);
    }

    // Gather the two sides; a stable order keeps the tree the same everywhere.
    items.sort_by_key(|item| bin_of(item) >= best.1);
    Some(items.partition_point(|item| bin_of(item) < best.1))
}

/// The point of a triangle closest to `point` [Eri05 sec. 5.1.5]; also for triangles without area.
pub fn closest_point_on_triangle(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> DVec3 {
    // The regions of the corners a and b, and of the edge between them.
    let (ab, ac, ap) = (b - a, c - a, point - a);
    let (d1, d2) = (ab.dot(ap), ac.dot(ap));
    if d1 <= 0.0 && d2 <= 0.0 {
        return a;
    }
    let bp = point - b;
    let (d3, d4) = (ab.dot(bp), ac.dot(bp));
    if d3 >= 0.0 && d4 <= d3 {
        return b;
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 && d1 > d3 {
        return a + ab * (d1 / (d1 - d3));
    }

    // The region of the corner c, and of its two edges.
    let cp = point - c;
    let (d5, d6) = (ab.dot(cp), ac.dot(cp));
    if d6 >= 0.0 && d5 <= d6 {
        return c;
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 && d2 > d6 {
        return a + ac * (d2 / (d2 - d6));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 && d4 - d3 + d5 - d6 > 0.0 {
        return b + (c - b) * ((d4 - d3) / (d4 - d3 + d5 - d6));
    }

    // The inside.
    let scale = 1.0 / (va + vb + vc);
    a + ab * (vb * scale) + ac * (vc * scale)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Another way to the closest point of a triangle: the plane where its foot lies inside, or
    /// else the nearest of the edges.
    fn reference_distance(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
        let to_edge = |from: DVec3, to: DVec3| {
            let way = to - from;
            let part = ((point - from).dot(way) / way.length_squared().max(1e-300)).clamp(0.0, 1.0);
            (point - from - way * part).length()
        };
        let edges = to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a));
        let normal = (b - a).cross(c - a);
        let beside = |from: DVec3, to: DVec3| normal.cross(to - from).dot(point - from) >= 0.0;
        if normal.length() > 1e-12 && beside(a, b) && beside(b, c) && beside(c, a) {
            edges.min((point - a).dot(normal.normalize()).abs())
        } else {
            edges
        }
    }

    fn any_point() -> impl Strategy<Value = DVec3> {
        prop::array::uniform3(-1.0..1.0f64).prop_map(DVec3::from_array)
    }

    fn any_triangle() -> impl Strategy<Value = [DVec3; 3]> {
        (any_point(), any_point(), any_point(), 0..4).prop_map(|(a, b, c, kind)| match kind {
            // Small ones as in meshes, and ones without area: an edge, or a point.
            0 => [a, a + 0.05 * b, a + 0.05 * c],
            1 => [a, b, a],
            2 => [a, a, a],
            _ => [a, b, c],
        })
    }

    proptest! {
        /// The tree finds what trying every triangle finds, and nothing beyond the bound.
        #[test]
        fn closest_point_is_that_of_brute_force(
            triangles in prop::collection::vec(any_triangle(), 1..60), point in any_point(), share in 0.5..1.5f64,
        ) {
            let bvh = Bvh::new(&triangles);
            let expected = triangles.iter().map(|corners| reference_distance(point, corners)).fold(f64::INFINITY, f64::min);
            let closest = bvh.closest(point, f64::INFINITY).unwrap();
            prop_assert!((closest.distance_squared.sqrt() - expected).abs() < 1e-9);
            prop_assert!(((closest.point - point).length() - expected).abs() < 1e-9);
            prop_assert!((reference_distance(point, &triangles[closest.triangle]) - expected).abs() < 1e-9);
            let bounded = bvh.closest(point, closest.distance_squared * share);
            prop_assert_eq!(bounded.is_some(), share > 1.0 && closest.distance_squared > 0.0);
        }
    }

    #[test]
    fn many_triangles_at_one_place_are_no_obstacle() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z];
        let bvh = Bvh::new(&[corners; 1000]);
        let closest = bvh.closest(DVec3::ZERO, f64::INFINITY).unwrap();
        assert!((closest.distance_squared - 1.0 / 3.0).abs() < 1e-15);
        assert_eq!(Bvh::new(&[]).closest(DVec3::ZERO, f64::INFINITY), None);
    }
}
