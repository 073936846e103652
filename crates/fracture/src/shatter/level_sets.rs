//! Level sets of the fragments: the parent's and the region's, intersected [Su09 sec. 4.2 "Level Set"].

use super::{components::Components, regions::NONE, slivers::Pieces};
use crate::pattern::Region;
use frangible_geometry::{Grid, GridSolid, HalfSpace, LevelSet, Outline};
use glam::DVec3;

/// Layers of nodes around a fragment's voxels, so that gradients at its surface are central.
const MARGIN: i64 = 2;

/// At nodes where another fragment's inside would read as this one's: the least distance, in units of the spacing.
/// Large enough to be seen in f32, too small to move a surface.
const OUTSIDE: f64 = 1e-3;

/// Where a piece lies on the parent's grid: lowest and highest node with its material.
#[derive(Clone, Copy)]
struct Extent {
    low: [usize; 3],
    high: [usize; 3],
}

/// One solid for each piece, each on its part of the parent's lattice.
pub(crate) fn intersect_level_sets(
    parent: &GridSolid,
    regions: &[Region],
    components: &Components,
    pieces: &Pieces,
) -> Vec<GridSolid> {
    let piece_of_node: Vec<u32> = components
        .of_node
        .iter()
        .map(|&component| if component == NONE { NONE } else { pieces.of_component[component as usize] })
        .collect();
    let extents = find_extents(parent.level_set.grid(), &piece_of_node, pieces.components.len());
    let intersect = |(piece, extent): (usize, Extent)| {
        // The regions that the piece is made of: one, and those of the slivers that joined it.
        let mut parts: Vec<&Region> = Vec::new();
        for &component in &pieces.components[piece] {
            let region = &regions[components.region[component as usize] as usize];
            if !parts.iter().any(|&known| std::ptr::eq(known, region)) {
                parts.push(region);
            }
        }
        Intersection { parent, parts, piece_of_node: &piece_of_node, piece: piece as u32 }.build(extent)
    };
    extents.into_iter().enumerate().map(intersect).collect()
}

/// The extents of all pieces.
fn find_extents(grid: &Grid, piece_of_node: &[u32], count: usize) -> Vec<Extent> {
    let mut extents = vec![Extent { low: [usize::MAX; 3], high: [0; 3] }; count];
    for row in 0..grid.dims[1] * grid.dims[2] {
        let [j, k] = [row % grid.dims[1], row / grid.dims[1]];
        let nodes = &piece_of_node[row * grid.dims[0]..(row + 1) * grid.dims[0]];
        for (i, &piece) in nodes.iter().enumerate() {
            if piece != NONE {
                let extent = &mut extents[piece as usize];
                for (axis, at) in [i, j, k].into_iter().enumerate() {
                    extent.low[axis] = extent.low[axis].min(at);
                    extent.high[axis] = extent.high[axis].max(at);
                }
            }
        }
    }
    extents
}

/// The larger of two numbers that are not NaN: one instruction, unlike [`f32::max`].
#[inline]
fn larger(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

/// Distances along one row of nodes.
struct RowScratch {
    /// To the region of the piece.
    region: Vec<f32>,
    /// To one part of it.
    part: Vec<f32>,
    /// To each plane of a part, at both ends of the row.
    ends: Vec<(f64, f64)>,
    /// 0, 1, 2, ...
    numbers: Vec<f32>,
}

impl RowScratch {
    fn new(width: usize) -> Self {
        let numbers = (0..width).map(|i| i as f32).collect();
        Self { region: vec![0.0; width], part: vec![0.0; width], ends: Vec::new(), numbers }
    }
}

/// All that one piece's solid is computed from.
struct Intersection<'a> {
    parent: &'a GridSolid,
    parts: Vec<&'a Region>,
    piece_of_node: &'a [u32],
    piece: u32,
}

