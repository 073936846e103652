//! The parts of a mesh on their way to solids: welded, paired and closed.

use crate::cleaning::clean_mesh::{CleanMesh, MeshChanges, Sheet};
use crate::cleaning::junctions::split_at_junctions;
use crate::cleaning::pairing::{NONE, Pairing};
use crate::cleaning::rims;
use crate::cleaning::shells::{self, Role, Shell};
use crate::mesh::TriMesh;
use glam::DVec3;

/// Below this ratio of volume to (area times diagonal) a surface that had to be closed is flat: the
/// rounding of single precision alone makes a tilted sheet 1e-7 thick.
pub(super) const FLAT_OPEN: f64 = 1e-6;
/// The same for one that was closed: the corners of both sides are the same numbers.
const FLAT_CLOSED: f64 = 3e-8;
/// A hole with less of its surface's area is a crack, no hole.
pub(super) const CRACK: f64 = 1e-6;
/// A surface is a sheet, rather than a solid with a hole, if its holes have more than this part of
/// its area: a dome lower than half of its radius.
pub(super) const SHEET: f64 = 0.8;

/// A surface with the holes that were closed.
#[derive(Default)]
pub(super) struct Part {
    /// Of the working triangles.
    pub(super) triangles: Vec<u32>,
    /// Of the holes.
    pub(super) holes: Vec<usize>,
}

/// The parts of a mesh on their way to solids.
pub(super) struct Assembly {
    pub(super) work: TriMesh,
    /// Representative of each vertex.
    pub(super) place_of: Vec<u32>,
    /// Raw triangle of each triangle.
    pub(super) source: Vec<u32>,
    pub(super) turned: Vec<bool>,
    pub(super) closed: rims::Closed,
}

impl Assembly {
    /// Welds and pairs what is closer than the `tolerances`, parts of the diagonal, and closes what
    /// is open.
    pub(super) fn new(raw: &TriMesh, tolerances: &[f64]) -> (Self, Vec<Part>) {
        let (low, high) = raw.bounds();
        let tolerances: Vec<f64> =
            tolerances.iter().map(|part| part * (high - low).length()).collect();
        let widest = tolerances.last().copied().unwrap_or(0.0);

        // Pair the triangles at their edges; where one ends in the middle of another, divide and
        // again.
        const MOST_DIVISIONS: usize = 3;
        let mut source: Vec<u32> = (0..raw.triangles.len() as u32).collect();
        let mut pairing = Pairing::new(raw.clone(), &tolerances);
        for _ in 0..MOST_DIVISIONS {
            let Some(split) = split_at_junctions(&pairing, &source, widest) else { break };
            source = split.source;
            let work = TriMesh { positions: pairing.mesh.positions, triangles: split.triangles };
            pairing = Pairing::new(work, &tolerances);
        }
        let (turned, part_of) = pairing.agree();
        let closed = rims::close(&pairing, &turned);

        // Gather the parts.
        let mut parts: Vec<Part> = Vec::new();
        let mut number = vec![NONE; part_of.len()];
        for (triangle, &part) in part_of.iter().enumerate().filter(|(_, part)| **part != NONE) {
            if part as usize == triangle {
                number[triangle] = parts.len() as u32;
                parts.push(Part::default());
            }
            parts[number[part as usize] as usize].triangles.push(triangle as u32);
        }
        for (hole, triangles) in closed.holes.iter().enumerate() {
            let part = part_of[triangles[0][0] as usize / 3];
            parts[number[part as usize] as usize].holes.push(hole);
        }
        let Pairing { mesh: work, place, .. } = pairing;
        (Self { work, place_of: place, source, turned, closed }, parts)
    }

    /// Corners `3 t + k` of a working triangle in the order that agrees with its part.
    pub(super) fn corners(&self, triangle: u32) -> [u32; 3] {
        let first = 3 * triangle;
        let [b, c] = if self.turned[triangle as usize] { [2, 1] } else { [1, 2] };
        [first, first + b, first + c]
    }

    pub(super) fn place(&self, corner: u32) -> u32 {
        let vertex = self.work.triangles[corner as usize / 3][corner as usize % 3];
        self.place_of[vertex as usize]
    }

