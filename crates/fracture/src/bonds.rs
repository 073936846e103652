//! Pieces that are glued together, and when the glue gives way.

use crate::stress::{RigidPiece, Stress, Wrench, bond_stresses, islands};
use crate::{Fragment, Interface, interfaces};
use frangible_geometry::{Hull, RigidTransform, Shape};
use glam::DVec3;
use std::sync::Arc;

/// What a bond bears [Pa].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BondStrength {
    /// Across it.
    pub tension: f64,
    /// Along it.
    pub shear: f64,
}

/// Convex pieces with a bond at each face that two of them share; all in one frame, that of the body before it broke.
#[derive(Clone, Debug)]
pub struct Glued {
    hulls: Vec<Arc<Hull>>,
    pieces: Vec<RigidPiece>,
    bonds: Vec<Interface>,
    strength: BondStrength,
    /// Of the last solution, from which the next one starts.
    displacements: Vec<Wrench>,
}

/// A force at a point, both in the pieces' frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLoad {
    /// [m]
    pub point: DVec3,
    /// [N]
    pub force: DVec3,
}

/// How many overstressed bonds break before the stresses are looked at again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Giving {
    /// The load stays while they break: those break first that are nearly as bad as the worst, and they may relieve the others.
    Worst,
    /// The load is over before a piece has moved: all that it overstresses.
    All,
}

/// What is nearly as bad as the worst.
const NEARLY: f64 = 0.8;

/// Rounds of breaking and looking again. What still gives then gives in the next frame.
const MOST_ROUNDS: u32 = 32;

impl Glued {
    /// Pieces that touch, of which some cannot move.
    pub fn new(hulls: Vec<Hull>, anchored: impl Fn(DVec3) -> bool, strength: BondStrength) -> Self {
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
        Self { hulls: hulls.into_iter().map(Arc::new).collect(), pieces, bonds, strength, displacements }
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

    /// Whether a piece cannot move.
    pub fn is_anchored(&self) -> bool {
        self.pieces.iter().any(|piece| piece.anchored)
    }

    /// How near each bond is to breaking, 1 if it just does not, under point loads and an acceleration that all pieces feel [m/s^2] at a
    /// density [kg/m^3].
    pub fn strains(&mut self, loads: &[PointLoad], field: DVec3, density: f64) -> Vec<f64> {
        let mut wrenches: Vec<Wrench> = self
            .pieces
            .iter()
            .map(|piece| Wrench { linear: density * piece.volume * field, angular: DVec3::ZERO })
            .collect();
        for load in loads {
            if let Some(index) = self.piece_at(load.point) {
                let wrench = Wrench::at(load.force, load.point, self.pieces[index].center);
                wrenches[index].linear += wrench.linear;
                wrenches[index].angular += wrench.angular;
            }
        }
        let strength = self.strength;
        let strain = |stress: Stress| (stress.tension / strength.tension).max(stress.shear / strength.shear);
        bond_stresses(&self.pieces, &self.bonds, &wrenches, &mut self.displacements)
            .into_iter()
            .map(strain)
            .collect()
    }

    /// Breaks bonds under loads, as in [`Glued::strains`], until none gives. Returns those that broke.
    pub fn give_way(
        &mut self,
        loads: &[PointLoad],
        field: DVec3,
        density: f64,
        giving: Giving,
    ) -> Vec<Interface> {
        let mut broken = Vec::new();
        for _ in 0..MOST_ROUNDS {
            let strains = self.strains(loads, field, density);
            let worst = strains.iter().copied().fold(0.0, f64::max);
            if worst <= 1.0 {
                break;
            }
            let least = if giving == Giving::All { 1.0 } else { (NEARLY * worst).max(1.0) };
            let mut strains = strains.into_iter();
            self.bonds.retain(|bond| {
                let holds = strains.next().is_none_or(|strain| strain < least || strain <= 1.0);
                if !holds {
                    broken.push(*bond);
                }
                holds
            });
        }
        broken
    }

    /// What still holds together, each with its bonds.
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

    /// The piece that a point lies in, or is nearest to.
    fn piece_at(&self, point: DVec3) -> Option<usize> {
        let distance = |hull: &Hull| hull.distance_and_gradient(point).0;
        (0..self.hulls.len())
            .map(|index| (distance(&self.hulls[index]), index))
            .min_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)))
            .map(|(_, index)| index)
    }
}

/// A bond for each face that two hulls share.
fn touching(hulls: &[Hull]) -> Vec<Interface> {
    let fragment = |hull: &Hull| {
        let (low, high) = hull.bounds();
        let shape = Shape::convex(hull.clone(), (high - low).max_element()).ok()?;
        let parent_from_fragment: RigidTransform = shape.body_from_grid.inverse();
        Some(Fragment { shape, parent_from_fragment })
    };
    let fragments: Option<Vec<Fragment>> = hulls.iter().map(fragment).collect();
    fragments.map(|fragments| interfaces(&fragments)).unwrap_or_default()
}
