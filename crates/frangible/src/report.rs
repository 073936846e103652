//! Report of one frame, with energy and momentum accounts.

pub(crate) mod at_rest;
pub(crate) mod books;

use crate::report::at_rest::{PieceContact, RestPose};
use frangible_bodies::BodyId;
use frangible_dynamics as dynamics;
use serde::{Deserialize, Serialize};

/// One frame.
#[derive(Clone, Debug, Serialize)]
pub struct StepReport {
    /// Counts from 1.
    pub frame: u64,
    /// At the end of the frame [s].
    pub time: f64,
    /// Living bodies at the end of the frame.
    pub bodies: usize,
    /// Number of bodies asleep in this frame.
    pub asleep: usize,
    /// Number of bodies that wait to start, at the end of the frame.
    pub waiting: usize,
    /// Number of overlapping pairs left out in crowds, where each body keeps its nearest pairs.
    /// Zero in scenes without crowds.
    pub pairs_left_out: usize,
    /// Number of islands with fewer substeps than their accuracy needs, and larger overlaps:
    /// `most_substeps` is the limit, or for large islands the work of a frame.
    pub short_of_substeps: usize,
    /// Number of groups of islands with more impacts, or contacts to detect again, than a frame has
    /// time for: later impacts were stopped without bouncing, later contacts acted as they were first
    /// seen. Zero but where bodies are crushed, rattle between others, or spin in crowds.
    pub short_of_impacts: usize,
    /// Mass of all dynamic bodies [kg].
    pub mass: f64,
    /// The energy books.
    pub energy: Energy,
    /// The momentum books.
    pub momentum: Momentum,
    /// Statistics of the ledger.
    pub balance: Balance,
    /// Collision and contact impulses.
    pub impulses: Impulses,
    /// Fractures, in order.
    pub fractures: Vec<Fracture>,
    /// Of the blows that broke nothing the one that came nearest to what its body bears. Not in the
    /// paper's method.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub borne: Option<BorneBlow>,
    /// Bodies whose numbers went bad and that were taken out of the world. Such a frame has no
    /// books.
    pub quarantined: Vec<Quarantined>,
    /// Time of each stage [ms], in order, by the clock that [`crate::World::set_clock`] was given.
    pub stages: Vec<(&'static str, f64)>,
}

/// A blow that broke nothing.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct BorneBlow {
    /// The body that bore it, and its name.
    pub body: u64,
    /// See `body`.
    pub name: String,
    /// What struck it.
    pub striker: String,
    /// Where, in the world [m].
    pub point: [f64; 3],
    /// [N s]
    pub impulse: f64,
    /// What the body bears there, at least [N s]. A blow above it had too little energy for the
    /// cracks, or nothing to part.
    pub bears: f64,
}

/// Energy accounts of one frame [J].
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Energy {
    /// Of all dynamic bodies, at the end of the frame.
    pub kinetic: f64,
    /// Of all dynamic bodies, relative to the world's origin.
    pub potential: f64,
    /// Their sum.
    pub total: f64,
    /// Work of kinematic bodies in this frame and of the caller's hand, plus the work of
    /// penetration recovery, which is at most the potential energy by which bodies rose.
    pub work: f64,
    /// Growth of the ledger's banks in this frame: dissipated energy available for reuse.
    pub banked: f64,
    /// Kinetic and potential energy with which waiting bodies started in this frame; E(n) counts
    /// it.
    pub started: f64,
    /// E(n+1) - E(n) - W, with what is in the banks counted as energy: what came out of nowhere in
    /// this frame, or, if negative, was dissipated.
    pub gain: f64,
    /// Components of E(n+1) - E(n).
    pub causes: Causes,
}

/// Energy change of the dynamic bodies in one frame, by cause [J]; the sum is E(n+1) - E(n).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Causes {
    /// Kinematic bodies, and impulses of the caller since the frame before.
    pub work: f64,
    /// Impacts with restitution.
    pub collision: f64,
    /// Resting and sliding contacts, along the normal.
    pub contact: f64,
    /// Coulomb's, rolling and spinning friction.
    pub friction: f64,
    /// Moving bodies out of each other.
    pub projection: f64,
    /// Breaking: energy of cracks, and rounding.
    pub fracture: f64,
    /// Energy removed by the ledger.
    pub balance: f64,
    /// Remainder: flight and rotation (conservative up to the rotation rule), and rounding.
    pub flight: f64,
}

