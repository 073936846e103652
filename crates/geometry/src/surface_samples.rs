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
mod tests {
    use super::*;

    /// Largest distance from points of the surface, found by projecting a fine lattice, to the
    /// nearest sample.
    fn largest_gap(form: &ClosedForm, samples: &[Vec3]) -> f64 {
        let (low, high) = form.bounds();
        let n = 20;
        let mut largest = 0.0f64;
        for index in 0..n * n * n {
            let fraction = DVec3::new(
                f64::from(index % n),
                f64::from(index / n % n),
                f64::from(index / n / n),
            ) + 0.5;
            let point = low + (high - low) * fraction / f64::from(n);
            let (distance, gradient) = form.distance_and_gradient(point);
            let foot = (point - distance * gradient).as_vec3();
            let nearest = samples.iter().map(|s| s.distance(foot)).fold(f32::INFINITY, f32::min);
            largest = largest.max(f64::from(nearest));
        }
        largest
    }

    #[test]
    fn formulas_are_covered_on_the_surface() {
        let forms = [
            ClosedForm::Sphere { radius: 0.5 },
            ClosedForm::Box { half: DVec3::new(0.5, 0.2, 0.33) },
            ClosedForm::Cylinder { radius: 0.3, half_height: 0.4 },
            ClosedForm::Capsule { radius: 0.2, half_height: 0.3 },
            ClosedForm::Cone { radius: 0.3, height: 0.8 },
        ];
        for form in &forms {
            for spacing in [0.1, 0.23, 5.0] {
                let samples = closed_form_samples(form, spacing);
                for sample in &samples {
                    assert!(form.distance_and_gradient(sample.as_dvec3()).0.abs() < 1e-7);
                }
                if spacing < 1.0 {
                    // Half of the diagonal of a square of that edge, and a little for the
                    // curvature.
                    let gap = largest_gap(form, &samples);
                    assert!(gap < 0.85 * spacing, "{form:?} {spacing}: {gap}");
                    for (n, sample) in samples.iter().enumerate() {
                        let nearest = samples[..n]
                            .iter()
                            .map(|s| s.distance(*sample))
                            .fold(f32::INFINITY, f32::min);
                        assert!(
                            f64::from(nearest) > 0.3 * spacing,
                            "{form:?} {spacing}: {nearest}"
                        );
                    }
                } else {
                    assert!(
                        (8..=14).contains(&samples.len()) || samples.len() == 26,
                        "{}",
                        samples.len()
                    );
                }
            }
        }
    }

    #[test]
    fn a_box_has_its_corners_and_points_along_its_edges() {
        let half = DVec3::new(0.5, 0.2, 0.33);
        let samples = closed_form_samples(&ClosedForm::Box { half }, 0.1);
        let faces_touched = |s: &Vec3| {
            (s.as_dvec3().abs() - half).abs().to_array().iter().filter(|d| **d < 1e-7).count()
        };
        assert_eq!(samples.iter().filter(|s| faces_touched(s) == 3).count(), 8);
        assert_eq!(samples.iter().filter(|s| faces_touched(s) == 2).count(), 4 * (9 + 3 + 6));
        assert!(samples.iter().all(|s| faces_touched(s) > 0));
    }

    #[test]
    fn a_box_on_a_grid_has_its_corners_and_edges() {
        let half = DVec3::new(0.5, 0.2, 0.35);
        let solid = GridSolid::from_closed_form(ClosedForm::Box { half }, [25, 10, 18], 2).unwrap();
        let spacing = 0.1;
        let samples = surface_samples(&solid, spacing);
        let on_faces = |s: &Vec3| {
            (s.as_dvec3().abs() - half).abs().to_array().iter().filter(|d| **d < 1e-6).count()
        };
        assert_eq!(samples.iter().filter(|s| on_faces(s) == 3).count(), 8);
        assert!(samples.iter().all(|s| on_faces(s) > 0));
        // Along each edge no gap is wider than what fits no further point, plus a voxel.
        for axis in 0..3 {
            for (u, v) in [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)] {
                let mut along: Vec<f64> = samples
                    .iter()
                    .filter(|s| on_faces(s) >= 2)
                    .map(|s| s.as_dvec3())
                    .filter(|s| s[(axis + 1) % 3] * u > 0.0 && s[(axis + 2) % 3] * v > 0.0)
                    .filter(|s| (s[(axis + 1) % 3].abs() - half[(axis + 1) % 3]).abs() < 1e-6)
                    .filter(|s| (s[(axis + 2) % 3].abs() - half[(axis + 2) % 3]).abs() < 1e-6)
                    .map(|s| s[axis])
                    .collect();
                along.sort_by(f64::total_cmp);
                let widest = along.windows(2).map(|pair| pair[1] - pair[0]).fold(0.0, f64::max);
                assert!(widest < 1.4 * spacing + 1.1 * solid.grid().spacing, "{axis}: {widest}");
            }
        }
        assert!(largest_gap(&ClosedForm::Box { half }, &samples) < 1.2 * spacing);
    }

    /// A ball known only from its samples, and cut: on the surface, apart, everywhere, and always
    /// the same.
    #[test]
    fn sampled_solids_are_covered_on_their_surface() {
        let ball = ClosedForm::Sphere { radius: 0.8 };
        let grid = Grid::around_box(DVec3::NEG_ONE, DVec3::ONE, [30; 3], 2);
        let level_set = LevelSet::sample(grid, |p| ball.distance_and_gradient(p).0);
        let solid = GridSolid::from_level_set(level_set);
        let spacing = 0.15;
        let samples = surface_samples(&solid, spacing);
        assert_eq!(samples, surface_samples(&solid, spacing));
        for (n, sample) in samples.iter().enumerate() {
            assert!(f64::from(solid.value(sample.as_dvec3()).abs()) < 1e-3 * grid.spacing);
            let nearest =
                samples[..n].iter().map(|s| s.distance(*sample)).fold(f32::INFINITY, f32::min);
            assert!(f64::from(nearest) > 0.5 * spacing);
        }
        assert!(largest_gap(&ball, &samples) < 1.2 * spacing);
        // A lattice of this spacing has 4 pi r^2 / spacing^2 points.
        let expected = 4.0 * PI * 0.64 / (spacing * spacing);
        assert!(
            (0.7..1.5).contains(&(samples.len() as f64 / expected)),
            "{} {expected}",
            samples.len()
        );
    }

    #[test]
    fn both_sides_of_a_thin_plate_are_sampled() {
        let half = DVec3::new(0.5, 0.02, 0.5);
        let solid = GridSolid::from_closed_form(ClosedForm::Box { half }, [50, 2, 50], 2).unwrap();
        let samples = surface_samples(&solid, 0.2);
        let above = samples.iter().filter(|s| s.y > 0.019).count();
        let below = samples.iter().filter(|s| s.y < -0.019).count();
        assert!(
            above > 25 && below > 25 && above + below == samples.len(),
            "{above} {below} {}",
            samples.len()
        );
    }
}
