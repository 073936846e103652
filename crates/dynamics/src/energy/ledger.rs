//! The ledger: no island of touching bodies ends a frame with more energy than at its start, plus
//! the work done on it.
//!
//! After contact, position correction and shock propagation the island's energy is compared with
//! its allowance: its energy at the frame's start, the work of kinematic bodies, and its bank.
//! Contacts that would fling light bodies are restrained in any case. Then contacts with an energy
//! gain repay it. The remaining excess comes out of the velocities relative to the island's rigid
//! part, and after that out of the displacements off the ballistic path. The fallback is ballistic
//! motion after collisions, whose energy never exceeds the allowance by construction. The bank
//! stores a little of an island's dissipated energy, up to a cap: a pile can rise again by the
//! overlap it sank.

use crate::energy::frame_accounts::FrameAccounts;
use crate::energy::frame_islands::find_islands;
use crate::energy::island::{ContactFreeState, energies, potential};
use crate::energy::island_balance::{Correction, IslandBalance};
use frangible_bodies::{Bodies, Frame, PerBody};
use frangible_math::check::{Check, Checked, require};
use frangible_math::threads;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Energy banks of all bodies, kept across frames.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Ledger {
    bank: PerBody<f64>,
}

/// Statistics of the ledger in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LedgerReport {
    /// Islands of touching bodies.
    pub islands: u64,
    /// Islands balanced by repayment of contacts alone.
    pub paid: u64,
    /// Islands with scaled relative velocities.
    pub scaled: u64,
    /// Islands with shortened displacements.
    pub shortened: u64,
    /// Removed energy, by restraint, repayment, scaling or shortening [J].
    pub removed: f64,
}

/// Energies of each dynamic body at the start of a frame [J].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyAtStart {
    /// Kinetic and potential energy.
    total: PerBody<f64>,
    potential: PerBody<f64>,
}

impl EnergyAtStart {
    /// Records all energies at the start of a frame.
    pub fn new(bodies: &Bodies, frame: &Frame) -> Self {
        let mut start = Self::default();
        for (i, energy) in energies(bodies, frame).into_iter().enumerate() {
            if !bodies.inertias[i].is_infinite() {
                start.total.insert(bodies.ids[i], energy);
                start.potential.insert(bodies.ids[i], potential(bodies, i, frame.gravity));
            }
        }
        start
    }

    /// Records a body that comes free at rest.
    pub fn admit(&mut self, bodies: &Bodies, i: usize, frame: &Frame) {
        let energy = potential(bodies, i, frame.gravity);
        self.total.insert(bodies.ids[i], energy);
        self.potential.insert(bodies.ids[i], energy);
    }

    /// Potential energy of bodies that have risen since, without those that sank or were born [J].
    fn risen(&self, bodies: &Bodies, members: &[usize], gravity: DVec3) -> f64 {
        let of = |&i: &usize| {
            let start = self.potential.get(bodies.ids[i])?;
            Some((potential(bodies, i, gravity) - start).max(0.0))
        };
        members.iter().filter_map(of).sum()
    }
}

impl Check for Ledger {
    fn check(&self) -> Checked {
        self.bank.check(|&banked| require((0.0..1e60).contains(&banked), "energy in a bank"))
    }
}

impl Ledger {
    /// Sum of all banks [J].
    pub fn bank(&self) -> f64 {
        self.bank.iter().map(|(_, amount)| amount).sum()
    }

    /// Balances every island at the end of a frame. In the accounts, broken bodies are linked to
    /// their fragments.
    pub fn balance(
        &mut self,
        bodies: &mut Bodies,
        start: &EnergyAtStart,
        contact_free: &ContactFreeState,
        frame: &Frame,
        accounts: &mut FrameAccounts,
    ) -> LedgerReport {
        let now = &*bodies;
        let (energies, islands) = threads::join(
            now.len(),
            || energies(now, frame),
            || find_islands(now, &start.total, &self.bank, accounts),
        );
        // Bodies born in this frame have no known gain.
        let gained_by =
            |i: usize| start.total.get(bodies.ids[i]).map_or(0.0, |start| energies[i] - start);
        let gained: Vec<f64> = (0..bodies.len()).map(gained_by).collect();

        let mut report = LedgerReport::default();
        let mut bank = PerBody::default();
        for mut island in islands {
            // A push out of an overlap may raise bodies, and leaves no velocity.
            let risen = start.risen(bodies, &island.members, frame.gravity);
            island.recovered = island.recovered.min(risen);
            let mut balance = IslandBalance::new(bodies, island, &energies, frame);
            let mut gains = balance.gains(accounts);
            let (before, work_before) = (balance.energy, accounts.causes.work);

            // Contacts that would fling light bodies are restrained; contacts with an energy gain
            // repay it, and the island pays the rest.
            let is_restrained = balance.restrain(bodies, (&mut gains, &gained), frame, accounts);
            let correction = balance.correct(bodies, &gains, contact_free, frame, accounts);
            report.count(correction);
            if is_restrained || correction.is_some() {
                let work = accounts.causes.work - work_before;
                let removed = before + work - balance.energy;
                report.removed += removed;
                accounts.causes.balance -= removed;
            }

            // The surplus goes to the bank, divided among members by mass.
            let kept = balance.bank_surplus(frame, accounts);
            for &i in &balance.island.members {
                bank.insert(bodies.ids[i], kept * bodies.masses[i] / balance.mass);
            }
        }

        // Bodies without contacts keep their bank.
        for (id, amount) in self.bank.iter() {
            if bodies.index_of(id).is_some() && bank.get(id).is_none() {
                bank.insert(id, amount);
            }
        }
        self.bank = bank;
        report
    }
}

impl LedgerReport {
    /// Counts an island and what it took to balance it.
    fn count(&mut self, correction: Option<Correction>) {
        self.islands += 1;
        match correction {
            None => {}
            Some(Correction::Repaid) => self.paid += 1,
            Some(Correction::Scaled) => self.scaled += 1,
            Some(Correction::Shortened) => {
                self.scaled += 1;
                self.shortened += 1;
            }
        }
    }
}
