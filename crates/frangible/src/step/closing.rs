//! The books of a frame: opened before anything gains energy, closed into the report.

use crate::hand::state::Handled;
use crate::report::books::Totals;
use crate::report::{Fracture, Impulses, StepReport, id_from_number};
use crate::step::moved::Moved;
use crate::world::World;
use frangible_bodies::Frame;
use frangible_dynamics::{EnergyAtStart, FrameAccounts, LedgerReport};

/// The books at a frame's start.
pub(crate) struct Opening {
    totals: Totals,
    energies: EnergyAtStart,
    /// In the ledger's banks [J].
    bank: f64,
    /// Breaks of anchored bodies: the parts start at rest.
    freed: Vec<Fracture>,
}

impl Opening {
    pub(crate) fn of(world: &World, freed: Vec<Fracture>, frame: &Frame) -> Self {
        Self {
            totals: Totals::of(&world.bodies, frame),
            energies: EnergyAtStart::new(&world.bodies, frame),
            bank: world.ledger.bank(),
            freed,
        }
    }

    /// Enters the pieces of anchored bodies that have come free since.
    pub(crate) fn admit(&mut self, world: &World, freed: Vec<Fracture>, frame: &Frame) {
        let pieces = freed.iter().flat_map(|fracture| &fracture.fragments);
        for i in pieces.filter_map(|&piece| world.bodies.index_of(id_from_number(piece))) {
            if !world.bodies.inertias[i].is_infinite() {
                self.totals = self.totals.plus(Totals::of_some(
                    &world.bodies,
                    i..i + 1,
                    &world.bodies.poses,
                    frame,
                ));
                self.energies.admit(&world.bodies, i, frame);
            }
        }
        self.freed.extend(freed);
    }

    /// Balances the energy of every island; broken bodies are in one with their fragments.
    pub(crate) fn balance_energy(
        &self,
        world: &mut World,
        moved: &mut Moved,
        frame: &Frame,
    ) -> LedgerReport {
        let Moved { fractures, contact_free, accounts, .. } = moved;
        accounts.links.extend(fractures.iter().flat_map(Fracture::links));
        world.ledger.balance(&mut world.bodies, &self.energies, contact_free, frame, accounts)
    }

    /// Closes the books and reports, without the times of the stages. The caller's deeds before the frame are part of its report.
    pub(crate) fn close(
        self,
        world: &mut World,
        moved: &mut Moved,
        balance: LedgerReport,
        frame: &Frame,
    ) -> StepReport {
        let Handled { work: by_hand, mut fractures } = std::mem::take(&mut world.hand.handled);
        fractures.extend(self.freed);
        fractures.append(&mut moved.fractures);
        let accounts = &mut moved.accounts;
        let after = Totals::of(&world.bodies, frame);
        let before = Totals { kinetic: self.totals.kinetic - by_hand, ..self.totals };
        accounts.causes.work += by_hand;
        let banked = world.ledger.bank() - self.bank;
        // Frames with removed bodies have no comparable sums.
        let (energy, momentum) = if moved.quarantined.is_empty() {
            world.books.close(&before, &after, moved.gravity, banked, accounts)
        } else {
            *accounts = FrameAccounts::default();
            world.books.close(&after, &after, Default::default(), 0.0, accounts)
        };
        world.frame += 1;
        StepReport {
            frame: world.frame,
            time: world.time(),
            bodies: world.bodies.len(),
            pairs_left_out: moved.left_out,
            short_of_substeps: moved.short_of_substeps,
            short_of_impacts: moved.short_of_impacts,
            asleep: world.bodies.ids.iter().filter(|&&id| world.is_asleep(id)).count(),
            waiting: world.labels.iter().filter(|label| label.waiting.is_some()).count(),
            mass: after.mass,
            energy,
            momentum,
            balance: balance.into(),
            impulses: Impulses {
                applied: accounts.impulses,
                clamped: accounts.clamps.shortened,
                discarded: accounts.clamps.dropped,
                withheld: accounts.clamps.withheld,
            },
            fractures,
            borne: moved.borne.take(),
            quarantined: std::mem::take(&mut moved.quarantined),
            stages: Vec::new(),
        }
    }
}
