//! Rigid bodies in motion that never gain energy.
//!
//! Each stage of a frame has a file of its own; `frangible::step` says in which order they run.
//! Static and kinematic bodies have infinite mass and are the outside: what they do is booked in a [`Tally`].

mod ball_contact;
pub mod birth_fits;
pub mod blows;
pub mod bodies;
pub mod broad_phase;
mod clusters;
pub mod collisions;
mod compound_contact;
pub mod contact;
mod contact_batch;
pub mod contact_forces;
pub mod contact_graph;
mod contact_kernels;
mod contact_rows;
mod contact_sweep;
pub mod detection;
pub mod displacements;
mod effort;
mod encounter;
pub mod energy_fix;
pub mod evolve;
pub mod exact_rotation;
pub mod first_contact;
mod flight;
mod hull_contact;
pub mod impulse;
pub mod impulse_clamp;
mod instructions;
mod islands;
mod jacobi;
pub mod kept_pairs;
mod lanes;
pub mod ledger;
pub mod manifold;
mod moving;
pub mod pair;
pub mod pair_rotation;
pub mod payment;
pub mod penetration;
mod plane_contact;
pub mod push_out;
mod rebounds;
mod regions;
pub mod rigid_part;
pub mod rotation;
pub mod settings;
pub mod shock_propagation;
pub mod state;
pub mod substeps;
mod take_out;
pub mod tally;
mod threads;
mod vector;
pub mod warm_start;

pub use bodies::{Bodies, BodyId, Contactant, Motion, NewBody, PairContactant};
pub use energy_fix::{EnergyFix, fix_rotational_energy};
pub use exact_rotation::rotate_exact;
pub use impulse::{Impulse, apply_impulse, collision_impulse, contact_matrix};
pub use impulse_clamp::{Clamp, ClampSide, clamp_impulse};
pub use rotation::{advance, rotate_second_order};
pub use settings::{Frame, Rotation, StepSettings, Width};
pub use state::{Inertia, Pose, Velocity};
pub use tally::Tally;
