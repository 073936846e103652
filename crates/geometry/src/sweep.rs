//! Distances far from a surface, by fast sweeping.

use crate::Grid;
use crate::bvh::closest_point_on_triangle;
use glam::DVec3;

/// No triangle is known yet.
pub(crate) const UNKNOWN: u32 = u32::MAX;

/// What is known at each node of a grid about the nearest of some triangles.
pub(crate) struct Nearest {
    /// [m]; infinite where nothing is known.
    pub(crate) distance: Vec<f32>,
    /// Index of the triangle, or [`UNKNOWN`].
    pub(crate) triangle: Vec<u32>,
}

impl Nearest {
    /// Hands the nearest triangle on from node to node, in the order of the fast sweeping method [Zha05], so that each
    /// node gets the exact distance to a triangle that is nearest to one of its neighbours. That is the nearest one
    /// to the node too, or misses it by much less than a cell.
    pub(crate) fn sweep(&mut self, grid: &Grid, triangles: &[[DVec3; 3]]) {
        let steps = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
        for direction in 0..8 {
            // One sweep for each octant that the way from the surface may point into.
            let upward = [0, 1, 2].map(|axis| direction >> axis & 1 == 0);
            let along =
                |axis: usize, count: usize| if upward[axis] { count } else { grid.dims[axis] - 1 - count };
            for k in (0..grid.dims[2]).map(|count| along(2, count)) {
                for j in (0..grid.dims[1]).map(|count| along(1, count)) {
                    for i in (0..grid.dims[0]).map(|count| along(0, count)) {
                        let (node, cell) = (grid.index(i, j, k), [i, j, k]);
                        for axis in 0..3 {
                            if upward[axis] && cell[axis] > 0 {
                                self.hand_on(grid, triangles, node - steps[axis], node);
                            } else if !upward[axis] && cell[axis] + 1 < grid.dims[axis] {
                                self.hand_on(grid, triangles, node + steps[axis], node);
                            }
                        }
                    }
                }
            }
        }
    }

    /// Tries the nearest triangle of a neighbour, which must be nearer to the surface.
    #[inline]
    fn hand_on(&mut self, grid: &Grid, triangles: &[[DVec3; 3]], from: usize, to: usize) {
        let candidate = self.triangle[from];
        if candidate == self.triangle[to] || self.distance[from] >= self.distance[to] {
            return;
        }
        let [i, j, k] = grid.coordinates(to);
        let point = grid.node(i, j, k);
        let way = point - closest_point_on_triangle(point, &triangles[candidate as usize]);
        let distance = way.length() as f32;
        if distance < self.distance[to] {
            self.distance[to] = distance;
            self.triangle[to] = candidate;
        }
    }
}
