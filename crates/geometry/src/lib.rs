//! Shapes at rest: no time and no mass in motion.
//!
//! Lengths are metres. A *grid frame* is the material frame in which a body's level set was
//! sampled; fragments keep their parent's. A *body frame* has its origin at the centre of mass and
//! its axes along the principal axes.

mod bvh;
mod cleaning;
mod closed_form;
mod closed_form_surface;
mod compound;
mod compound_surface;
mod contour_mesh;
mod coverage;
mod crossings;
mod dual_contour;
mod face_polygon;
mod fast_sweeping;
mod grid;
mod grid_solid;
mod half_space;
mod hull;
mod level_set;
mod line_crossings;
mod mass_properties;
mod mesh;
mod mesh_boundary;
mod mesh_check;
pub mod mesh_io;
mod mesh_to_level_set;
mod mesh_topology;
mod moments;
mod outline_clip;
mod outline_pieces;
mod polygon;
mod polygonize;
mod qef;
mod read_file;
mod revolved;
mod run_core;
mod runs;
mod sample_clusters;
mod sampled_normal;
mod shape;
mod sheets;
mod solid_boundary;
mod static_mesh;
mod surface_samples;
mod texture;
mod thickness;
mod vertex_placement;
mod voxel_bounds;
mod voxel_runs;
mod winding_number;

pub use bvh::{Bvh, closest_point_on_triangle};
pub use cleaning::clean_mesh::{CleanMesh, MeshChanges, Sheet};
pub use cleaning::meeting::Meeting;
pub use cleaning::thicken::Thickened;
pub use closed_form::ClosedForm;
pub use closed_form_surface::closed_form_surface;
pub use compound::{Compound, Part};
pub use grid::Grid;
pub use grid_solid::{GridSolid, Outline, Root};
pub use half_space::HalfSpace;
pub use hull::cell_cutter::CellCutter;
pub use hull::columns::Columns;
pub use hull::edges::HullEdge;
pub use hull::plane_clip::PlaneClipper;
pub use hull::quickhull::HullError;
pub use hull::weld::weld_hulls;
pub use hull::{Hull, HullFace};
pub use level_set::LevelSet;
pub use mass_properties::{MassProperties, NoMass, outer, parallel_axis};
pub use mesh::{Surface, TriMesh};
pub use mesh_boundary::MeshBoundary;
pub use mesh_check::MeshError;
pub use mesh_io::attributes::{CornerAttributes, FaceAttributes, MeshAttributes};
pub use mesh_to_level_set::{
    MeshToLevelSetError, mesh_to_level_set, solids_and_boundary, solids_to_level_set,
};
pub use mesh_topology::MeshInfo;
pub use moments::{Portion, RowSums};
pub use outline_clip::Clip;
pub use polygonize::polygonize;
pub use read_file::read_file;
pub use revolved::{Revolved, RevolvedEnd};
pub use runs::{Run, Span};
pub use sample_clusters::{ClusteredSamples, SampleCluster};
pub use shape::{BodyFrame, Geometry, Shape};
pub use static_mesh::StaticMesh;
pub use static_mesh::closed_sheet::Compartment;
pub use static_mesh::distance::NearestPoint;
pub use static_mesh::heightfield::heightfield_mesh;
pub use static_mesh::kinds::{EdgeKind, Neighbour, Sides};
pub use surface_samples::{mesh_samples, surface_samples};
pub use voxel_runs::VoxelRuns;
pub use winding_number::{WindingNumber, triangle_solid_angle};
