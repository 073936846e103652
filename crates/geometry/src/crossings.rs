//! Where the edges of a grid cross a solid's surface.

use crate::grid::Grid;
use crate::grid_solid::GridSolid;
use crate::level_set::LevelSet;
use crate::outline_pieces::OutlinePieces;
use crate::sampled_normal::sampled_normal;
use glam::DVec3;
use rayon::prelude::*;

/// A grid padded by one layer of outside nodes: solids at the border are closed there.
pub(crate) struct PaddedSigns<'a> {
    pub(crate) grid: Grid,
    level_set: &'a LevelSet,
}

/// A point on the surface, on the edge from a node to the next one along an axis, and the plane
/// that touches there.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Crossing {
    /// Index of the edge's lower node in the padded grid.
    pub(crate) node: usize,
    pub(crate) axis: usize,
    /// True if the lower node is inside.
    pub(crate) outward: bool,
    /// In the grid frame [m].
    pub(crate) point: DVec3,
    /// Unit, outward.
    pub(crate) normal: DVec3,
    /// The piece of the outline that is crossed; none where the samples have a surface that the
    /// outline does not know, as around merged slivers and at the border of the grid.
    pub(crate) piece: Option<usize>,
}

impl<'a> PaddedSigns<'a> {
    pub(crate) fn new(level_set: &'a LevelSet) -> Self {
        let inner = level_set.grid();
        let origin = inner.origin - DVec3::splat(inner.spacing);
        Self {
            grid: Grid { origin, spacing: inner.spacing, dims: inner.dims.map(|n| n + 2) },
            level_set,
        }
    }

    /// Signed distance at a node of the padded grid [m]; none in the added layer.
    fn phi(&self, node: [usize; 3]) -> Option<f64> {
        let inner = self.level_set.grid();
        let within = (0..3).all(|axis| (1..=inner.dims[axis]).contains(&node[axis]));
        within.then(|| f64::from(self.level_set.at(node[0] - 1, node[1] - 1, node[2] - 1)))
    }

    /// Per node of the padded grid: true inside.
    pub(crate) fn inside(&self) -> Vec<bool> {
        let inner = self.level_set.grid();
        let mut inside = vec![false; self.grid.len()];
        for k in 0..inner.dims[2] {
            for j in 0..inner.dims[1] {
                let row = self.grid.index(1, j + 1, k + 1);
                let first = inner.index(0, j, k);
                let phi = &self.level_set.phi()[first..first + inner.dims[0]];
                for (inside, &phi) in inside[row..].iter_mut().zip(phi) {
                    *inside = phi < 0.0;
                }
            }
        }
        inside
    }
}

/// All crossings, by node and axis.
pub(crate) fn find_crossings(
    solid: &GridSolid,
    signs: &PaddedSigns,
    inside: &[bool],
    pieces: &OutlinePieces,
) -> Vec<Crossing> {
    let grid = &signs.grid;
    let strides = [1, grid.dims[0], grid.dims[0] * grid.dims[1]];
    let slabs: Vec<Vec<Crossing>> = (0..grid.dims[2])
        .into_par_iter()
        .map(|k| {
            let mut found = Vec::new();
            for node in k * strides[2]..(k + 1) * strides[2] {
                let coordinates = grid.coordinates(node);
                for axis in 0..3 {
                    if coordinates[axis] + 1 == grid.dims[axis]
                        || inside[node] == inside[node + strides[axis]]
                    {
                        continue;
                    }
                    let (point, normal, piece) =
                        cross(solid, signs, pieces, coordinates, axis, inside[node]);
                    found.push(Crossing {
                        node,
                        axis,
                        outward: inside[node],
                        point,
                        normal,
                        piece,
                    });
                }
            }
            found
        })
        .collect();
    slabs.concat()
}

/// Point, normal and piece where one edge leaves the solid.
fn cross(
    solid: &GridSolid,
    signs: &PaddedSigns,
    pieces: &OutlinePieces,
    node: [usize; 3],
    axis: usize,
    outward: bool,
) -> (DVec3, DVec3, Option<usize>) {
    let spacing = signs.grid.spacing;
    let mut next = node;
    next[axis] += 1;
    let (from, to) = if outward { (node, next) } else { (next, node) };
    let (inside, outside) =
        (signs.grid.node(from[0], from[1], from[2]), signs.grid.node(to[0], to[1], to[2]));

    // The first piece behind which the edge leaves the solid.
    if let Some((fraction, piece)) = first_exit(pieces, inside, outside, spacing) {
        let point = inside.lerp(outside, fraction);
        return (point, pieces.normal(piece, point), Some(piece));
    }

    // The samples change sign where the outline does not; beyond the border their surface is the
    // face of the voxel.
    let fraction = match (signs.phi(from), signs.phi(to)) {
        (Some(low), Some(high)) if high.is_finite() && low.is_finite() => low / (low - high),
        _ => 0.5,
    };
    let point = inside.lerp(outside, fraction);
    let nearest = (0..pieces.len())
        .map(|piece| (pieces.value(piece, point).abs(), piece))
        .min_by(|a, b| a.0.total_cmp(&b.0))
        .filter(|(distance, _)| *distance < 0.5 * spacing);
    if let Some((_, piece)) = nearest {
        return (point, pieces.normal(piece, point), Some(piece));
    }
    let along = (outside - inside) / spacing;
    let normal = if signs.phi(to).is_some() {
        sampled_normal(solid.level_set(), point).unwrap_or(along)
    } else {
        along
    };
    (point, normal, None)
}

/// The smallest fraction of the way from `inside` to `outside` at which a piece changes sign.
///
/// A piece that has the inside node on its outer side does not bound the solid here: a sliver from
/// beyond it was merged.
fn first_exit(
    pieces: &OutlinePieces,
    inside: DVec3,
    outside: DVec3,
    spacing: f64,
) -> Option<(f64, usize)> {
    // Samples are rounded to f32.
    let rounding = 1e-3 * spacing;
    let mut first: Option<(f64, usize)> = None;
    for piece in 0..pieces.len() {
        let (low, high) = (pieces.value(piece, inside), pieces.value(piece, outside));
        if low >= rounding || high < 0.0 {
            continue;
        }
        let fraction = if low >= 0.0 {
            0.0
        } else {
            root_between(pieces, piece, inside, outside, [low, high])
        };
        if first.is_none_or(|(best, _)| fraction < best) {
            first = Some((fraction, piece));
        }
    }
    first
}

/// False position with Illinois's halving, which ends at once for planes.
fn root_between(
    pieces: &OutlinePieces,
    piece: usize,
    inside: DVec3,
    outside: DVec3,
    values: [f64; 2],
) -> f64 {
    const MAX_STEPS: usize = 8;
    let tolerance = 1e-12 * (values[1] - values[0]);
    let [mut low_value, mut high_value] = values;
    let (mut low, mut high) = (0.0, 1.0);
    let mut fraction = low_value / (low_value - high_value);
    if pieces.is_plane(piece) {
        return fraction;
    }
    for _ in 0..MAX_STEPS {
        let value = pieces.value(piece, inside.lerp(outside, fraction));
        if value.abs() <= tolerance {
            break;
        }
        if value < 0.0 {
            (low, low_value, high_value) = (fraction, value, 0.5 * high_value);
        } else {
            (high, high_value, low_value) = (fraction, value, 0.5 * low_value);
        }
        fraction = low + (high - low) * low_value / (low_value - high_value);
    }
    fraction
}
