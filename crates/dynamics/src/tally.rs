//! What one frame did to the bodies from outside, and how often its safeguards were needed.

use crate::pair::{Approach, Pair, PairImpulse};
use crate::{Bodies, BodyId, Motion};
use glam::DVec3;
use std::collections::BTreeMap;

/// Running sums over one frame. Static and kinematic bodies are the outside; gravity is booked by the step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Sum of the impulses that the outside gave to dynamic bodies [N s].
    pub outside_impulse: DVec3,
    /// Change of the angular momentum about the world's origin that it explains [kg m^2/s].
    pub outside_angular_impulse: DVec3,
    /// Work that kinematic bodies did: each impulse times their velocity at the contact point [J].
    pub kinematic_work: f64,
    /// The same, for each body that it was done on [J].
    pub work: BTreeMap<BodyId, f64>,
    /// Pairs that exchanged impulses or pushed each other.
    pub links: Vec<(BodyId, BodyId)>,
    /// Impulses applied to velocities that last.
    pub impulses: u64,
    /// Impulses shortened because they would have raised the kinetic energy [Su09 sec. 3.2].
    pub clamped: u64,
    /// Impulses dropped because no length of them would have kept the kinetic energy.
    pub discarded: u64,
}

impl Tally {
    /// Books an impulse on the first body of a pair, and its negative on the second, at the poses of `bodies`.
    pub fn book_impulse(&mut self, bodies: &Bodies, pair: Pair, approach: &Approach, impulse: &PairImpulse) {
        self.impulses += 1;
        self.link(bodies, pair);
        let j = impulse.at_contact;
        let sides = [(pair.first, pair.second, j), (pair.second, pair.first, -j)];
        for ((body, other, j), lever) in sides.into_iter().zip(approach.levers) {
            let (mobile, immobile) = (bodies.inertias[body], bodies.inertias[other]);
            if mobile.is_infinite() || !immobile.is_infinite() {
                continue;
            }
            self.outside_impulse += j;
            self.outside_angular_impulse += (bodies.poses[body].position + lever).cross(j);
            if let Motion::Kinematic { linear, angular } = bodies.motions[other] {
                let other_lever = approach.contact.point - bodies.poses[other].position;
                let work = j.dot(linear + angular.cross(other_lever));
                self.kinematic_work += work;
                *self.work.entry(bodies.ids[body]).or_insert(0.0) += work;
            }
        }
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
        self.kinematic_work += other.kinematic_work;
        for (id, work) in other.work {
            *self.work.entry(id).or_insert(0.0) += work;
        }
        self.links.extend(other.links);
        self.impulses += other.impulses;
        self.clamped += other.clamped;
        self.discarded += other.discarded;
    }
}
