//! Surface samples of one body inside the level set of another, in both directions [GBF03 sec. 3].

use crate::Pose;
use frangible_geometry::{ClosedForm, Geometry, LevelSet, RigidTransform, Shape};
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

/// The samples of a pair that are near the other body, found once and asked many times: while the pair moves little, only
/// they can be inside.
#[derive(Clone, Debug)]
pub struct NearSamples {
    /// Of the first body, near the second; and the other way round.
    near: [Vec<u32>; 2],
    /// `second_from_first` when they were gathered.
    gathered_at: RigidTransform,
    /// The relative motion that they allow for [m].
    margin: f64,
}

/// The relative motion that near samples allow for, relative to the size of the smaller body: some frames of a resting
/// pair, a fraction of a frame of a fast one, few samples that are near in vain.
const MARGIN: f64 = 0.02;

/// How much faster than the way a trilinear level set can change: each of the three slopes is at most 1.
const STEEPEST: f64 = 1.733;

impl NearSamples {
    /// Gathers the samples of a pair that can get inside, as deep as `contour` [m] at least, while it moves little.
    pub fn gather(first: Placed, second: Placed, contour: f32) -> Self {
        let gathered_at = second_from_first(first, second);
        let margin = MARGIN * radius(first.shape).min(radius(second.shape));
        let reach = contour + (STEEPEST * margin) as f32;
        let mut near = [Vec::new(), Vec::new()];
        visit_inside(first.shape, second.shape, &gathered_at, reach, None, |sample, _| near[0].push(sample));
        visit_inside(second.shape, first.shape, &gathered_at.inverse(), reach, None, |sample, _| {
            near[1].push(sample)
        });
        Self { near, gathered_at, margin }
    }

    /// Collects every sample of either body where the other's signed distance is at most `contour` [m]; gathers anew if
    /// the pair has moved too far.
    pub fn find_penetrations(
        &mut self,
        first: Placed,
        second: Placed,
        contour: f32,
        found: &mut Vec<Penetration>,
    ) {
        let relative = second_from_first(first, second);
        if self.moved(&relative, first.shape) > self.margin {
            *self = Self::gather(first, second, contour);
        }
        found.clear();
        let near = Some(&self.near[0][..]);
        visit_inside(first.shape, second.shape, &relative, contour, near, |sample, phi| {
            found.push(Penetration { sample_of_first: true, sample, phi });
        });
        let near = Some(&self.near[1][..]);
        visit_inside(second.shape, first.shape, &relative.inverse(), contour, near, |sample, phi| {
            found.push(Penetration { sample_of_first: false, sample, phi });
        });
    }

    /// The furthest that a point of either body can have moved relative to the other since the gathering [m].
    fn moved(&self, relative: &RigidTransform, first: &Shape) -> f64 {
        let shift = (relative.translation - self.gathered_at.translation).length();
        // Of unit quaternions, |R - R'| <= 2 |q - q'|, up to the sign of q.
        let [q, p] = [relative.rotation, self.gathered_at.rotation].map(glam::DVec4::from);
        let turn = 2.0 * (q - p).length().min((q + p).length());
        shift + turn * (radius(first) + relative.translation.length())
    }
}

/// Whether either body has a sample inside the other.
pub fn overlap(first: Placed, second: Placed) -> bool {
    deepest(first, second).is_some()
}

/// Signed distance of the deepest sample of either body in the other [m]; `None` if there is none inside.
pub fn deepest(first: Placed, second: Placed) -> Option<f32> {
    let relative = second_from_first(first, second);
    let mut least = f32::INFINITY;
    visit_inside(first.shape, second.shape, &relative, 0.0, None, |_, phi| least = least.min(phi));
    visit_inside(second.shape, first.shape, &relative.inverse(), 0.0, None, |_, phi| least = least.min(phi));
    (least <= 0.0).then_some(least)
}

fn second_from_first(first: Placed, second: Placed) -> RigidTransform {
    second.pose.world_from_body().inverse().after(&first.pose.world_from_body())
}

/// Of a ball around the centre of mass that holds the body [m]; infinite for a half-space.
fn radius(shape: &Shape) -> f64 {
    shape.bounds.0.abs().max(shape.bounds.1.abs()).length()
}

