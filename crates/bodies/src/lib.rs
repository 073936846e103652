//! Bodies and how they fly freely: the store of all bodies of a world, their poses, velocities and
//! inertia, and where a body that nothing touches gets to in a frame.

mod activity;
mod bodies;
mod body_id;
mod collision_classes;
mod enclosures;
mod frame;
mod free_flight;
mod near_sheets;
mod pair;
mod state;

pub use activity::{Activity, Drowsiness, Substeps};
pub use bodies::{Bodies, Motion, NewBody, PairSurface, PerBody, SurfaceProperties};
pub use body_id::BodyId;
pub use collision_classes::{CollisionClass, CollisionClasses};
pub use frame::{Frame, MOST_SUBSTEPS, Rotation, StepSettings};
pub use free_flight::ballistic_path::BallisticPath;
pub use free_flight::energy_fix::{EnergyFix, fix_rotational_energy};
pub use free_flight::evolve::{accelerate, evolve, evolve_all, evolve_these, half_fallen, predict};
pub use free_flight::exact_rotation::rotate_exact;
pub use free_flight::rotation::{advance, rotate_second_order, rotation_by};
pub use pair::Pair;
pub use state::{Inertia, Pose, Velocity};