impl Causes {
    /// The stages' accounts, and the remainder of a frame's energy change [J].
    pub(crate) fn of(booked: &dynamics::Causes, change: f64) -> Self {
        let dynamics::Causes { work, collision, contact, friction, projection, fracture, balance } =
            *booked;
        let flight = change - booked.sum();
        Self { work, collision, contact, friction, projection, fracture, balance, flight }
    }
}

/// Statistics of the ledger in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Balance {
    /// Islands of touching bodies.
    pub islands: u64,
    /// Islands balanced by repayment of contacts alone.
    pub paid: u64,
    /// Islands whose relative velocities were scaled down.
    pub scaled: u64,
    /// Islands whose displacements were shortened.
    pub shortened: u64,
    /// Energy that was taken out, by payment, scaling or shortening [J].
    pub removed: f64,
}

impl From<dynamics::LedgerReport> for Balance {
    fn from(balance: dynamics::LedgerReport) -> Self {
        let dynamics::LedgerReport { islands, paid, scaled, shortened, removed } = balance;
        Self { islands, paid, scaled, shortened, removed }
    }
}

/// Momentum accounts. Errors accumulate from the start of the world, relative to the largest sum
/// over bodies to date of: momentum, gravity's impulse in a frame, and the momentum of a thousandth
/// of a body's size per frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Momentum {
    /// Of all dynamic bodies at the end of the frame, in the world frame [N s].
    pub linear: [f64; 3],
    /// The same about the world's origin [N m s].
    pub angular: [f64; 3],
    /// Change of linear momentum that neither gravity nor a static or kinematic body explains.
    pub linear_error: f64,
    /// The same of angular momentum about the world's origin.
    pub angular_error: f64,
}

/// Collision and contact impulses of one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Impulses {
    /// Applied to velocities that last; by the frame-rate method, those that act at the end of
    /// passes, a number for each point.
    pub applied: u64,
    /// Shortened because they would have raised the kinetic energy [Su09 sec. 3.2].
    pub clamped: u64,
    /// Dropped, for the same reason.
    pub discarded: u64,
    /// Energy gain avoided by both [J].
    pub withheld: f64,
}

/// A body broke.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Fracture {
    /// Start of the frame, when the pieces took the body's place [s].
    pub time: f64,
    /// The broken body; its id is no longer alive.
    pub body: u64,
    /// The striker; the body itself if its bonds gave way under load, or if the caller cut it.
    pub striker: u64,
    /// Where the two first touched on their way through the frame, in the world frame [m]. The
    /// fracture is centred on the material that was there then.
    pub point: [f64; 3],
    /// The impulse that would have stopped the blow [N s].
    pub impulse: f64,
    /// Impulse up to the strength, felt by body and striker before the break [N s].
    pub borne: f64,
    /// Fracture energy taken from the relative motion of both bodies [J]; zero if strength is an
    /// impulse.
    pub energy: f64,
    /// Number of pieces in the body's description, if given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wanted: Option<usize>,
    /// As many came, without loose parts and slivers below a hundredth of the mean piece.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted: Option<usize>,
    /// Fragments of the body.
    pub fragments: Vec<u64>,
    /// Where each fragment lay in the body.
    pub rest_poses: Vec<RestPose>,
    /// Fragments that touched in the body, each pair once.
    pub contacts: Vec<PieceContact>,
    /// Relative change of the body's mass, momentum, angular momentum and kinetic energy by the
    /// break: round-off.
    pub imbalance: Imbalance,
}

impl Fracture {
    /// The body with each of its fragments.
    pub(crate) fn links(&self) -> impl Iterator<Item = (BodyId, BodyId)> {
        self.fragments.iter().map(|&fragment| (id_from_number(self.body), id_from_number(fragment)))
    }
}

/// A body that was taken out of the world.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub struct Quarantined {
    /// The removed body.
    pub body: u64,
    /// The fault of its numbers.
    pub cause: &'static str,
}

/// Relative differences between a body and the sum of its fragments: of momenta, to the sum of the
/// lengths of the fragments'.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Imbalance {
    /// Of mass.
    pub mass: f64,
    /// Of linear momentum.
    pub momentum: f64,
    /// Of angular momentum about the body's centre of mass.
    pub angular_momentum: f64,
    /// Of kinetic energy.
    pub kinetic_energy: f64,
}

/// An id as one number, for files and other languages.
pub fn id_number(id: BodyId) -> u64 {
    u64::from(id.generation) << 32 | u64::from(id.index)
}

/// The id that [`id_number`] made `number` from.
pub fn id_from_number(number: u64) -> BodyId {
    BodyId { index: number as u32, generation: (number >> 32) as u32 }
}
