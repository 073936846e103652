//! Points on surfaces: what is tested against other bodies' level sets.

use crate::closed_form::ClosedForm;
use crate::contour_mesh::Vertex;
use crate::dual_contour::DualContour;
use crate::grid::Grid;
use crate::grid_solid::GridSolid;
use crate::level_set::LevelSet;
use crate::mesh_boundary::MeshBoundary;
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::f64::consts::{FRAC_PI_2, PI, TAU};

/// Points on the surface of a solid in its grid frame [m], about `spacing` [m] apart but not closer
/// than the grid's nodes: all corners, then points along edges, then on faces.
pub fn surface_samples(solid: &GridSolid, spacing: f64) -> Vec<Vec3> {
    let contour = DualContour::new(solid);
    let settle = |vertex: &Vertex| Vertex {
        position: on_surface(vertex, &contour, solid.level_set()),
        ..*vertex
    };
    apart(solid.grid(), spacing, contour.vertices.iter().map(settle).collect())
}

/// The same of a solid that was sampled from triangles: on these.
pub fn mesh_samples(solid: &GridSolid, boundary: &MeshBoundary, spacing: f64) -> Vec<Vec3> {
    let contour = DualContour::new(solid);
    let settle = |vertex: &Vertex| boundary.settle(vertex, solid.grid().spacing);
    apart(solid.grid(), spacing, contour.vertices.par_iter().map(settle).collect())
}

/// Vertices about `spacing` [m] apart, the sharpest first.
fn apart(grid: &Grid, spacing: f64, mut vertices: Vec<Vertex>) -> Vec<Vec3> {
    // Accepted points this close keep others out; what is left between them is then filled with
    // gaps around `spacing`.
    const CLOSEST: f64 = 0.85;
    // Corners closer than this, in units of the grid's spacing, are the same corner seen from two
    // cells.
    const SAME_CORNER: f64 = 0.1;
    // The two sides of a thin plate are both sampled: only points that face the same way keep each
    // other out.
    const SAME_SIDE: f64 = 0.3;

    vertices.sort_by_key(|vertex| std::cmp::Reverse(vertex.sharpness));

    let mut accepted = Buckets::new(grid, (CLOSEST * spacing).max(SAME_CORNER * grid.spacing));
    for vertex in vertices {
        let closest =
            if vertex.sharpness == 3 { SAME_CORNER * grid.spacing } else { CLOSEST * spacing };
        let same_side = |other: &Vertex| other.normal.dot(vertex.normal) > SAME_SIDE;
        if !accepted.any_near(vertex.position, closest, same_side) {
            accepted.insert(vertex);
        }
    }
    accepted.vertices.iter().map(|vertex| vertex.position.as_vec3()).collect()
}

/// Moves a vertex along the normal onto its surface.
fn on_surface(vertex: &Vertex, contour: &DualContour, level_set: &LevelSet) -> DVec3 {
    const MAX_STEPS: usize = 8;
    // A distance has slope 1, but on a ridge the slope of its samples vanishes. Down to 1/30 it is
    // believed, below that Newton's step would leave the cell.
    const LEAST_SLOPE_SQUARED: f64 = 1e-3;
    let spacing = level_set.grid().spacing;
    // Newton's method on the outline, or on the samples where the outline does not know of the
    // surface.
    let project = |step: &dyn Fn(DVec3) -> DVec3| {
        let mut point = vertex.position;
        for _ in 0..MAX_STEPS {
            point -= step(point);
        }
        (point.distance(vertex.position) < 0.5 * spacing).then_some(point)
    };
    let to_outline = |point: DVec3| match contour.pieces.max_value(point) {
        Some((value, piece)) => value * contour.pieces.normal(piece, point),
        None => DVec3::ZERO,
    };
    let to_samples = |point: DVec3| {
        let (value, gradient) = level_set.value_and_gradient(point);
        let slope = gradient.as_dvec3();
        slope * (f64::from(value) / slope.length_squared().max(LEAST_SLOPE_SQUARED))
    };
    let known = if vertex.in_outline { project(&to_outline) } else { None };
    known.or_else(|| project(&to_samples)).unwrap_or(vertex.position)
}

