//! The smooth surfaces that a solid's outline is made of.

use crate::closed_form::ClosedForm;
use crate::grid::Grid;
use crate::grid_solid::{GridSolid, Root};
use crate::half_space::HalfSpace;
use crate::level_set::LevelSet;
use crate::sampled_normal::sampled_normal;
use glam::{DVec2, DVec3};

/// A smooth surface; the solid lies on the negative side of all of them.
enum Piece<'a> {
    Plane(HalfSpace),
    Sphere {
        radius: f64,
    },
    /// The side of a cylinder around the y axis.
    Side {
        radius: f64,
    },
    /// A capsule.
    Capsule(ClosedForm),
    /// The side of a cone around the y axis: its radius at the origin, and its normal away from the
    /// axis and along it.
    Cone {
        radius: f64,
        side: DVec2,
    },
    /// A level set's zero; smooth only between its own sharp features.
    Sampled(&'a LevelSet),
}

/// The pieces of an outline that can be met within a grid.
pub(crate) struct OutlinePieces<'a> {
    pieces: Vec<Piece<'a>>,
    /// Number of pieces from the root; the others come from cuts.
    of_root: usize,
}

impl<'a> OutlinePieces<'a> {
    pub(crate) fn of(solid: &'a GridSolid) -> Self {
        let mut pieces = match &solid.outline.root {
            Root::Sampled(level_set) => vec![Piece::Sampled(level_set)],
            Root::ClosedForm(form) => pieces_of(form),
            Root::Hull(hull) => hull.planes().iter().map(|&plane| Piece::Plane(plane)).collect(),
        };
        let grid = solid.grid();
        pieces.retain(|piece| piece.reaches(grid));
        let of_root = pieces.len();
        let cuts = solid
            .outline
            .cuts
            .iter()
            .map(|&cut| Piece::Plane(cut))
            .filter(|piece| piece.reaches(grid));
        let cracks: Vec<Piece> = cuts.filter(|cut| parts_nodes(grid, &pieces, cut)).collect();
        pieces.extend(cracks);
        pieces.extend(solid.outline.rough.iter().map(|cell| Piece::Sampled(cell)));
        Self { pieces, of_root }
    }

    pub(crate) fn len(&self) -> usize {
        self.pieces.len()
    }

    /// True for pieces from cracks.
    pub(crate) fn is_cut(&self, piece: usize) -> bool {
        piece >= self.of_root
    }

    /// True with any crack.
    pub(crate) fn has_cuts(&self) -> bool {
        self.of_root < self.pieces.len()
    }

    /// The piece of the root that is known from samples only.
    pub(crate) fn sampled(&self) -> Option<usize> {
        (0..self.of_root).find(|&piece| !self.is_formula(piece))
    }

    /// True for formulas, known at every point, unlike samples.
    pub(crate) fn is_formula(&self, piece: usize) -> bool {
        !matches!(self.pieces[piece], Piece::Sampled(_))
    }

    /// True for planes.
    pub(crate) fn is_plane(&self, piece: usize) -> bool {
        matches!(self.pieces[piece], Piece::Plane(_))
    }

    /// Signed distance to one piece [m].
    pub(crate) fn value(&self, piece: usize, point: DVec3) -> f64 {
        self.pieces[piece].value(point)
    }

    /// Unit normal of one piece at a point.
    pub(crate) fn normal(&self, piece: usize, point: DVec3) -> DVec3 {
        self.pieces[piece].normal(point)
    }

    /// Signed distance to the solid [m] near its surface, and the piece that decides it.
    pub(crate) fn max_value(&self, point: DVec3) -> Option<(f64, usize)> {
        let mut largest: Option<(f64, usize)> = None;
        for (n, piece) in self.pieces.iter().enumerate() {
            let value = piece.value(point);
            if largest.is_none_or(|(best, _)| value > best) {
                largest = Some((value, n));
            }
        }
        largest
    }
}

/// True if any node of the body before it broke lies beyond a cut. If not, what the cut parted from
/// the solid is thinner than a voxel, and is the solid's own: no crack ends it there.
fn parts_nodes(grid: &Grid, root: &[Piece], cut: &Piece) -> bool {
    let [nx, ny, nz] = grid.dims;
    let nodes = (0..nz).flat_map(|k| (0..ny).flat_map(move |j| (0..nx).map(move |i| [i, j, k])));
    let mut points = nodes.map(|[i, j, k]| grid.node(i, j, k));
    points.any(|point| cut.value(point) > 0.0 && root.iter().all(|piece| piece.value(point) < 0.0))
}

/// The faces of a closed form.
fn pieces_of(form: &ClosedForm) -> Vec<Piece<'static>> {
    let face = |normal: DVec3, offset: f64| Piece::Plane(HalfSpace { normal, offset });
    match *form {
        ClosedForm::HalfSpace(half_space) => vec![Piece::Plane(half_space)],
        ClosedForm::Sphere { radius } => vec![Piece::Sphere { radius }],
        ClosedForm::Box { half } => DVec3::AXES
            .into_iter()
            .zip(half.to_array())
            .flat_map(|(axis, half)| [face(axis, half), face(-axis, half)])
            .collect(),
        ClosedForm::Cylinder { radius, half_height } => {
            vec![
                Piece::Side { radius },
                face(DVec3::Y, half_height),
                face(DVec3::NEG_Y, half_height),
            ]
        }
        ClosedForm::Capsule { .. } => vec![Piece::Capsule(*form)],
        ClosedForm::Cone { radius, height } => {
            let side = DVec2::new(height, radius).normalize();
            let at_origin = 0.75 * radius;
            vec![Piece::Cone { radius: at_origin, side }, face(DVec3::NEG_Y, 0.25 * height)]
        }
    }
}

impl Piece<'_> {
    fn value(&self, point: DVec3) -> f64 {
        match self {
            Self::Plane(plane) => plane.distance(point),
            Self::Sphere { radius } => point.length() - radius,
            Self::Side { radius } => (point.x * point.x + point.z * point.z).sqrt() - radius,
            Self::Capsule(form) => form.distance(point),
            Self::Cone { radius, side } => {
                let from_axis = (point.x * point.x + point.z * point.z).sqrt();
                side.dot(DVec2::new(from_axis - radius, point.y))
            }
            Self::Sampled(level_set) => f64::from(level_set.value(point)),
        }
    }

    fn normal(&self, point: DVec3) -> DVec3 {
        let direction = match self {
            Self::Plane(plane) => return plane.normal,
            Self::Sphere { .. } => point,
            Self::Side { .. } => DVec3::new(point.x, 0.0, point.z),
            Self::Capsule(form) => return form.distance_and_gradient(point).1,
            Self::Cone { side, .. } => {
                let outward = DVec3::new(point.x, 0.0, point.z).normalize_or(DVec3::X);
                return side.x * outward + side.y * DVec3::Y;
            }
            Self::Sampled(level_set) => {
                return sampled_normal(level_set, point).unwrap_or(DVec3::Y);
            }
        };
        direction.try_normalize().unwrap_or(DVec3::Y)
    }

    /// True if the piece may be zero in a grid or a layer around it.
    fn reaches(&self, grid: &Grid) -> bool {
        let (low, high) = grid.bounds();
        let reach = 0.5 * (high - low).length() + 2.0 * grid.spacing;
        matches!(self, Self::Sampled(_)) || self.value(0.5 * (low + high)).abs() < reach
    }
}
