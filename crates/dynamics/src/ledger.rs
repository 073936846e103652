//! The ledger: no island of touching bodies ends a frame with more energy than it began with, plus the work done on it.
//!
//! Whatever contact, position correction and shock propagation did, the island's energy E' is compared with what it may have: its
//! energy at the frame's start, the work of kinematic bodies, and what is left in its bank. Too much is taken from the velocities
//! relative to the island's rigid part, and, if that is not enough, from the displacements off the ballistic path; at the
//! end of both lies the flight after collisions, whose energy is no more than it was by construction. The bank holds a little of what
//! an island dissipated, up to a cap, so that a pile can be lifted out of the sag that it lost energy by.

use crate::islands::Islands;
use crate::pair::Pair;
use crate::payment::pay;
use crate::rigid_part::Twist;
use crate::tally::Debt;
use crate::{Bodies, BodyId, Frame, Motion, Pose, Tally, Velocity};
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// Halvings of the interval in which the displacements' part is sought: 2^-30 of a displacement is no displacement.
const HALVINGS: u32 = 30;

/// Relative to an island's energy: less is rounding.
const ROUNDING: f64 = 1e-14;

/// The banks of all bodies, kept over the frames.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Ledger {
    bank: BTreeMap<BodyId, f64>,
}

/// What the ledger had to do in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance {
    /// Islands of touching bodies.
    pub islands: u64,
    /// Islands in which the contacts that gave energy could pay it back.
    pub paid: u64,
    /// Islands whose relative velocities were scaled down.
    pub scaled: u64,
    /// Islands whose displacements were shortened.
    pub shortened: u64,
    /// Energy that was taken out by both [J].
    pub removed: f64,
}

/// Kinetic and potential energy of each dynamic body at the start of a frame [J].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Opening(BTreeMap<BodyId, f64>);

/// Kinetic and potential energy of the dynamic bodies of a pair at `poses`, with the velocities that they have [J].
pub(crate) fn pair_energy(bodies: &Bodies, pair: Pair, poses: &[Pose], gravity: DVec3) -> f64 {
    let dynamic = [pair.first, pair.second].into_iter().filter(|&i| !bodies.inertias[i].is_infinite());
    dynamic.map(|i| energy(bodies, i, &poses[i], &bodies.velocities[i], gravity)).sum()
}

/// Kinetic and potential energy of one dynamic body [J].
fn energy(bodies: &Bodies, i: usize, pose: &Pose, velocity: &Velocity, gravity: DVec3) -> f64 {
    let mass = bodies.masses[i];
    let spin = bodies.inertias[i].rotational_energy(pose.orientation, velocity.angular_momentum);
    0.5 * mass * velocity.linear.length_squared() + spin - mass * gravity.dot(pose.position)
}

impl Opening {
    /// Opens the books of a frame.
    pub fn new(bodies: &Bodies, frame: &Frame) -> Self {
        let dynamic = (0..bodies.len()).filter(|&i| !bodies.inertias[i].is_infinite());
        let entry = |i: usize| {
            (bodies.ids[i], energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity))
        };
        Self(dynamic.map(entry).collect())
    }
}

/// An island of touching bodies.
struct Island {
    /// Dense indices of its living dynamic bodies.
    members: Vec<usize>,
    /// What moves it from outside, if anything does.
    anchor: Anchor,
    /// The energy that it may have at the end of the frame, without the bank [J].
    allowance: f64,
    /// What kinematic bodies took out of it on balance, each by itself [J].
    taken: f64,
    /// [J]
    bank: f64,
    /// Of its contacts, by their place in the tally.
    debts: Vec<usize>,
}

/// What an island touches besides itself.
#[derive(Clone, Copy, PartialEq)]
enum Anchor {
    Free,
    Kinematic(usize),
    Fixed,
}

impl Ledger {
    /// All that is in the banks [J].
    pub fn bank(&self) -> f64 {
        self.bank.values().sum()
    }

