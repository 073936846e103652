//! Fracture patterns and breaking: a pure function of a body, a pattern and an impact [Su09 sec.
//! 4]; and glue between pieces.
//!
//! Nothing moves here, and there is no list of bodies. Lengths are metres, except in a pattern,
//! which is scaled onto the body.

pub mod align;
pub mod bonds;
mod cell_mesh;
pub mod drawn;
pub mod generators;
pub mod interfaces;
pub mod mesh_break;
mod nearby;
pub mod noise;
pub mod pattern;
mod pattern_file;
mod polygon;
pub mod rough;
pub mod shapes;
pub mod shatter;
pub mod shatter_hull;
pub mod slivers;
pub mod stress;
pub mod velocities;

pub use align::{Impact, Placement, align_pattern};
pub use bonds::{BondStrength, GaveWay, Glued, PointLoad, prescore};
pub use drawn::Drawn;
pub use generators::{Bricks, Concrete, MOST_CELLS, Natural, Radial, Slices, Splinters, Voronoi};
pub use interfaces::{CutPiece, Interface, interfaces, mesh_interfaces};
pub use mesh_break::{Cutter, MeshBreakError, break_on_grid, cutters, resurfaced, sampled_body};
pub use noise::Noise;
pub use pattern::{Cells, Cut, Pattern, PatternError, Region};
pub use rough::Rough;
pub use shapes::CellShape;
pub use shatter::{Fragment, ShatterSettings, shatter};
pub use shatter_hull::shatter_hull;
pub use slivers::{Contact, Smallest, join_slivers};
pub use velocities::fragment_velocity;
