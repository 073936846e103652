//! Pieces that are glued together, and when the glue gives way.

use crate::align::{Impact, align_pattern};
use crate::fragment::Fragment;
use crate::interfaces::interface::Interface;
use crate::pattern::Pattern;
use crate::shatter::settings::ShatterSettings;
use crate::shatter_hull::cut_hull;
use crate::slivers::Smallest;
use crate::stress::{RigidPiece, Stress, Wrench, bond_stresses, islands};
use crate::{interfaces, polygon};
use frangible_geometry::outer;
use frangible_geometry::{Geometry, HalfSpace, Hull, PlaneClipper, Shape};
use frangible_math::RigidTransform;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

/// Strength of a bond [Pa].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct BondStrength {
    /// Across it.
    pub tension: f64,
    /// Along it.
    pub shear: f64,
}

/// Convex pieces with a bond at each common face; all in the frame of the body before it broke.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Glued {
    #[serde(with = "frangible_math::shared")]
    hulls: Vec<Arc<Hull>>,
    /// Of each piece, in the body that all of them were first glued together in.
    numbers: Vec<u32>,
    /// For each piece; no bond breaks between two of one block.
    blocks: Vec<u32>,
    pieces: Vec<RigidPiece>,
    bonds: Vec<Interface>,
    strength: BondStrength,
    /// Of the last solution, from which the next one starts.
    displacements: Vec<Wrench>,
}

/// Blocks of pieces.
struct Rigid {
    /// For each piece.
    block_of: Vec<usize>,
    blocks: Vec<RigidPiece>,
}

/// A force at a point, both in the pieces' frame.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PointLoad {
    /// [m]
    pub point: DVec3,
    /// [N]
    pub force: DVec3,
}

/// The bonds that gave way under a load.
#[derive(Clone, Debug, PartialEq)]
pub struct GaveWay {
    /// Broken bonds, in order.
    pub broken: Vec<Interface>,
    /// The largest part of the load that bonds carried when the next ones broke, from 0 to 1: the
    /// load at which the piece came free that was struck.
    pub bore: f64,
}

/// Strains above this fraction of the worst also break.
const NEARLY: f64 = 0.8;

/// Maximum number of rounds of breaking and stress analysis per frame. The next frame continues.
const MOST_ROUNDS: u32 = 32;

impl Glued {
    /// Touching pieces, of which some are anchored. Pieces of one block stay together.
    pub fn new(
        prescored: Prescored,
        anchored: impl Fn(DVec3) -> bool,
        strength: BondStrength,
    ) -> Self {
        let Prescored { hulls, blocks } = prescored;
        let piece = |hull: &Hull| {
            let mass = hull.mass_properties();
            RigidPiece {
                center: mass.center,
                volume: mass.volume,
                inertia: mass.inertia,
                anchored: anchored(mass.center),
            }
        };
        let pieces: Vec<RigidPiece> = hulls.iter().map(piece).collect();
        let bonds = touching(&hulls);
        let displacements = vec![Wrench::default(); pieces.len()];
        Self {
            numbers: (0..hulls.len() as u32).collect(),
            hulls: hulls.into_iter().map(Arc::new).collect(),
            blocks,
            pieces,
            bonds,
            strength,
            displacements,
        }
    }

    /// In the pieces' frame.
    pub fn hulls(&self) -> &[Arc<Hull>] {
        &self.hulls
    }

    /// In the order of the hulls.
    pub fn pieces(&self) -> &[RigidPiece] {
        &self.pieces
    }

    /// Those that hold.
    pub fn bonds(&self) -> &[Interface] {
        &self.bonds
    }

    /// True for an anchored piece.
    pub fn is_anchored(&self) -> bool {
        self.pieces.iter().any(|piece| piece.anchored)
    }

    /// True if a bond holds that could break.
    pub fn can_break(&self) -> bool {
        self.bonds.iter().any(|bond| !self.is_within_block(bond))
    }

    fn is_within_block(&self, bond: &Interface) -> bool {
        self.blocks[bond.a] == self.blocks[bond.b]
    }

