//! Shapes at rest: no time and no mass in motion.
//!
//! Lengths are metres. A *grid frame* is the material frame in which a body's level set was sampled; fragments keep
//! their parent's. A *body frame* has its origin at the centre of mass and its axes along the principal axes.

pub mod closed_form;
pub mod coverage;
pub mod grid;
pub mod grid_solid;
pub mod half_space;
pub mod level_set;
pub mod mass_properties;
pub mod mesh;
pub mod rigid_transform;
pub mod shape;
pub mod surface_samples;

pub use closed_form::ClosedForm;
pub use grid::Grid;
pub use grid_solid::{GridSolid, NoMass, Outline, Root};
pub use half_space::HalfSpace;
pub use level_set::LevelSet;
pub use mass_properties::MassProperties;
pub use mesh::{Surface, TriMesh};
pub use rigid_transform::RigidTransform;
pub use shape::{Geometry, Shape};
