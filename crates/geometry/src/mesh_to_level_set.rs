//! Triangle mesh to level set: the exact distance to the boundary between inside and outside.

use crate::bvh::{Bvh, closest_point_on_triangle};
use crate::hole_patches::hole_patches;
use crate::mesh_check::{MeshError, short};
use crate::solid_boundary::boundary_triangles;
use crate::sweep::{Nearest, UNKNOWN};
use crate::winding_number::INSIDE;
use crate::{CleanMesh, Grid, LevelSet, TriMesh, WindingNumber};
use glam::DVec3;
use rayon::prelude::*;

/// Half of the width, in cells, of the band in which each node is compared with all triangles. Beyond it nodes learn from
/// their neighbours; the surface, its gradients and the contacts lie within.
const BAND: f64 = 3.0;

/// Voxels along the longest side beyond which more of them are no advice.
const MOST_VOXELS: f64 = 1024.0;

/// Why a mesh has no level set on a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshToLevelSetError {
    /// See [`TriMesh::check`] and [`TriMesh::check_volume`].
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
        /// Voxels along the longest side that would resolve it, if there can be so many.
        enough: Option<usize>,
    },
}

/// Samples the signed distance [m] of the solid that a mesh bounds, exact to rounding within three cells of
/// the surface and to a small part of a cell beyond.
///
/// Inside is where the winding number exceeds one half [JKS13], so that holes and self-intersections do no harm: the
/// distance is to the triangles that separate inside from outside (not to those buried in the solid, as where parts
/// overlap), and to patches over the holes. A mesh that faces inward is turned. Does not depend on the number of threads.
pub fn mesh_to_level_set(mesh: &TriMesh, grid: Grid) -> Result<LevelSet, MeshToLevelSetError> {
    check_grid(&grid)?;
    mesh.check("the mesh")?;
    mesh.check_volume("the mesh")?;
    let mut mesh = mesh.clone();
    if mesh.mass_properties().volume < 0.0 {
        mesh.flip();
    }
    let watertight = mesh.is_watertight();
    sample(&mesh, |_| false, watertight, grid)
}

/// The same of solids that are clean already, see [`TriMesh::cleaned`]: sooner, as only surfaces
/// that meet others can lie in a solid.
///
/// # Errors
/// If the grid does not fit into memory, or no node lies inside.
pub fn solids_to_level_set(clean: &CleanMesh, grid: Grid) -> Result<LevelSet, MeshToLevelSetError> {
    check_grid(&grid)?;
    let meeting = clean.meeting();
    let alone = |triangle: usize| {
        let solid = clean.solid[triangle] as usize;
        !meeting.others[solid] && meeting.buried[solid] == 0.0
    };
    sample(&clean.mesh, alone, true, grid)
}

fn check_grid(grid: &Grid) -> Result<(), MeshToLevelSetError> {
    let nodes = grid.dims.iter().try_fold(1_usize, |product, &n| product.checked_mul(n));
    if nodes.is_none_or(|nodes| nodes > Grid::MOST_NODES) {
        return Err(MeshToLevelSetError::TooManyNodes { dims: grid.dims });
    }
    Ok(())
}

/// Samples the distance to a mesh; `bounds` says of which triangles it is known that the solid
/// ends there.
fn sample(
    mesh: &TriMesh,
    bounds: impl Fn(usize) -> bool,
    watertight: bool,
    grid: Grid,
) -> Result<LevelSet, MeshToLevelSetError> {
    // Find the triangles that bound the solid.
    let triangles: Vec<[DVec3; 3]> =
        (0..mesh.triangles.len()).map(|triangle| mesh.corners(triangle)).collect();
    let winding_number = WindingNumber::new(Bvh::new(&triangles));
    let (known, asked): (Vec<usize>, Vec<usize>) =
        (0..triangles.len()).partition(|&triangle| bounds(triangle));
    let mut boundary: Vec<[DVec3; 3]> = known.iter().map(|&triangle| triangles[triangle]).collect();
    if !asked.is_empty() {
        let corners: Vec<[DVec3; 3]> = asked.iter().map(|&triangle| triangles[triangle]).collect();
        let faces = asked.iter().map(|&triangle| mesh.triangles[triangle]).collect();
        let part = TriMesh { positions: mesh.positions.clone(), triangles: faces };
        boundary.extend(boundary_triangles(&winding_number, &part, &corners, grid.spacing));
    }

    // Measure the nodes near the triangles, and find how often the mesh winds around each node.
    let mut nearest =
        Nearest { distance: vec![f32::INFINITY; grid.len()], triangle: vec![UNKNOWN; grid.len()] };
    measure_band(&grid, &boundary, 0, &mut nearest);
    let winding = node_windings(&winding_number, watertight, &grid, &nearest);

    // Close the holes, and go on to the nodes far from the surface.
    if !watertight {
        let closed = boundary.len();
        boundary.extend(hole_patches(&winding_number, &grid, &nearest.distance, &winding));
        measure_band(&grid, &boundary[closed..], closed, &mut nearest);
    }
    nearest.sweep(&grid, &boundary, (BAND * grid.spacing) as f32);

    // Tell inside from outside.
    let mut phi = nearest.distance;
    let mut inner = 0_usize;
    for (value, &winding) in phi.iter_mut().zip(&winding) {
        if f64::from(winding) > INSIDE {
            *value = -*value;
            inner += 1;
        }
    }
    if inner == 0 {
        return Err(nothing_inside(mesh, &grid));
    }
    Ok(LevelSet::new(grid, phi))
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

/// The winding number at each node.
fn node_windings(number: &WindingNumber, watertight: bool, grid: &Grid, nearest: &Nearest) -> Vec<f32> {
    let [nx, ny, _] = grid.dims;
    let mut winding = vec![0.0; grid.len()];
    winding.par_chunks_mut(nx).zip(nearest.triangle.par_chunks(nx)).enumerate().for_each(
        |(row, (winding, triangle))| {
            for i in 0..nx {
                // Between two nodes outside of the band lies no triangle, and without holes nothing changes there.
                let as_before = watertight && i > 0 && triangle[i - 1] == UNKNOWN && triangle[i] == UNKNOWN;
                winding[i] = if as_before {
                    winding[i - 1]
                } else {
                    number.at(grid.node(i, row % ny, row / ny)) as f32
                };
            }
        },
    );
    winding
}

/// Finds the nearest of some triangles for each node in the band around them, where it is nearer than what is known.
/// `first` is the index of the first triangle.
fn measure_band(grid: &Grid, triangles: &[[DVec3; 3]], first: usize, nearest: &mut Nearest) {
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
            let bound = f64::from(distance[i]).min(BAND * grid.spacing);
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
                triangle[i] = (first + last) as u32;
            }
        }
    });
}
