//! Breaking a mesh that nobody simulates: on a grid, or by a Boolean library that is handed the
//! pattern's cells.
//!
//! Everything is in the mesh's own frame, which stands for the grid frame and for the body frame of
//! the [`Impact`].

use crate::align::{Impact, corners};
use crate::fragment::Fragment;
use crate::pattern::Pattern;
use crate::placement::Placement;
use crate::shatter;
use crate::shatter::settings::ShatterSettings;
use frangible_geometry::polygonize;
use frangible_geometry::{
    Grid, GridSolid, LevelSet, MeshToLevelSetError, NoMass, Shape, TriMesh, solids_to_level_set,
};
use frangible_math::RigidTransform;
use glam::DVec3;
use std::collections::BTreeMap;

/// Relative enlargement of the pattern's box: box walls must not coincide with the mesh's own
/// faces, to tell both apart. Far above rounding, far below visible sizes.
const CLEAR_OF_THE_BOX: f64 = 1e-6;

/// Triangles this close to a plane, relative to their cell, lie in it.
const SAME_PLANE: f64 = 1e-9;

/// Edges of rough cells' triangles, in units of a mean cell's edge: fine enough that their ripples
/// look smooth.
const ROUGH_EDGE: f64 = 0.125;

/// Layers of voxels around the mesh, so that all gradients at its surface are central.
const MARGIN: usize = 2;

/// One cell of a pattern, laid onto a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Cutter {
    /// Closed; what of it is inside of the mesh is crack, because the pattern's box is clear of the
    /// mesh.
    pub mesh: TriMesh,
    /// For each triangle, which face of the cell it is a part of: a plane, or a rough crack towards
    /// one neighbour.
    pub face: Vec<u32>,
}

