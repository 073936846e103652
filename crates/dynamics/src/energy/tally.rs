//! What one frame did: momentum from outside, energy by cause, who owes it, and how often the
//! safeguards were needed.

use crate::energy::rigid_part::Twist;
use crate::impulse::energy_clamp::Clamps;
use crate::impulse::pair_impulse::{Approach, PairImpulse};
use frangible_bodies::{Bodies, BodyId, Motion, Pair, Velocity};
use glam::DVec3;
use std::collections::BTreeMap;

/// Running sums over one frame. Static and kinematic bodies are the outside; gravity is booked by
/// the step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Sum of the impulses that the outside gave to dynamic bodies [N s].
    pub outside_impulse: DVec3,
    /// Change of the angular momentum about the world's origin that it explains [kg m^2/s].
    pub outside_angular_impulse: DVec3,
    /// What changed the energy of dynamic bodies.
    pub causes: Causes,
    /// The work on each dynamic body by each kinematic body [J].
    pub work: BTreeMap<[BodyId; 2], f64>,
    /// Contacts that gave energy to their bodies.
    pub debts: Vec<Debt>,
    /// Energy that islands gained by closing overlaps [J].
    pub recovery: f64,
    /// Work of closing the overlaps of each pair [J].
    pub(crate) recovered: Vec<([BodyId; 2], f64)>,
    /// Pairs that exchanged impulses or pushed each other.
    pub links: Vec<(BodyId, BodyId)>,
    /// Impulses applied to velocities that last.
    pub impulses: u64,
    /// Impulses that would have raised the kinetic energy.
    pub clamps: Clamps,
}

/// What changes the energy of dynamic bodies in a frame, from its start to its end [J].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Causes {
    /// Of kinematic bodies: each impulse times their velocity at the contact point.
    pub work: f64,
    /// What stops an approach, and what comes back by restitution.
    pub collision: f64,
    /// What keeps touching bodies from approaching.
    pub contact: f64,
    /// Coulomb's, rolling and spinning friction.
    pub friction: f64,
    /// Moving bodies out of each other, as far as it stayed.
    pub projection: f64,
    /// Breaking, booked by whoever breaks bodies.
    pub fracture: f64,
    /// What the ledger took out.
    pub balance: f64,
}

/// One of [`Causes`] that an impulse between two bodies can have.
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
    /// Books energy that dynamic bodies gained [J].
    pub fn add(&mut self, cause: Cause, energy: f64) {
        match cause {
            Cause::Collision => self.collision += energy,
            Cause::Contact => self.contact += energy,
            Cause::Friction => self.friction += energy,
            Cause::Projection => self.projection += energy,
        }
    }

    /// All of it [J].
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

/// A contact that gave energy to its bodies in a frame, and pays it back before others do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Debt {
    /// The pair.
    pub ids: [BodyId; 2],
    /// Where they touch at the end of the frame, in the world frame [m].
    pub point: DVec3,
    /// [J]
    pub energy: f64,
    /// What all contacts of its lighter body gave between them, if that is known, else 0 [J]: the
    /// ground gives, again and again, what holds up a load, and the load takes it.
    pub net: f64,
}

impl Debt {
    /// Its lighter body, then its heavier one, if both live.
    pub(crate) fn by_weight(&self, bodies: &Bodies) -> Option<[usize; 2]> {
        let [Some(first), Some(second)] = self.ids.map(|id| bodies.index_of(id)) else {
            return None;
        };
        let [a, b] = [first, second].map(|i| bodies.inertias[i].inverse_mass);
        Some(if a >= b { [first, second] } else { [second, first] })
    }
}

impl Tally {
    /// Books an impulse on a pair whose bodies have `velocities` before it acts, at the poses of
    /// `bodies`. `cause` is that of its normal part.
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

        // What it gives: the part of friction is its tangential part times the mean slip.
        let given = impulse.energy_given(bodies, pair, approach, velocities);
        let friction = impulse.energy_of_friction(bodies, pair, approach, velocities);
        self.causes.add(Cause::Friction, friction);
        self.causes.add(cause, given - friction);

        // What comes from outside.
        let j = impulse.at_contact;
        let sides = [(pair.first, pair.second, j), (pair.second, pair.first, -j)];
        for ((body, other, j), lever) in sides.into_iter().zip(approach.levers) {
            let moment = (bodies.poses[body].position + lever).cross(j);
            let work = kinematic_work(bodies, other, j, approach.contact.point.cross(j));
            self.book_outside(bodies, [body, other], (j, moment), work);
        }
    }

    /// Books what `other`, if it is static or kinematic, gave to `body`, if it is dynamic: an
    /// impulse [N s], its moment about the world's origin [kg m^2/s], and the work [J].
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

    /// Notes the work of closing the overlaps of a pair in a frame [J]: the ledger books what its
    /// island kept of it.
    pub(crate) fn recover(&mut self, bodies: &Bodies, pair: Pair, energy: f64) {
        self.recovered.push((pair.ids(bodies), energy));
    }

    /// Notes that a pair touched.
    pub fn link(&mut self, bodies: &Bodies, pair: Pair) {
        let link = (bodies.ids[pair.first], bodies.ids[pair.second]);
        // A pair is handled several times in a row.
        if self.links.last() != Some(&link) {
            self.links.push(link);
        }
    }

    /// Adds another stage's sums.
    pub fn add(&mut self, other: Self) {
        self.outside_impulse += other.outside_impulse;
        self.outside_angular_impulse += other.outside_angular_impulse;
        self.causes.add_all(&other.causes);
        append(&mut self.debts, other.debts);
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

/// Puts a list behind another one.
fn append<T>(list: &mut Vec<T>, mut other: Vec<T>) {
    if list.capacity() == 0 {
        *list = other;
    } else {
        list.append(&mut other);
    }
}

/// The work that a body does by an impulse [N s] with a moment about the world's origin [kg m^2/s];
/// zero unless it is kinematic [J].
pub(crate) fn kinematic_work(bodies: &Bodies, i: usize, impulse: DVec3, moment: DVec3) -> f64 {
    match bodies.motions[i] {
        Motion::Kinematic { linear, angular } => {
            Twist { origin: bodies.poses[i].position, linear, angular }.work(impulse, moment)
        }
        Motion::Static | Motion::Dynamic => 0.0,
    }
}
