//! Fracture patterns and breaking: a pure function of a body, a pattern and an impact [Su09 sec.
//! 4]; and glue between pieces.
//!
//! Nothing moves here, and there is no list of bodies. Lengths are metres, except in a pattern,
//! which is scaled onto the body.

mod align;
mod bonds;
mod cell_mesh;
mod crater;
mod filling;
mod fragment;
mod generators;
mod grid_pieces;
mod interfaces;
mod mesh_break;
mod mesh_pattern;
mod nearby;
mod noise;
mod pattern;
mod pattern_file;
mod piece;
mod placement;
mod polygon;
mod prescore;
mod reach;
mod rough;
mod shapes;
mod shatter;
mod shatter_hull;
mod shatter_solid;
mod slivers;
mod strength_points;
mod stress;
mod velocities;

pub use align::{Impact, align_pattern};
pub use bonds::{BondStrength, GaveWay, Glued, PointLoad};
pub use filling::Filling;
pub use fragment::Fragment;
pub use generators::bricks::Bricks;
pub use generators::concrete::Concrete;
pub use generators::natural::Natural;
pub use generators::parameters::MOST_CELLS;
pub use generators::radial::Radial;
pub use generators::slices::Slices;
pub use generators::splinters::Splinters;
pub use generators::voronoi::Voronoi;
pub use interfaces::cross_section::CrossSection;
pub use interfaces::interface::Interface;
pub use interfaces::meshes::{CutPiece, mesh_interfaces};
pub use interfaces::{interfaces, interfaces_between};
pub use mesh_break::{Cutter, MeshBreakError, break_on_grid, cutters, resurfaced, sampled_body};
pub use mesh_pattern::Drawn;
pub use mesh_pattern::parts::closed_parts;
pub use noise::Noise;
pub use pattern::error::PatternError;
pub use pattern::region::{Cut, Region};
pub use pattern::{Cells, Pattern};
pub use placement::Placement;
pub use prescore::{Prescored, prescore, prescore_parts};
pub use reach::{Reach, Rim};
pub use rough::Rough;
pub use shapes::CellShape;
pub use shatter::settings::ShatterSettings;
pub use shatter::shatter;
pub use shatter_hull::shatter_hull;
pub use slivers::{Contact, Smallest, join_slivers};
pub use strength_points::StrengthPoints;
pub use stress::RigidPiece;
pub use velocities::fragment_velocity;
