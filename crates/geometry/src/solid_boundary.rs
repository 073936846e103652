//! The part of a surface that separates inside from outside, and patches over its holes.
//!
//! Inside is where the winding number exceeds one half. Where parts of a mesh overlap, pieces of its surface have the
//! inside on both sides: they bound nothing, and a distance to them would put false surfaces into a solid. Where a mesh
//! has a hole, inside ends without a triangle.

use crate::{Grid, TriMesh, WindingNumber};
use glam::DVec3;
use rayon::prelude::*;

/// Winding number of the boundary between inside and outside.
pub(crate) const INSIDE: f64 = 0.5;
/// How far in front of a triangle its front side is probed, in cells: less than any thickness that a grid resolves.
const PROBE: f64 = 1e-4;
/// Triangles longer than this many cells are probed in parts, so that no other surface crosses them unseen.
const COARSE: f64 = 1.0;
/// Length in cells down to which a triangle that another surface crosses is divided: the error at the crease.
const CREASE: f64 = 0.125;

/// The triangles, or parts of triangles, with outside in front and inside behind. `triangles` are the corners [m] of
/// those of the mesh, which may be turned.
pub(crate) fn boundary_triangles(
    winding: &WindingNumber,
    mesh: &TriMesh,
    triangles: &[[DVec3; 3]],
    spacing: f64,
) -> Vec<[DVec3; 3]> {
    // Probe each small triangle once.
    let probe_of = |corners: &[DVec3; 3]| {
        let front = normal(corners).try_normalize()?;
        Some(Probe { winding, offset: front * (PROBE * spacing), spacing })
    };
    let answers: Vec<Option<bool>> = triangles
        .par_iter()
        .map(|corners| {
            let probe = probe_of(corners).filter(|_| longest_edge(corners) <= COARSE * spacing)?;
            Some(probe.separates(center(corners)))
        })
        .collect();

    // Where neighbours disagree another surface passes.
    let mut heard = vec![[false; 2]; mesh.positions.len()];
    for (triangle, answer) in mesh.triangles.iter().zip(&answers) {
        for (&vertex, &answer) in
            triangle.iter().flat_map(|vertex| answer.iter().map(move |answer| (vertex, answer)))
        {
            heard[vertex as usize][usize::from(answer)] = true;
        }
    }
    let disputed =
        |triangle: &[u32; 3]| triangle.iter().any(|&vertex| heard[vertex as usize] == [true, true]);

    // Keep what separates, and divide what is large or disputed.
    let collect = |(corners, (triangle, answer)): (&[DVec3; 3], (&[u32; 3], &Option<bool>))| {
        let mut pieces = Vec::new();
        match answer {
            Some(answer) if !disputed(triangle) => pieces.extend(answer.then_some(*corners)),
            _ => {
                if let Some(probe) = probe_of(corners) {
                    probe.gather(corners, &mut pieces);
                }
            }
        }
        pieces
    };
    triangles.par_iter().zip(mesh.triangles.par_iter().zip(&answers)).flat_map_iter(collect).collect()
}

fn center(&[a, b, c]: &[DVec3; 3]) -> DVec3 {
    (a + b + c) / 3.0
}

fn longest_edge(&[a, b, c]: &[DVec3; 3]) -> f64 {
    (b - a).length().max((c - b).length()).max((a - c).length())
}

fn normal([a, b, c]: &[DVec3; 3]) -> DVec3 {
    (b - a).cross(c - a)
}

struct Probe<'a> {
    winding: &'a WindingNumber,
    /// From a point of the triangle to just in front of it [m].
    offset: DVec3,
    /// [m]
    spacing: f64,
}

impl Probe<'_> {
    /// Whether the outside begins in front of a point of the triangle and the inside behind it, one winding more.
    fn separates(&self, point: DVec3) -> bool {
        let front = self.winding.at(point + self.offset);
        front <= INSIDE && front + 1.0 > INSIDE
    }

    /// Collects the parts of a triangle that separate, whole where it does as a whole; returns whether it does.
    fn gather(&self, corners: &[DVec3; 3], pieces: &mut Vec<[DVec3; 3]>) -> bool {
        // Ask at the centre and near the corners, unless the triangle is too large or too small for that.
        let longest = longest_edge(corners);
        let center = center(corners);
        let mut unanimous = None;
        if longest <= COARSE * self.spacing {
            let answer = self.separates(center);
            let agrees = |corner: &DVec3| self.separates(corner.lerp(center, 0.1)) == answer;
            if longest <= CREASE * self.spacing || corners.iter().all(agrees) {
                unanimous = Some(answer);
            }
        }

        // Divide it at its longest edge where the answers differ.
        let start = pieces.len();
        let whole = unanimous.unwrap_or_else(|| {
            let [a, b, c] = *corners;
            let halves = if (b - a).length() == longest {
                let middle = a.midpoint(b);
                [[a, middle, c], [middle, b, c]]
            } else if (c - b).length() == longest {
                let middle = b.midpoint(c);
                [[a, b, middle], [a, middle, c]]
            } else {
                let middle = c.midpoint(a);
                [[a, b, middle], [middle, b, c]]
            };
            let first = self.gather(&halves[0], pieces);
            let second = self.gather(&halves[1], pieces);
            first && second
        });
        if whole {
            pieces.truncate(start);
            pieces.push(*corners);
        }
        whole
    }
}

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

/// Where inside ends between an inner and an outer node.
fn crossing(a: &Sample, b: &Sample) -> DVec3 {
    let part = if is_hole(a, b) {
        // The winding number is smooth across a hole.
        (INSIDE - a.winding) / (b.winding - a.winding)
    } else {
        // It jumps at a triangle, but the distances tell where.
        a.distance / (a.distance + b.distance).max(f64::MIN_POSITIVE)
    };
    a.point.lerp(b.point, part)
}

/// Triangles across the holes, where the winding number is one half: marching tetrahedra through the cells that no
/// boundary triangle closes. `distance` [m] to the boundary triangles and `winding` hold one value for each node.
pub(crate) fn hole_patches(grid: &Grid, distance: &[f32], winding: &[f32]) -> Vec<[DVec3; 3]> {
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
fn patch_tetrahedron(corners: &[Sample; 4], patches: &mut Vec<[DVec3; 3]>) {
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
