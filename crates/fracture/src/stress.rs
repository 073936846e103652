//! Stress in the glue between pieces: rigid pieces joined by springs at common faces, the
//! rigid-body-spring model [Kaw78].
//!
//! A bond stretches, shears, bends and twists like a short bar between the centres of its two
//! pieces, with the area and the second moments of the face that they share. It twists as the
//! rectangle with this area and this ratio of second moments. Only ratios of stiffness matter:
//! Young's modulus is 1. Balanced displacements x solve K x = f, by conjugate
//! gradients with the 6 x 6 blocks of the pieces as preconditioner, from the last solution on.
//! Islands without anchor accelerate as one body, and inertia balances their loads (inertia
//! relief).

use crate::interfaces::interface::Interface;
use frangible_geometry::{outer, parallel_axis};
use frangible_math::DisjointSets;
use glam::{DMat3, DVec3};
use serde::{Deserialize, Serialize};

/// A rigid piece at unit density.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct RigidPiece {
    /// Centre of mass, in the frame that all pieces share [m].
    pub center: DVec3,
    /// [m^3]
    pub volume: f64,
    /// About its centre, in the shared frame [m^5].
    pub inertia: DMat3,
    /// True for anchored pieces.
    pub anchored: bool,
}

impl RigidPiece {
    /// Pieces that move as one body.
    pub(crate) fn of(pieces: &[&Self]) -> Self {
        if let [piece] = pieces {
            return **piece;
        }
        let volume: f64 = pieces.iter().map(|piece| piece.volume).sum();
        let center = pieces.iter().map(|piece| piece.volume * piece.center).sum::<DVec3>() / volume;
        let inertia =
            |piece: &&Self| piece.inertia + parallel_axis(piece.volume, piece.center - center);
        Self {
            center,
            volume,
            inertia: pieces.iter().map(inertia).fold(DMat3::ZERO, |sum, part| sum + part),
            anchored: pieces.iter().any(|piece| piece.anchored),
        }
    }
}

/// A force [N] and a torque about a piece's centre [N m]; or a displacement [m] and a rotation
/// [rad] of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct Wrench {
    /// Force, or displacement.
    pub linear: DVec3,
    /// Torque, or rotation.
    pub angular: DVec3,
}

/// The largest stresses in a bond [Pa].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Stress {
    /// Across the face, by pulling and bending; negative if all of it is pressed.
    pub tension: f64,
    /// Along the face, by shearing and twisting.
    pub shear: f64,
}

/// Shear modulus over Young's: of Poisson's ratio 0.25, which stone and concrete have.
const SHEAR_MODULUS: f64 = 0.4;

/// A section thinner than this part of its length, by the ratio of its principal second moments,
/// counts as that thin [1]: faces of no width have no stiffness.
const THINNEST: f64 = 1e-6;

/// A bond counts as no shorter than this, in units of its width: pieces' centres may lie side by
/// side.
const SHORTEST: f64 = 0.1;

/// The residual, relative to the loads, at which the displacements are good enough: stresses are
/// then right to a per mille.
const TOLERANCE: f64 = 1e-6;

/// Steps of conjugate gradients for each piece: exact arithmetic needs six.
const STEPS_PER_PIECE: usize = 12;

impl Wrench {
    /// Of a force at a point, about a piece's centre.
    pub(crate) fn at(force: DVec3, point: DVec3, center: DVec3) -> Self {
        Self { linear: force, angular: (point - center).cross(force) }
    }

    fn dot(&self, other: &Self) -> f64 {
        self.linear.dot(other.linear) + self.angular.dot(other.angular)
    }

    fn plus(&self, scale: f64, other: &Self) -> Self {
        Self {
            linear: self.linear + scale * other.linear,
            angular: self.angular + scale * other.angular,
        }
    }
}

/// A bond as a spring.
struct Spring {
    a: usize,
    b: usize,
    /// From the pieces' centres to its middle [m].
    levers: [DVec3; 2],
    /// Force per displacement and moment per rotation at its middle.
    stretch: DMat3,
    bend: DMat3,
    section: Section,
}

