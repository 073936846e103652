//! Closed sheets: two-sided meshes whose surfaces part space. Whoever is inside of such a surface
//! meets it as a mesh that is solid outside of it, whoever is outside as one that is solid inside,
//! so that a body which has sunk into it comes back to where it was.

use crate::static_mesh::adjacency::Adjacency;
use crate::static_mesh::kinds::Sides;
use crate::static_mesh::{StaticMesh, TriMesh};
use glam::DVec3;
use std::sync::OnceLock;

/// Least volume of a surface over its area to the power 3/2 [1]: two triangles back to back enclose
/// nothing.
const LEAST_VOLUME: f64 = 1e-7;

/// Ways out of a surface, of which most decide: a way may meet an edge. In general position.
const WAYS: [DVec3; 3] = [
    DVec3::new(0.836_421_3, 0.421_937_1, 0.350_117_9),
    DVec3::new(-0.312_718_9, 0.787_653_1, -0.530_911_7),
    DVec3::new(0.219_313_7, -0.603_117_1, -0.766_928_3),
];

/// A part of space that a closed sheet bounds: the inside of one of its surfaces, or the outside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Compartment(
    /// Number of the surface, from 1; 0 for the outside.
    pub u32,
);

/// The surfaces of a closed sheet, and the sheet as it is seen from each side.
#[derive(Clone, Debug)]
pub(crate) struct ClosedSheet {
    /// Of each triangle.
    surface_of: Vec<u32>,
    /// True for triangles whose front is outside.
    is_outward: Vec<bool>,
    /// Of each surface [m^3].
    volumes: Vec<f64>,
    /// From the outside, then from the inside of each surface; made when somebody is there.
    seen: Vec<OnceLock<Box<StaticMesh>>>,
}

impl PartialEq for ClosedSheet {
    fn eq(&self, other: &Self) -> bool {
        (&self.surface_of, &self.is_outward) == (&other.surface_of, &other.is_outward)
    }
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
        let seen = vec![OnceLock::new(); volumes.len() + 1];
        Some(Self { surface_of, is_outward, volumes, seen })
    }

    /// The innermost surface around a point that an odd number of its triangles meets on its way
    /// out.
    fn compartment(&self, mesh: &StaticMesh, point: DVec3) -> Compartment {
        let (low, high) = mesh.bounds();
        if point.cmplt(low).any() || point.cmpgt(high).any() {
            return Compartment::default();
        }
        let out = 2.0 * (high - low).length();
        let mut inside = vec![0_u8; self.volumes.len()];
        for way in WAYS {
            let end = point + out * way;
            let mut is_inside = vec![false; self.volumes.len()];
            mesh.visit_way([point, end], 0.0, |triangle| {
                if is_crossed(mesh.corners(triangle), point, end - point) {
                    is_inside[self.surface_of[triangle] as usize] ^= true;
                }
            });
            is_inside.iter().zip(&mut inside).for_each(|(&one, votes)| *votes += u8::from(one));
        }
        let around =
            (0..inside.len()).filter(|&surface| 2 * usize::from(inside[surface]) > WAYS.len());
        let innermost = around.min_by(|&a, &b| self.volumes[a].total_cmp(&self.volumes[b]));
        Compartment(innermost.map_or(0, |surface| surface as u32 + 1))
    }

    fn seen_from(&self, mesh: &StaticMesh, compartment: Compartment) -> Option<&StaticMesh> {
        let seen = self.seen.get(compartment.0 as usize)?;
        if let Some(known) = seen.get() {
            return Some(known);
        }
        let front = |triangle: usize, corners: &[u32; 3]| {
            let &[a, b, c] = corners;
            let is_around = self.surface_of[triangle] + 1 == compartment.0;
            if self.is_outward[triangle] != is_around { [a, b, c] } else { [a, c, b] }
        };
        let triangles =
            mesh.triangles.iter().enumerate().map(|(at, corners)| front(at, corners)).collect();
        let one_sided = TriMesh { positions: mesh.positions.clone(), triangles };
        let one_sided = StaticMesh::new(&one_sided, Sides::One)?;
        Some(seen.get_or_init(|| Box::new(one_sided)))
    }
}

/// True if a way from a point goes through a triangle [MT97].
fn is_crossed([a, b, c]: [DVec3; 3], from: DVec3, way: DVec3) -> bool {
    let (along, across) = (b - a, c - a);
    let p = way.cross(across);
    let determinant = along.dot(p);
    if determinant == 0.0 {
        return false;
    }
    let to = from - a;
    let u = to.dot(p) / determinant;
    let q = to.cross(along);
    let v = way.dot(q) / determinant;
    let t = across.dot(q) / determinant;
    u >= 0.0 && v >= 0.0 && u + v <= 1.0 && (0.0..=1.0).contains(&t)
}

impl StaticMesh {
    /// True for a two-sided mesh whose surfaces have no border.
    pub fn is_closed_sheet(&self) -> bool {
        self.closed.is_some()
    }

    /// Where a point is; outside, for any mesh but a [closed sheet](Self::is_closed_sheet).
    pub fn compartment(&self, point: DVec3) -> Compartment {
        self.closed
            .as_ref()
            .map_or_else(Compartment::default, |closed| closed.compartment(self, point))
    }

    /// The mesh for a body in a compartment: solid beyond it. Any mesh but a closed sheet is the
    /// same for all bodies.
    pub fn seen_from(&self, compartment: Compartment) -> &Self {
        let seen = self.closed.as_ref().and_then(|closed| closed.seen_from(self, compartment));
        seen.unwrap_or(self)
    }
}