    pub(super) fn points(&self, corners: [u32; 3]) -> [DVec3; 3] {
        corners.map(|corner| self.work.positions[self.place(corner) as usize])
    }

    pub(super) fn hole_area(&self, hole: usize) -> f64 {
        let area = |&corners: &[u32; 3]| {
            let [a, b, c] = self.points(corners);
            0.5 * (b - a).cross(c - a).length()
        };
        self.closed.holes[hole].iter().map(area).sum()
    }

    pub(super) fn holes_area(&self, part: &Part) -> f64 {
        part.holes.iter().map(|&hole| self.hole_area(hole)).sum()
    }

    pub(super) fn shell(&self, part: &Part) -> Shell {
        let own = part.triangles.iter().map(|&triangle| self.points(self.corners(triangle)));
        let filled = part.holes.iter().flat_map(|&hole| &self.closed.holes[hole]);
        Shell::new(own.chain(filled.map(|&corners| self.points(corners))).collect())
    }

    pub(super) fn sheet(&self, part: &Part) -> Sheet {
        let first = part.triangles.iter().map(|&triangle| self.source[triangle as usize]).min();
        let points = part.triangles.iter().map(|&triangle| self.points(self.corners(triangle)));
        let shell = Shell::new(points.collect());
        Sheet {
            first: first.unwrap_or(0),
            triangles: part.triangles.len(),
            area: shell.area,
            bounds: (shell.low, shell.high),
        }
    }

    /// Tells solids from sheets, and writes the solids.
    pub(super) fn finish(self, raw: &TriMesh, parts: &[Part]) -> CleanMesh {
        let mut changes = MeshChanges::default();
        let mut solids: Vec<(usize, Shell)> = Vec::new();
        let mut domes: Vec<(usize, Shell)> = Vec::new();
        let mut flat: Vec<usize> = Vec::new();
        for (number, part) in parts.iter().enumerate().filter(|part| !part.1.triangles.is_empty()) {
            let shell = self.shell(part);
            let hole_area = self.holes_area(part);
            let own_area = shell.area - hole_area;
            let is_open = hole_area > CRACK * own_area;
            let least = if is_open { FLAT_OPEN } else { FLAT_CLOSED };
            if shell.volume.abs() <= least * shell.area * shell.diagonal() {
                flat.push(number);
            } else if is_open && hole_area > SHEET * own_area {
                domes.push((number, shell));
            } else {
                solids.push((number, shell));
            }
        }
        // A dome is a solid only where there is no other.
        if solids.is_empty() {
            solids = domes;
        } else {
            changes.sheets.extend(domes.iter().map(|&(number, _)| self.sheet(&parts[number])));
        }
        // A part on a solid's own triangles is no sheet, but a face that was there twice.
        let mut faces: Vec<[u32; 3]> = Vec::new();
        if !flat.is_empty() {
            let of_solids = solids.iter().flat_map(|&(number, _)| &parts[number].triangles);
            faces.extend(of_solids.map(|&triangle| self.sorted_places(triangle)));
            faces.sort_unstable();
        }
        for part in flat.into_iter().map(|number| &parts[number]) {
            let lies_there =
                |&triangle: &u32| faces.binary_search(&self.sorted_places(triangle)).is_ok();
            if !part.triangles.iter().all(lies_there) {
                changes.sheets.push(self.sheet(part));
            }
        }
        changes.sheets.sort_by_key(|sheet| sheet.first);
        let (numbers, shells): (Vec<usize>, Vec<Shell>) = solids.into_iter().unzip();
        let roles = shells::roles(&shells);
        let kept: Vec<(&Part, f64, Role, usize)> = (0..shells.len())
            .filter(|&shell| roles[shell] != Role::Repeated)
            .map(|shell| (&parts[numbers[shell]], shells[shell].volume, roles[shell], shell))
            .collect();
        drop(shells);
        self.write(raw, &kept, changes)
    }

    pub(super) fn sorted_places(&self, triangle: u32) -> [u32; 3] {
        let mut places = self.corners(triangle).map(|corner| self.place(corner));
        places.sort_unstable();
        places
    }

