//! Triangle mesh to level set: the exact distance to the boundary between inside and outside.

use crate::bvh::{Bvh, closest_point_on_triangle};
use crate::cleaning::clean_mesh::CleanMesh;
use crate::fast_sweeping::{Nearest, UNKNOWN};
use crate::grid::Grid;
use crate::level_set::LevelSet;
use crate::line_crossings::LineCrossings;
use crate::mesh::TriMesh;
use crate::mesh_boundary::MeshBoundary;
use crate::mesh_check::{MeshError, short};
use crate::solid_boundary::{Deep, boundary_triangles};
use glam::DVec3;
use rayon::prelude::*;

/// Half of the width, in cells, of the band in which each node is compared with all triangles.
/// Beyond it nodes learn from their neighbours; the surface, its gradients and the contacts lie
/// within.
const BAND: f64 = 3.0;

/// Voxels along the longest side beyond which more of them are no advice.
const MOST_VOXELS: f64 = 1024.0;

/// Why a mesh has no level set on a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshToLevelSetError {
    /// See [`TriMesh::check`].
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// Would not fit into memory.
    #[error("the grid has {} x {} x {} nodes, must have at most {} in all", dims[0], dims[1], dims[2], Grid::MOST_NODES)]
    TooManyNodes {
        /// Nodes along x, y and z.
        dims: [usize; 3],
    },
    /// The solid is thinner than the grid can tell, or lies beside it.
    #[error(
        "the mesh has 0 grid nodes inside, must have at least 1 (the grid's spacing is {} m, and the mesh about {} m thick{})",
        short(*spacing),
        short(*thickness),
        enough.map_or(String::new(), |voxels| format!("; use {voxels} voxels along its longest side"))
    )]
    NothingInside {
        /// Of the grid [m].
        spacing: f64,
        /// Of the mesh, if it is a plate [m].
        thickness: f64,
        /// Voxels along the longest side for full resolution, if feasible.
        enough: Option<usize>,
    },
}

/// [`solids_to_level_set`] of a raw mesh, cleaned first: see [`TriMesh::cleaned`].
///
/// # Errors
/// If the mesh encloses nothing, the grid does not fit into memory, or no node lies inside.
pub fn mesh_to_level_set(mesh: &TriMesh, grid: Grid) -> Result<LevelSet, MeshToLevelSetError> {
    check_grid(&grid)?;
    solids_to_level_set(&mesh.cleaned("the mesh")?, grid)
}

/// Samples the signed distance [m] of the solids that a mesh bounds, exact to rounding within three
/// cells of the surface and to a small part of a cell beyond.
///
/// Inside is where the surfaces wind around a point, so that crossings do no harm: the distance is
/// to the triangles that separate inside from outside, not to those buried in a solid, as where
/// parts overlap. Does not depend on the number of threads.
///
/// # Errors
/// If the grid does not fit into memory, or no node lies inside.
pub fn solids_to_level_set(clean: &CleanMesh, grid: Grid) -> Result<LevelSet, MeshToLevelSetError> {
    solids_and_boundary(clean, grid).map(|(level_set, _)| level_set)
}

/// The same, with the triangles that separate inside from outside.
///
/// # Errors
/// If the grid does not fit into memory, or no node lies inside.
pub fn solids_and_boundary(
    clean: &CleanMesh,
    grid: Grid,
) -> Result<(LevelSet, MeshBoundary), MeshToLevelSetError> {
    check_grid(&grid)?;
    // Find the triangles that bound the solid: of a surface that meets none, all of them.
    let mesh = &clean.mesh;
    let triangles: Vec<[DVec3; 3]> =
        (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect();
    let surfaces = LineCrossings::new(&triangles);
    let meeting = clean.meeting();
    let meets = |triangle: &usize| {
        let solid = clean.solid[*triangle] as usize;
        meeting.others[solid] || meeting.buried[solid] > 0.0
    };
    let (asked, alone): (Vec<usize>, Vec<usize>) = (0..triangles.len()).partition(meets);
    let mut boundary: Vec<[DVec3; 3]> =
        alone.into_iter().map(|triangle| triangles[triangle]).collect();
    let windings = surfaces.at_nodes(&grid);
    if !asked.is_empty() {
        boundary.extend(boundary_triangles(&surfaces, &asked, &Deep::new(&grid, &windings)));
    }

    // Measure the nodes near the triangles, then those far from them.
    let mut nearest = measure_band(&grid, &boundary);
    nearest.sweep(&grid, &boundary, (BAND * grid.spacing) as f32);

    // Tell inside from outside.
    let mut phi = nearest.distance;
    let mut inner = 0_usize;
    for (value, winding) in phi.iter_mut().zip(windings) {
        if winding > 0 {
            *value = -*value;
            inner += 1;
        }
    }
    if inner == 0 {
        return Err(nothing_inside(mesh, &grid));
    }
    Ok((LevelSet::new(grid, phi), MeshBoundary::new(boundary)))
}

fn check_grid(grid: &Grid) -> Result<(), MeshToLevelSetError> {
    let nodes = grid.dims.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    if nodes.is_none_or(|nodes| nodes > Grid::MOST_NODES) {
        return Err(MeshToLevelSetError::TooManyNodes { dims: grid.dims });
    }
    Ok(())
}

/// The sentence for a mesh that no node lies in.
fn nothing_inside(mesh: &TriMesh, grid: &Grid) -> MeshToLevelSetError {
    let (low, high) = mesh.bounds();
    let longest = (high - low).max_element();
    let thickness = 2.0 * mesh.mass_properties().volume.abs() / mesh.area();
    let enough = 2.0 * longest / thickness;
    MeshToLevelSetError::NothingInside {
        spacing: grid.spacing,
        thickness,
        enough: (enough <= MOST_VOXELS).then_some(enough.ceil() as usize),
    }
}

/// Finds the nearest triangle for each node in the band around them.
fn measure_band(grid: &Grid, triangles: &[[DVec3; 3]]) -> Nearest {
    let mut nearest =
        Nearest { distance: vec![f32::INFINITY; grid.len()], triangle: vec![UNKNOWN; grid.len()] };
    let bvh = Bvh::new(triangles);
    let [nx, ny, _] = grid.dims;
    let rows = nearest.distance.par_chunks_mut(nx).zip(nearest.triangle.par_chunks_mut(nx));
    rows.enumerate().for_each(|(row, (distance, triangle))| {
        let mut last: Option<usize> = None;
        for i in 0..nx {
            // The nearest triangle of the last node is a good guess.
            let node = grid.node(i, row % ny, row / ny);
            let guess = last.map_or(f64::INFINITY, |last| {
                (node - closest_point_on_triangle(node, &triangles[last])).length_squared()
            });
            let bound = BAND * grid.spacing;
            let mut squared = bound * bound;
            if guess < squared {
                squared = guess;
            } else {
                last = None;
            }
            if let Some(closest) = bvh.closest(node, squared) {
                squared = closest.distance_squared;
                last = Some(closest.triangle);
            }
            if let Some(last) = last {
                distance[i] = squared.sqrt() as f32;
                triangle[i] = last as u32;
            }
        }
    });
    nearest
}
