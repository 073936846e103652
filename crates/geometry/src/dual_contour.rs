//! Dual contouring [JLSW02]: one vertex for each sheet of the surface in a cell, one quad for each crossed edge.
//!
//! Two sheets of a cell get two vertices, and where the surface could pass a face in two ways, the way is chosen so that
//! each edge of the mesh belongs to two quads exactly [SJW07: Schaefer, Ju & Warren 2007, Manifold dual contouring].

use crate::crossings::{Crossing, PaddedSigns, find_crossings};
use crate::outline_pieces::OutlinePieces;
use crate::qef::Qef;
use crate::sheets::{is_ambiguous, passes_twice, sheets};
use crate::symmetric::symmetric_eigen;
use crate::{Grid, GridSolid};
use glam::{DMat3, DVec3};
use rayon::prelude::*;

/// Vertices and quads of a solid's surface, in the grid frame.
pub(crate) struct DualContour<'a> {
    pub(crate) pieces: OutlinePieces<'a>,
    pub(crate) vertices: Vec<Vertex>,
    pub(crate) quads: Vec<Quad>,
}

/// A point on the surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Vertex {
    /// [m]
    pub(crate) position: DVec3,
    /// Unit: the mean of the normals around.
    pub(crate) normal: DVec3,
    /// 1 on a smooth face, 2 on an edge, 3 at a corner.
    pub(crate) sharpness: u8,
    /// Whether the outline knows all of the surface around.
    pub(crate) in_outline: bool,
}

/// Around a crossed edge.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Quad {
    /// Vertices, counter-clockwise seen from outside.
    pub(crate) vertices: [u32; 4],
    /// Unit normal at the crossing.
    pub(crate) normal: DVec3,
    /// The piece of the outline that is crossed.
    pub(crate) piece: Option<usize>,
}

/// The part of the surface in one cell that is connected there.
#[derive(Clone, Copy)]
struct Sheet {
    /// Index of the cell's lowest node.
    cell: usize,
    /// Bit for each corner that is inside.
    inside: u8,
    /// Indices of its crossings.
    crossings: [u32; 12],
    count: usize,
}

