//! Shapes at rest: no time and no mass in motion.
//!
//! Lengths are metres. A *grid frame* is the material frame in which a body's level set was
//! sampled; fragments keep their parent's. A *body frame* has its origin at the centre of mass and
//! its axes along the principal axes.

pub mod bvh;
pub mod cleaning;
pub mod clip;
pub mod closed_form;
pub mod closed_form_surface;
pub mod compound;
pub mod coverage;
mod crossings;
mod dual_contour;
pub mod grid;
pub mod grid_solid;
pub mod half_space;
pub mod hull;
pub mod level_set;
mod line_crossings;
pub mod mass_properties;
pub mod material;
pub mod mesh;
pub mod mesh_check;
pub mod mesh_io;
pub mod mesh_to_level_set;
pub mod mesh_topology;
pub mod moments;
mod outline_pieces;
mod placement;
mod polygon;
pub mod polygonize;
mod qef;
mod read_file;
mod run_core;
pub mod sample_clusters;
pub mod shape;
mod sheets;
mod solid_boundary;
pub mod surface_samples;
mod sweep;
mod texture;
pub mod winding_number;

pub use cleaning::{CleanMesh, Meeting, MeshChanges, Sheet, Thickened};
pub use clip::Clip;
pub use closed_form::ClosedForm;
pub use compound::{Compound, Part};
pub use grid::Grid;
pub use grid_solid::{GridSolid, NoMass, Outline, Root};
pub use half_space::HalfSpace;
pub use hull::{Carver, Clipper, Columns, Hull, HullEdge, HullError, HullFace};
pub use level_set::LevelSet;
pub use mass_properties::MassProperties;
pub use material::{Material, Run, Span};
pub use mesh::{Surface, TriMesh};
pub use mesh_check::MeshError;
pub use mesh_to_level_set::{MeshToLevelSetError, mesh_to_level_set, solids_to_level_set};
pub use mesh_topology::MeshInfo;
pub use moments::{Portion, RowSums, RunSums};
pub use read_file::read_file;
pub use run_core::RunCore;
pub use sample_clusters::{ClusteredSamples, SampleCluster};
pub use shape::{BodyFrame, Geometry, Shape};
pub use surface_samples::surface_samples;
pub use winding_number::WindingNumber;
