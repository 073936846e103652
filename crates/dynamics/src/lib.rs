//! Contact dynamics of rigid bodies, without energy gain.
//!
//! Each stage of a frame has a file of its own; `frangible::step` lists them in order. Static and
//! kinematic bodies have infinite mass and act from outside: a [`FrameAccounts`] books their
//! impulses and work.

mod energy;
mod frame_rate;
mod impacts;
mod impulse;
mod paper;

pub use energy::contact_repayment::{energy_at, repay_at};
pub use energy::frame_accounts::{Cause, Causes, FrameAccounts};
pub use energy::island::ContactFreeState;
pub use energy::ledger::{EnergyAtStart, Ledger, LedgerReport};
pub use frame_rate::contact_forces::{ContactForce, contact_forces};
pub use frame_rate::finish::Solved;
pub use frame_rate::impact_log::{Impact, PointImpulse};
pub use frame_rate::solve;
pub use impacts::blows::{
    Bearing, Blow, LocalStrength, Strike, hardest_blow, in_order, pass_on, strikes,
    touch_by_rotation,
};
pub use impacts::impact_chain::find_impact_chain;
pub use impacts::recent_impacts::RecentImpacts;
pub use impulse::collision_impulse::{Impulse, apply_impulse, collision_impulse, contact_matrix};
pub use impulse::energy_clamp::{Clamp, ClampSide, Clamps, clamp_impulse};
pub use impulse::pair_impulse::{Approach, PairImpulse};
pub use paper::collisions::{Collisions, Response};
pub use paper::contact::{Contact, Phase};
pub use paper::contact_graph::contact_graph;
pub use paper::displacements::Displacements;
pub use paper::push_out::push_out;
pub use paper::shock_propagation::propagate_shock;