    /// Closes the books of a frame: balances every island. `flight` is where the bodies would be without position contact,
    /// shock propagation and push-out. Bodies that broke are linked to their fragments in the tally.
    pub fn balance(
        &mut self,
        bodies: &mut Bodies,
        opening: &Opening,
        flight: &[Pose],
        frame: &Frame,
        tally: &mut Tally,
    ) -> Balance {
        let mut balance = Balance::default();
        let mut bank = BTreeMap::new();
        for mut island in self.islands(bodies, opening, tally) {
            let members = &island.members;
            let total = |bodies: &Bodies| -> f64 {
                members
                    .iter()
                    .map(|&i| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity))
                    .sum()
            };
            let before = total(bodies);
            let mut excess = before - island.allowance - island.bank;
            balance.islands += 1;

            // The contacts that gave the energy pay first; what they have not, the island pays.
            if frame.settings.ledger && excess > ROUNDING * before.abs() {
                let work_before = tally.causes.work;
                let debts: Vec<Debt> = island.debts.iter().map(|&index| tally.debts[index]).collect();
                pay(bodies, &debts, excess, tally);
                island.allowance += tally.causes.work - work_before;
                excess = total(bodies) - island.allowance - island.bank;
                if excess > ROUNDING * before.abs() {
                    let (shortened, work) = take_out(bodies, &island, flight, excess, frame, tally);
                    island.allowance += work;
                    balance.scaled += 1;
                    balance.shortened += u64::from(shortened);
                } else {
                    balance.paid += 1;
                }
                balance.removed += before + (tally.causes.work - work_before) - total(bodies);
            }

            tally.causes.balance = -balance.removed;

            // What is left goes into the bank, up to its cap, and is the members' by mass.
            let mass: f64 = members.iter().map(|&i| bodies.masses[i]).sum();
            let left = island.allowance + island.bank - total(bodies);
            let kept = left.clamp(0.0, frame.settings.bank_cap * mass);
            bank.extend(members.iter().map(|&i| (bodies.ids[i], kept * bodies.masses[i] / mass)));
        }

        // Bodies that touched nothing keep theirs.
        for (&id, &amount) in &self.bank {
            if bodies.index_of(id).is_some() {
                bank.entry(id).or_insert(amount);
            }
        }
        self.bank = bank;
        balance
    }

    /// The islands of a frame. A body that broke still stands in for its fragments.
    fn islands(&self, bodies: &Bodies, opening: &Opening, tally: &Tally) -> Vec<Island> {
        let mut islands = Islands::default();
        let immobile = |id: BodyId| bodies.index_of(id).is_some_and(|i| bodies.inertias[i].is_infinite());
        let mut anchors: BTreeMap<BodyId, BTreeSet<BodyId>> = BTreeMap::new();
        for &(a, b) in &tally.links {
            match (immobile(a), immobile(b)) {
                (false, false) => islands.link(a, b),
                (false, true) => drop(anchors.entry(a).or_default().insert(b)),
                (true, false) => drop(anchors.entry(b).or_default().insert(a)),
                (true, true) => {}
            }
        }
        for &id in anchors.keys() {
            islands.link(id, id);
        }

        // A debt is its mobile bodies' island's.
        let mut debts: BTreeMap<BodyId, Vec<usize>> = BTreeMap::new();
        for (index, debt) in tally.debts.iter().enumerate() {
            if let Some(&id) = debt.ids.iter().find(|&&id| !immobile(id)) {
                debts.entry(id).or_default().push(index);
            }
        }

        let island = |ids: Vec<BodyId>| {
            let touched: BTreeSet<BodyId> =
                ids.iter().filter_map(|id| anchors.get(id)).flatten().copied().collect();
            let sum =
                |amounts: &BTreeMap<BodyId, f64>| ids.iter().filter_map(|id| amounts.get(id)).sum::<f64>();
            let works = || ids.iter().flat_map(|&id| work_on(tally, id));
            Island {
                members: ids.iter().filter_map(|&id| bodies.index_of(id)).collect(),
                anchor: anchor_of(bodies, &touched),
                allowance: sum(&opening.0) + works().sum::<f64>(),
                taken: works().map(|work| (-work).max(0.0)).sum(),
                bank: sum(&self.bank),
                debts: ids.iter().filter_map(|id| debts.get(id)).flatten().copied().collect(),
            }
        };
        islands.members().into_iter().map(island).filter(|island| !island.members.is_empty()).collect()
    }
}

/// The work on a body by each kinematic body [J].
fn work_on(tally: &Tally, id: BodyId) -> impl Iterator<Item = f64> {
    const FIRST: BodyId = BodyId { index: 0, generation: 0 };
    const LAST: BodyId = BodyId { index: u32::MAX, generation: u32::MAX };
    tally.work.range([id, FIRST]..=[id, LAST]).map(|(_, &work)| work)
}

/// One kinematic body moves an island along; anything else holds it.
fn anchor_of(bodies: &Bodies, touched: &BTreeSet<BodyId>) -> Anchor {
    let mut touched = touched.iter();
    match (touched.next(), touched.next()) {
        (None, _) => Anchor::Free,
        (Some(&id), None) => match bodies.index_of(id) {
            Some(i) if matches!(bodies.motions[i], Motion::Kinematic { .. }) => Anchor::Kinematic(i),
            _ => Anchor::Fixed,
        },
        (Some(_), Some(_)) => Anchor::Fixed,
    }
}

