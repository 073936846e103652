//! Rigid bodies in motion that never gain energy.
//!
//! Each stage of a frame has a file of its own; `frangible::step` says in which order they run.
//! Static and kinematic bodies have infinite mass and are the outside: what they do is booked in a
//! [`Tally`].

pub mod blows;
pub mod collisions;
pub mod contact;
pub mod contact_forces;
pub mod contact_graph;
pub mod displacements;
pub mod frame_rate;
pub mod impulse;
pub mod impulse_clamp;
mod islands;
pub mod ledger;
pub mod pair;
pub mod pair_rotation;
pub mod payment;
pub mod push_out;
pub mod rigid_part;
pub mod shock_propagation;
mod sleep;
pub mod struck;
mod take_out;
pub mod tally;

pub use impulse::{Impulse, apply_impulse, collision_impulse, contact_matrix};
pub use impulse_clamp::{Clamp, ClampSide, clamp_impulse};
pub use tally::Tally;
