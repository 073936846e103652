//! Exact winding numbers of closed surfaces, by counting crossings of a line along x.
//!
//! Lines through an edge or a vertex are displaced symbolically, first along y and by far less
//! along z [EM90]: exactly one of two triangles with a common edge is crossed.

use crate::bvh::Bvh;
use crate::grid::Grid;
use glam::{DVec3, Vec3Swizzles};
use rayon::prelude::*;
use robust::{Coord, Coord3D, orient2d, orient3d};

/// Triangles longer than this part of the whole are known by the boxes of their parts, where their
/// own are far larger than they.
const SHORT: f64 = 1.0 / 128.0;
/// A box seen along x is far larger than a triangle from this many times its area on.
const ROOMY: f64 = 4.0;
/// Most boxes a triangle, on average, or in all for few.
const MOST_BOXES: usize = 4;
const MOST_BOXES_OF_FEW: usize = 200_000;
/// Boxes are larger by this part of the largest coordinate: halving rounds.
const CLEAR: f64 = 1e-14;

/// Closed surfaces and their line crossings.
pub(crate) struct LineCrossings<'a> {
    triangles: &'a [[DVec3; 3]],
    /// Of boxes that hold the triangles, and whose box each is.
    tree: Bvh,
    source: Vec<u32>,
}

impl<'a> LineCrossings<'a> {
    /// Of triangles, given by their corners [m]. At each edge as many must run one way as the
    /// other, between the same numbers.
    pub(crate) fn new(triangles: &'a [[DVec3; 3]]) -> Self {
        let all = || triangles.iter().flatten();
        let low = all().fold(DVec3::INFINITY, |low, corner| low.min(*corner));
        let high = all().fold(DVec3::NEG_INFINITY, |high, corner| high.max(*corner));
        let most = (MOST_BOXES * triangles.len()).max(MOST_BOXES_OF_FEW);
        let clear = CLEAR * low.abs().max(high.abs()).max_element();

        // Longer parts where there would be too many.
        let mut shortest = SHORT * (high - low).length();
        loop {
            let mut boxes = Vec::with_capacity(triangles.len());
            let mut source = Vec::with_capacity(triangles.len());
            for (triangle, corners) in triangles.iter().enumerate() {
                add_boxes(corners, shortest, clear, &mut boxes);
                source.resize(boxes.len(), triangle as u32);
                if boxes.len() > most {
                    break;
                }
            }
            if boxes.len() <= most {
                return Self { triangles, tree: Bvh::of_boxes(&boxes), source };
            }
            shortest *= 2.0;
        }
    }

    /// Corners of the triangles [m].
    pub(crate) fn triangles(&self) -> &[[DVec3; 3]] {
        self.triangles
    }

    /// The triangles in boxes that `enters`, in their order: see [`Bvh::visit`].
    pub(crate) fn in_boxes(&self, enters: impl FnMut(DVec3, DVec3) -> bool) -> Vec<usize> {
        let mut found = Vec::new();
        self.tree.visit(enters, |number| found.push(self.source[number] as usize));
        found.sort_unstable();
        found.dedup();
        found
    }

    /// Calls `met` with each triangle in a box that `enters` and that the line along x through a
    /// point passes through, and with the turn of that.
    fn passed(
        &self,
        point: DVec3,
        enters: impl FnMut(DVec3, DVec3) -> bool,
        mut met: impl FnMut(&[DVec3; 3], i32),
    ) {
        let mut known: Vec<u32> = Vec::new();
        self.tree.visit(enters, |number| {
            let triangle = self.source[number];
            let corners = &self.triangles[triangle as usize];
            let turn = passes(point, corners);
            if turn != 0 && !known.contains(&triangle) {
                known.push(triangle);
                met(corners, turn);
            }
        });
    }

    /// Winding number around a point; for a point on a surface, around a neighbouring point.
    pub(crate) fn winding(&self, point: DVec3) -> i32 {
        let mut winding = 0;
        let enters = |low: DVec3, high: DVec3| {
            low.x < point.x
                && (low.y <= point.y && point.y <= high.y)
                && (low.z <= point.z && point.z <= high.z)
        };
        self.passed(point, enters, |corners, turn| {
            if lies_beyond(point, corners, turn) {
                winding -= turn;
            }
        });
        winding
    }

