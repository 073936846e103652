//! Rigid bodies in motion that never gain energy.

pub mod energy_fix;
pub mod impulse;
pub mod impulse_clamp;
pub mod rotation;
pub mod state;

pub use energy_fix::{EnergyFix, fix_rotational_energy};
pub use impulse::{apply_impulse, collision_impulse, contact_matrix};
pub use impulse_clamp::{Clamp, ClampSide, clamp_impulse};
pub use rotation::{advance, rotate_second_order};
pub use state::{Inertia, Pose, Velocity};
