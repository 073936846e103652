//! The part of a surface that separates inside from outside.
//!
//! Where parts of a mesh overlap, pieces of its surface have the inside on both sides: they bound nothing, and a distance
//! to them would put false surfaces into a solid.

use crate::winding_number::INSIDE;
use crate::{TriMesh, WindingNumber};
use glam::DVec3;
use rayon::prelude::*;

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
    // Probe each triangle, a large one in several places.
    let probe_of = |corners: &[DVec3; 3]| {
        let front = normal(corners).try_normalize()?;
        Some(Probe { winding, offset: front * (PROBE * spacing), spacing })
    };
    let answers: Vec<Option<bool>> =
        triangles.par_iter().map(|corners| probe_of(corners)?.unanimous(corners)).collect();

    // Where the answers of neighbours differ another surface passes.
    let mut heard = vec![[false; 2]; mesh.positions.len()];
    for (triangle, answer) in mesh.triangles.iter().zip(&answers) {
        for &vertex in triangle {
            let [kept, dropped] = &mut heard[vertex as usize];
            *kept |= *answer != Some(false);
            *dropped |= *answer != Some(true);
        }
    }
    let disputed =
        |triangle: &[u32; 3]| triangle.iter().any(|&vertex| heard[vertex as usize] == [true, true]);

    // Keep what separates, and divide what is disputed.
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

    /// The answer of all parts of a triangle that are no larger than a cell, if it is the same.
    fn unanimous(&self, corners: &[DVec3; 3]) -> Option<bool> {
        if longest_edge(corners) <= COARSE * self.spacing {
            return Some(self.separates(center(corners)));
        }
        let [first, second] = halves(corners);
        self.unanimous(&first).filter(|&answer| self.unanimous(&second) == Some(answer))
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

        // Divide it where the answers differ.
        let start = pieces.len();
        let whole = unanimous.unwrap_or_else(|| {
            let [first, second] = halves(corners).map(|half| self.gather(&half, pieces));
            first && second
        });
        if whole {
            pieces.truncate(start);
            pieces.push(*corners);
        }
        whole
    }
}

/// A triangle cut at the middle of its longest edge.
fn halves(corners: &[DVec3; 3]) -> [[DVec3; 3]; 2] {
    let [a, b, c] = *corners;
    let longest = longest_edge(corners);
    if (b - a).length() == longest {
        let middle = a.midpoint(b);
        [[a, middle, c], [middle, b, c]]
    } else if (c - b).length() == longest {
        let middle = b.midpoint(c);
        [[a, b, middle], [a, middle, c]]
    } else {
        let middle = c.midpoint(a);
        [[a, b, middle], [middle, b, c]]
    }
}
