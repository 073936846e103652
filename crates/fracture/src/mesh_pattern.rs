//! Patterns from user meshes: closed meshes that fill a box.

use crate::cell_mesh::CellMesh;
use crate::nearby::Nearby;
use frangible_geometry::{Grid, LevelSet, TriMesh, mesh_to_level_set};
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::sync::{Arc, OnceLock};

pub(crate) mod fit;
pub(crate) mod parts;

/// Nodes along the longest edge of the box on which the cells' distances are sampled, and the
/// fewest along the shortest: a pane is thin.
const NODES: f64 = 64.0;
const LAYERS: f64 = 2.0;

/// The most nodes in the box: thinner plates have fewer layers.
const MOST_NODES: f64 = 1e6;

/// Layers of nodes around a cell, for central differences at its surface.
const MARGIN: f64 = 3.0;

/// A triangle this close to a wall, relative to the box, lies on it: the precision of a file of
/// single-precision numbers.
const ON_THE_BOX: f64 = 1e-5;

/// Error of a pattern without meshes.
const EMPTY: &str = "has no cells, must have at least 1";

/// Closed meshes, one per cell.
///
/// A point belongs to the cell with the deepest enclosing surface; outside of all cells, to the
/// nearest. The cells tile the box, and all of space, even with small gaps or overlaps of the
/// meshes.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "DrawnRecord", into = "DrawnRecord")]
pub struct Drawn {
    /// Closed surfaces, outward, pattern frame.
    meshes: Vec<TriMesh>,
    /// Signed distance to each, on parts of one lattice.
    fields: Vec<LevelSet>,
    /// The cells near each place of the box; made when a body breaks first.
    nearby: OnceLock<Arc<Nearby>>,
}

/// Linear between the nodes of a lattice, a distance changes by as much along each of three axes; a
/// little more than that.
const STEEPEST: f64 = 1.8;

/// Distances are made from the meshes.
impl PartialEq for Drawn {
    fn eq(&self, other: &Self) -> bool {
        self.meshes == other.meshes
    }
}

