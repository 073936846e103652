//! Surface samples of one body inside the level set of another, in both directions [GBF03 sec. 3].

use crate::Pose;
use frangible_geometry::{ClosedForm, Geometry, LevelSet, Shape};
use glam::{DVec3, Mat3, Vec3};

/// A sample of one body inside the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// Whether the sample belongs to the pair's first body; the level set is the other's.
    pub sample_of_first: bool,
    /// Index into that body's samples.
    pub sample: u32,
    /// The level set's value there [m], not positive.
    pub phi: f32,
}

/// Where two bodies meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// World frame [m]; one point for both bodies, so that they feel opposite torques about it.
    pub point: DVec3,
    /// Unit, from the second body to the first.
    pub normal: DVec3,
}

/// A body as detection sees it: what it is and where.
#[derive(Clone, Copy, Debug)]
pub struct Placed<'a> {
    /// Geometry and samples.
    pub shape: &'a Shape,
    /// At the time level that is asked about.
    pub pose: &'a Pose,
}

/// Collects every sample of either body where the other's signed distance is at most `contour` [m].
pub fn find_penetrations(first: Placed, second: Placed, contour: f32, found: &mut Vec<Penetration>) {
    found.clear();
    samples_inside(first, second, contour, |sample, phi| {
        found.push(Penetration { sample_of_first: true, sample, phi });
    });
    samples_inside(second, first, contour, |sample, phi| {
        found.push(Penetration { sample_of_first: false, sample, phi });
    });
}

/// Whether either body has a sample inside the other.
pub fn overlap(first: Placed, second: Placed) -> bool {
    let mut any = false;
    samples_inside(first, second, 0.0, |_, _| any = true);
    if !any {
        samples_inside(second, first, 0.0, |_, _| any = true);
    }
    any
}

/// Signed distance of the deepest sample of either body in the other [m]; `None` if there is none inside.
pub fn deepest(first: Placed, second: Placed) -> Option<f32> {
    let mut least = 0.0_f32;
    samples_inside(first, second, 0.0, |_, phi| least = least.min(phi));
    samples_inside(second, first, 0.0, |_, phi| least = least.min(phi));
    (least < 0.0).then_some(least)
}

/// Calls `visit(sample index, signed distance)` for the samples of `body` inside `other`.
fn samples_inside(body: Placed, other: Placed, contour: f32, visit: impl FnMut(u32, f32)) {
    if body.shape.samples.is_empty() {
        return;
    }
    match &other.shape.geometry {
        Geometry::Grid(solid) => samples_inside_grid(body, other, &solid.level_set, contour, visit),
        Geometry::ClosedForm(form) => samples_inside_form(body, other, form, contour, visit),
    }
}

/// The inner loop over a sampled level set, in its lattice units and single precision: the coordinates are relative to
/// the two bodies, so they are small.
fn samples_inside_grid(
    body: Placed,
    other: Placed,
    level_set: &LevelSet,
    contour: f32,
    mut visit: impl FnMut(u32, f32),
) {
    let grid = level_set.grid();
    let other_from_world = other.pose.world_from_body().inverse();
    let grid_from_other = other.shape.body_from_grid.inverse();
    let grid_from_body = grid_from_other.after(&other_from_world).after(&body.pose.world_from_body());
    let lattice_from_body = (grid_from_body.matrix() * (1.0 / grid.spacing)).as_mat3();
    let shift = grid.lattice_from_point(grid_from_body.translation).as_vec3();
    let top = Vec3::new((grid.dims[0] - 1) as f32, (grid.dims[1] - 1) as f32, (grid.dims[2] - 1) as f32);
    if apart(body.shape, lattice_from_body, shift, top) {
        return;
    }
    for (index, &sample) in body.shape.samples.iter().enumerate() {
        let lattice = lattice_from_body * sample + shift;
        if lattice.cmpge(Vec3::ZERO).all() && lattice.cmple(top).all() {
            let phi = level_set.value_at_lattice(lattice);
            if phi <= contour {
                visit(index as u32, phi);
            }
        }
    }
}

/// Whether the box of a body's samples misses the box of the grid along one of the grid's axes.
fn apart(shape: &Shape, lattice_from_body: Mat3, shift: Vec3, top: Vec3) -> bool {
    let (low, high) = shape.bounds;
    let center = lattice_from_body * (0.5 * (low + high)).as_vec3() + shift;
    let half = (0.5 * (high - low)).as_vec3();
    let reach = Vec3::new(
        lattice_from_body.row(0).abs().dot(half),
        lattice_from_body.row(1).abs().dot(half),
        lattice_from_body.row(2).abs().dot(half),
    );
    (center + reach).cmplt(Vec3::ZERO).any() || (center - reach).cmpgt(top).any()
}

/// The same loop over a formula.
fn samples_inside_form(
    body: Placed,
    other: Placed,
    form: &ClosedForm,
    contour: f32,
    mut visit: impl FnMut(u32, f32),
) {
    let form_from_other = other.shape.body_from_grid.inverse();
    let other_from_world = other.pose.world_from_body().inverse();
    let form_from_body = form_from_other.after(&other_from_world).after(&body.pose.world_from_body());
    let (low, high) = body.shape.bounds;
    let (center, reach) = (0.5 * (low + high), 0.5 * (high - low).length());
    if form.distance_and_gradient(form_from_body.point(center)).0 > reach + f64::from(contour) {
        return;
    }
    let matrix = form_from_body.matrix();
    for (index, sample) in body.shape.samples.iter().enumerate() {
        let point = matrix * sample.as_dvec3() + form_from_body.translation;
        let phi = form.distance_and_gradient(point).0 as f32;
        if phi <= contour {
            visit(index as u32, phi);
        }
    }
}

/// Point and normal of a penetration, seen at the given poses (which need not be those where it was found).
pub fn contact_point(first: Placed, second: Placed, penetration: &Penetration) -> ContactPoint {
    let (body, other) = if penetration.sample_of_first { (first, second) } else { (second, first) };
    let sample = body.shape.samples[penetration.sample as usize].as_dvec3();
    let point = body.pose.world_from_body().point(sample);
    let other_from_world = other.pose.world_from_body().inverse();
    let (_, gradient) = other.shape.distance_and_gradient(other_from_world.point(point));
    let outward = other.pose.orientation * gradient;
    ContactPoint { point, normal: if penetration.sample_of_first { outward } else { -outward } }
}