/// Points hashed by cube, for neighbour queries.
struct Buckets {
    grid: Grid,
    of_cube: Vec<Vec<u32>>,
    vertices: Vec<Vertex>,
}

impl Buckets {
    /// For points within a voxel of `around`, and for distances up to `edge`.
    fn new(around: &Grid, edge: f64) -> Self {
        let (low, high) = around.bounds();
        let edge = edge.max(around.spacing);
        let origin = low - 2.0 * around.spacing;
        let dims =
            ((high - origin + 2.0 * around.spacing) / edge).to_array().map(|n| n as usize + 1);
        let grid = Grid { origin, spacing: edge, dims };
        Self { grid, of_cube: vec![Vec::new(); grid.len()], vertices: Vec::new() }
    }

    fn cube(&self, position: DVec3) -> [usize; 3] {
        let lattice = self.grid.lattice_from_point(position).to_array();
        std::array::from_fn(|axis| (lattice[axis].max(0.0) as usize).min(self.grid.dims[axis] - 1))
    }

    fn insert(&mut self, vertex: Vertex) {
        let [i, j, k] = self.cube(vertex.position);
        self.of_cube[self.grid.index(i, j, k)].push(self.vertices.len() as u32);
        self.vertices.push(vertex);
    }

    /// True if a point accepted by `counts` lies closer than `distance`.
    fn any_near(&self, position: DVec3, distance: f64, counts: impl Fn(&Vertex) -> bool) -> bool {
        let cube = self.cube(position);
        let around = |axis: usize| {
            cube[axis].saturating_sub(1)..=(cube[axis] + 1).min(self.grid.dims[axis] - 1)
        };
        around(2).any(|k| {
            around(1).any(|j| {
                around(0).any(|i| {
                    self.of_cube[self.grid.index(i, j, k)].iter().any(|&n| {
                        let other = &self.vertices[n as usize];
                        other.position.distance(position) < distance && counts(other)
                    })
                })
            })
        })
    }
}

/// Points on the surface of a formula in its frame [m], about `spacing` [m] apart, with the
/// corners, edges and rims. None for a half-space: what lies on it has the samples.
pub(crate) fn closed_form_samples(form: &ClosedForm, spacing: f64) -> Vec<Vec3> {
    match *form {
        ClosedForm::HalfSpace(_) => Vec::new(),
        ClosedForm::Sphere { radius } => sphere_samples(radius, spacing),
        ClosedForm::Box { half } => box_samples(half, spacing),
        ClosedForm::Cylinder { radius, half_height } => {
            cylinder_samples(radius, half_height, spacing)
        }
        ClosedForm::Capsule { radius, half_height } => {
            capsule_samples(radius, half_height, spacing)
        }
        ClosedForm::Cone { radius, height } => cone_samples(radius, height, spacing),
    }
}

/// Number of steps of at most `spacing` along `length`, at least `least`.
fn steps(length: f64, spacing: f64, least: usize) -> usize {
    // A length that is a multiple of the spacing up to rounding is divided as such.
    ((length / spacing - 1e-9).ceil() as usize).max(least)
}

/// A spiral of equal areas: each point is as far from its neighbours on the same turn as from the
/// next turn.
fn sphere_samples(radius: f64, spacing: f64) -> Vec<Vec3> {
    let golden_angle = PI * (3.0 - 5.0f64.sqrt());
    let count = steps(4.0 * PI * radius * radius, spacing * spacing, 12);
    let point = |n: usize| {
        let y = 1.0 - (2 * n + 1) as f64 / count as f64;
        let ring = (1.0 - y * y).sqrt();
        let angle = golden_angle * n as f64;
        (radius * DVec3::new(ring * libm::cos(angle), y, ring * libm::sin(angle))).as_vec3()
    };
    (0..count).map(point).collect()
}

