//! A solid cut by many convex cells at once.

use super::Solid;
use super::clip::{Clipper, Left, Loose};
use super::elements::{Face, FaceOrigin};
use super::parts::{SolidPart, connected_parts};
use crate::half_space::HalfSpace;
use frangible_math::cancel;
use glam::DVec3;

/// Vertices this close to a plane, relative to the solid's longest side, lie on it.
pub(crate) const ON_THE_CUT: f64 = 1e-12;

/// Parts of less than this fraction of the solid's volume are round-off.
const NO_VOLUME: f64 = 1e-13;

/// The box around cells is wider by this part of the solid's longest side: its faces touch none.
const CLEAR: f64 = 1e-6;

/// A solid of so few edges is cut by each cell without a tree. Between 32 and 256 the time for 60
/// cells of 1,150 triangles changes by less than a tenth.
const FEW_EDGES: usize = 96;

/// A convex cell: what lies inside of all its planes.
#[derive(Clone, Debug)]
pub struct Cell {
    /// Those that reach the solid.
    pub planes: Vec<HalfSpace>,
    /// A box that holds what it has of the solid [m].
    pub bounds: (DVec3, DVec3),
}

impl Solid {
    /// The connected parts of the solid in each cell, with the cell's number, cell by cell. Exact:
    /// vertices that no plane cuts off stay as they are, and parts of cells that fill space fill the
    /// solid.
    pub fn cut(&self, cells: &[Cell]) -> Vec<(usize, SolidPart)> {
        let (low, high) = self.bounds();
        let size = (high - low).max_element();
        let volume = self.mass_properties().volume;
        let mut cutter = Cutter {
            faces: &self.faces,
            planes: Vec::new(),
            cells,
            size,
            least: NO_VOLUME * volume,
            clipper: Clipper::default(),
            parts: Vec::new(),
        };
        let whole = Loose { vertices: self.vertices.clone(), edges: self.edges.clone() };
        cutter.cut(&whole, (low, high), &mut (0..cells.len()).collect::<Vec<_>>());
        let mut parts = cutter.parts;
        parts.sort_by_key(|part| part.0);
        parts
    }

    /// The connected parts of the solid inside of planes.
    pub fn inside_of(&self, planes: &[HalfSpace]) -> Vec<SolidPart> {
        let cell = Cell { planes: planes.to_vec(), bounds: self.bounds() };
        self.cut(&[cell]).into_iter().map(|(_, part)| part).collect()
    }
}

struct Cutter<'a> {
    /// Of the solid; the numbers of caps are those behind.
    faces: &'a [Face],
    /// Of the caps.
    planes: Vec<HalfSpace>,
    cells: &'a [Cell],
    /// Longest side of the solid [m].
    size: f64,
    /// [m^3]
    least: f64,
    clipper: Clipper,
    parts: Vec<(usize, SolidPart)>,
}

impl Cutter<'_> {
    /// Cuts what a box around some cells holds of the solid: cell by cell, or after it was halved.
    /// The caps of boxes lie outside of their cells, which cut them off again.
    fn cut(&mut self, loose: &Loose, bounds: (DVec3, DVec3), cells: &mut [usize]) {
        if cells.len() < 2 || loose.edges.len() <= FEW_EDGES {
            for &mut cell in cells {
                self.cut_cell(loose, cell);
            }
            return;
        }
        let middle = |cell: usize| {
            let (low, high) = self.cells[cell].bounds;
            0.5 * (low + high)
        };
        let none = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (low, high) = cells
            .iter()
            .fold(none, |(low, high), &cell| (low.min(middle(cell)), high.max(middle(cell))));
        let axis = (high - low).max_position();
        cells.sort_by(|&a, &b| middle(a)[axis].total_cmp(&middle(b)[axis]).then(a.cmp(&b)));
        let half = cells.len() / 2;
        let (first, second) = cells.split_at_mut(half);
        for own in [first, second] {
            let (low, high) = own.iter().fold(none, |(low, high), &cell| {
                let bounds = self.cells[cell].bounds;
                (low.min(bounds.0), high.max(bounds.1))
            });
            let clear = CLEAR * self.size;
            let own_bounds = (low - clear, high + clear);
            let planes: Vec<HalfSpace> = box_planes(own_bounds, bounds).collect();
            if planes.is_empty() {
                self.cut(loose, bounds, own);
            } else if let Some(inside) = self.clipped(loose, &planes) {
                self.cut(&inside, own_bounds, own);
            }
            self.planes.truncate(self.planes.len() - planes.len());
        }
    }

    fn cut_cell(&mut self, loose: &Loose, cell: usize) {
        cancel::check();
        let planes = &self.cells[cell].planes;
        if let Some(inside) = self.clipped(loose, planes) {
            let (faces, caps) = (self.faces, &self.planes);
            let face = |number: u32| match faces.get(number as usize) {
                Some(face) => *face,
                None => {
                    Face { plane: caps[number as usize - faces.len()], origin: FaceOrigin::Crack }
                }
            };
            let parts = connected_parts(inside, self.least, face);
            self.parts.extend(parts.into_iter().map(|part| (cell, part)));
        }
        self.planes.truncate(self.planes.len() - planes.len());
    }

    /// The part inside of planes, whose caps have numbers from then on; `None` if there is none.
    fn clipped(&mut self, loose: &Loose, planes: &[HalfSpace]) -> Option<Loose> {
        let first = self.planes.len();
        self.planes.extend(planes);
        let (faces, caps) = (self.faces, &self.planes);
        let normal_of = |number: u32| match faces.get(number as usize) {
            Some(face) => face.plane.normal,
            None => caps[number as usize - faces.len()].normal,
        };
        let close = ON_THE_CUT * self.size;
        let [mut now, mut next] = [Loose::default(), Loose::default()];
        let mut is_whole = true;
        for (plane, cap) in planes.iter().zip(faces.len() + first..) {
            let from = if is_whole { loose } else { &now };
            match self.clipper.clip(from, plane, (cap as u32, close), normal_of, &mut next) {
                Left::All => continue,
                Left::Nothing => return None,
                Left::Some => std::mem::swap(&mut now, &mut next),
            }
            is_whole = false;
        }
        Some(if is_whole { loose.clone() } else { now })
    }
}

/// The faces of a box that lie within another one.
fn box_planes(
    (low, high): (DVec3, DVec3),
    around: (DVec3, DVec3),
) -> impl Iterator<Item = HalfSpace> {
    (0..3).flat_map(move |axis| {
        let normal = DVec3::AXES[axis];
        let below = HalfSpace { normal, offset: high[axis] };
        let above = HalfSpace { normal: -normal, offset: -low[axis] };
        [(high[axis] < around.1[axis], below), (low[axis] > around.0[axis], above)]
            .into_iter()
            .filter_map(|(cuts, plane)| cuts.then_some(plane))
    })
}
