//! Accounts of one frame: momentum from outside, energy by cause, gains, and counts of the
//! safeguards.

use crate::energy::rigid_part::Twist;
use crate::impulse::energy_clamp::Clamps;
use crate::impulse::pair_impulse::{Approach, PairImpulse};
use frangible_bodies::{Bodies, BodyId, Motion, Pair, Velocity};
use glam::DVec3;
use std::collections::BTreeMap;

/// Running sums over one frame. Static and kinematic bodies act from outside; the step books
/// gravity.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FrameAccounts {
    /// Impulses from outside on dynamic bodies [N s].
    pub outside_impulse: DVec3,
    /// Change of angular momentum about the world's origin by outside impulses [kg m^2/s].
    pub outside_angular_impulse: DVec3,
    /// Energy changes of dynamic bodies, by cause.
    pub causes: Causes,
    /// Work on each dynamic body by each kinematic body [J].
    pub work: BTreeMap<[BodyId; 2], f64>,
    /// Contacts with an energy gain.
    pub gains: Vec<EnergyGain>,
    /// Energy gain of islands by penetration recovery [J].
    pub recovery: f64,
    /// Work of penetration recovery per pair [J].
    pub(crate) recovered: Vec<([BodyId; 2], f64)>,
    /// Pairs with mutual impulses or displacements.
    pub links: Vec<(BodyId, BodyId)>,
    /// Number of impulses on final velocities.
    pub impulses: u64,
    /// Impulses clamped to no energy gain.
    pub clamps: Clamps,
}

/// Energy change of dynamic bodies in a frame, by cause, from start to end [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Causes {
    /// Work of kinematic bodies: each impulse times their velocity at the contact point.
    pub work: f64,
    /// Impacts with restitution.
    pub collision: f64,
    /// Resting and sliding contacts, along the normal.
    pub contact: f64,
    /// Coulomb, rolling and spinning friction.
    pub friction: f64,
    /// Penetration recovery, as far as its energy remained.
    pub projection: f64,
    /// Breaking, booked by the step.
    pub fracture: f64,
    /// Energy removed by the ledger.
    pub balance: f64,
}

/// Cause of an impulse between two bodies; see [`Causes`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Cause {
    /// See [`Causes::collision`].
    Collision,
    /// See [`Causes::contact`].
    Contact,
    /// See [`Causes::friction`].
    Friction,
    /// See [`Causes::projection`].
    Projection,
}

impl Causes {
    /// Books an energy gain of dynamic bodies [J].
    pub fn add(&mut self, cause: Cause, energy: f64) {
        match cause {
            Cause::Collision => self.collision += energy,
            Cause::Contact => self.contact += energy,
            Cause::Friction => self.friction += energy,
            Cause::Projection => self.projection += energy,
        }
    }

    /// Sum of all causes [J].
    pub fn sum(&self) -> f64 {
        let Self { work, collision, contact, friction, projection, fracture, balance } = self;
        work + collision + contact + friction + projection + fracture + balance
    }

    fn add_all(&mut self, other: &Self) {
        self.work += other.work;
        self.collision += other.collision;
        self.contact += other.contact;
        self.friction += other.friction;
        self.projection += other.projection;
        self.fracture += other.fracture;
        self.balance += other.balance;
    }
}

/// A contact with an energy gain in a frame, first to repay it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnergyGain {
    /// The pair.
    pub ids: [BodyId; 2],
    /// Contact point at the end of the frame, world frame [m].
    pub point: DVec3,
    /// [J]
    pub energy: f64,
    /// Net gain of all contacts of the lighter body, or 0 if unknown [J]. The ground keeps giving
    /// energy to a support, and the load above takes it.
    pub net: f64,
}

impl EnergyGain {
    /// Its lighter body, then its heavier one, if both live.
    pub(crate) fn by_weight(&self, bodies: &Bodies) -> Option<[usize; 2]> {
        lighter_first(bodies, self.ids)
    }
}

/// The lighter body of a pair, then its heavier one, if both live.
pub(crate) fn lighter_first(bodies: &Bodies, ids: [BodyId; 2]) -> Option<[usize; 2]> {
    let [Some(first), Some(second)] = ids.map(|id| bodies.index_of(id)) else {
        return None;
    };
    let [a, b] = [first, second].map(|i| bodies.inertias[i].inverse_mass);
    Some(if a >= b { [first, second] } else { [second, first] })
}