/// Record of a file.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct DrawnRecord {
    meshes: Vec<MeshRecord>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct MeshRecord {
    positions: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl From<Drawn> for DrawnRecord {
    fn from(drawn: Drawn) -> Self {
        let record = |TriMesh { positions, triangles }| MeshRecord { positions, triangles };
        Self { meshes: drawn.meshes.into_iter().map(record).collect() }
    }
}

impl TryFrom<DrawnRecord> for Drawn {
    type Error = String;

    fn try_from(record: DrawnRecord) -> Result<Self, String> {
        let mesh = |MeshRecord { positions, triangles }| TriMesh { positions, triangles };
        Self::new(record.meshes.into_iter().map(mesh).collect(), DVec3::ZERO)
    }
}

/// Bounding box of the meshes.
pub(crate) fn bounds(meshes: &[TriMesh]) -> Option<(DVec3, DVec3)> {
    meshes.iter().map(TriMesh::bounds).reduce(|a, b| (a.0.min(b.0), a.1.max(b.1)))
}

impl Drawn {
    /// Checks and samples; `origin` is added to the places in a sentence.
    pub(crate) fn new(meshes: Vec<TriMesh>, origin: DVec3) -> Result<Self, String> {
        let (drawn, spacing) = Self::sampled(meshes, origin)?;
        let around = bounds(&drawn.meshes).ok_or(EMPTY)?;
        fit::check(&|point| drawn.nearest(point), around, spacing, origin)?;
        Ok(drawn)
    }

    /// The same of meshes that need not fill their box; and the distance of the samples.
    pub(crate) fn sampled(mut meshes: Vec<TriMesh>, origin: DVec3) -> Result<(Self, f64), String> {
        let (low, high) = bounds(&meshes).ok_or(EMPTY)?;
        for (cell, mesh) in meshes.iter_mut().enumerate() {
            mesh.check(&format!("cell {cell}")).map_err(|error| error.to_string())?;
            if let Some(place) = parts::open_edge(mesh) {
                let place = parts::place(place + origin);
                return Err(format!("cell {cell} is not closed: there is an open edge at {place}"));
            }
            if mesh.mass_properties().volume < 0.0 {
                mesh.flip();
            }
        }

        // Sample each on its part of one lattice, whose nodes are the middles of cubes that fill
        // the box.
        let spacing = spacing_in(high - low);
        let sample = |(cell, mesh): (usize, &TriMesh)| {
            mesh_to_level_set(mesh, grid_around(mesh, low, spacing))
                .map_err(|error| format!("cell {cell}: {error}"))
        };
        let fields = meshes.iter().enumerate().map(sample).collect::<Result<_, _>>()?;
        Ok((Self { meshes, fields, nearby: OnceLock::new() }, spacing))
    }

    /// True if a mesh in the box from `low` to `high` is thick enough to be sampled.
    pub(crate) fn resolves(mesh: &TriMesh, (low, high): (DVec3, DVec3)) -> bool {
        mesh_to_level_set(mesh, grid_around(mesh, low, spacing_in(high - low))).is_ok()
    }

    /// The cells' surfaces, pattern frame.
    pub fn meshes(&self) -> &[TriMesh] {
        &self.meshes
    }

    /// Signed distance to a cell's mesh. Beyond its samples a lower bound: the cell lies within
    /// their box, so that it is as far from a point as the box is, and as far as it is from the
    /// nearest point of the box.
    pub(crate) fn to_mesh(&self, cell: usize, point: DVec3) -> f64 {
        let field = &self.fields[cell];
        let (low, high) = field.grid().bounds();
        let nearest = point.clamp(low, high);
        let value = f64::from(field.value(nearest));
        if nearest == point { value } else { value.max(nearest.distance(point)) }
    }

    /// The two least distances to the meshes, each with its cell.
    fn nearest(&self, point: DVec3) -> [(f64, usize); 2] {
        let mut least = [(f64::INFINITY, usize::MAX); 2];
        let around = self.nearby.get().and_then(|nearby| nearby.around(point));
        let all = 0..if around.is_some() { 0 } else { self.meshes.len() };
        for cell in around.unwrap_or_default().iter().map(|&cell| cell as usize).chain(all) {
            let distance = self.to_mesh(cell, point);
            if distance < least[0].0 {
                least = [(distance, cell), least[0]];
            } else if distance < least[1].0 {
                least[1] = (distance, cell);
            }
        }
        least
    }

    /// Computes the neighbourhoods of cells, if not yet done.
    pub(crate) fn prepare(&self) {
        let Some((low, high)) = bounds(&self.meshes) else { return };
        let half_extent = low.abs().max(high.abs());
        self.nearby.get_or_init(|| {
            let distance = |cell: usize, point: DVec3| self.to_mesh(cell, point);
            Arc::new(Nearby::new(half_extent, self.meshes.len(), STEEPEST, distance))
        });
    }

    /// See [`crate::Pattern::region_at`].
    pub(crate) fn region_at(&self, point: DVec3) -> Option<usize> {
        if let Some(cell) = self.nearby.get().and_then(|nearby| nearby.sure(point)) {
            return Some(cell);
        }
        let [(_, cell), _] = self.nearest(point);
        (cell < self.meshes.len()).then_some(cell)
    }

    /// See [`crate::Pattern::distance`]: half of how much nearer this cell is than the next. In a
    /// tiling without gaps that is the distance to the crack between the two; less deep beside a
    /// wall of the box, and far from the crack, where only bounds are known.
    pub(crate) fn distance(&self, cell: usize, point: DVec3) -> f64 {
        let [first, second] = self.nearest(point);
        let other = if first.1 == cell { second.0 } else { first.0 };
        // One cell is all of space.
        if other == f64::INFINITY {
            f64::NEG_INFINITY
        } else {
            0.5 * (self.to_mesh(cell, point) - other)
        }
    }

    /// See [`crate::Pattern::region_mesh`].
    pub(crate) fn cell_mesh(&self, cell: usize, half_extent: DVec3) -> CellMesh {
        let mesh = self.meshes[cell].clone();
        let close = ON_THE_BOX * half_extent.max_element();
        let on_wall = |triangle: usize| {
            let corners = mesh.corners(triangle).map(|corner| corner / half_extent);
            let relative = close / half_extent.min_element();
            (0..3).any(|axis| {
                [1.0, -1.0]
                    .iter()
                    .any(|sign| corners.iter().all(|c| (sign * c[axis] - 1.0).abs() < relative))
            })
        };
        let crack = (0..mesh.triangles.len()).map(|triangle| !on_wall(triangle)).collect();
        CellMesh { mesh, crack }
    }
}

/// Distance of the samples of cells that fill a box.
fn spacing_in(extent: DVec3) -> f64 {
    let mut spacing = (extent.max_element() / NODES).min(extent.min_element() / LAYERS);
    while (extent / spacing).element_product() > MOST_NODES {
        spacing *= 2.0;
    }
    spacing
}

/// The part around a mesh of the lattice whose nodes are the middles of cubes from `low` on.
fn grid_around(mesh: &TriMesh, low: DVec3, spacing: f64) -> Grid {
    let (cell_low, cell_high) = mesh.bounds();
    let first = ((cell_low - low) / spacing - 0.5).floor() - MARGIN;
    let last = ((cell_high - low) / spacing - 0.5).ceil() + MARGIN;
    let dims = (last - first).to_array().map(|count| count as usize + 1);
    Grid { origin: low + spacing * (first + 0.5), spacing, dims }
}
