//! Dual contouring [JLSW02]: one vertex for each sheet of the surface in a cell, one quad for each
//! crossed edge.
//!
//! Two sheets of a cell get two vertices, and where the surface could pass a face in two ways, the
//! way is chosen so that each edge of the mesh belongs to two quads exactly [SJW07: Schaefer, Ju &
//! Warren 2007, Manifold dual contouring].

use crate::contour_mesh::Quad;
use crate::contour_mesh::Sheet;
use crate::contour_mesh::Vertex;
use crate::crossings::{PaddedSigns, find_crossings};
use crate::grid::Grid;
use crate::grid_solid::GridSolid;
use crate::outline_pieces::OutlinePieces;
use crate::sheets::{is_ambiguous, passes_twice, sheets};
use crate::vertex_placement::{CornerClaim, Placement, settle_corners};
use rayon::prelude::*;

/// Vertices and quads of a solid's surface, in the grid frame.
pub(crate) struct DualContour<'a> {
    pub(crate) pieces: OutlinePieces<'a>,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) quads: Vec<Quad>,
}

/// Cells crossed by the surface.
struct ActiveCells {
    /// Lowest node and inside corners of each.
    cells: Vec<(usize, u8)>,
    /// Place in `cells` of each node's cell, [`ActiveCells::NONE`] if it has no surface.
    place: Vec<u32>,
}

impl ActiveCells {
    const NONE: u32 = u32::MAX;

    fn of(grid: &Grid, inside: &[bool]) -> Self {
        let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
        let corner_offsets: [usize; 8] = std::array::from_fn(|c| {
            (c & 1) * strides[0] + (c >> 1 & 1) * strides[1] + (c >> 2) * strides[2]
        });
        let mut active = Self { cells: Vec::new(), place: vec![Self::NONE; grid.len()] };
        for k in 0..grid.dims[2] - 1 {
            for j in 0..grid.dims[1] - 1 {
                for i in 0..grid.dims[0] - 1 {
                    let cell = grid.index(i, j, k);
                    let mut corners = 0u8;
                    for (c, offset) in corner_offsets.iter().enumerate() {
                        corners |= u8::from(inside[cell + offset]) << c;
                    }
                    if corners != 0 && corners != u8::MAX {
                        active.place[cell] = active.cells.len() as u32;
                        active.cells.push((cell, corners));
                    }
                }
            }
        }
        active
    }

    /// Per cell, faces with separate outside corners: otherwise a sheet would pass such a face
    /// twice, and four quads would meet in an edge.
    fn joined_faces(&self, strides: [usize; 3]) -> Vec<u8> {
        let mut joined = vec![0u8; self.cells.len()];
        for here in 0..self.cells.len() {
            let (cell, inside) = self.cells[here];
            for axis in 0..3 {
                let (high, low) = (2 * axis + 1, 2 * axis);
                if !is_ambiguous(inside, high) {
                    continue;
                }
                // The layer outside of the grid has no ambiguous faces, so that there is a cell
                // behind this one.
                let there = self.place[cell + strides[axis]] as usize;
                let twice_there = passes_twice(self.cells[there].1, joined[there], low);
                if twice_there && passes_twice(inside, joined[here], high) {
                    joined[here] |= 1 << high;
                    joined[there] |= 1 << low;
                }
            }
        }
        joined
    }
}

impl<'a> DualContour<'a> {
    pub(crate) fn new(solid: &'a GridSolid) -> Self {
        // Where the surface passes.
        let pieces = OutlinePieces::of(solid);
        let signs = PaddedSigns::new(solid.level_set());
        let grid = signs.grid;
        let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
        let inside = signs.inside();
        let crossings = find_crossings(solid, &signs, &inside, &pieces);
        let active = ActiveCells::of(&grid, &inside);
        let joined = active.joined_faces(strides);

        // Number the sheets of all cells.
        let mut all_sheets = Vec::with_capacity(active.cells.len());
        let mut sheets_of_cell = Vec::with_capacity(active.cells.len());
        for (&(cell, corners), &joined) in active.cells.iter().zip(&joined) {
            let (sheet_of_edge, count) = sheets(corners, joined);
            sheets_of_cell.push((all_sheets.len() as u32, sheet_of_edge));
            let empty = Sheet { cell, inside: corners, crossings: [0; 12], count: 0 };
            all_sheets.extend(std::iter::repeat_n(empty, usize::from(count)));
        }

        // A quad joins the sheets of the four cells around an edge.
        let mut quads = Vec::with_capacity(crossings.len());
        for (index, crossing) in crossings.iter().enumerate() {
            let (second, third) =
                (strides[(crossing.axis + 1) % 3], strides[(crossing.axis + 2) % 3]);
            let around = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(p, q)| {
                let cell = active.place[crossing.node - p * second - q * third] as usize;
                let (first, sheet_of_edge) = sheets_of_cell[cell];
                let vertex = first + u32::from(sheet_of_edge[4 * crossing.axis + p + 2 * q]);
                let sheet = &mut all_sheets[vertex as usize];
                sheet.crossings[sheet.count] = index as u32;
                sheet.count += 1;
                vertex
            });
            let [a, b, c, d] = around;
            let vertices = if crossing.outward { [a, b, c, d] } else { [d, c, b, a] };
            quads.push(Quad { vertices, normal: crossing.normal, piece: crossing.piece });
        }

        // Place the vertices, and make sure that each corner of the outline has one.
        let placement = Placement { grid: &grid, pieces: &pieces, crossings: &crossings };
        let mut vertices: Vec<Vertex> =
            all_sheets.par_iter().map(|sheet| placement.vertex(sheet)).collect();
        let claims: Vec<Vec<CornerClaim>> = all_sheets
            .par_iter()
            .zip(&vertices)
            .enumerate()
            .map(|(index, (sheet, vertex))| placement.corners_near(sheet, index, vertex.position))
            .collect();
        settle_corners(&mut vertices, claims.concat(), grid.spacing);
        Self { pieces, vertices, quads }
    }
}