/// The section of a bond, as bending and twisting see it.
struct Section {
    area: f64,
    normal: DVec3,
    /// Principal axes of the section in its plane, and second moments along them [m^4].
    axes: [DVec3; 2],
    moments: [f64; 2],
    /// Torsion constant [m^4] and torsional section modulus [m^3].
    torsion: [f64; 2],
}

impl Section {
    fn new(bond: &Interface) -> Self {
        let (area, normal) = (bond.area, bond.normal);
        let (u, v) = normal.any_orthonormal_pair();
        let second = &bond.section.second_moment;
        let [uu, vv, uv] = [u.dot(*second * u), v.dot(*second * v), u.dot(*second * v)];
        let angle = 0.5 * libm::atan2(2.0 * uv, uu - vv);
        let (sine, cosine) = (libm::sin(angle), libm::cos(angle));
        let half_way = libm::hypot(0.5 * (uu - vv), uv);
        let large = (0.5 * (uu + vv) + half_way).max(f64::MIN_POSITIVE);
        let small = (0.5 * (uu + vv) - half_way).max(THINNEST * THINNEST * large);
        Self {
            area,
            normal,
            axes: [cosine * u + sine * v, cosine * v - sine * u],
            moments: [large, small],
            torsion: torsion_of_rectangle(area, (small / large).sqrt()),
        }
    }

    /// Moment per rotation, times a bond's length. A rotation opens the face by its cross product
    /// with the lever, so it meets the second moment along the axis across its own.
    fn bend(&self) -> DMat3 {
        let [large, small] = self.axes.map(|axis| outer(axis, axis));
        let along = outer(self.normal, self.normal);
        small * self.moments[0]
            + large * self.moments[1]
            + along * (SHEAR_MODULUS * self.torsion[0])
    }

    /// The largest pull at the rim by a moment [Pa]: the stress that bends is linear over a face.
    fn bending_stress(&self, moment: DVec3, rim: &[DVec3]) -> f64 {
        let turned = self.normal.cross(moment);
        let [one, other] =
            [0, 1].map(|n| self.axes[n] * (self.axes[n].dot(turned) / self.moments[n]));
        let gradient = one + other;
        rim.iter().map(|corner| gradient.dot(*corner)).fold(0.0, f64::max)
    }
}

/// Torsion constant [m^4] and torsional section modulus [m^3] of a rectangle of an area [m^2] and a
/// ratio of its sides, at most 1 [YB02, table 10.1].
fn torsion_of_rectangle(area: f64, ratio: f64) -> [f64; 2] {
    let (a, r) = (0.5 * (area / ratio).sqrt(), ratio);
    let b = r * a;
    let r4 = r * r * r * r;
    let constant = a * b * b * b * (16.0 / 3.0 - 3.36 * r * (1.0 - r4 / 12.0));
    let peak = 1.0 + 0.6095 * r + 0.8865 * r * r - 1.8023 * r * r * r + 0.91 * r4;
    [constant, 8.0 * a * b * b / (3.0 * peak)]
}

impl Spring {
    fn new(pieces: &[RigidPiece], bond: &Interface) -> Self {
        let (a, b) = (&pieces[bond.a], &pieces[bond.b]);
        let (area, n) = (bond.area, bond.normal);
        let length = (b.center - a.center).dot(n).abs().max(SHORTEST * area.sqrt());
        let along = outer(n, n);
        let section = Section::new(bond);
        let across = DMat3::IDENTITY - along;
        Self {
            a: bond.a,
            b: bond.b,
            levers: [bond.centroid - a.center, bond.centroid - b.center],
            stretch: (along + across * SHEAR_MODULUS) * (area / length),
            bend: section.bend() * (1.0 / length),
            section,
        }
    }

    /// Force and moment with which it pulls the two pieces together.
    fn pull(&self, x: &[Wrench]) -> (DVec3, DVec3) {
        let moved =
            |side: usize, piece: usize| x[piece].linear + x[piece].angular.cross(self.levers[side]);
        let apart = moved(1, self.b) - moved(0, self.a);
        (self.stretch * apart, self.bend * (x[self.b].angular - x[self.a].angular))
    }

    /// Its part of K x.
    fn add_to(&self, x: &[Wrench], product: &mut [Wrench]) {
        let (force, moment) = self.pull(x);
        for (piece, side, sign) in [(self.a, 0, -1.0), (self.b, 1, 1.0)] {
            let at_center =
                Wrench { linear: force, angular: self.levers[side].cross(force) + moment };
            product[piece] = product[piece].plus(sign, &at_center);
        }
    }
}

