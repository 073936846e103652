//! Where in its cell a sheet of a dual contour has its vertex.

use crate::contour_mesh::{Sheet, Vertex};
use crate::crossings::Crossing;
use crate::grid::Grid;
use crate::outline_pieces::OutlinePieces;
use crate::qef::Qef;
use glam::{DMat3, DVec3};

/// Noise in sampled normals bends a face by up to 35 degrees [JLSW02].
const SAMPLED_TRUNCATION: f64 = 0.1;

/// Maximum distance of a sampled vertex from the cell's middle, in cells: samples resolve no
/// sharper edges.
const SAMPLED_REACH: f64 = 0.55;

/// A corner of the outline that a vertex could be moved to.
#[derive(Clone, Copy)]
pub(crate) struct CornerClaim {
    vertex: usize,
    corner: DVec3,
    /// From the vertex to the corner [m].
    distance: f64,
}

/// Moves the nearest vertex to each corner: a tip can lie in a cell that has none of its faces on
/// an edge.
pub(crate) fn settle_corners(vertices: &mut [Vertex], mut claims: Vec<CornerClaim>, spacing: f64) {
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

/// Inputs of a vertex position.
pub(crate) struct Placement<'a> {
    pub(crate) grid: &'a Grid,
    pub(crate) pieces: &'a OutlinePieces<'a>,
    pub(crate) crossings: &'a [Crossing],
}

