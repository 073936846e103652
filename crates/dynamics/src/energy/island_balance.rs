//! Balance of one island at the end of a frame: its energy against its allowance, what takes the
//! excess, and what of a surplus is banked.

use crate::energy::contact_repayment::{cap_ejection, repay, return_recovered};
use crate::energy::frame_accounts::{Cause, EnergyGain, FrameAccounts};
use crate::energy::island::{ContactFreeState, Island, energy, magnitude};
use crate::energy::island_correction::reduce_energy;
use frangible_bodies::{Bodies, Frame};

/// An excess below this part of the magnitude of an island's energies is rounding [1].
const ROUNDING: f64 = 1e-14;

/// How an island lost its excess.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Correction {
    /// Contacts with an energy gain repaid it.
    Repaid,
    /// Velocities relative to the island's rigid motion were scaled too.
    Scaled,
    /// Displacements off the ballistic path were shortened too.
    Shortened,
}

/// An island and its energy at the end of a frame.
pub(crate) struct IslandBalance {
    pub(crate) island: Island,
    /// Present kinetic and potential energy [J].
    pub(crate) energy: f64,
    /// [kg]
    pub(crate) mass: f64,
    /// Excess that is no rounding [J].
    rounding: f64,
}

impl IslandBalance {
    /// With the present `energies` of all bodies [J].
    pub(crate) fn new(bodies: &Bodies, island: Island, energies: &[f64], frame: &Frame) -> Self {
        let (mut energy, mut scale, mut mass) = (0.0, 0.0, 0.0);
        for &i in &island.members {
            energy += energies[i];
            scale += magnitude(bodies, i, energies[i], frame.gravity);
            mass += bodies.masses[i];
        }
        Self { island, energy, mass, rounding: ROUNDING * scale }
    }

    /// The island's contacts with an energy gain.
    pub(crate) fn gains(&self, accounts: &FrameAccounts) -> Vec<EnergyGain> {
        self.island.gains.iter().map(|&index| accounts.gains[index]).collect()
    }

    /// Restrains contacts that would fling light bodies: limits the energy left in the pair's
    /// relative motion. True if any did.
    pub(crate) fn restrain(
        &mut self,
        bodies: &mut Bodies,
        gains: (&mut [EnergyGain], &[f64]),
        frame: &Frame,
        accounts: &mut FrameAccounts,
    ) -> bool {
        let work_before = accounts.causes.work;
        let is_sound = frame.settings.ledger && self.energy.is_finite();
        let is_restrained = is_sound && cap_ejection(bodies, gains, frame, accounts);
        if is_restrained {
            self.measure_after(work_before, bodies, frame, accounts);
        }
        is_restrained
    }

    /// Removes the excess over the allowance, if there is one: contacts with an energy gain repay
    /// first, and pairs with penetration recovery; the island pays the rest.
    pub(crate) fn correct(
        &mut self,
        bodies: &mut Bodies,
        gains: &[EnergyGain],
        contact_free: &ContactFreeState,
        frame: &Frame,
        accounts: &mut FrameAccounts,
    ) -> Option<Correction> {
        let excess = self.excess(frame)?;
        let work_before = accounts.causes.work;
        repay(bodies, gains, excess, accounts);
        self.measure_after(work_before, bodies, frame, accounts);
        let Some(excess) = self.excess(frame) else { return Some(Correction::Repaid) };
        let work_before = accounts.causes.work;
        let recovered: Vec<_> =
            self.island.recoveries.iter().map(|&index| accounts.recovered[index]).collect();
        return_recovered(bodies, &recovered, excess, accounts);
        self.measure_after(work_before, bodies, frame, accounts);
        let Some(excess) = self.excess(frame) else { return Some(Correction::Repaid) };
        let island = &mut self.island;
        let is_shortened = reduce_energy(bodies, island, contact_free, excess, frame, accounts);
        self.measure(bodies, frame);
        Some(if is_shortened { Correction::Shortened } else { Correction::Scaled })
    }

    /// Part of the surplus that goes to the bank, at most its cap [J]. Energy needed by penetration
    /// recovery does not count as gain.
    pub(crate) fn bank_surplus(&self, frame: &Frame, accounts: &mut FrameAccounts) -> f64 {
        let Island { allowance, bank, recovered, .. } = self.island;
        let needed = (self.energy - allowance - bank).max(0.0).min(recovered);
        accounts.recovery += needed;
        accounts.causes.add(Cause::Projection, needed);
        accounts.causes.add(Cause::Contact, -needed);
        let left = allowance + bank + needed - self.energy;
        let cap = frame.settings.bank_cap * self.mass;
        // Non-finite islands bank zero.
        if left.is_finite() { left.clamp(0.0, cap) } else { 0.0 }
    }

    /// Energy above the allowance by more than rounding [J].
    fn excess(&self, frame: &Frame) -> Option<f64> {
        let Island { allowance, bank, recovered, .. } = self.island;
        let excess = self.energy - allowance - bank - recovered;
        (frame.settings.ledger && excess > self.rounding).then_some(excess)
    }

    /// Allows the work since `work_before` [J], and sums the energies anew.
    fn measure_after(
        &mut self,
        work_before: f64,
        bodies: &Bodies,
        frame: &Frame,
        accounts: &FrameAccounts,
    ) {
        self.island.allowance += accounts.causes.work - work_before;
        self.measure(bodies, frame);
    }

    /// Sums the energies anew after a correction.
    fn measure(&mut self, bodies: &Bodies, frame: &Frame) {
        let of =
            |&i: &usize| energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity);
        self.energy = self.island.members.iter().map(of).sum();
    }
}
