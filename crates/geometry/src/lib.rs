//! Shapes at rest: no time and no mass in motion.
//!
//! Lengths are metres. A *grid frame* is the material frame in which a body's level set was sampled; fragments keep
//! their parent's. A *body frame* has its origin at the centre of mass and its axes along the principal axes.

pub mod closed_form;
pub mod closed_form_surface;
pub mod coverage;
mod crossings;
mod dual_contour;
pub mod grid;
pub mod grid_solid;
pub mod half_space;
pub mod level_set;
pub mod mass_properties;
pub mod mesh;
mod outline_pieces;
pub mod polygonize;
mod qef;
pub mod rigid_transform;
pub mod shape;
mod sheets;
pub mod surface_samples;
mod symmetric;

pub use closed_form::ClosedForm;
pub use grid::Grid;
pub use grid_solid::{GridSolid, NoMass, Outline, Root};
pub use half_space::HalfSpace;
pub use level_set::LevelSet;
pub use mass_properties::MassProperties;
pub use mesh::{Surface, TriMesh};
pub use rigid_transform::RigidTransform;
pub use shape::{Geometry, Shape};