    /// Winding number around each node of a grid.
    pub(crate) fn at_nodes(&self, grid: &Grid) -> Vec<i32> {
        let [nx, ny, _] = grid.dims;
        let mut winding = vec![0; grid.len()];
        winding.par_chunks_mut(nx).enumerate().for_each(|(row, winding)| {
            let first = grid.node(0, row % ny, row / ny);
            let enters = |low: DVec3, high: DVec3| {
                (low.y <= first.y && first.y <= high.y) && (low.z <= first.z && first.z <= high.z)
            };
            self.passed(first, enters, |corners, turn| {
                // The first node beyond the triangle: about where the line meets it.
                let beyond =
                    |i: usize| lies_beyond(grid.node(i, row % ny, row / ny), corners, turn);
                let guess = (met_at(first, corners) - first.x) / grid.spacing;
                let mut node = guess.clamp(0.0, nx as f64) as usize;
                while node > 0 && beyond(node - 1) {
                    node -= 1;
                }
                while node < nx && !beyond(node) {
                    node += 1;
                }
                if let Some(winding) = winding.get_mut(node) {
                    *winding -= turn;
                }
            });
            let mut sum = 0;
            for winding in winding {
                sum += *winding;
                *winding = sum;
            }
        });
        winding
    }
}

/// Adds the box of a triangle, or those of its halves where that is far larger, seen along x, than
/// the triangle, and longer than `shortest` [m].
fn add_boxes(corners: &[DVec3; 3], shortest: f64, clear: f64, boxes: &mut Vec<(DVec3, DVec3)>) {
    let [a, b, c] = *corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let size = high - low;
    let area = 0.5 * (b - a).cross(c - a).x.abs();
    let sides = [(b - a).yz().length(), (c - b).yz().length(), (a - c).yz().length()];
    let longest = sides[0].max(sides[1]).max(sides[2]);
    if longest > shortest && size.y * size.z > ROOMY * area && size.y.min(size.z) > 0.5 * shortest {
        let halves = if longest == sides[0] {
            [[a, a.midpoint(b), c], [a.midpoint(b), b, c]]
        } else if longest == sides[1] {
            [[a, b, b.midpoint(c)], [a, b.midpoint(c), c]]
        } else {
            [[a, b, c.midpoint(a)], [c.midpoint(a), b, c]]
        };
        halves.iter().for_each(|half| add_boxes(half, shortest, clear, boxes));
    } else {
        boxes.push((low - clear, high + clear));
    }
}

