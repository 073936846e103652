//! Distances far from a surface, by fast sweeping.

use crate::bvh::closest_point_on_triangle;
use crate::grid::Grid;
use glam::DVec3;

/// No triangle is known yet.
pub(crate) const UNKNOWN: u32 = u32::MAX;

/// Nearest triangle per node of a grid.
pub(crate) struct Nearest {
    /// [m]; infinite where nothing is known.
    pub(crate) distance: Vec<f32>,
    /// Index of the triangle, or [`UNKNOWN`].
    pub(crate) triangle: Vec<u32>,
}

impl Nearest {
    /// Propagates the nearest triangle from node to node by fast sweeping [Zha05]: each node
    /// farther than `exact` [m] gets the best triangle of its neighbours. The result is the nearest
    /// triangle, or misses it by much less than a cell.
    pub(crate) fn sweep(&mut self, grid: &Grid, triangles: &[[DVec3; 3]], exact: f32) {
        let [nx, ny, nz] = grid.dims;
        for direction in 0..8 {
            // One sweep per octant of directions from the surface.
            let upward = [0, 1, 2].map(|axis| direction >> axis & 1 == 0);
            let along = |axis: usize, count: usize| {
                if upward[axis] { count } else { grid.dims[axis] - 1 - count }
            };
            let [x, y, z] = [(0, 1), (1, nx), (2, nx * ny)].map(|(axis, step): (usize, usize)| {
                if upward[axis] { -(step as isize) } else { step as isize }
            });
            let back = [0, x, y, x + y, z, z + x, z + y, z + x + y];

            for (c, b) in (0..nz).flat_map(|c| (0..ny).map(move |b| (c, b))) {
                for a in 0..nx {
                    let cell = [along(0, a), along(1, b), along(2, c)];
                    let node = grid.index(cell[0], cell[1], cell[2]);
                    if self.distance[node] <= exact {
                        continue;
                    }

                    // Ask the neighbours across the faces, edges and the corner behind the node,
                    // one for each set of axes along which there is one.
                    let present =
                        usize::from(a > 0) + 2 * usize::from(b > 0) + 4 * usize::from(c > 0);
                    for (axes, back) in back.iter().enumerate().skip(1) {
                        if axes & !present == 0 {
                            self.hand_on(grid, triangles, node.wrapping_add_signed(*back), cell);
                        }
                    }
                }
            }
        }
    }

    /// Tries the nearest triangle of a neighbour, which must be nearer to the surface.
    #[inline]
    fn hand_on(
        &mut self,
        grid: &Grid,
        triangles: &[[DVec3; 3]],
        from: usize,
        [i, j, k]: [usize; 3],
    ) {
        let to = grid.index(i, j, k);
        let candidate = self.triangle[from];
        if candidate == self.triangle[to] || self.distance[from] >= self.distance[to] {
            return;
        }
        let point = grid.node(i, j, k);
        let way = point - closest_point_on_triangle(point, &triangles[candidate as usize]);
        let distance = way.length() as f32;
        if distance < self.distance[to] {
            self.distance[to] = distance;
            self.triangle[to] = candidate;
        }
    }
}