/// Stresses in bonds under loads on pieces. `displacements` holds the last solution or zeros, one
/// per piece, and receives the new solution.
pub(crate) fn bond_stresses(
    pieces: &[RigidPiece],
    bonds: &[Interface],
    loads: &[Wrench],
    displacements: &mut [Wrench],
) -> Vec<Stress> {
    let springs: Vec<Spring> = bonds.iter().map(|bond| Spring::new(pieces, bond)).collect();
    let balanced = balanced(pieces, bonds, loads);
    solve(pieces, &springs, [&balanced, loads], displacements);
    let stress = |(spring, bond): (&Spring, &Interface)| {
        let (force, moment) = spring.pull(displacements);
        let (pull, twist) = (force.dot(bond.normal), moment.dot(bond.normal));
        let shear = (force - pull * bond.normal).length();
        let Section { area, torsion: [_, torsion_modulus], .. } = spring.section;
        Stress {
            tension: pull / area + spring.section.bending_stress(moment, &bond.section.rim),
            shear: shear / area + twist.abs() / torsion_modulus,
        }
    };
    springs.iter().zip(bonds).map(stress).collect()
}

/// The pieces that bonds join, in order of their first members, each in order.
pub(crate) fn islands(count: usize, bonds: &[Interface]) -> Vec<Vec<usize>> {
    let mut sets = DisjointSets::new(count);
    bonds.iter().for_each(|bond| sets.unite(bond.a as u32, bond.b as u32));
    let mut members = vec![Vec::new(); count];
    for piece in 0..count {
        members[sets.root(piece as u32) as usize].push(piece);
    }
    members.retain(|island| !island.is_empty());
    members
}