    /// Strain of each bond relative to its strength (0 within a block), under point loads and an
    /// acceleration field [m/s^2] at a density [kg/m^3].
    pub fn strains(&mut self, loads: &[PointLoad], field: DVec3, density: f64) -> Vec<f64> {
        let Rigid { block_of, blocks } = self.rigid_blocks();
        let mut wrenches: Vec<Wrench> = blocks
            .iter()
            .map(|block| Wrench { linear: density * block.volume * field, angular: DVec3::ZERO })
            .collect();
        for load in loads {
            if let Some(index) = self.piece_at(load.point).map(|piece| block_of[piece]) {
                let wrench = Wrench::at(load.force, load.point, blocks[index].center);
                wrenches[index].linear += wrench.linear;
                wrenches[index].angular += wrench.angular;
            }
        }
        let between =
            |bond: &Interface| Interface { a: block_of[bond.a], b: block_of[bond.b], ..*bond };
        let breakable = self.bonds.iter().filter(|bond| !self.is_within_block(bond));
        let bonds: Vec<Interface> = breakable.map(between).collect();
        let mut displacements = vec![Wrench::default(); blocks.len()];
        for (piece, &block) in block_of.iter().enumerate() {
            displacements[block] = self.displacements[piece];
        }
        let stresses = bond_stresses(&blocks, &bonds, &wrenches, &mut displacements);
        for (piece, &block) in block_of.iter().enumerate() {
            self.displacements[piece] = displacements[block];
        }
        let strength = self.strength;
        let strain =
            |stress: Stress| (stress.tension / strength.tension).max(stress.shear / strength.shear);
        let mut strains = stresses.into_iter().map(strain);
        let of_bond =
            |bond| if self.is_within_block(bond) { 0.0 } else { strains.next().unwrap_or(0.0) };
        self.bonds.iter().map(of_bond).collect()
    }

    /// The blocks as they are, each rigid, as no bond of theirs breaks.
    fn rigid_blocks(&self) -> Rigid {
        let mut index_of = BTreeMap::new();
        let mut members: Vec<Vec<&RigidPiece>> = Vec::new();
        let mut block_of = Vec::with_capacity(self.pieces.len());
        for (piece, block) in self.pieces.iter().zip(&self.blocks) {
            let index = *index_of.entry(*block).or_insert(members.len());
            if index == members.len() {
                members.push(Vec::new());
            }
            members[index].push(piece);
            block_of.push(index);
        }
        Rigid { block_of, blocks: members.iter().map(|pieces| RigidPiece::of(pieces)).collect() }
    }

    /// Breaks bonds under loads, as in [`Glued::strains`], until none gives. Those break first that
    /// are nearly as bad as the worst: they may relieve the others.
    pub fn give_way(&mut self, loads: &[PointLoad], field: DVec3, density: f64) -> GaveWay {
        let mut gave = GaveWay { broken: Vec::new(), bore: 0.0 };
        for _ in 0..MOST_ROUNDS {
            let strains = self.strains(loads, field, density);
            let worst = strains.iter().copied().fold(0.0, f64::max);
            if worst <= 1.0 {
                break;
            }
            gave.bore = gave.bore.max(1.0 / worst);
            let least = (NEARLY * worst).max(1.0);
            let mut strains = strains.into_iter();
            self.bonds.retain(|bond| {
                let holds = strains.next().is_none_or(|strain| strain < least || strain <= 1.0);
                if !holds {
                    gave.broken.push(*bond);
                }
                holds
            });
        }
        gave
    }

    /// True if the piece at a point has come free of what is anchored or, if nothing is, of any
    /// piece.
    pub fn comes_free(&self, point: DVec3) -> bool {
        let islands = islands(self.pieces.len(), &self.bonds);
        if !self.is_anchored() {
            return islands.len() > 1;
        }
        let Some(struck) = self.piece_at(point) else { return false };
        let of_struck = islands.iter().filter(|island| island.contains(&struck)).flatten();
        !of_struck.into_iter().any(|&piece| self.pieces[piece].anchored)
    }

    /// The numbers of a bond's pieces in the body that all were first glued together in.
    pub fn name_of(&self, bond: &Interface) -> [u32; 2] {
        [self.numbers[bond.a], self.numbers[bond.b]]
    }

