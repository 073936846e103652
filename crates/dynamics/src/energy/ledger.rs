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

use crate::energy::contact_repayment::{cap_ejection, repay};
use crate::energy::frame_accounts::{Cause, EnergyGain, FrameAccounts};
use crate::energy::island::{
    Anchor, ContactFreeState, Island, energies, energy, magnitude, work_on,
};
use crate::energy::island_correction::reduce_energy;
use crate::energy::islands::Islands;
use frangible_bodies::{Bodies, BodyId, Frame, Inertia, PerBody};
use frangible_math::threads;
use serde::{Deserialize, Serialize};

/// Rounding threshold relative to the magnitude of an island's energies.
const ROUNDING: f64 = 1e-14;

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

/// Kinetic and potential energy of each dynamic body at the start of a frame [J].
#[derive(Clone, Debug, Default, PartialEq)]
pub struct EnergyAtStart(PerBody<f64>);

impl EnergyAtStart {
    /// Records all energies at the start of a frame.
    pub fn new(bodies: &Bodies, frame: &Frame) -> Self {
        let mut start = Self::default();
        for (i, energy) in energies(bodies, frame).into_iter().enumerate() {
            if !bodies.inertias[i].is_infinite() {
                start.0.insert(bodies.ids[i], energy);
            }
        }
        start
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
        let mut balance = LedgerReport::default();
        let mut bank = PerBody::default();
        let energy_of = |bodies: &Bodies, i: usize| {
            energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity)
        };
        let now = &*bodies;
        let find_islands = || self.islands(now, start, accounts);
        let (energies, islands) = threads::join(now.len(), || energies(now, frame), find_islands);
        // Bodies born in this frame have no known gain.
        let gained_by =
            |i: usize| start.0.get(bodies.ids[i]).map_or(0.0, |start| energies[i] - start);
        let gained: Vec<f64> = (0..bodies.len()).map(gained_by).collect();
        for mut island in islands {
            let total = |bodies: &Bodies, members: &[usize]| -> f64 {
                members.iter().map(|&i| energy_of(bodies, i)).sum()
            };
            let (mut before, mut scale, mut mass) = (0.0, 0.0, 0.0);
            for &i in &island.members {
                before += energies[i];
                scale += magnitude(bodies, i, energies[i], frame.gravity);
                mass += bodies.masses[i];
            }
            let too_much = |total: f64, island: &Island| {
                let excess = total - island.allowance - island.bank - island.recovered;
                (frame.settings.ledger && excess > ROUNDING * scale).then_some(excess)
            };
            balance.islands += 1;

            // Restrain contacts that would fling light bodies: limit the energy left in the pair's
            // relative motion.
            let work_before = accounts.causes.work;
            let mut gains: Vec<EnergyGain> =
                island.gains.iter().map(|&index| accounts.gains[index]).collect();
            let is_sound = frame.settings.ledger && before.is_finite();
            let is_restrained =
                is_sound && cap_ejection(bodies, (&mut gains, &gained), frame, accounts);
            let mut after = before;
            if is_restrained {
                island.allowance += accounts.causes.work - work_before;
                after = total(bodies, &island.members);
            }

            // Contacts with an energy gain repay first; the island pays the rest.
            let excess = too_much(after, &island);
            if let Some(excess) = excess {
                let work_before = accounts.causes.work;
                repay(bodies, &gains, excess, accounts);
                island.allowance += accounts.causes.work - work_before;
                if let Some(excess) = too_much(total(bodies, &island.members), &island) {
                    let shortened =
                        reduce_energy(bodies, &mut island, contact_free, excess, frame, accounts);
                    balance.scaled += 1;
                    balance.shortened += u64::from(shortened);
                } else {
                    balance.paid += 1;
                }
                after = total(bodies, &island.members);
            }
            if is_restrained || excess.is_some() {
                let removed = before + (accounts.causes.work - work_before) - after;
                balance.removed += removed;
                accounts.causes.balance -= removed;
            }

            // Bank the surplus up to the cap, divided among members by mass. Energy needed by
            // penetration recovery does not count as gain.
            let needed = (after - island.allowance - island.bank).max(0.0).min(island.recovered);
            accounts.recovery += needed;
            accounts.causes.add(Cause::Projection, needed);
            accounts.causes.add(Cause::Contact, -needed);
            let left = island.allowance + island.bank + needed - after;
            let cap = frame.settings.bank_cap * mass;
            // Non-finite islands bank zero.
            let kept = if left.is_finite() { left.clamp(0.0, cap) } else { 0.0 };
            for &i in &island.members {
                bank.insert(bodies.ids[i], kept * bodies.masses[i] / mass);
            }
        }