/// 1 if the line through a point passes through a triangle out of its front, that is with x, -1 if
/// out of its back; 0 if it passes beside it.
fn passes(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> i32 {
    let first = side(point, a, b);
    if first != 0 && side(point, b, c) == first && side(point, c, a) == first { first } else { 0 }
}

/// The side of an edge that the line through a point is on, seen along x: 1 for the left, 0 if the
/// edge has no length there.
#[inline]
fn side(point: DVec3, from: DVec3, to: DVec3) -> i32 {
    let flat = |corner: DVec3| Coord { x: corner.y, y: corner.z };
    let area = orient2d(flat(from), flat(to), flat(point));
    let sign = |value: f64| i32::from(value > 0.0) - i32::from(value < 0.0);
    if area != 0.0 {
        sign(area)
    } else if from.z != to.z {
        sign(from.z - to.z)
    } else {
        sign(to.y - from.y)
    }
}

/// True if a point lies beyond a triangle that the line through it passes through with `turn`.
fn lies_beyond(point: DVec3, corners: &[DVec3; 3], turn: i32) -> bool {
    let [a, b, c, d] = [corners[0], corners[1], corners[2], point].map(|corner| Coord3D {
        x: corner.x,
        y: corner.y,
        z: corner.z,
    });
    // Positive behind the triangle.
    let volume = orient3d(a, b, c, d);
    if turn > 0 { volume < 0.0 } else { volume > 0.0 }
}

/// About where the line through a point meets a triangle's plane, within the triangle's x [m].
fn met_at(point: DVec3, &[a, b, c]: &[DVec3; 3]) -> f64 {
    let normal = (b - a).cross(c - a);
    let way = point - a;
    let x = a.x - (normal.y * way.y + normal.z * way.z) / normal.x;
    // `max` and `min` drop NaN.
    x.max(a.x.min(b.x).min(c.x)).min(a.x.max(b.x).max(c.x))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::winding_number::triangle_solid_angle;
    use glam::DQuat;
    use std::f64::consts::PI;

    /// A cube of edge 2 around the origin, turned and moved.
    fn cube(turn: DQuat, way: DVec3) -> Vec<[DVec3; 3]> {
        let faces =
            [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
        let corner = |n: usize| {
            let along = |axis: usize| if n >> axis & 1 == 1 { 1.0 } else { -1.0 };
            turn * DVec3::new(along(0), along(1), along(2)) + way
        };
        faces
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .map(|t| t.map(corner))
            .collect()
    }

    /// Rows through corners, along edges, along faces and along their diagonals: beside the surface
    /// every node is inside or outside, and both ways of counting agree.
    #[test]
    fn rows_through_corners_and_edges_leave_a_cube_as_often_as_they_enter_it() {
        let grid = Grid { origin: DVec3::splat(-2.0), spacing: 0.25, dims: [17; 3] };
        let mut triangles = cube(DQuat::IDENTITY, DVec3::ZERO);
        for _ in 0..2 {
            let surfaces = LineCrossings::new(&triangles);
            for (index, winding) in surfaces.at_nodes(&grid).into_iter().enumerate() {
                let [i, j, k] = grid.coordinates(index);
                let node = grid.node(i, j, k);
                let distance = node.abs().max_element() - 1.0;
                assert!(
                    distance == 0.0 || winding == i32::from(distance < 0.0),
                    "{node}: {winding}"
                );
                assert!(winding == 0 || winding == 1, "{node}: {winding}");
                assert_eq!(winding, surfaces.winding(node), "{node}");
            }
            // The same with the corners of the triangles in another order.
            triangles.iter_mut().enumerate().for_each(|(n, corners)| corners.rotate_left(n % 3));
            triangles.reverse();
        }
    }

    /// Overlapping cubes and one turned inside out, against the sum of solid angles.
    #[test]
    fn counts_what_solid_angles_add_up_to() {
        let mut triangles = Vec::new();
        for n in 0..7 {
            let turn =
                DQuat::from_rotation_y(0.4 * f64::from(n)) * DQuat::from_rotation_x(f64::from(n));
            triangles.extend(cube(turn, 0.3 * f64::from(n) * DVec3::new(1.0, -0.5, 0.25)));
        }
        let mut inward = cube(DQuat::IDENTITY, DVec3::splat(0.5));
        inward.iter_mut().for_each(|corners| corners.swap(1, 2));
        triangles.extend(inward);
        let surfaces = LineCrossings::new(&triangles);
        let grid = Grid { origin: DVec3::splat(-1.93), spacing: 0.371, dims: [16; 3] };
        for (index, winding) in surfaces.at_nodes(&grid).into_iter().enumerate() {
            let [i, j, k] = grid.coordinates(index);
            let node = grid.node(i, j, k);
            let angles = triangles.iter().map(|corners| triangle_solid_angle(node, corners));
            let expected = angles.sum::<f64>() / (4.0 * PI);
            assert!((f64::from(winding) - expected).abs() < 1e-6, "{node}: {winding} {expected}");
        }
    }

    /// A cone of 5000 sides over a fan of as many slivers, upright and tilted.
    #[test]
    fn slivers_are_no_obstacle() {
        let n = 5000_u32;
        let rim = |k: u32| {
            let (sin, cos) = libm::sincos(2.0 * PI * f64::from(k % n) / f64::from(n));
            DVec3::new(sin, 0.0, cos)
        };
        for turn in [DQuat::IDENTITY, DQuat::from_rotation_x(0.3) * DQuat::from_rotation_z(1.1)] {
            let apex = DVec3::new(0.0, 2.0, 0.0);
            let triangles: Vec<[DVec3; 3]> = (0..n)
                .flat_map(|k| [[rim(k), rim(k + 1), apex], [rim(k + 1), rim(k), DVec3::ZERO]])
                .map(|corners| corners.map(|corner| turn * corner))
                .collect();
            let surfaces = LineCrossings::new(&triangles);
            let grid = Grid { origin: DVec3::splat(-1.97), spacing: 0.125, dims: [33; 3] };
            let mut inside = 0;
            for (index, winding) in surfaces.at_nodes(&grid).into_iter().enumerate() {
                let [i, j, k] = grid.coordinates(index);
                let point = turn.inverse() * grid.node(i, j, k);
                let beside = 1.0 - 0.5 * point.y - point.with_y(0.0).length();
                let depth = beside.min(point.y);
                assert!(
                    depth.abs() < 1e-5 || winding == i32::from(depth > 0.0),
                    "{point}: {winding}"
                );
                inside += winding;
            }
            assert!(inside > 1000, "{inside}");
        }
    }
}
