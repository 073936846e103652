//! Contacts of pieces on one lattice: the faces between their voxels.

use crate::interfaces::cross_section::{CrossSection, Farthest, FlatPart};
use crate::interfaces::interface::{Contacts, Interface};
use crate::interfaces::sections::{axes, section};
use frangible_geometry::{Grid, GridSolid, HalfSpace, outer};
use glam::{DMat3, DVec2, DVec3};
use std::collections::BTreeMap;

/// Maximum difference of two sides of one crack plane, in units of the spacing.
const SAME_PLANE: f64 = 1e-6;
/// A voxel face belongs to a crack plane that passes its centre this closely, in units of the
/// spacing: half a voxel by construction, and as much again for where a break snaps to the lattice.
const AT_PLANE: f64 = 1.0;
/// A contact ends within this distance of its voxel faces, in units of the spacing.
const SECTION_REACH: f64 = 1.5;
/// Edge of the cubes in which a contact away from all shared planes counts as flat [voxels].
const CUBE: usize = 4;
/// No piece.
const NONE: u32 = u32::MAX;

/// The contacts of solids that share out the voxels of one lattice, in its grid frame.
pub(super) fn contacts(solids: &[&GridSolid]) -> Vec<Interface> {
    // Sum up the faces of each flat part of each pair's contact.
    let Some(lattice) = Lattice::new(solids) else { return Vec::new() };
    let spacing = lattice.grid.spacing;
    let mut planes: BTreeMap<(u32, u32), Vec<HalfSpace>> = BTreeMap::new();
    let mut parts: BTreeMap<(u32, u32, Part), PartSum> = BTreeMap::new();
    let mut contacts = Contacts::default();
    lattice.for_each_face(|face| {
        let (a, b) = face.pieces;
        // Of a smooth surface the faces across an axis have the area of its shadow along it.
        if let Some(normal) = rough_normal(solids[a as usize], solids[b as usize], face.center) {
            let area = spacing * spacing * face.filled * normal.dot(face.direction).max(0.0);
            let part = FlatPart {
                vector: area * normal,
                centroid: face.center,
                section: CrossSection {
                    second_moment: face.spread(spacing) * area,
                    rim: face.corners(spacing).map(|corner| corner - face.center).to_vec(),
                },
            };
            contacts.add((a as usize, b as usize), part);
            return;
        }
        let shared = planes
            .entry(face.pieces)
            .or_insert_with(|| shared_planes(solids[a as usize], solids[b as usize], spacing));
        let part = face.part(shared, spacing);
        let plane = if let Part::OnPlane(plane) = part { Some(&shared[plane]) } else { None };
        parts.entry((a, b, part)).or_default().add(&face, spacing, plane);
    });

    // Cracks at a slant leave the material between nodes.
    let rims = Rims::new(solids, &planes);
    lattice.for_each_rim(|face| {
        for (other, plane) in rims.beyond(&face) {
            let (a, b) = (face.pieces.0.min(other), face.pieces.0.max(other));
            let direction = if a == other { -face.direction } else { face.direction };
            if let Some(sum) = parts.get_mut(&(a, b, Part::OnPlane(plane))) {
                let plane = &planes[&(a, b)][plane];
                sum.add(&Face { direction, ..face }, spacing, Some(plane));
            }
        }
    });

    // A part on a plane has the plane's normal; what its staircase has across it comes from its
    // rim.
    let reach = SECTION_REACH * spacing;
    for ((a, b, part), sum) in parts {
        if let Part::OnPlane(plane) = part {
            let plane = &planes[&(a, b)][plane];
            let pair = [a, b].map(|piece| solids[piece as usize]);
            let around = (sum.low - reach, sum.high + reach);
            let is_between = |point| lattice.is_between([a, b], point);
            if let Some(part) = section(pair, plane, around, is_between) {
                contacts.add((a as usize, b as usize), part);
                continue;
            }
        }
        let vector = match part {
            Part::OnPlane(plane) => {
                let normal = planes[&(a, b)][plane].normal;
                normal * normal.dot(sum.vector).max(0.0)
            }
            Part::InCube(_) => sum.vector,
        };
        contacts.add((a as usize, b as usize), sum.flat_part(spacing * spacing * vector));
    }
    contacts.into_interfaces()
}