/// Loads with inertia relief: the loads of each island without anchor add up to zero.
fn balanced(pieces: &[RigidPiece], bonds: &[Interface], loads: &[Wrench]) -> Vec<Wrench> {
    let mut balanced = loads.to_vec();
    for island in islands(pieces.len(), bonds) {
        if island.iter().any(|&i| pieces[i].anchored) {
            continue;
        }
        let volume: f64 = island.iter().map(|&i| pieces[i].volume).sum();
        let center =
            island.iter().map(|&i| pieces[i].volume * pieces[i].center).sum::<DVec3>() / volume;
        let (mut inertia, mut force, mut torque) = (DMat3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for &i in &island {
            let lever = pieces[i].center - center;
            inertia += pieces[i].inertia + parallel_axis(pieces[i].volume, lever);
            force += loads[i].linear;
            torque += loads[i].angular + lever.cross(loads[i].linear);
        }
        let (linear, angular) = (force / volume, inertia.inverse() * torque);
        for &i in &island {
            let lever = pieces[i].center - center;
            let along = pieces[i].volume * (linear + angular.cross(lever));
            let about = pieces[i].inertia * angular;
            balanced[i] = loads[i].plus(-1.0, &Wrench { linear: along, angular: about });
        }
    }
    balanced
}

/// Preconditioned conjugate gradients [She94]. The residual is small relative to the loads before
/// inertia relief: in free fall the balanced loads are pure rounding.
fn solve(
    pieces: &[RigidPiece],
    springs: &[Spring],
    [loads, before]: [&[Wrench]; 2],
    x: &mut [Wrench],
) {
    let blocks = Blocks::new(pieces, springs);
    let multiply = |x: &[Wrench]| {
        let mut product = vec![Wrench::default(); x.len()];
        springs.iter().for_each(|spring| spring.add_to(x, &mut product));
        product
    };
    // Anchored pieces do not move.
    let free = |mut values: Vec<Wrench>| {
        for (value, _) in values.iter_mut().zip(pieces).filter(|(_, piece)| piece.anchored) {
            *value = Wrench::default();
        }
        values
    };
    let dot = |a: &[Wrench], b: &[Wrench]| a.iter().zip(b).map(|(a, b)| a.dot(b)).sum::<f64>();

    let loads = free(loads.to_vec());
    let scale = dot(before, &blocks.apply(before));
    let product = multiply(x);
    let mut residual: Vec<Wrench> =
        free(loads.iter().zip(&product).map(|(f, kx)| f.plus(-1.0, kx)).collect());
    let mut direction = blocks.apply(&residual);
    let mut size = dot(&residual, &direction);
    // Where the loads are gone, nothing is a better start than the last solution.
    let unloaded = blocks.apply(&loads);
    if dot(&loads, &unloaded) <= TOLERANCE * TOLERANCE * size {
        x.fill(Wrench::default());
        (size, direction, residual) = (dot(&loads, &unloaded), unloaded, loads);
    }
    for _ in 0..STEPS_PER_PIECE * pieces.len() {
        if size <= TOLERANCE * TOLERANCE * scale {
            return;
        }
        let product = free(multiply(&direction));
        let curvature = dot(&direction, &product);
        if curvature <= 0.0 {
            return;
        }
        let step = size / curvature;
        for i in 0..x.len() {
            x[i] = x[i].plus(step, &direction[i]);
            residual[i] = residual[i].plus(-step, &product[i]);
        }
        let next = blocks.apply(&residual);
        let size_next = dot(&residual, &next);
        for (direction, next) in direction.iter_mut().zip(&next) {
            *direction = next.plus(size_next / size, direction);
        }
        size = size_next;
    }
}

/// Of each piece the Cholesky factor of its own block of K; `None` for a piece without bonds.
struct Blocks(Vec<Option<[[f64; 6]; 6]>>);

impl Blocks {
    fn new(pieces: &[RigidPiece], springs: &[Spring]) -> Self {
        let mut blocks = vec![[[0.0; 6]; 6]; pieces.len()];
        for spring in springs {
            for (piece, lever) in [(spring.a, spring.levers[0]), (spring.b, spring.levers[1])] {
                // Column by column: what a unit displacement or rotation of the piece alone asks
                // for.
                for column in 0..6 {
                    let unit = |from: usize| {
                        if column >= from { axis(column - from) } else { DVec3::ZERO }
                    };
                    let (linear, angular) =
                        if column < 3 { (unit(0), DVec3::ZERO) } else { (DVec3::ZERO, unit(3)) };
                    let force = spring.stretch * (linear + angular.cross(lever));
                    let moment = lever.cross(force) + spring.bend * angular;
                    for row in 0..3 {
                        blocks[piece][row][column] += force[row];
                        blocks[piece][row + 3][column] += moment[row];
                    }
                }
            }
        }
        Self(blocks.iter().map(cholesky).collect())
    }

    /// The solution of each block.
    fn apply(&self, values: &[Wrench]) -> Vec<Wrench> {
        let solved = |(factor, value): (&Option<[[f64; 6]; 6]>, &Wrench)| {
            let Some(factor) = factor else { return Wrench::default() };
            let mut y = [0.0; 6];
            y[..3].copy_from_slice(&value.linear.to_array());
            y[3..].copy_from_slice(&value.angular.to_array());
            for row in 0..6 {
                let known: f64 = (0..row).map(|k| factor[row][k] * y[k]).sum();
                y[row] = (y[row] - known) / factor[row][row];
            }
            for row in (0..6).rev() {
                let known: f64 = (row + 1..6).map(|k| factor[k][row] * y[k]).sum();
                y[row] = (y[row] - known) / factor[row][row];
            }
            Wrench { linear: DVec3::new(y[0], y[1], y[2]), angular: DVec3::new(y[3], y[4], y[5]) }
        };
        self.0.iter().zip(values).map(solved).collect()
    }
}

fn axis(number: usize) -> DVec3 {
    DVec3::AXES[number % 3]
}

/// The lower factor of a symmetric matrix; `None` if it is not positive.
fn cholesky(matrix: &[[f64; 6]; 6]) -> Option<[[f64; 6]; 6]> {
    let mut factor = [[0.0; 6]; 6];
    for row in 0..6 {
        for column in 0..=row {
            let known: f64 = (0..column).map(|k| factor[row][k] * factor[column][k]).sum();
            let left = matrix[row][column] - known;
            factor[row][column] = if row == column {
                if left <= 0.0 {
                    return None;
                }
                left.sqrt()
            } else {
                left / factor[column][column]
            };
        }
    }
    Some(factor)
}
