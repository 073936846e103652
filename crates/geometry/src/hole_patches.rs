//! Patches over the holes of a surface.
//!
//! Where a mesh has a hole, inside ends without a triangle: where the winding number falls through one half.

use crate::winding_number::INSIDE;
use crate::{Grid, WindingNumber};
use glam::DVec3;
use rayon::prelude::*;

/// Halvings of the way between two nodes: a triangle is met to one part in 64 of it.
const HALVINGS: usize = 6;
/// A winding number this close to one half is taken for it: the tree is no more exact.
const FLAT: f64 = 1e-3;

/// Corner offsets of a cell.
const CELL: [[usize; 3]; 8] =
    [[0, 0, 0], [1, 0, 0], [0, 1, 0], [1, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1], [1, 1, 1]];

/// Corner offsets of the six tetrahedra around the diagonal of a cell: they fill it, and match across cell faces.
const TETRAHEDRA: [[[usize; 3]; 4]; 6] = {
    const O: [usize; 3] = [0, 0, 0];
    const X: [usize; 3] = [1, 0, 0];
    const Y: [usize; 3] = [0, 1, 0];
    const Z: [usize; 3] = [0, 0, 1];
    const XY: [usize; 3] = [1, 1, 0];
    const YZ: [usize; 3] = [0, 1, 1];
    const ZX: [usize; 3] = [1, 0, 1];
    const XYZ: [usize; 3] = [1, 1, 1];
    [[O, X, XY, XYZ], [O, XY, Y, XYZ], [O, Y, YZ, XYZ], [O, YZ, Z, XYZ], [O, Z, ZX, XYZ], [O, ZX, X, XYZ]]
};

/// A node with what is known there.
#[derive(Clone, Copy)]
struct Sample {
    point: DVec3,
    /// To the boundary triangles [m].
    distance: f64,
    winding: f64,
}

impl Sample {
    fn inside(&self) -> bool {
        self.winding > INSIDE
    }
}

/// Whether inside ends between two nodes farther from any triangle than the way between them: at a hole.
fn is_hole(a: &Sample, b: &Sample) -> bool {
    let way = (a.point - b.point).length();
    a.inside() != b.inside() && a.distance + b.distance > 1.001 * way
}

/// Where inside ends between an inner and an outer node: at a triangle, or where the winding number falls through one
/// half.
fn crossing(number: &WindingNumber, a: &Sample, b: &Sample) -> DVec3 {
    // Take turns between a straight line's zero, which is soon right where the number is smooth, and the middle, which
    // closes in on a jump.
    let (mut low, mut high) = ((0.0, a.winding - INSIDE), (1.0, b.winding - INSIDE));
    let mut part = 0.5;
    for turn in 0..2 * HALVINGS {
        part = if turn % 2 == 0 {
            (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1)
        } else {
            0.5 * (low.0 + high.0)
        };
        let value = number.at(a.point.lerp(b.point, part)) - INSIDE;
        if value.abs() < FLAT {
            break;
        }
        let end = if (value > 0.0) == (low.1 > 0.0) { &mut low } else { &mut high };
        *end = (part, value);
    }
    a.point.lerp(b.point, part)
}

/// Triangles across the holes, where the winding number is one half: marching tetrahedra through the cells that no
/// boundary triangle closes. `distance` [m] to the boundary triangles and `winding` hold one value for each node.
pub(crate) fn hole_patches(
    number: &WindingNumber,
    grid: &Grid,
    distance: &[f32],
    winding: &[f32],
) -> Vec<[DVec3; 3]> {
    let [nx, ny, nz] = grid.dims;
    let sample = |[i, j, k]: [usize; 3]| {
        let index = grid.index(i, j, k);
        Sample {
            point: grid.node(i, j, k),
            distance: f64::from(distance[index]),
            winding: f64::from(winding[index]),
        }
    };
    (0..nz - 1)
        .into_par_iter()
        .flat_map_iter(|k| {
            let mut patches = Vec::new();
            for j in 0..ny - 1 {
                for i in 0..nx - 1 {
                    let cell = CELL.map(|[u, v, w]| winding[grid.index(i + u, j + v, k + w)]);
                    let inner = cell.iter().filter(|&&value| f64::from(value) > INSIDE).count();
                    if inner == 0 || inner == cell.len() {
                        continue;
                    }
                    for tetrahedron in &TETRAHEDRA {
                        patch_tetrahedron(
                            number,
                            &tetrahedron.map(|[u, v, w]| sample([i + u, j + v, k + w])),
                            &mut patches,
                        );
                    }
                }
            }
            patches
        })
        .collect()
}

/// The part of the patches within a tetrahedron of nodes.
fn patch_tetrahedron(number: &WindingNumber, corners: &[Sample; 4], patches: &mut Vec<[DVec3; 3]>) {
    let crossing = |a: &Sample, b: &Sample| crossing(number, a, b);
    let open = |a: usize, b: usize| is_hole(&corners[a], &corners[b]);
    if !(open(0, 1) || open(0, 2) || open(0, 3) || open(1, 2) || open(1, 3) || open(2, 3)) {
        return;
    }
    let (inner, outer): (Vec<Sample>, Vec<Sample>) = corners.iter().partition(|corner| corner.inside());
    match (inner.as_slice(), outer.as_slice()) {
        ([p], [q, r, s]) | ([q, r, s], [p]) => patches.push([crossing(p, q), crossing(p, r), crossing(p, s)]),
        ([p, q], [r, s]) => {
            let (pr, ps, qr, qs) = (crossing(p, r), crossing(p, s), crossing(q, r), crossing(q, s));
            patches.push([pr, ps, qs]);
            patches.push([pr, qs, qr]);
        }
        _ => {}
    }
}