/// A part of a contact that counts as flat.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Part {
    /// On a common plane of the two pieces.
    OnPlane(usize),
    /// In a cube of [`CUBE`] voxels a side, at these places in the row of cubes along each axis.
    InCube([usize; 3]),
}

/// The voxel faces of one part.
struct PartSum {
    /// Number of faces, weighted by their fill.
    weight: f64,
    /// Sum of their directions.
    vector: DVec3,
    /// Sum of their centres, grid frame [m].
    moment: DVec3,
    /// Sum of the integrals of `x x^T` over each, relative to its area [m^2].
    second_moment: DMat3,
    farthest: Farthest,
    /// On a plane the lowest and highest corner of the rectangle around their centres, along the
    /// plane's [`axes`] [m].
    low: DVec2,
    high: DVec2,
}

impl Default for PartSum {
    fn default() -> Self {
        Self {
            weight: 0.0,
            vector: DVec3::ZERO,
            moment: DVec3::ZERO,
            second_moment: DMat3::ZERO,
            farthest: Farthest::default(),
            low: DVec2::INFINITY,
            high: DVec2::NEG_INFINITY,
        }
    }
}

impl PartSum {
    fn add(&mut self, face: &Face, spacing: f64, plane: Option<&HalfSpace>) {
        self.weight += face.filled;
        self.vector += face.filled * face.direction;
        self.moment += face.filled * face.center;
        self.second_moment +=
            (outer(face.center, face.center) + face.spread(spacing)) * face.filled;
        face.corners(spacing).into_iter().for_each(|corner| self.farthest.add(corner));
        if let Some(plane) = plane {
            let at = DVec2::from_array(axes(plane).map(|axis| axis.dot(face.center)));
            self.low = self.low.min(at);
            self.high = self.high.max(at);
        }
    }

    /// With a vector area [m^2] that all faces together stand for.
    fn flat_part(&self, vector: DVec3) -> FlatPart {
        let centroid = self.moment / self.weight;
        let spread = self.second_moment * (1.0 / self.weight) - outer(centroid, centroid);
        let section = CrossSection {
            second_moment: spread * vector.length(),
            rim: self.farthest.rim(centroid),
        };
        FlatPart { vector, centroid, section }
    }
}

/// Two voxels side by side: of two pieces, or at the rim of one.
#[derive(Clone, Copy)]
struct Face {
    /// The smaller number first; twice the same at the rim.
    pieces: (u32, u32),
    /// From the first piece to the second or out of the material, along an axis.
    direction: DVec3,
    /// Between the two nodes, grid frame [m].
    center: DVec3,
    /// The node at the lower end.
    node: [usize; 3],
    /// Material fraction of the face, in (0, 1]: the mean of both voxels.
    filled: f64,
}

/// Pieces behind the crack planes of each piece.
///
/// At a slanted crack, a wedge thinner than half a voxel has no voxel of its own, and the staircase
/// of faces stops short by half a voxel on average. The contact area therefore also counts faces
/// between the last voxel and the empty voxel across the crack, by half like all half-empty faces.
struct Rims<'a> {
    solids: &'a [&'a GridSolid],
    /// For each piece: another one, the plane between the two, whose inside is the first piece's,
    /// and its number.
    behind: Vec<Vec<(u32, HalfSpace, usize)>>,
}

impl<'a> Rims<'a> {
    fn new(solids: &'a [&'a GridSolid], planes: &BTreeMap<(u32, u32), Vec<HalfSpace>>) -> Self {
        let mut behind = vec![Vec::new(); solids.len()];
        for (&(a, b), shared) in planes {
            for (number, &plane) in shared.iter().enumerate() {
                behind[a as usize].push((b, plane, number));
                behind[b as usize].push((a, plane.flipped(), number));
            }
        }
        Self { solids, behind }
    }

    /// The pieces, and the numbers of the planes, behind which the empty node of a face at the rim
    /// lies.
    fn beyond(&self, face: &Face) -> impl Iterator<Item = (u32, usize)> {
        let half = 0.5 * self.solids[0].grid().spacing;
        let empty = face.center + half * face.direction;
        let is_behind = move |(other, plane, _): &&(u32, HalfSpace, usize)| {
            let cuts = &self.solids[*other as usize].outline.cuts;
            plane.distance(empty) > 0.0 && cuts.iter().all(|cut| cut.distance(empty) <= 0.0)
        };
        self.behind[face.pieces.0 as usize]
            .iter()
            .filter(is_behind)
            .map(|&(other, _, number)| (other, number))
    }
}