/// The cells that the surface passes through.
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
        let corner_offsets: [usize; 8] =
            std::array::from_fn(|c| (c & 1) * strides[0] + (c >> 1 & 1) * strides[1] + (c >> 2) * strides[2]);
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

    /// For each cell the faces whose outside corners are kept apart: those that would else be passed twice by one sheet
    /// of either cell, so that four quads would meet in an edge.
    fn joined_faces(&self, strides: [usize; 3]) -> Vec<u8> {
        let mut joined = vec![0u8; self.cells.len()];
        for here in 0..self.cells.len() {
            let (cell, inside) = self.cells[here];
            for axis in 0..3 {
                let (high, low) = (2 * axis + 1, 2 * axis);
                if !is_ambiguous(inside, high) {
                    continue;
                }
                // The layer outside of the grid has no ambiguous faces, so that there is a cell behind this one.
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
        let signs = PaddedSigns::new(&solid.level_set);
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
            let (second, third) = (strides[(crossing.axis + 1) % 3], strides[(crossing.axis + 2) % 3]);
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
        let mut vertices: Vec<Vertex> = all_sheets.par_iter().map(|sheet| placement.vertex(sheet)).collect();
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

/// A corner of the outline that a vertex could be moved to.
#[derive(Clone, Copy)]
struct CornerClaim {
    vertex: usize,
    corner: DVec3,
    /// From the vertex to the corner [m].
    distance: f64,
}

/// Moves the nearest vertex to each corner: a tip can lie in a cell that has none of its faces on an edge.
fn settle_corners(vertices: &mut [Vertex], mut claims: Vec<CornerClaim>, spacing: f64) {
    claims.sort_by(|a, b| a.distance.total_cmp(&b.distance).then(a.vertex.cmp(&b.vertex)));
    let mut settled: Vec<CornerClaim> = Vec::new();
    for claim in claims {
        let taken = |other: &CornerClaim| {
            other.vertex == claim.vertex || other.corner.distance(claim.corner) < 1e-3 * spacing
        };
        if !settled.iter().any(taken) {
            vertices[claim.vertex].position = claim.corner;
            vertices[claim.vertex].sharpness = 3;
            settled.push(claim);
        }
    }
}

/// What a vertex's place follows from.
struct Placement<'a> {
    grid: &'a Grid,
    pieces: &'a OutlinePieces<'a>,
    crossings: &'a [Crossing],
}

impl Placement<'_> {
    /// The point of a sheet that lies on all surfaces that pass through it.
    fn vertex(&self, sheet: &Sheet) -> Vertex {
        let spacing = self.grid.spacing;
        let [i, j, k] = self.grid.coordinates(sheet.cell);
        let middle = self.grid.node(i, j, k) + DVec3::splat(0.5 * spacing);
        let crossings =
            || sheet.crossings[..sheet.count].iter().map(|&index| &self.crossings[index as usize]);

        // Formulas are touched again wherever the point moves; samples only at their crossings.
        let mut start = DVec3::ZERO;
        let mut normal = DVec3::ZERO;
        let mut sampled = Qef::ZERO;
        let mut formulas: Vec<usize> = Vec::with_capacity(4);
        let mut normals = DMat3::ZERO;
        let mut only_formulas = true;
        for crossing in crossings() {
            let point = (crossing.point - middle) / spacing;
            start += point / sheet.count as f64;
            normal += crossing.normal;
            let n = crossing.normal;
            normals += DMat3::from_cols(n * n.x, n * n.y, n * n.z);
            match crossing.piece.filter(|&piece| self.pieces.is_formula(piece)) {
                Some(piece) if formulas.contains(&piece) => {}
                Some(piece) => formulas.push(piece),
                None => {
                    only_formulas = false;
                    sampled.add_plane(point, n);
                }
            }
        }

        // Noise in sampled normals bends a face by up to 35 degrees [JLSW02 use 0.1]; formulas have an edge from 1 on.
        // The tip of a wedge can pass between the nodes, and end some cells further.
        let (truncation, reach) = if only_formulas { (1e-4, 2.0) } else { (0.1, 0.55) };
        const MAX_ROUNDS: usize = 8;
        let mut point = start;
        for _ in 0..MAX_ROUNDS {
            let mut qef = sampled;
            for &piece in &formulas {
                let at = middle + point * spacing;
                let n = self.pieces.normal(piece, at);
                qef.add_plane(point - n * (self.pieces.value(piece, at) / spacing), n);
            }
            let next = qef.minimize(start, truncation, reach);
            let moved = (next - point).length();
            point = next;
            if let Some(piece) = self.cut_off_by(sheet, middle + point * spacing, &formulas) {
                formulas.push(piece);
            } else if moved < 1e-9 || formulas.iter().all(|&piece| self.pieces.is_plane(piece)) {
                break;
            }
        }

        let position = middle + point * spacing;
        let mut sharpness = self.pieces_meeting(position);
        if !only_formulas {
            let (eigenvalues, _) = symmetric_eigen(&normals);
            let strong = eigenvalues
                .to_array()
                .iter()
                .filter(|&&l| l > truncation * eigenvalues.max_element())
                .count();
            sharpness = sharpness.max(strong);
        }
        let normal = normal.try_normalize().unwrap_or(DVec3::Y);
        let in_outline = crossings().all(|crossing| crossing.piece.is_some());
        Vertex { position, normal, sharpness: sharpness.clamp(1, 3) as u8, in_outline }
    }

    /// The corners of the outline around a vertex: points of the solid where three of its formulas meet.
    fn corners_near(&self, sheet: &Sheet, vertex: usize, position: DVec3) -> Vec<CornerClaim> {
        let reach = 1.2 * self.grid.spacing;
        let near: Vec<usize> = (0..self.pieces.len())
            .filter(|&piece| {
                self.pieces.is_formula(piece) && self.pieces.value(piece, position).abs() < reach
            })
            .collect();
        if near.len() < 3 {
            return Vec::new();
        }
        let near: Vec<usize> = near.into_iter().filter(|&piece| self.bounds_cell(sheet, piece)).collect();
        let mut claims = Vec::new();
        for (a, &first) in near.iter().enumerate() {
            for (b, &second) in near.iter().enumerate().skip(a + 1) {
                for &third in &near[b + 1..] {
                    let Some(corner) = self.meeting_point([first, second, third], position) else { continue };
                    let distance = corner.distance(position);
                    let on_solid = self.pieces.max_value(corner).is_some_and(|(value, piece)| {
                        value < if self.pieces.is_formula(piece) { 1e-6 } else { 0.05 } * self.grid.spacing
                    });
                    if distance < reach && on_solid {
                        claims.push(CornerClaim { vertex, corner, distance });
                    }
                }
            }
        }
        claims
    }

    /// Where three formulas are zero, by Newton's method.
    fn meeting_point(&self, three: [usize; 3], start: DVec3) -> Option<DVec3> {
        const MAX_ROUNDS: usize = 8;
        // Faces that meet at less than a few degrees have no corner worth a vertex.
        const LEAST_DETERMINANT: f64 = 0.02;
        let mut point = start;
        for _ in 0..MAX_ROUNDS {
            let normals = three.map(|piece| self.pieces.normal(piece, point));
            let values = DVec3::from_array(three.map(|piece| self.pieces.value(piece, point)));
            let rows = DMat3::from_cols(normals[0], normals[1], normals[2]).transpose();
            if rows.determinant().abs() < LEAST_DETERMINANT {
                return None;
            }
            if values.abs().max_element() < 1e-9 * self.grid.spacing {
                return Some(point);
            }
            point -= rows.inverse() * values;
        }
        None
    }

    /// The formula that a point of a sheet lies furthest outside of, not one of `known`, and one that bounds the solid
    /// here.
    fn cut_off_by(&self, sheet: &Sheet, point: DVec3, known: &[usize]) -> Option<usize> {
        let spacing = self.grid.spacing;
        (0..self.pieces.len())
            .filter(|piece| self.pieces.is_formula(*piece) && !known.contains(piece))
            .map(|piece| (self.pieces.value(piece, point), piece))
            .filter(|(value, _)| *value > 1e-6 * spacing)
            .max_by(|a, b| a.0.total_cmp(&b.0))
            .filter(|&(_, piece)| self.bounds_cell(sheet, piece))
            .map(|(_, piece)| piece)
    }

    /// Whether all inside corners of a cell are inside of a piece; not so where a sliver from beyond it was merged.
    fn bounds_cell(&self, sheet: &Sheet, piece: usize) -> bool {
        let [i, j, k] = self.grid.coordinates(sheet.cell);
        (0..8).filter(|corner| sheet.inside >> corner & 1 == 1).all(|corner| {
            let node = self.grid.node(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
            self.pieces.value(piece, node) < 1e-3 * self.grid.spacing
        })
    }

    /// How many different surfaces a point lies on.
    fn pieces_meeting(&self, point: DVec3) -> usize {
        let mut normals: Vec<DVec3> = Vec::with_capacity(3);
        for piece in (0..self.pieces.len()).filter(|&piece| self.pieces.is_formula(piece)) {
            if self.pieces.value(piece, point).abs() < 1e-3 * self.grid.spacing {
                let normal = self.pieces.normal(piece, point);
                if normals.iter().all(|other| other.dot(normal).abs() < 0.98) {
                    normals.push(normal);
                }
            }
        }
        normals.len()
    }
}
