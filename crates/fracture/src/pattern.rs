//! Fracture patterns: all of space, broken in advance [Su09 sec. 4.1].

pub(crate) mod drawn_cells;
pub(crate) mod error;
pub(crate) mod region;

use crate::pattern::region::Region;
use crate::pattern::region::nearest_region;
use crate::{cell_mesh::CellMesh, mesh_pattern::Drawn, polygon, rough::Rough};
use frangible_geometry::{HalfSpace, TriMesh};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A box broken into cells around one point.
///
/// The *pattern frame* has its origin in the middle of the box; +z is the direction of the
/// collision normal, out of the broken body and towards the striker; x and y lie across. A break
/// moves, turns and uniformly scales the pattern onto the body. Lengths are in the pattern's own
/// unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pattern {
    /// Half of the box's edge lengths.
    pub half_extent: DVec3,
    /// The fracture centre, strictly inside of the box: what is laid on the impact point.
    pub center: DVec3,
    /// Size of the box relative to the smallest enclosing box of a body, at least 1: larger
    /// patterns have fewer cells in the body.
    #[serde(default = "unmagnified", skip_serializing_if = "is_unmagnified")]
    pub magnification: f64,
    /// Metres per unit of a pattern that was made for a body; others are as large as encloses it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// The cells that are mortar between others, in ascending order.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub joints: Vec<usize>,
    /// Cells that tile the box, and continue beyond it.
    pub cells: Cells,
}

fn unmagnified() -> f64 {
    1.0
}

fn is_unmagnified(magnification: &f64) -> bool {
    *magnification == 1.0
}

/// Kinds of pattern cells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Cells {
    /// Convex regions between planes.
    Planar(Vec<Region>),
    /// Planar regions with rough faces.
    Rough(Rough),
    /// Closed meshes.
    Drawn(Drawn),
}

impl Pattern {
    /// A pattern of convex cells in a centred box, none of them mortar.
    pub(crate) fn planar_in_box(half_extent: DVec3, regions: Vec<Region>) -> Self {
        Self {
            half_extent,
            center: DVec3::ZERO,
            magnification: unmagnified(),
            scale: None,
            joints: Vec::new(),
            cells: Cells::Planar(regions),
        }
    }

    /// The regions of a pattern of convex cells; `None` for one with other cells.
    pub fn planar(&self) -> Option<&[Region]> {
        match &self.cells {
            Cells::Planar(regions) => Some(regions),
            Cells::Rough(_) | Cells::Drawn(_) => None,
        }
    }

    /// The same cells with the plain faces that noise makes rough: as many, in the same places.
    /// `None` for cells of other kinds.
    pub fn without_roughness(&self) -> Option<Self> {
        let Cells::Rough(rough) = &self.cells else { return None };
        Some(Self {
            half_extent: self.half_extent,
            center: self.center,
            magnification: self.magnification,
            scale: self.scale,
            joints: self.joints.clone(),
            cells: Cells::Planar(rough.regions.clone()),
        })
    }

    /// True for mortar between other cells.
    pub fn is_joint(&self, cell: usize) -> bool {
        self.joints.binary_search(&cell).is_ok()
    }

    /// Number of cells.
    pub fn len(&self) -> usize {
        match &self.cells {
            Cells::Planar(regions) => regions.len(),
            Cells::Rough(rough) => rough.regions.len(),
            Cells::Drawn(drawn) => drawn.meshes().len(),
        }
    }

    /// True without cells.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The cell that holds a point of the pattern frame, inside of the box or beyond: the one with
    /// the least distance, the first of equals. `None` only without cells.
    pub fn region_at(&self, point: DVec3) -> Option<usize> {
        match &self.cells {
            Cells::Planar(regions) => nearest_region(regions, point),
            Cells::Rough(rough) => rough.region_at(point, self.half_extent),
            Cells::Drawn(drawn) => drawn.region_at(point),
        }
    }

    /// Signed distance from a point of the pattern frame to a cell, negative inside: of the right
    /// sign, and nowhere larger than it is far. The walls of the box bound no cell.
    pub fn distance(&self, cell: usize, point: DVec3) -> f64 {
        match &self.cells {
            Cells::Planar(regions) => regions[cell].distance(point),
            Cells::Rough(rough) => rough.distance(cell, point, self.half_extent),
            Cells::Drawn(drawn) => drawn.distance(cell, point),
        }
    }