impl Face {
    /// Integral of `r r^T` over it relative to its area, `r` from its centre [m^2].
    fn spread(&self, spacing: f64) -> DMat3 {
        DMat3::from_diagonal((DVec3::ONE - self.direction.abs()) * (spacing * spacing / 12.0))
    }

    fn corners(&self, spacing: f64) -> [DVec3; 4] {
        let axis = self.direction.abs();
        let [across, along] =
            [DVec3::new(axis.y, axis.z, axis.x), DVec3::new(axis.z, axis.x, axis.y)];
        let half = 0.5 * spacing;
        [(-half, -half), (half, -half), (half, half), (-half, half)]
            .map(|(u, v)| self.center + u * across + v * along)
    }

    fn part(&self, planes: &[HalfSpace], spacing: f64) -> Part {
        let away = |plane: usize| planes[plane].distance(self.center).abs();
        let nearest = (0..planes.len()).min_by(|&p, &q| away(p).total_cmp(&away(q)));
        match nearest.filter(|&plane| away(plane) <= AT_PLANE * spacing) {
            Some(plane) => Part::OnPlane(plane),
            None => Part::InCube(self.node.map(|n| n / CUBE)),
        }
    }
}

/// Cracks of a piece that face a crack of the other piece.
fn shared_planes(a: &GridSolid, b: &GridSolid, spacing: f64) -> Vec<HalfSpace> {
    // The lattice's middle is where the planes must agree; the origin may be far away.
    let (low, high) = a.grid().bounds();
    let (middle, reach) = (0.5 * (low + high), (high - low).length());
    let other_side = |cut: &HalfSpace, other: &HalfSpace| {
        let turned = (cut.normal + other.normal).length() * reach;
        let moved = cut.distance(middle) + other.distance(middle);
        turned <= SAME_PLANE * spacing && moved.abs() <= SAME_PLANE * spacing
    };
    let is_shared = |cut: &&HalfSpace| b.outline.cuts.iter().any(|other| other_side(cut, other));
    a.outline.cuts.iter().filter(is_shared).copied().collect()
}

/// Unit normal, from `a` to `b`, of the rough crack that passes between the two within a voxel of a
/// point.
fn rough_normal(a: &GridSolid, b: &GridSolid, point: DVec3) -> Option<DVec3> {
    let near = AT_PLANE * a.grid().spacing;
    let nearest = |solid: &GridSolid| {
        let here = solid.outline.rough.iter().map(|cell| cell.value_and_gradient(point));
        let found = here.min_by(|p, q| p.0.abs().total_cmp(&q.0.abs()));
        let (_, gradient) = found.filter(|(distance, _)| f64::from(distance.abs()) <= near)?;
        gradient.as_dvec3().try_normalize()
    };
    (nearest(a)? - nearest(b)?).try_normalize()
}

/// The part of the lattice that holds all pieces.
struct Lattice {
    grid: Grid,
    /// Which piece each voxel belongs to.
    owner: Vec<u32>,
    /// Material fraction of each voxel.
    coverage: Vec<f32>,
}