    pub(super) fn write(
        mut self,
        raw: &TriMesh,
        kept: &[(&Part, f64, Role, usize)],
        mut changes: MeshChanges,
    ) -> CleanMesh {
        // Number the solids, then give their numbers to cavities.
        let mut solid_of: Vec<u32> =
            vec![NONE; kept.iter().map(|part| part.3 + 1).max().unwrap_or(0)];
        let solids = || kept.iter().filter(|part| matches!(part.2, Role::Solid | Role::In(_)));
        solids().zip(0..).for_each(|(part, number)| solid_of[part.3] = number);

        let outer = |role: Role| match role {
            Role::In(outer) => Some(solid_of[outer]),
            Role::Solid | Role::CavityOf(_) | Role::Repeated => None,
        };
        let nested = solids().map(|part| outer(part.2)).collect();

        // Triangles in the order of the raw mesh, those of holes last.
        let mut triangles: Vec<(u32, Option<u32>, u32, [u32; 3])> = Vec::new();
        for &(part, volume, role, shell) in kept {
            let (solid, outward) = match role {
                Role::CavityOf(outer) => (solid_of[outer], false),
                Role::Solid | Role::In(_) | Role::Repeated => (solid_of[shell], true),
            };
            let turn = (volume > 0.0) != outward;
            let facing = |[a, b, c]: [u32; 3]| if turn { [a, c, b] } else { [a, b, c] };
            let mut disagree = 0;
            for &triangle in &part.triangles {
                disagree += usize::from(self.turned[triangle as usize]);
                let source = Some(self.source[triangle as usize]);
                triangles.push((triangle, source, solid, facing(self.corners(triangle))));
            }
            changes.turned += disagree;
            for &hole in &part.holes {
                let crack = CRACK * part_area(&self, part);
                changes.holes += usize::from(self.hole_area(hole) > crack);
                let filled = self.closed.holes[hole].iter();
                triangles.extend(filled.map(|&corners| (NONE, None, solid, facing(corners))));
            }
        }
        triangles.sort_by_key(|&(triangle, _, _, _)| triangle);
        let mut used = vec![false; raw.triangles.len()];
        triangles.iter().flat_map(|t| t.1).for_each(|source| used[source as usize] = true);
        let left_out: usize = changes.sheets.iter().map(|sheet| sheet.triangles).sum();
        changes.mostly_left_out =
            (2 * left_out > raw.triangles.len()).then_some(raw.triangles.len());
        let missing = used.iter().filter(|&&used| !used).count();
        changes.repeated = missing.saturating_sub(left_out);

        // Number the vertices by their places.
        let mut roots: Vec<(u32, u32)> = Vec::with_capacity(3 * triangles.len());
        for &corner in triangles.iter().flat_map(|(_, _, _, corners)| corners) {
            roots.push((self.place(corner), self.closed.vertices.root(corner)));
        }
        let corner_roots = roots.clone();
        roots.sort_unstable();
        roots.dedup();
        let mut number = vec![NONE; 3 * self.work.triangles.len()];
        roots.iter().zip(0..).for_each(|(&(_, root), vertex)| number[root as usize] = vertex);
        let positions =
            roots.iter().map(|&(place, _)| self.work.positions[place as usize]).collect();
        let corners = corner_roots.chunks_exact(3);
        let indices = corners.map(|t| [t[0].1, t[1].1, t[2].1].map(|root| number[root as usize]));
        CleanMesh {
            mesh: TriMesh { positions, triangles: indices.collect() },
            source: triangles.iter().map(|triangle| triangle.1).collect(),
            solid: triangles.iter().map(|triangle| triangle.2).collect(),
            nested,
            changes,
        }
    }
}

/// Area of a part without its holes [m^2].
fn part_area(assembly: &Assembly, part: &Part) -> f64 {
    let area = |&triangle: &u32| {
        let [a, b, c] = assembly.points(assembly.corners(triangle));
        0.5 * (b - a).cross(c - a).length()
    };
    part.triangles.iter().map(area).sum()
}