    /// Signed distances from a point of the pattern frame to the nearest of its own cells and to
    /// the nearest of the others, each alone: of drawn cells, to their meshes.
    pub(crate) fn distances_to(&self, is_own: &[bool], point: DVec3) -> [f64; 2] {
        let mut nearest = [f64::INFINITY; 2];
        let mut to_regions = |regions: &[Region], point: DVec3| {
            for (region, &own) in regions.iter().zip(is_own) {
                let nearest = &mut nearest[usize::from(!own)];
                *nearest = nearest.min(region.distance_up_to(point, *nearest));
            }
        };
        match &self.cells {
            Cells::Planar(regions) => to_regions(regions, point),
            Cells::Rough(rough) => {
                to_regions(&rough.regions, rough.moved_point(point, self.half_extent));
                let part = 1.0 / (1.0 + rough.noise.steepness);
                nearest = nearest.map(|distance| distance * part);
            }
            Cells::Drawn(drawn) => {
                for (cell, &own) in is_own.iter().enumerate() {
                    let nearest = &mut nearest[usize::from(!own)];
                    *nearest = nearest.min(drawn.to_mesh(cell, point));
                }
            }
        }
        nearest
    }

    /// The closed surface of a cell within the box, without an edge longer than `longest_edge`
    /// (infinite: each face as large as it is). Cells that meet face to face share the vertices of
    /// the face bit for bit, and its triangles.
    pub fn region_mesh(&self, cell: usize, longest_edge: f64) -> TriMesh {
        self.cell_mesh(cell, longest_edge, 1.0).mesh
    }

    /// Points around a cell, and how far it may reach beyond them; `None` for a drawn cell.
    pub(crate) fn around_cell(&self, cell: usize) -> Option<(Vec<DVec3>, f64)> {
        let (regions, reach) = match &self.cells {
            Cells::Planar(regions) => (regions, 0.0),
            Cells::Rough(rough) => (&rough.regions, rough.noise.reach()),
            Cells::Drawn(_) => return None,
        };
        let hull = regions[cell].hull(self.half_extent);
        Some((hull.map_or_else(Vec::new, |hull| hull.vertices().to_vec()), reach))
    }

    /// Samples cells that are not planar, as the first break would otherwise: takes some tenths of
    /// a second.
    pub fn prepare(&self) {
        match &self.cells {
            Cells::Planar(_) => {}
            Cells::Rough(rough) => rough.prepare(self.half_extent),
            Cells::Drawn(drawn) => drawn.prepare(),
        }
    }

    pub(crate) fn cell_mesh(&self, cell: usize, longest_edge: f64, coarseness: f64) -> CellMesh {
        match &self.cells {
            Cells::Planar(regions) => {
                CellMesh::planar(regions, self.half_extent, cell).refined(longest_edge)
            }
            Cells::Rough(rough) => {
                rough.cell_mesh(cell, longest_edge, self.half_extent, coarseness)
            }
            Cells::Drawn(drawn) => drawn.cell_mesh(cell, self.half_extent).refined(longest_edge),
        }
    }

    /// Volume of a region within the box, by the divergence theorem.
    pub fn region_volume(&self, region: &Region) -> f64 {
        let walls = polygon::box_half_spaces(-self.half_extent, self.half_extent);
        let cuts: Vec<HalfSpace> = region.cuts.iter().map(|cut| cut.half_space).collect();
        let faces: f64 =
            region.cuts.iter().map(|cut| cut.half_space.offset * polygon::area(&cut.face)).sum();
        let outer: f64 = walls
            .iter()
            .map(|wall| {
                let section = polygon::box_section(wall, self.half_extent);
                let face = cuts.iter().fold(section, |face, cut| polygon::clip(&face, cut));
                wall.offset * polygon::area(&face)
            })
            .sum();
        (faces + outer) / 3.0
    }

    /// Relative difference between the regions' total volume and the box's: zero for a tiling.
    /// Rough cells tile like their regions; meshes of drawn cells may leave small gaps, which
    /// neighbours fill.
    pub fn tiling_defect(&self) -> f64 {
        let e = self.half_extent;
        let whole = 8.0 * e.x * e.y * e.z;
        let parts: f64 = match &self.cells {
            Cells::Planar(regions) | Cells::Rough(Rough { regions, .. }) => {
                regions.iter().map(|region| self.region_volume(region)).sum()
            }
            Cells::Drawn(drawn) => {
                drawn.meshes().iter().map(|mesh| mesh.mass_properties().volume).sum()
            }
        };
        (parts - whole).abs() / whole
    }
}