/// Linear and angular momentum, the latter about the world's origin.
fn momenta(bodies: &Bodies, members: &[usize]) -> (DVec3, DVec3) {
    let mut sums = (DVec3::ZERO, DVec3::ZERO);
    for &i in members {
        let momentum = bodies.masses[i] * bodies.velocities[i].linear;
        sums.0 += momentum;
        sums.1 += bodies.poses[i].position.cross(momentum) + bodies.velocities[i].angular_momentum;
    }
    sums
}

/// Takes `excess` [J] out of an island. Tells whether displacements had to be shortened, and the work that a kinematic anchor did.
fn take_out(
    bodies: &mut Bodies,
    island: &Island,
    flight: &[Pose],
    excess: f64,
    frame: &Frame,
    tally: &mut Tally,
) -> (bool, f64) {
    let members = &island.members;
    let before = momenta(bodies, members);
    let rigid = rigid_part(bodies, island, &bodies.poses, before);
    let relative = rigid.relative_energy(bodies, &bodies.poses, &bodies.velocities, members);

    // Scale the relative velocities so that the excess is gone, or stop them and shorten the displacements.
    let shortened = excess > relative;
    if shortened {
        shorten(bodies, island, flight, before, frame);
    } else {
        let scale = (1.0 - excess / relative).sqrt();
        let mut velocities = std::mem::take(&mut bodies.velocities);
        rigid.scale_relative(bodies, &bodies.poses, &mut velocities, members, scale);
        bodies.velocities = velocities;
    }

    // What holds or carries the island gave it the change of its momenta.
    if island.anchor == Anchor::Free {
        return (shortened, 0.0);
    }
    let after = momenta(bodies, members);
    let (impulse, moment) = (after.0 - before.0, after.1 - before.1);
    tally.outside_impulse += impulse;
    tally.outside_angular_impulse += moment;
    let mut work = rigid.work(impulse, moment);

    // What was stopped on its flight has no less energy left: kinematic bodies took out that much less than was booked.
    if shortened {
        let of = |&i: &usize| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity);
        let missing = members.iter().map(of).sum::<f64>() - island.allowance - island.bank - work;
        work += missing.clamp(0.0, island.taken);
    }
    tally.causes.work += work;
    (shortened, work)
}

/// The rigid motion that an island keeps, with the bodies at `poses`.
fn rigid_part(
    bodies: &Bodies,
    island: &Island,
    poses: &[Pose],
    (momentum, angular_momentum): (DVec3, DVec3),
) -> Twist {
    match island.anchor {
        Anchor::Free => Twist::of_momentum(bodies, poses, &island.members, momentum, angular_momentum),
        Anchor::Fixed => Twist::default(),
        Anchor::Kinematic(i) => match bodies.motions[i] {
            Motion::Kinematic { linear, angular } => Twist { origin: poses[i].position, linear, angular },
            Motion::Static | Motion::Dynamic => Twist::default(),
        },
    }
}

/// Leaves the island its rigid motion only, and as much of its displacements as its energy allows.
fn shorten(bodies: &mut Bodies, island: &Island, flight: &[Pose], momenta: (DVec3, DVec3), frame: &Frame) {
    let reached = bodies.poses.clone();
    let at = |part: f64| {
        let mut poses = reached.clone();
        for &i in &island.members {
            poses[i] = Pose {
                position: flight[i].position.lerp(reached[i].position, part),
                orientation: flight[i].orientation.slerp(reached[i].orientation, part),
            };
        }
        poses
    };
    // The energy of the rigid motion, less the work that its anchor does to bring it about.
    let rigid_energy = |poses: &[Pose]| -> f64 {
        let rigid = rigid_part(bodies, island, poses, momenta);
        let along: Vec<Velocity> =
            island.members.iter().map(|&i| rigid.velocity_of(bodies, poses, i)).collect();
        let entries = || island.members.iter().copied().zip(&along);
        let total: f64 =
            entries().map(|(i, velocity)| energy(bodies, i, &poses[i], velocity, frame.gravity)).sum();
        if island.anchor == Anchor::Free {
            return total;
        }
        let (mut impulse, mut moment) = (-momenta.0, -momenta.1);
        for (i, velocity) in entries() {
            let momentum = bodies.masses[i] * velocity.linear;
            impulse += momentum;
            moment += poses[i].position.cross(momentum) + velocity.angular_momentum;
        }
        total - rigid.work(impulse, moment)
    };

    // The largest part that the allowance pays for, to the precision of the halvings.
    let allowed = island.allowance + island.bank;
    let (mut low, mut high) = (0.0, 1.0);
    if rigid_energy(&reached) <= allowed {
        low = 1.0;
    } else {
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if rigid_energy(&at(middle)) <= allowed { low = middle } else { high = middle }
        }
    }
    let poses = at(low);
    let rigid = rigid_part(bodies, island, &poses, momenta);
    for &i in &island.members {
        bodies.velocities[i] = rigid.velocity_of(bodies, &poses, i);
    }
    bodies.poses = poses;
}