        // Bodies without contacts keep their bank.
        for (id, amount) in self.bank.iter() {
            if bodies.index_of(id).is_some() && bank.get(id).is_none() {
                bank.insert(id, amount);
            }
        }
        self.bank = bank;
        balance
    }

    /// Islands of a frame. Broken bodies connect their fragments.
    fn islands(
        &self,
        bodies: &Bodies,
        start: &EnergyAtStart,
        accounts: &FrameAccounts,
    ) -> Vec<Island> {
        let are_immobile: Vec<bool> = bodies.inertias.iter().map(Inertia::is_infinite).collect();
        let is_immobile = |id: BodyId| bodies.index_of(id).is_some_and(|i| are_immobile[i]);
        let mut islands = Islands::new(bodies);
        let mut anchored = Vec::new();
        for &(a, b) in &accounts.links {
            match (is_immobile(a), is_immobile(b)) {
                (false, false) => {
                    let [a, b] = [a, b].map(|id| islands.node(bodies, id));
                    islands.link(a, b);
                }
                (false, true) => anchored.push((a, b)),
                (true, false) => anchored.push((b, a)),
                (true, true) => {}
            }
        }
        let mut nodes = |(id, by)| {
            let [node, by] = [id, by].map(|id| islands.node(bodies, id));
            islands.join(node);
            (node, by)
        };
        let anchored: Vec<(u32, u32)> = anchored.into_iter().map(&mut nodes).collect();
        let members = islands.members(bodies);

        // Find the anchor of each island, and the gains of its mobile bodies.
        let mut anchors = vec![AnchorKind::Free; members.len()];
        for (node, by) in anchored {
            let Some(number) = islands.number(node) else { continue };
            let anchor = &mut anchors[number];
            *anchor = match *anchor {
                AnchorKind::Free => AnchorKind::One(by),
                AnchorKind::One(other) if other == by => AnchorKind::One(by),
                AnchorKind::One(_) | AnchorKind::Many => AnchorKind::Many,
            };
        }
        let mut gains = vec![Vec::new(); members.len()];
        for (index, gain) in accounts.gains.iter().enumerate() {
            let Some(&mobile) = gain.ids.iter().find(|&&id| !is_immobile(id)) else { continue };
            let node = islands.node(bodies, mobile);
            if let Some(number) = islands.number(node) {
                gains[number].push(index);
            }
        }

        let mut recovered = vec![0.0; members.len()];
        for (ids, energy) in &accounts.recovered {
            let Some(&mobile) = ids.iter().find(|&&id| !is_immobile(id)) else { continue };
            let node = islands.node(bodies, mobile);
            if let Some(number) = islands.number(node) {
                recovered[number] += energy;
            }
        }

        let island = |number: usize| {
            let ids = &members[number];
            Island {
                members: ids.iter().filter_map(|&id| bodies.index_of(id)).collect(),
                anchor: anchor_of(bodies, anchors[number]),
                recovered: recovered[number].max(0.0),
                allowance: sum(&start.0, ids) + work_on(&accounts.work, ids),
                bank: sum(&self.bank, ids),
                gains: gains[number].clone(),
            }
        };
        let mut all = threads::list(members.len(), island);
        all.retain(|island| !island.members.is_empty());
        all
    }
}

/// Immovable bodies in contact with an island.
#[derive(Clone, Copy)]
enum AnchorKind {
    Free,
    /// One body, by dense index.
    One(u32),
    Many,
}

fn sum(amounts: &PerBody<f64>, ids: &[BodyId]) -> f64 {
    ids.iter().filter_map(|&id| amounts.get(id)).sum()
}

/// A single kinematic body carries an island; otherwise it is fixed.
fn anchor_of(bodies: &Bodies, anchored: AnchorKind) -> Anchor {
    match anchored {
        AnchorKind::Free => Anchor::Free,
        AnchorKind::One(i) => Anchor::of(bodies, i as usize),
        AnchorKind::Many => Anchor::Fixed,
    }
}
