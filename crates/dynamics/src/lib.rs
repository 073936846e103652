//! Rigid bodies in motion that never gain energy.

pub mod state;

pub use state::{Inertia, Pose, Velocity};