impl Lattice {
    fn new(solids: &[&GridSolid]) -> Option<Self> {
        // Place each piece's grid on the first one's lattice.
        let first = solids.first()?.grid();
        let places: Vec<[i64; 3]> = solids
            .iter()
            .map(|solid| first.lattice_from_point(solid.grid().origin))
            .map(|offset| offset.to_array().map(|n| (n + 0.5).floor() as i64))
            .collect();
        let mut low = [i64::MAX; 3];
        let mut high = [i64::MIN; 3];
        for (place, solid) in places.iter().zip(solids) {
            for axis in 0..3 {
                low[axis] = low[axis].min(place[axis]);
                high[axis] = high[axis].max(place[axis] + solid.grid().dims[axis] as i64);
            }
        }
        let corner = DVec3::new(low[0] as f64, low[1] as f64, low[2] as f64);
        let dims = std::array::from_fn(|axis| (high[axis] - low[axis]) as usize);
        let grid =
            Grid { origin: first.origin + first.spacing * corner, spacing: first.spacing, dims };

        // Enter its voxels, row by row.
        let mut owner = vec![NONE; grid.len()];
        let mut coverage = vec![0.0; grid.len()];
        for ((place, solid), piece) in places.iter().zip(solids).zip(0_u32..) {
            let own = solid.grid();
            let filled = solid.coverage();
            let [i, j, k]: [usize; 3] =
                std::array::from_fn(|axis| (place[axis] - low[axis]) as usize);
            for row in 0..own.dims[1] * own.dims[2] {
                let from = row * own.dims[0];
                let to = grid.index(i, j + row % own.dims[1], k + row / own.dims[1]);
                for n in 0..own.dims[0] {
                    if filled[from + n] > 0.0 {
                        owner[to + n] = piece;
                        coverage[to + n] = filled[from + n];
                    }
                }
            }
        }
        Some(Self { grid, owner, coverage })
    }

    /// True if a point is between two pieces, and not between others of their cells: both have a
    /// voxel in its cell or beside it, or one has and no third piece. A wedge thinner than half a
    /// voxel has none.
    fn is_between(&self, [a, b]: [u32; 2], point: DVec3) -> bool {
        let place = self.grid.lattice_from_point(point).to_array();
        let range = |axis: usize, margin: i64| {
            let low = libm::floor(place[axis]) as i64;
            let last = self.grid.dims[axis] as i64 - 1;
            (low - margin).max(0)..=(low + 1 + margin).min(last)
        };
        let mut near = [false; 3];
        for margin in 0..2 {
            for k in range(2, margin) {
                for j in range(1, margin) {
                    let row = self.grid.index(0, j as usize, k as usize);
                    for i in range(0, margin) {
                        let owner = self.owner[row + i as usize];
                        near[0] |= owner == a;
                        near[1] |= owner == b;
                        near[2] |= owner != a && owner != b && owner != NONE;
                    }
                }
            }
            if near[0] && near[1] {
                return true;
            }
        }
        (near[0] || near[1]) && !near[2]
    }

    /// Visits each pair of neighbouring voxels of two pieces.
    fn for_each_face(&self, mut visit: impl FnMut(Face)) {
        self.for_each_pair(|face, [low, high]| {
            if low != NONE && high != NONE {
                let direction = if low < high { face.direction } else { -face.direction };
                visit(Face { pieces: (low.min(high), low.max(high)), direction, ..face });
            }
        });
    }

    /// Visits each voxel of a piece that has an empty one beside it.
    fn for_each_rim(&self, mut visit: impl FnMut(Face)) {
        self.for_each_pair(|face, [low, high]| {
            if low == NONE {
                visit(Face { pieces: (high, high), direction: -face.direction, ..face });
            } else if high == NONE {
                visit(Face { pieces: (low, low), ..face });
            }
        });
    }

    /// Visits each pair of neighbouring voxels that do not belong to the same piece, as a face
    /// whose direction is an axis, with the two owners in its order.
    fn for_each_pair(&self, mut visit: impl FnMut(Face, [u32; 2])) {
        let [nx, ny, _] = self.grid.dims;
        let half = 0.5 * self.grid.spacing;
        for (axis, stride) in [1, nx, nx * ny].into_iter().enumerate() {
            for node in 0..self.owner.len().saturating_sub(stride) {
                let owners = [self.owner[node], self.owner[node + stride]];
                if owners[0] == owners[1] {
                    continue;
                }
                // The last voxel of a row is followed by another row's first.
                let [i, j, k] = self.grid.coordinates(node);
                if [i, j, k][axis] + 1 == self.grid.dims[axis] {
                    continue;
                }
                let direction = DVec3::AXES[axis];
                let face = Face {
                    pieces: (NONE, NONE),
                    direction,
                    center: self.grid.node(i, j, k) + half * direction,
                    node: [i, j, k],
                    filled: 0.5 * f64::from(self.coverage[node] + self.coverage[node + stride]),
                };
                visit(face, owners);
            }
        }
    }
}
