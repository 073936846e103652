//! State of a frame between motion and the ledger.

use crate::report::{BorneBlow, Fracture, Quarantined};
use crate::step::quarantine::Before;
use frangible_bodies::BodyId;
use frangible_dynamics::{ContactFreeState, FrameAccounts};
use glam::DVec3;

/// State of a frame once its bodies have moved, before its energy is balanced. Both methods end in
/// it.
pub(crate) struct Moved {
    /// Fractures of the frame.
    pub(crate) fractures: Vec<Fracture>,
    /// The frame without contact.
    pub(crate) contact_free: ContactFreeState,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub(crate) gravity: (DVec3, DVec3),
    /// Impulses and work of static and kinematic bodies, energy by cause.
    pub(crate) accounts: FrameAccounts,
    /// Number of pairs left out in crowds.
    pub(crate) left_out: usize,
    /// Number of islands with fewer substeps than needed.
    pub(crate) short_of_substeps: usize,
    /// Number of groups of islands whose later impacts did not bounce.
    pub(crate) short_of_impacts: usize,
    /// Bodies removed before the solver.
    pub(crate) quarantined: Vec<Quarantined>,
    /// State at the solver's start.
    pub(crate) before: Before,
    /// The blow that came nearest to breaking something, and did not.
    pub(crate) borne: Option<BorneBlow>,
    /// Waiting bodies that a blow reached.
    pub(crate) hit: Vec<BodyId>,
}
