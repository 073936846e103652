//! Local payment: a contact that gave energy to its bodies pays it back out of their relative velocity, before the island has to.

use crate::detection::ContactPoint;
use crate::pair::{Approach, Pair, PairImpulse, approach_at, pair_contact_matrix};
use crate::tally::{Debt, kinematic_work};
use crate::{Bodies, Tally};
use glam::DVec3;

/// Lets debtors pay `excess` [J] between them, each in proportion to its debt and as far as its relative velocity has it. Impulses at the
/// contact are mutual, so momentum and angular momentum stay.
pub(crate) fn pay(bodies: &mut Bodies, debts: &[Debt], excess: f64, tally: &mut Tally) {
    let owed: f64 = debts.iter().map(|debt| debt.energy).sum();
    if owed <= 0.0 {
        return;
    }
    let part = (excess / owed).min(1.0);
    for debt in debts {
        let [Some(first), Some(second)] = debt.ids.map(|id| bodies.index_of(id)) else { continue };
        pay_at(bodies, Pair { first, second }, debt.point, part * debt.energy, tally);
    }
}

/// The energy of a pair's relative velocity u at a point: u.K^-1 u / 2 [J].
pub fn energy_at(bodies: &Bodies, pair: Pair, point: DVec3) -> f64 {
    let (approach, stopping) = stopping_impulse(bodies, pair, point);
    energy_of(&approach, stopping)
}

/// What an impulse that stops a pair takes from it [J].
fn energy_of(approach: &Approach, stopping: DVec3) -> f64 {
    let available = -0.5 * stopping.dot(approach.relative_velocity);
    if stopping.is_finite() { available.max(0.0) } else { 0.0 }
}

/// Takes `energy` [J], or all there is, out of the relative velocity u of a pair at a point: of u.K^-1 u / 2, by an impulse
/// j = -alpha K^-1 u.
pub fn pay_at(bodies: &mut Bodies, pair: Pair, point: DVec3, energy: f64, tally: &mut Tally) {
    let (approach, stopping) = stopping_impulse(bodies, pair, point);
    let available = energy_of(&approach, stopping);
    if available <= 0.0 {
        return;
    }
    let alpha = if energy < available { 1.0 - (1.0 - energy / available).sqrt() } else { 1.0 };
    let impulse = PairImpulse::new(&approach, alpha * stopping);
    impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
    for (body, other, j) in
        [(pair.first, pair.second, impulse.at_contact), (pair.second, pair.first, -impulse.at_contact)]
    {
        let moment = point.cross(j);
        tally.book_outside(bodies, [body, other], (j, moment), kinematic_work(bodies, other, j, moment));
    }
}

/// How a pair moves at a point, and the impulse there -K^-1 u that stops it [N s].
fn stopping_impulse(bodies: &Bodies, pair: Pair, point: DVec3) -> (Approach, DVec3) {
    let contact = ContactPoint { point, normal: DVec3::Y };
    let approach = approach_at(bodies, pair, contact, &bodies.poses, &bodies.velocities);
    let k = pair_contact_matrix(pair, approach.levers, &bodies.poses, &bodies.inertias);
    (approach, -(k.inverse() * approach.relative_velocity))
}