impl FrameAccounts {
    /// Books an impulse on a pair with `velocities` before it, at the poses of `bodies`. `cause`
    /// applies to its normal part.
    pub(crate) fn book_impulse(
        &mut self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
        (velocities, cause): (&[Velocity], Cause),
    ) {
        self.impulses += 1;
        self.link(bodies, pair);

        // Energy change; friction's share is the tangential impulse times the mean slip.
        let given = impulse.energy_given(bodies, pair, approach, velocities);
        let friction = impulse.energy_of_friction(bodies, pair, approach, velocities);
        self.causes.add(Cause::Friction, friction);
        self.causes.add(cause, given - friction);

        self.book_share(bodies, pair, approach, impulse);
    }

    /// Books the share of static and kinematic bodies in an impulse on a pair.
    pub(crate) fn book_share(
        &mut self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
    ) {
        let j = impulse.at_contact;
        let sides = [(pair.first, pair.second, j), (pair.second, pair.first, -j)];
        for ((body, other, j), lever) in sides.into_iter().zip(approach.levers) {
            let moment = (bodies.poses[body].position + lever).cross(j);
            let work = kinematic_work(bodies, other, j, approach.contact.point.cross(j));
            self.book_outside(bodies, [body, other], (j, moment), work);
        }
    }

    /// Books an action of `other` (if static or kinematic) on `body` (if dynamic): an impulse [N
    /// s], its moment about the world's origin [kg m^2/s], and the work [J].
    pub(crate) fn book_outside(
        &mut self,
        bodies: &Bodies,
        [body, other]: [usize; 2],
        (impulse, moment): (DVec3, DVec3),
        work: f64,
    ) {
        if bodies.inertias[body].is_infinite() || !bodies.inertias[other].is_infinite() {
            return;
        }
        self.outside_impulse += impulse;
        self.outside_angular_impulse += moment;
        if work != 0.0 {
            self.causes.work += work;
            *self.work.entry([bodies.ids[body], bodies.ids[other]]).or_insert(0.0) += work;
        }
    }

    /// Books the work of penetration recovery of a pair in a frame [J]; the ledger keeps the part
    /// still present in the island.
    pub(crate) fn recover(&mut self, bodies: &Bodies, pair: Pair, energy: f64) {
        self.recovered.push((pair.ids(bodies), energy));
    }

    /// Registers a contact of a pair.
    pub fn link(&mut self, bodies: &Bodies, pair: Pair) {
        let link = (bodies.ids[pair.first], bodies.ids[pair.second]);
        // Consecutive impulses often belong to the same pair.
        if self.links.last() != Some(&link) {
            self.links.push(link);
        }
    }

    /// Adds another stage's sums.
    pub fn add(&mut self, other: Self) {
        self.outside_impulse += other.outside_impulse;
        self.outside_angular_impulse += other.outside_angular_impulse;
        self.causes.add_all(&other.causes);
        append(&mut self.gains, other.gains);
        for (id, work) in other.work {
            *self.work.entry(id).or_insert(0.0) += work;
        }
        append(&mut self.links, other.links);
        append(&mut self.recovered, other.recovered);
        self.recovery += other.recovery;
        self.impulses += other.impulses;
        self.clamps.add(other.clamps);
    }
}

/// Appends a list, by move if possible.
fn append<T>(list: &mut Vec<T>, mut other: Vec<T>) {
    if list.capacity() == 0 {
        *list = other;
    } else {
        list.append(&mut other);
    }
}

/// Work of a body by an impulse [N s] with a moment about the world's origin [kg m^2/s]; zero for
/// bodies other than kinematic [J].
pub(crate) fn kinematic_work(bodies: &Bodies, i: usize, impulse: DVec3, moment: DVec3) -> f64 {
    match bodies.motions[i] {
        Motion::Kinematic { linear, angular } => {
            Twist { origin: bodies.poses[i].position, linear, angular }.work(impulse, moment)
        }
        Motion::Static | Motion::Dynamic => 0.0,
    }
}
