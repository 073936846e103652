//! Closed sheets: two-sided meshes whose surfaces part space. Whoever is inside of such a surface
//! meets it as a mesh that is solid outside of it, whoever is outside as one that is solid inside,
//! so that a body which has sunk into it comes back to where it was.

use crate::static_mesh::adjacency::Adjacency;
use glam::DVec3;

/// Least volume of a surface over its area to the power 3/2 [1]: two triangles back to back enclose
/// nothing.
const LEAST_VOLUME: f64 = 1e-7;

/// A part of space that a closed sheet bounds: the inside of one of its surfaces, or the outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compartment(
    /// Number of the surface, from 1; 0 for the outside.
    pub u32,
);

/// The surfaces of a closed sheet.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ClosedSheet {
    /// Of each triangle.
    pub(crate) surface_of: Vec<u32>,
    /// True for triangles whose front is outside.
    is_outward: Vec<bool>,
    /// Of each surface [m^3].
    pub(crate) volumes: Vec<f64>,
}

impl ClosedSheet {
    /// `None` if a surface has a border, one side only, or no volume.
    pub(crate) fn of(
        positions: &[DVec3],
        triangles: &[[u32; 3]],
        adjacency: &Adjacency,
    ) -> Option<Self> {
        const UNKNOWN: u32 = u32::MAX;
        let mut surface_of = vec![UNKNOWN; triangles.len()];
        let mut is_outward = vec![true; triangles.len()];
        let mut volumes = Vec::new();
        for first in 0..triangles.len() {
            if surface_of[first] != UNKNOWN {
                continue;
            }
            let surface = volumes.len() as u32;
            let origin = positions[triangles[first][0] as usize];
            let (mut members, mut next) = (vec![first], 0);
            let (mut volume, mut area) = (0.0, 0.0);
            surface_of[first] = surface;
            while let Some(&triangle) = members.get(next) {
                next += 1;
                let [a, b, c] =
                    triangles[triangle].map(|vertex| positions[vertex as usize] - origin);
                let six_volumes = a.dot(b.cross(c));
                volume += if is_outward[triangle] { six_volumes } else { -six_volumes } / 6.0;
                area += 0.5 * (b - a).cross(c - a).length();
                for corner in 0..3 {
                    let beside = adjacency.neighbour(triangle, corner)?;
                    let expected = is_outward[triangle] != beside.is_flipped;
                    if surface_of[beside.triangle] == UNKNOWN {
                        surface_of[beside.triangle] = surface;
                        is_outward[beside.triangle] = expected;
                        members.push(beside.triangle);
                    } else if is_outward[beside.triangle] != expected {
                        return None;
                    }
                }
            }
            if volume.abs() <= LEAST_VOLUME * area * area.sqrt() {
                return None;
            }
            if volume < 0.0 {
                members.iter().for_each(|&triangle| is_outward[triangle] ^= true);
            }
            volumes.push(volume.abs());
        }
        Some(Self { surface_of, is_outward, volumes })
    }

    /// Corners of the triangles with their fronts towards a compartment.
    pub(crate) fn facing(&self, triangles: &[[u32; 3]], compartment: Compartment) -> Vec<[u32; 3]> {
        let front = |(triangle, &[a, b, c]): (usize, &[u32; 3])| {
            let is_around = self.surface_of[triangle] + 1 == compartment.0;
            if self.is_outward[triangle] != is_around { [a, b, c] } else { [a, c, b] }
        };
        triangles.iter().enumerate().map(front).collect()
    }
}