/// Calls `visit(sample index, signed distance)` for the samples of `body` where `other`'s signed distance is at most
/// `contour` [m]; of those listed in `near`, if given.
fn visit_inside(
    body: &Shape,
    other: &Shape,
    other_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[u32]>,
    visit: impl FnMut(u32, f32),
) {
    if near.map_or(body.samples.is_empty(), <[u32]>::is_empty) {
        return;
    }
    let grid_from_body = other.body_from_grid.inverse().after(other_from_body);
    match &other.geometry {
        Geometry::Grid(solid) => {
            visit_inside_grid(body, &solid.level_set, &grid_from_body, contour, near, visit);
        }
        Geometry::ClosedForm(form) => visit_inside_form(body, form, &grid_from_body, contour, near, visit),
    }
}

/// The inner loop over a sampled level set, in its lattice units and single precision: the coordinates are relative to
/// the two bodies, so they are small.
fn visit_inside_grid(
    body: &Shape,
    level_set: &LevelSet,
    grid_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[u32]>,
    mut visit: impl FnMut(u32, f32),
) {
    let grid = level_set.grid();
    let lattice_from_body = (grid_from_body.matrix() * (1.0 / grid.spacing)).as_mat3();
    let shift = grid.lattice_from_point(grid_from_body.translation).as_vec3();

    // The box of the grid, and what may be inside the contour beyond it.
    let beyond = Vec3::splat((contour / grid.spacing as f32).max(0.0));
    let top = Vec3::new((grid.dims[0] - 1) as f32, (grid.dims[1] - 1) as f32, (grid.dims[2] - 1) as f32);
    let (low, high) = (-beyond, top + beyond);
    let inside_box =
        |lattice: Vec3, slack: f32| lattice.cmpge(low - slack).all() && lattice.cmple(high + slack).all();
    let mut test = |index: u32| {
        let lattice = lattice_from_body * body.samples[index as usize] + shift;
        if inside_box(lattice, 0.0) {
            let phi = level_set.value_at_lattice(lattice);
            if phi <= contour {
                visit(index, phi);
            }
        }
    };
    if let Some(near) = near {
        near.iter().for_each(|&index| test(index));
        return;
    }
    if apart(body, lattice_from_body, shift, low, high) {
        return;
    }
    for cluster in &body.sample_clusters {
        let center = lattice_from_body * cluster.center + shift;
        let reach = contour + STEEPEST as f32 * cluster.radius;
        if inside_box(center, cluster.radius / grid.spacing as f32)
            && level_set.value_at_lattice(center) <= reach
        {
            (cluster.first..cluster.first + cluster.count).for_each(&mut test);
        }
    }
}

/// Whether the box of a body's samples misses the box from `low` to `high` along one of the latter's axes.
fn apart(shape: &Shape, lattice_from_body: Mat3, shift: Vec3, low: Vec3, high: Vec3) -> bool {
    let center = lattice_from_body * (0.5 * (shape.bounds.0 + shape.bounds.1)).as_vec3() + shift;
    let half = (0.5 * (shape.bounds.1 - shape.bounds.0)).as_vec3();
    let reach = Vec3::new(
        lattice_from_body.row(0).abs().dot(half),
        lattice_from_body.row(1).abs().dot(half),
        lattice_from_body.row(2).abs().dot(half),
    );
    (center + reach).cmplt(low).any() || (center - reach).cmpgt(high).any()
}

/// The same loop over a formula.
fn visit_inside_form(
    body: &Shape,
    form: &ClosedForm,
    form_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[u32]>,
    mut visit: impl FnMut(u32, f32),
) {
    let matrix = form_from_body.matrix();
    let mut test = |index: u32| {
        let sample = body.samples[index as usize].as_dvec3();
        let phi = form.distance(matrix * sample + form_from_body.translation) as f32;
        if phi <= contour {
            visit(index, phi);
        }
    };
    if let Some(near) = near {
        near.iter().for_each(|&index| test(index));
        return;
    }
    for cluster in &body.sample_clusters {
        let center = form_from_body.point(cluster.center.as_dvec3());
        if form.distance(center) <= f64::from(contour + cluster.radius) {
            (cluster.first..cluster.first + cluster.count).for_each(&mut test);
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