impl Intersection<'_> {
    /// The solid on the parent's lattice, from the piece's lowest node to its highest and [`MARGIN`] further.
    fn build(&self, extent: Extent) -> GridSolid {
        let parent_grid = self.parent.level_set.grid();
        let h = parent_grid.spacing;
        let low = extent.low.map(|n| n as i64 - MARGIN);
        let dims: [usize; 3] =
            std::array::from_fn(|axis| extent.high[axis] - extent.low[axis] + 1 + 2 * MARGIN as usize);
        let origin = parent_grid.origin + h * DVec3::new(low[0] as f64, low[1] as f64, low[2] as f64);
        let grid = Grid { origin, spacing: h, dims };

        let mut phi = vec![0.0; grid.len()];
        let mut coverage = vec![0.0; grid.len()];
        let mut row_ends = Vec::with_capacity(2 * dims[1] * dims[2]);
        let mut scratch = RowScratch::new(dims[0]);
        for row in 0..dims[1] * dims[2] {
            let [j, k] = [row % dims[1], row / dims[1]];
            let nodes = row * dims[0]..(row + 1) * dims[0];
            let start = grid.node(0, j, k);
            self.region_distances(start, &mut scratch);
            let lattice = [low[0], low[1] + j as i64, low[2] + k as i64];
            let own = self.fill_row(
                lattice,
                &scratch.region,
                &mut phi[nodes.clone()],
                &mut coverage[nodes.clone()],
            );
            for i in own.into_iter().flatten() {
                row_ends.push(grid.node(i, j, k));
            }
        }
        let outline = self.outline(&row_ends);
        GridSolid { level_set: LevelSet::new(grid, phi), coverage, outline }
    }

    /// Distance to the union of the parts along a row of nodes from `start`. From the planes themselves, not
    /// interpolated: the cracks meet exactly at the impact point.
    fn region_distances(&self, start: DVec3, scratch: &mut RowScratch) {
        let h = self.parent.level_set.grid().spacing;
        let last = (scratch.region.len() - 1) as f64;
        scratch.region.fill(f32::INFINITY);
        for part in &self.parts {
            // Planes at both ends of the row. The distance is nowhere below `least`, so that a plane which is not
            // above it at either end is never the farthest.
            scratch.ends.clear();
            let mut least = f64::NEG_INFINITY;
            for cut in &part.cuts {
                let at_start = cut.half_space.distance(start);
                let at_end = at_start + cut.half_space.normal.x * h * last;
                least = least.max(at_start.min(at_end));
                scratch.ends.push((at_start, at_end));
            }
            scratch.part.fill(least as f32);
            for (cut, &(at_start, at_end)) in part.cuts.iter().zip(&scratch.ends) {
                if at_start.max(at_end) > least {
                    let (at_start, step) = (at_start as f32, (cut.half_space.normal.x * h) as f32);
                    for (distance, &i) in scratch.part.iter_mut().zip(&scratch.numbers) {
                        *distance = larger(at_start + step * i, *distance);
                    }
                }
            }
            for (nearest, &distance) in scratch.region.iter_mut().zip(&scratch.part) {
                *nearest = if distance < *nearest { distance } else { *nearest };
            }
        }
    }

    /// Distances and coverage of a row that begins at `lattice`, counted in the parent's nodes. Returns the first and
    /// the last of the piece's own nodes.
    fn fill_row(
        &self,
        lattice: [i64; 3],
        region: &[f32],
        phi: &mut [f32],
        coverage: &mut [f32],
    ) -> Option<[usize; 2]> {
        let grid = self.parent.level_set.grid();
        let outside = (OUTSIDE * grid.spacing) as f32;

        // Beyond the parent's grid: the value at its nearest node and the way to it.
        let parent_phi = self.parent.level_set.phi();
        let nearest = |axis: usize, n: i64| n.clamp(0, grid.dims[axis] as i64 - 1);
        let [y, z] = [nearest(1, lattice[1]), nearest(2, lattice[2])];
        let [beyond_y, beyond_z] = [lattice[1] - y, lattice[2] - z];
        let parent_row = grid.index(0, y as usize, z as usize);
        let beyond = |i: usize| {
            let at = lattice[0] + i as i64;
            let x = nearest(0, at);
            let square = (at - x) * (at - x) + beyond_y * beyond_y + beyond_z * beyond_z;
            let way = (square as f64).sqrt() * grid.spacing;
            larger(larger(parent_phi[parent_row + x as usize] + way as f32, region[i]), outside)
        };
        let width = phi.len();
        let (first, end) = if beyond_y == 0 && beyond_z == 0 {
            // Pieces lie within the grid, so that part of the row does.
            ((-lattice[0]).max(0) as usize, (grid.dims[0] as i64 - lattice[0]).min(width as i64) as usize)
        } else {
            (0, 0)
        };
        for i in (0..first).chain(end..width) {
            phi[i] = beyond(i);
        }
        if first == end {
            return None;
        }

        // Within it.
        let start = (parent_row as i64 + lattice[0] + first as i64) as usize;
        let nodes = start..start + (end - first);
        let pieces = &self.piece_of_node[nodes.clone()];
        let inputs = parent_phi[nodes.clone()].iter().zip(&region[first..end]).zip(pieces);
        for (((&parent, &region), &piece), phi) in inputs.zip(&mut phi[first..end]) {
            let distance = larger(parent, region);
            // Own nodes are inside if they were inside of the parent. Nodes of others are not: of another component of
            // the same region, or of what a sliver was cut off from.
            let own = if parent <= 0.0 && distance > 0.0 { 0.0 } else { distance };
            let foreign = if distance > 0.0 { distance } else { larger(-distance, outside) };
            *phi = if piece == self.piece { own } else { foreign };
        }
        let materials = self.parent.coverage[nodes].iter().zip(pieces);
        for ((&material, &piece), coverage) in materials.zip(&mut coverage[first..end]) {
            *coverage = if piece == self.piece { material } else { 0.0 };
        }
        let first_own = pieces.iter().position(|&piece| piece == self.piece)?;
        let last_own = pieces.iter().rposition(|&piece| piece == self.piece)?;
        Some([first + first_own, first + last_own])
    }

    /// The parent's cuts and the region's own, as far as they come within a voxel of the piece's nodes. One that does
    /// not is the nearest surface to none of them. `row_ends` are the first and the last of the piece's nodes in each
    /// row: no other node is farther out along any direction.
    fn outline(&self, row_ends: &[DVec3]) -> Outline {
        let h = self.parent.level_set.grid().spacing;
        let bounds = |half_space: &HalfSpace| {
            let voxel = h * half_space.normal.abs().element_sum();
            row_ends.iter().any(|&node| half_space.distance(node) >= -voxel)
        };
        let inherited = self.parent.outline.cuts.iter();
        let new = self.parts.first().into_iter().flat_map(|region| &region.cuts).map(|cut| &cut.half_space);
        let cuts = inherited.chain(new).filter(|&half_space| bounds(half_space)).copied().collect();
        Outline { root: self.parent.outline.root.clone(), cuts }
    }
}