/// The outer nodes of a lattice with a node on each corner.
fn box_samples(half: DVec3, spacing: f64) -> Vec<Vec3> {
    let counts = half.to_array().map(|half| steps(2.0 * half, spacing, 1));
    let at = |axis: usize, n: usize| half[axis] * (2.0 * n as f64 / counts[axis] as f64 - 1.0);
    let mut samples = Vec::new();
    for k in 0..=counts[2] {
        for j in 0..=counts[1] {
            // Rows inside the box have only their two ends on the surface.
            let on_face = k == 0 || k == counts[2] || j == 0 || j == counts[1];
            let stride = if on_face { 1 } else { counts[0] };
            for i in (0..=counts[0]).step_by(stride) {
                samples.push(DVec3::new(at(0, i), at(1, j), at(2, k)).as_vec3());
            }
        }
    }
    samples
}

/// Rings around the side, from rim to rim, and smaller rings on both caps down to their middles.
fn cylinder_samples(radius: f64, half_height: f64, spacing: f64) -> Vec<Vec3> {
    let mut samples = Vec::new();
    let mut ring = |radius: f64, y: f64| add_ring(&mut samples, radius, y, spacing);
    let rows = steps(2.0 * half_height, spacing, 1);
    for row in 0..=rows {
        ring(radius, half_height * (2.0 * row as f64 / rows as f64 - 1.0));
    }
    let rings = steps(radius, spacing, 1);
    for inner in 0..rings {
        for y in [-half_height, half_height] {
            ring(radius * inner as f64 / rings as f64, y);
        }
    }
    samples
}

/// Rings around the side and around both half balls, up to their tips.
fn capsule_samples(radius: f64, half_height: f64, spacing: f64) -> Vec<Vec3> {
    let mut samples = Vec::new();
    let rows = steps(2.0 * half_height, spacing, 1);
    for row in 0..=rows {
        let y = half_height * (2.0 * row as f64 / rows as f64 - 1.0);
        add_ring(&mut samples, radius, y, spacing);
    }
    let rings = steps(FRAC_PI_2 * radius, spacing, 2);
    for n in 1..=rings {
        let angle = FRAC_PI_2 * n as f64 / rings as f64;
        let around = if n == rings { 0.0 } else { radius * libm::cos(angle) };
        for up in [-1.0, 1.0] {
            let y = up * (half_height + radius * libm::sin(angle));
            add_ring(&mut samples, around, y, spacing);
        }
    }
    samples
}

/// Rings around the side, from the rim to the apex, and smaller rings on the base.
fn cone_samples(radius: f64, height: f64, spacing: f64) -> Vec<Vec3> {
    let mut samples = Vec::new();
    let (low, high) = (-0.25 * height, 0.75 * height);
    let rows = steps((radius * radius + height * height).sqrt(), spacing, 1);
    for row in 0..=rows {
        let part = row as f64 / rows as f64;
        add_ring(&mut samples, radius * (1.0 - part), low + part * (high - low), spacing);
    }
    let rings = steps(radius, spacing, 1);
    for inner in 0..rings {
        add_ring(&mut samples, radius * inner as f64 / rings as f64, low, spacing);
    }
    samples
}

/// At least six points around the y axis, or one on it.
fn add_ring(samples: &mut Vec<Vec3>, radius: f64, y: f64, spacing: f64) {
    let count = steps(TAU * radius, spacing, if radius > 0.0 { 6 } else { 1 });
    for n in 0..count {
        let angle = TAU * n as f64 / count as f64;
        let point = DVec3::new(radius * libm::cos(angle), y, radius * libm::sin(angle));
        samples.push(point.as_vec3());
    }
}

#[cfg(test)]
mod tests;
