//! Rigid bodies in motion that never gain energy.
//!
//! Each stage of a frame has a file of its own; `frangible::step` says in which order they run.
//! Static and kinematic bodies have infinite mass and are the outside: what they do is booked in a
//! [`Tally`].

mod ball_contact;
pub mod birth_fits;
pub mod blows;
pub mod broad_phase;
pub mod collisions;
mod compound_contact;
pub mod contact;
pub mod contact_forces;
pub mod contact_graph;
pub mod detection;
pub mod displacements;
mod encounter;
pub mod first_contact;
pub mod frame_rate;
mod hull_contact;
pub mod impulse;
pub mod impulse_clamp;
mod islands;
pub mod kept_pairs;
pub mod ledger;
pub mod manifold;
pub mod pair;
pub mod pair_rotation;
pub mod payment;
pub mod penetration;
mod plane_contact;
pub mod push_out;
pub mod rigid_part;
pub mod shock_propagation;
mod sleep;
pub mod struck;
mod take_out;
pub mod tally;
pub mod warm_start;

pub use impulse::{Impulse, apply_impulse, collision_impulse, contact_matrix};
pub use impulse_clamp::{Clamp, ClampSide, clamp_impulse};
pub use tally::Tally;