    /// Breaks the bonds with these [names](Glued::name_of).
    pub fn cut(&mut self, names: &BTreeSet<[u32; 2]>) {
        let numbers = &self.numbers;
        self.bonds.retain(|bond| !names.contains(&[numbers[bond.a], numbers[bond.b]]));
    }

    /// Islands of intact bonds, each with its bonds.
    pub fn islands(&self) -> Vec<Self> {
        let mut place = vec![(0, 0); self.pieces.len()];
        let members = islands(self.pieces.len(), &self.bonds);
        for (island, members) in members.iter().enumerate() {
            for (index, &piece) in members.iter().enumerate() {
                place[piece] = (island, index);
            }
        }
        let part = |(island, members): (usize, &Vec<usize>)| Self {
            hulls: members.iter().map(|&piece| self.hulls[piece].clone()).collect(),
            numbers: members.iter().map(|&piece| self.numbers[piece]).collect(),
            blocks: members.iter().map(|&piece| self.blocks[piece]).collect(),
            pieces: members.iter().map(|&piece| self.pieces[piece]).collect(),
            bonds: self
                .bonds
                .iter()
                .filter(|bond| place[bond.a].0 == island)
                .map(|bond| Interface { a: place[bond.a].1, b: place[bond.b].1, ..*bond })
                .collect(),
            strength: self.strength,
            displacements: members.iter().map(|&piece| self.displacements[piece]).collect(),
        };
        members.iter().enumerate().map(part).collect()
    }

    /// Spreads the point forces of a flat contact over the faces of pieces in it: a flat contact
    /// has few points but a distributed pressure. A linear pressure keeps the centre of pressure.
    /// Contacts that are not flat, or have fewer than three points, stay unchanged.
    pub fn spread(&self, contact: Vec<PointLoad>) -> Vec<PointLoad> {
        let force: DVec3 = contact.iter().map(|load| load.force).sum();
        let Some(normal) = force.try_normalize().filter(|_| contact.len() >= 3) else {
            return contact;
        };
        let weights = || contact.iter().map(|load| load.force.dot(normal));
        let total: f64 = weights().sum();
        let middle = contact
            .iter()
            .zip(weights())
            .map(|(load, weight)| weight / total * load.point)
            .sum::<DVec3>();

        // Faces in the plane of the points and in their box. Friction leans the force, and faces
        // lie across their own normals.
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for load in &contact {
            (low, high) = (low.min(load.point), high.max(load.point));
        }
        let close = FLAT * (high - low).max_element();
        let mut faces: Vec<(DVec3, f64)> = Vec::new();
        for face in
            self.hulls.iter().flat_map(|hull| (0..hull.faces().len()).map(move |at| (hull, at)))
        {
            let (hull, plane) = (face.0, face.0.face(face.1).plane);
            let holds_all = contact.iter().all(|load| plane.distance(load.point).abs() <= close);
            if holds_all && plane.normal.dot(normal) < 0.0 {
                let corners: Vec<DVec3> = hull
                    .face(face.1)
                    .vertices
                    .iter()
                    .map(|&vertex| hull.vertices()[vertex as usize])
                    .collect();
                let (area, centroid) = polygon::area_and_centroid(&corners);
                if centroid.cmpge(low - close).all() && centroid.cmple(high + close).all() {
                    faces.push((centroid, area));
                }
            }
        }

        // The share of each face is its area's, and a gradient's that moves the middle to where it
        // was.
        let area: f64 = faces.iter().map(|face| face.1).sum();
        if faces.is_empty() || area <= 0.0 {
            return contact;
        }
        let center = faces.iter().map(|(at, part)| *part / area * *at).sum::<DVec3>();
        let mut second = DMat3::ZERO;
        for (at, part) in &faces {
            second += outer(*at - center, *at - center) * (*part / area);
        }
        // Across the plane, and along a row of faces, there is no gradient to be had.
        second += DMat3::IDENTITY * (FLAT * (high - low).length_squared());
        let gradient = second.inverse() * (middle - center);
        let share = |(at, part): (DVec3, f64)| PointLoad {
            point: at,
            force: force * (part / area * (1.0 + gradient.dot(at - center))),
        };
        faces.into_iter().map(share).collect()
    }