/// Why a mesh cannot be broken on a grid.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshBreakError {
    /// It has no level set there.
    #[error(transparent)]
    Sampling(#[from] MeshToLevelSetError),
    /// The part on the grid has no mass.
    #[error(transparent)]
    NoMass(#[from] NoMass),
}

/// The cells of a pattern, laid onto the box from `low` to `high` around a mesh that is struck at
/// `impact`: intersected with the mesh they are its pieces. Empty meshes stand for cells that the
/// pattern has none of, and for those that lie beside the box. Triangles of rough cells are larger
/// by `coarseness`, 1 for pieces that are shown.
pub fn cutters(
    pattern: &Pattern,
    impact: &Impact,
    (low, high): (DVec3, DVec3),
    coarseness: f64,
) -> Vec<Cutter> {
    let mut placement = Placement::around(pattern, impact, &corners((low, high)));
    if pattern.scale.is_none() {
        placement.scale *= 1.0 + CLEAR_OF_THE_BOX;
    }

    // Place the cells in the mesh's frame.
    let volume = 8.0 * pattern.half_extent.element_product();
    let longest_edge = match pattern.planar() {
        Some(_) => f64::INFINITY,
        None => coarseness * ROUGH_EDGE * libm::cbrt(volume / pattern.len() as f64),
    };
    let clear = CLEAR_OF_THE_BOX * (high - low).max_element();
    let lies_beside = |number: usize| {
        let Some((points, reach)) = pattern.around_cell(number) else { return false };
        let reach = reach * placement.scale + clear;
        let points = points.iter().map(|&point| placement.point(point));
        let bounds = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let bounds =
            points.fold(bounds, |(least, most), point| (least.min(point), most.max(point)));
        (bounds.0 - reach).cmpgt(high).any() || (bounds.1 + reach).cmplt(low).any()
    };
    let cell = |number: usize| {
        if lies_beside(number) {
            return TriMesh::default();
        }
        let mut mesh = pattern.cell_mesh(number, longest_edge, coarseness).mesh;
        mesh.positions.iter_mut().for_each(|position| *position = placement.point(*position));
        mesh
    };
    let meshes: Vec<TriMesh> = (0..pattern.len()).map(cell).collect();
    if pattern.planar().is_some() {
        return meshes.into_iter().map(with_planes).collect();
    }

    // The triangle on the other side of a rough crack has the same corners.
    let mut cells_of: BTreeMap<[[u64; 3]; 3], Vec<u32>> = BTreeMap::new();
    for (mesh, cell) in meshes.iter().zip(0_u32..) {
        for triangle in 0..mesh.triangles.len() {
            cells_of.entry(corner_bits(mesh, triangle)).or_default().push(cell);
        }
    }
    let with_neighbours = |(mesh, cell): (TriMesh, u32)| {
        let across = |triangle: usize| {
            let cells = cells_of.get(&corner_bits(&mesh, triangle));
            cells
                .and_then(|cells| cells.iter().copied().find(|&other| other != cell))
                .unwrap_or(cell)
        };
        let face = (0..mesh.triangles.len()).map(across).collect();
        Cutter { mesh, face }
    };
    meshes.into_iter().zip(0..).map(with_neighbours).collect()
}

/// Groups a polyhedron's triangles by plane.
fn with_planes(mesh: TriMesh) -> Cutter {
    let (low, high) = mesh.bounds();
    let near = SAME_PLANE * (high - low).max_element();
    let mut planes: Vec<(DVec3, DVec3)> = Vec::new();
    let plane_of = |triangle: usize| {
        let [a, b, c] = mesh.corners(triangle);
        let normal = (b - a).cross(c - a).normalize_or_zero();
        let lies_in = |&(point, across): &(DVec3, DVec3)| {
            across.dot(normal) >= 0.0
                && [a, b, c].iter().all(|&corner| across.dot(corner - point).abs() <= near)
        };
        let known = planes.iter().position(lies_in);
        known.unwrap_or_else(|| {
            planes.push((a, normal));
            planes.len() - 1
        }) as u32
    };
    let face = (0..mesh.triangles.len()).map(plane_of).collect();
    Cutter { mesh, face }
}

/// The corners of a triangle in an order of their own.
fn corner_bits(mesh: &TriMesh, triangle: usize) -> [[u64; 3]; 3] {
    // Adding zero makes -0 and 0 the same.
    let mut bits =
        mesh.corners(triangle).map(|corner| (corner + DVec3::ZERO).to_array().map(f64::to_bits));
    bits.sort_unstable();
    bits
}

/// Volume of a mesh on a grid [m^3], and its pieces. `voxels` are along the longest side of the
/// bounding box. The pieces' grid frame and their parent's body frame are the mesh's.
///
/// The mesh is cleaned first, see [`TriMesh::cleaned`]; its solids may cross.
///
/// # Errors
/// If the mesh encloses nothing, or nothing that the grid resolves, or the grid does not
/// fit into memory.
pub fn break_on_grid(
    mesh: &TriMesh,
    pattern: &Pattern,
    impact: &Impact,
    voxels: usize,
) -> Result<(f64, Vec<Fragment>), MeshBreakError> {
    let parent = sampled_body(mesh, voxels)?;
    let pieces = shatter(&parent, pattern, impact, &ShatterSettings::default());
    Ok((parent.volume, pieces))
}

/// A mesh on a grid, as a body whose frame is the mesh's; see [`break_on_grid`].
///
/// # Errors
/// As for [`break_on_grid`].
pub fn sampled_body(mesh: &TriMesh, voxels: usize) -> Result<Shape, MeshBreakError> {
    // Nobody collides with the pieces, so no sample is needed.
    let (level_set, bounds) = sampled(mesh, voxels)?;
    let mut body = Shape::from_grid_solid(GridSolid::from_level_set(level_set), Vec::new())?;
    body.body_from_grid = RigidTransform::IDENTITY;
    body.bounds = bounds;
    Ok(body)
}

/// The surface of what a mesh encloses, closed and free of crossings: made anew by dual contouring
/// of the level set on a grid of so many `voxels` along the longest side of the bounding box.
///
/// # Errors
/// As for [`break_on_grid`].
pub fn resurfaced(mesh: &TriMesh, voxels: usize) -> Result<TriMesh, MeshBreakError> {
    Ok(polygonize(&GridSolid::from_level_set(sampled(mesh, voxels)?.0)).mesh)
}

/// Level set of the solids that a mesh bounds, and their bounding box.
fn sampled(
    mesh: &TriMesh,
    voxels: usize,
) -> Result<(LevelSet, (DVec3, DVec3)), MeshToLevelSetError> {
    let clean = mesh.cleaned("the mesh")?;
    let (low, high) = clean.mesh.bounds();
    let spacing = (high - low).max_element() / voxels as f64;
    let along = ((high - low) / spacing).to_array().map(|count| count.ceil().max(1.0) as usize);
    let grid = Grid::around_box(low, high, along, MARGIN);
    Ok((solids_to_level_set(&clean, grid)?, (low, high)))
}