impl Placement<'_> {
    /// Point of a sheet on all surfaces that pass through it.
    pub(crate) fn vertex(&self, sheet: &Sheet) -> Vertex {
        let spacing = self.grid.spacing;
        let [i, j, k] = self.grid.coordinates(sheet.cell);
        let middle = self.grid.node(i, j, k) + DVec3::splat(0.5 * spacing);
        let crossings =
            || sheet.crossings[..sheet.count].iter().map(|&index| &self.crossings[index as usize]);

        // Formulas are touched again wherever the point moves; samples only at their crossings.
        let mut start = DVec3::ZERO;
        let mut normal = DVec3::ZERO;
        let mut normals = Qef::ZERO;
        let mut sampled = Qef::ZERO;
        let mut formulas: Vec<usize> = Vec::with_capacity(4);
        for crossing in crossings() {
            let point = (crossing.point - middle) / spacing;
            start += point / sheet.count as f64;
            normal += crossing.normal;
            normals.add_plane(point, crossing.normal);
            match crossing.piece.filter(|&piece| self.pieces.is_formula(piece)) {
                Some(piece) if formulas.contains(&piece) => {}
                Some(piece) => formulas.push(piece),
                None => sampled.add_plane(point, crossing.normal),
            }
        }

        // Without formulas the samples alone decide; else they decide where on the formulas the
        // point lies.
        let only_formulas = sampled.is_empty();
        let mut point = start;
        if formulas.is_empty() {
            point = sampled.minimize(start, SAMPLED_TRUNCATION, SAMPLED_REACH);
            formulas.extend(self.cut_off_by(sheet, middle + point * spacing, &formulas));
        }
        while !formulas.is_empty() {
            let exact = self.meet_formulas(sheet, middle, start, &mut formulas);
            point = self.meet_samples(sheet, middle, exact, &sampled);
            let Some(piece) = self.cut_off_by(sheet, middle + point * spacing, &formulas) else {
                break;
            };
            formulas.push(piece);
        }

        let position = middle + point * spacing;
        let mut sharpness = self.pieces_meeting(position);
        if !only_formulas {
            sharpness = sharpness.max(normals.rank(SAMPLED_TRUNCATION));
        }
        let normal = normal.try_normalize().unwrap_or(DVec3::Y);
        let in_outline = crossings().all(|crossing| crossing.piece.is_some());
        Vertex { position, normal, sharpness: sharpness.clamp(1, 3) as u8, in_outline }
    }

    /// Point nearest to `start` (in cells from the cell's middle) on all formulas and on formulas
    /// that cut it off, with the remaining free directions.
    fn meet_formulas(
        &self,
        sheet: &Sheet,
        middle: DVec3,
        start: DVec3,
        formulas: &mut Vec<usize>,
    ) -> (DVec3, DMat3) {
        // Formulas have an edge from 1 degree on. The tip of a wedge can pass between the nodes,
        // and end some cells further.
        const TRUNCATION: f64 = 1e-4;
        const REACH: f64 = 2.0;
        const MAX_ROUNDS: usize = 8;
        let spacing = self.grid.spacing;
        let mut point = start;
        let mut planes = Qef::ZERO;
        for _ in 0..MAX_ROUNDS {
            planes = Qef::ZERO;
            for &piece in &*formulas {
                let at = middle + point * spacing;
                let n = self.pieces.normal(piece, at);
                planes.add_plane(point - n * (self.pieces.value(piece, at) / spacing), n);
            }
            let next = planes.minimize(start, TRUNCATION, REACH);
            let moved = (next - point).length();
            point = next;
            if let Some(piece) = self.cut_off_by(sheet, middle + point * spacing, formulas) {
                formulas.push(piece);
            } else if moved < 1e-9 || formulas.iter().all(|&piece| self.pieces.is_plane(piece)) {
                break;
            }
        }
        (point, planes.free_directions(TRUNCATION))
    }

    /// Moves a point along `free` to where the samples have their surface, if that passes through
    /// the sheet.
    fn meet_samples(
        &self,
        sheet: &Sheet,
        middle: DVec3,
        (foot, free): (DVec3, DMat3),
        sampled: &Qef,
    ) -> DVec3 {
        // In cells: by how much samples round off a crease, and how far they lead out of the cell.
        const ROUNDED: f64 = 0.35;
        const CREASE_REACH: f64 = 0.8;
        let value = |root, point: DVec3| {
            self.pieces.value(root, middle + point * self.grid.spacing) / self.grid.spacing
        };
        let pieces = || {
            sheet.crossings[..sheet.count].iter().map(|&index| self.crossings[index as usize].piece)
        };
        let mut crossed = pieces().flatten().filter(|&piece| !self.pieces.is_formula(piece));
        let root = crossed.next().or_else(|| self.pieces.sampled());
        let is_one =
            crossed.all(|piece| Some(piece) == root) && pieces().all(|piece| piece.is_some());
        let Some(root) = root.filter(|_| is_one) else {
            return sampled.minimize_along(&free, foot, SAMPLED_TRUNCATION, CREASE_REACH);
        };
        if sampled.is_empty() && value(root, foot) < 0.02 {
            return foot;
        }
        if sampled.rank(SAMPLED_TRUNCATION) > 1 {
            let crease = sampled.minimize_along(&free, foot, SAMPLED_TRUNCATION, CREASE_REACH);
            if value(root, crease).abs() < ROUNDED {
                return crease;
            }
        }

        // On a smooth face by Newton's method; where that leads nowhere, the best point on the way.
        const MAX_STEPS: usize = 6;
        const LONGEST_STEP: f64 = 0.5;
        const REACH: f64 = 3.0;
        // Squared sine of the angle from which on a face and a formula have an edge.
        const LEAST_SLOPE: f64 = 0.01;
        let mut point = foot;
        let mut best = (f64::INFINITY, foot);
        for _ in 0..MAX_STEPS {
            let value = value(root, point);
            if value.abs() < best.0 {
                best = (value.abs(), point);
            }
            let slope = free * self.pieces.normal(root, middle + point * self.grid.spacing);
            if value.abs() < 1e-3 || slope.length_squared() < LEAST_SLOPE {
                break;
            }
            point -= (slope * (value / slope.length_squared())).clamp_length_max(LONGEST_STEP);
            if point.abs().max_element() > REACH {
                break;
            }
        }
        best.1
    }

    /// The corners of the outline around a vertex: points of the solid where three of its formulas
    /// meet.
    pub(crate) fn corners_near(
        &self,
        sheet: &Sheet,
        vertex: usize,
        position: DVec3,
    ) -> Vec<CornerClaim> {
        let reach = 1.2 * self.grid.spacing;
        let near: Vec<usize> = (0..self.pieces.len())
            .filter(|&piece| {
                self.pieces.is_formula(piece) && self.pieces.value(piece, position).abs() < reach
            })
            .collect();
        if near.len() < 3 {
            return Vec::new();
        }
        let near: Vec<usize> =
            near.into_iter().filter(|&piece| self.bounds_cell(sheet, piece)).collect();
        let mut claims = Vec::new();
        for (a, &first) in near.iter().enumerate() {
            for (b, &second) in near.iter().enumerate().skip(a + 1) {
                for &third in &near[b + 1..] {
                    let Some(corner) = self.meeting_point([first, second, third], position) else {
                        continue;
                    };
                    let distance = corner.distance(position);
                    let on_solid = self.pieces.max_value(corner).is_some_and(|(value, piece)| {
                        value
                            < if self.pieces.is_formula(piece) { 1e-6 } else { 0.05 }
                                * self.grid.spacing
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

    /// The formula with the largest distance outside of a sheet's point, not in `known`, among
    /// formulas that bound the solid here.
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

    /// True if all inside corners of a cell are inside a piece; merged slivers from beyond break
    /// this.
    fn bounds_cell(&self, sheet: &Sheet, piece: usize) -> bool {
        let [i, j, k] = self.grid.coordinates(sheet.cell);
        (0..8).filter(|corner| sheet.inside >> corner & 1 == 1).all(|corner| {
            let node = self.grid.node(i + (corner & 1), j + (corner >> 1 & 1), k + (corner >> 2));
            self.pieces.value(piece, node) < 1e-3 * self.grid.spacing
        })
    }

    /// Number of different surfaces at a point.
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