    /// The piece that a point lies in, or is nearest to.
    fn piece_at(&self, point: DVec3) -> Option<usize> {
        let distance = |hull: &Hull| hull.distance_and_gradient(point).0;
        (0..self.hulls.len())
            .map(|index| (distance(&self.hulls[index]), index))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, index)| index)
    }
}

/// The pieces that a glued body is cut into.
#[derive(Clone, Debug)]
pub struct Prescored {
    /// In the frame of the body's grid.
    pub hulls: Vec<Hull>,
    /// Block of each piece. Pieces of one block stay together: mortar sticks to the brick of its
    /// block.
    pub blocks: Vec<u32>,
}

impl From<Vec<Hull>> for Prescored {
    /// Each a block.
    fn from(hulls: Vec<Hull>) -> Self {
        Self { blocks: (0..hulls.len() as u32).collect(), hulls }
    }
}

impl Prescored {
    fn with_capacity(pieces: usize) -> Self {
        Self { hulls: Vec::with_capacity(pieces), blocks: Vec::with_capacity(pieces) }
    }

    /// Adds the piece that a cell of a pattern cuts out of one of a body's parts. A joint belongs
    /// to the block of the last non-joint cell before it, and has its own material.
    fn add(&mut self, hull: Hull, pattern: &Pattern, part: usize, cell: usize) {
        let owner = (0..=cell).rev().find(|&cell| !pattern.is_joint(cell)).unwrap_or(cell);
        self.hulls.push(if pattern.is_joint(cell) { hull.all_inner() } else { hull });
        self.blocks.push((part * pattern.len() + owner) as u32);
    }
}

/// The pieces of a body that is one convex polyhedron or several, in the frame of its grid: each
/// cut along a pattern, that is laid on the body as for an impact, if there is one. `None` if the
/// body, or a cell of the pattern, is not made of convex polyhedra.
pub fn prescore(body: &Shape, pattern: Option<&Pattern>, impact: &Impact) -> Option<Prescored> {
    let parts: Vec<Hull> = match &body.geometry {
        Geometry::Compound(compound) => {
            compound.parts().iter().map(|part| part.hull.clone()).collect()
        }
        _ => vec![body.breaks_as()?.clone()],
    };
    let Some(pattern) = pattern else { return Some(parts.into()) };
    pattern.planar()?;
    if body.breaks_as().is_some() {
        let settings =
            ShatterSettings { smallest: Smallest::of_first(body), ..ShatterSettings::default() };
        let fragments = cut_hull(body, pattern, impact, &settings, false);
        let mut pieces = Prescored::with_capacity(fragments.len());
        for fragment in fragments {
            pieces.add(fragment.shape.breaks_as()?.clone(), pattern, 0, fragment.cell as usize);
        }
        return Some(pieces);
    }

    // Each part of a compound is cut by itself.
    let regions = align_pattern(pattern, impact, body);
    let mut clipper = PlaneClipper::default();
    let mut pieces = Prescored::with_capacity(parts.len());
    for (number, part) in parts.iter().enumerate() {
        for (cell, region) in regions.iter().enumerate() {
            let cuts: Vec<HalfSpace> = region.cuts.iter().map(|cut| cut.half_space).collect();
            let piece = clipper.clipped(part, &cuts);
            if let Some(piece) = piece.filter(|piece| piece.volume() > SMALLEST_PIECE * body.volume)
            {
                pieces.add(piece, pattern, number, cell);
            }
        }
    }
    Some(pieces)
}

/// Maximum distance from a plane, relative to a contact's extent, for points and faces in the
/// contact.
const FLAT: f64 = 1e-3;

/// Part of a body's volume below which a piece is rounding.
const SMALLEST_PIECE: f64 = 1e-12;

/// A bond for each face that two hulls share.
fn touching(hulls: &[Hull]) -> Vec<Interface> {
    let fragment = |hull: &Hull| {
        let (low, high) = hull.bounds();
        let shape = Shape::convex(hull.clone(), (high - low).max_element()).ok()?;
        let parent_from_fragment: RigidTransform = shape.body_from_grid.inverse();
        Some(Fragment { shape, parent_from_fragment, cell: 0 })
    };
    let fragments: Option<Vec<Fragment>> = hulls.iter().map(fragment).collect();
    fragments.map(|fragments| interfaces(&fragments)).unwrap_or_default()
}
