//! Pieces that are glued together, and when the glue gives way.

mod contact_pressure;

use crate::grid_pieces::GridPieces;
use crate::interfaces::interface::Interface;
use crate::prescore::{Forms, Prescored, touching};
use crate::strength_points::StrengthPoints;
use crate::stress::{RigidPiece, Stress, Wrench, bond_stresses, islands};
use frangible_geometry::{Compound, Hull, NoMass, Shape};
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
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

/// Pieces with a bond at each contact; all in the frame of the body before it broke.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Glued {
    /// Of convex pieces.
    #[serde(with = "frangible_math::shared")]
    hulls: Vec<Arc<Hull>>,
    /// All pieces of the body that these were first glued together in, if that lies on a grid.
    #[serde(with = "frangible_math::shared")]
    grid: Option<Arc<GridPieces>>,
    /// Of each piece, in the body that all of them were first glued together in.
    numbers: Vec<u32>,
    /// For each piece; no bond breaks between two of one block.
    blocks: Vec<u32>,
    pieces: Vec<RigidPiece>,
    bonds: Vec<Interface>,
    strength: BondStrength,
    /// Where it is more, or less.
    #[serde(with = "frangible_math::shared")]
    strength_points: Option<Arc<StrengthPoints>>,
    /// Of the last solution, from which the next one starts.
    displacements: Vec<Wrench>,
}

impl Check for PointLoad {
    fn check(&self) -> Checked {
        finite_vector(self.point)?;
        finite_vector(self.force)
    }
}

impl Check for Glued {
    fn check(&self) -> Checked {
        let count = self.pieces.len();
        let lengths = [self.numbers.len(), self.blocks.len(), self.displacements.len()];
        require(count > 0 && lengths == [count; 3], "numbers and blocks of all pieces")?;
        match &self.grid {
            Some(grid) => {
                let are_pieces = self.numbers.iter().all(|&number| (number as usize) < grid.len());
                require(are_pieces && self.hulls.is_empty(), "pieces that were cut")?;
                let mut numbers = self.numbers.clone();
                numbers.sort_unstable();
                numbers.dedup();
                require(numbers.len() == count, "each piece once")?;
            }
            None => require(self.hulls.len() == count, "a polyhedron for each piece")?,
        }
        for RigidPiece { center, volume, inertia, .. } in &self.pieces {
            require(*volume > 0.0 && *volume < 1e30, "pieces with a volume")?;
            let axes = inertia.to_cols_array_2d().map(DVec3::from_array);
            axes.into_iter().chain([*center]).try_for_each(finite_vector)?;
        }
        for &Interface { a, b, area, centroid, normal, section: _ } in &self.bonds {
            require(a < b && b < count, "bonds between two pieces")?;
            require(area > 0.0 && area < 1e30, "bonds with an area")?;
            [centroid, normal].into_iter().try_for_each(finite_vector)?;
        }
        let BondStrength { tension, shear } = self.strength;
        require(tension > 0.0 && shear > 0.0, "bonds with a strength")?;
        self.displacements.iter().try_for_each(|Wrench { linear, angular }| {
            finite_vector(*linear)?;
            finite_vector(*angular)
        })
    }
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
        let Prescored { forms, blocks, contacts } = prescored;
        let (hulls, grid) = match forms {
            Forms::Hulls(hulls) => (hulls, None),
            Forms::Grid(grid) => (Vec::new(), Some(grid)),
        };
        let of_hull = |hull: &Hull| {
            let mass = hull.mass_properties();
            let (center, volume, inertia) = (mass.center, mass.volume, mass.inertia);
            RigidPiece { center, volume, inertia, anchored: false }
        };
        let mut pieces: Vec<RigidPiece> = match &grid {
            Some(grid) => (0..grid.len()).map(|piece| grid.rigid(piece)).collect(),
            None => hulls.iter().map(of_hull).collect(),
        };
        pieces.iter_mut().for_each(|piece| piece.anchored = anchored(piece.center));
        let bonds = contacts.unwrap_or_else(|| match &grid {
            Some(grid) => grid.contacts(),
            None => touching(&hulls),
        });
        Self {
            numbers: (0..pieces.len() as u32).collect(),
            hulls: hulls.into_iter().map(Arc::new).collect(),
            grid,
            blocks,
            displacements: vec![Wrench::default(); pieces.len()],
            pieces,
            bonds,
            strength,
            strength_points: None,
        }
    }

    /// With bonds that are stronger at one place than at another.
    pub fn with_strength_points(self, strength_points: Option<Arc<StrengthPoints>>) -> Self {
        Self { strength_points, ..self }
    }

    /// Times the strength of a bond.
    fn factor(&self, bond: &Interface) -> f64 {
        self.strength_points.as_ref().map_or(1.0, |points| points.factor(bond.centroid))
    }

    /// Of convex pieces, in their frame; empty for others.
    pub fn hulls(&self) -> &[Arc<Hull>] {
        &self.hulls
    }

    /// All pieces together, in their frame. Samples of polyhedra lie `sample_spacing` [m] apart.
    ///
    /// # Errors
    /// If the volume or a moment vanishes.
    pub fn shape(&self, sample_spacing: f64) -> Result<Shape, NoMass> {
        if let Some(grid) = &self.grid {
            return grid.union(&self.numbers).ok_or(NoMass);
        }
        let mut hulls: Vec<Hull> = self.hulls.iter().map(|hull| Hull::clone(hull)).collect();
        match (hulls.len(), hulls.pop()) {
            (1, Some(hull)) => Shape::convex(hull, sample_spacing),
            (_, last) => {
                hulls.extend(last);
                Shape::compound(Compound::new(hulls), sample_spacing)
            }
        }
    }

    /// Masses and places.
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
        let between = |bond: &Interface| Interface {
            a: block_of[bond.a],
            b: block_of[bond.b],
            ..bond.clone()
        };
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
        let of_bond = |bond| {
            let is_rigid = self.is_within_block(bond);
            if is_rigid { 0.0 } else { strains.next().unwrap_or(0.0) / self.factor(bond) }
        };
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
                    gave.broken.push(bond.clone());
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
            hulls: members.iter().filter_map(|&piece| self.hulls.get(piece).cloned()).collect(),
            grid: self.grid.clone(),
            numbers: members.iter().map(|&piece| self.numbers[piece]).collect(),
            blocks: members.iter().map(|&piece| self.blocks[piece]).collect(),
            pieces: members.iter().map(|&piece| self.pieces[piece]).collect(),
            bonds: self
                .bonds
                .iter()
                .filter(|bond| place[bond.a].0 == island)
                .map(|bond| Interface { a: place[bond.a].1, b: place[bond.b].1, ..bond.clone() })
                .collect(),
            strength: self.strength,
            strength_points: self.strength_points.clone(),
            displacements: members.iter().map(|&piece| self.displacements[piece]).collect(),
        };
        members.iter().enumerate().map(part).collect()
    }

    /// The piece that a point lies in, or is nearest to.
    fn piece_at(&self, point: DVec3) -> Option<usize> {
        let distance = |index: usize| match &self.grid {
            Some(grid) => grid.distance(self.numbers[index] as usize, point),
            None => self.hulls[index].distance_and_gradient(point).0,
        };
        (0..self.pieces.len())
            .map(|index| (distance(index), index))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, index)| index)
    }
}
