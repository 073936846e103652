//! Surface samples of a body inside the level set of another, in both directions [GBF03 sec. 3]. A
//! ball has one sample, its centre with a radius, so its contact is exact.

use crate::relative_motion::Placed;
use crate::relative_motion::moved_since;
use crate::relative_motion::second_from_first;
use frangible_geometry::{ClosedForm, Geometry, GridSolid, Shape};
use frangible_math::RigidTransform;
use glam::{DVec3, Mat3, Vec3};

/// A sample of one body inside the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Penetration {
    /// True for a sample of the pair's first body; the level set is the other body's.
    pub sample_of_first: bool,
    /// Sample index; 0 for a ball.
    pub sample: u32,
    /// Value of the level set [m], not positive.
    pub phi: f32,
}

/// Contact of two bodies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactPoint {
    /// World frame [m]; a common point for both bodies, for opposite torques about it.
    pub point: DVec3,
    /// Unit, from the second body to the first.
    pub normal: DVec3,
}

/// Samples near the other body, gathered once for many queries: while the pair moves little, no
/// other sample can be inside.
#[derive(Clone, Debug)]
pub struct NearSamples {
    /// Samples of the first body near the second, and vice versa, sorted by signed distance at
    /// gathering [m].
    near: [Vec<(f32, u32)>; 2],
    /// `second_from_first` at gathering.
    gathered_at: RigidTransform,
    /// Allowed relative motion [m].
    margin: f64,
}

/// Allowed relative motion, relative to the smaller body's size: several frames of a resting pair,
/// a fraction of a frame of a fast pair, with few extra samples.
const MARGIN: f64 = 0.02;

/// Maximum slope of a trilinear level set: each of the three partial slopes is at most 1.
const STEEPEST: f64 = 1.733;

impl NearSamples {
    /// Gathers samples that can get inside by at least `contour` [m] within the allowed motion.
    pub fn gather(first: Placed, second: Placed, contour: f32) -> Self {
        let gathered_at = second_from_first(first, second);
        let margin = MARGIN * first.shape.radius().min(second.shape.radius());
        let reach = contour + (STEEPEST * margin) as f32;
        let mut near = [Vec::new(), Vec::new()];
        let [of_first, of_second] = &mut near;
        visit_inside(first.shape, second.shape, &gathered_at, reach, None, |sample, phi| {
            of_first.push((phi, sample));
        });
        visit_inside(
            second.shape,
            first.shape,
            &gathered_at.inverse(),
            reach,
            None,
            |sample, phi| {
                of_second.push((phi, sample));
            },
        );
        for near in &mut near {
            near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        }
        Self { near, gathered_at, margin }
    }

    /// Collects every sample of either body with a signed distance of at most `contour` [m];
    /// gathers again beyond the allowed motion.
    pub fn find_penetrations(
        &mut self,
        first: Placed,
        second: Placed,
        contour: f32,
        found: &mut Vec<Penetration>,
    ) {
        let relative = second_from_first(first, second);
        let mut moved = moved_since(&self.gathered_at, first, second, STEEPEST * self.margin);
        if moved > self.margin {
            *self = Self::gather(first, second, contour);
            moved = 0.0;
        }
        // Skip samples too far away for the motion since gathering.
        let reach = contour + (STEEPEST * moved) as f32;
        let [of_first, of_second] = &self.near;
        found.clear();
        let near = Some(within(of_first, reach));
        visit_inside(first.shape, second.shape, &relative, contour, near, |sample, phi| {
            found.push(Penetration { sample_of_first: true, sample, phi });
        });
        let near = Some(within(of_second, reach));
        visit_inside(
            second.shape,
            first.shape,
            &relative.inverse(),
            contour,
            near,
            |sample, phi| {
                found.push(Penetration { sample_of_first: false, sample, phi });
            },
        );
    }
}

/// Samples with a gathered distance of at most `reach` [m].
fn within(sorted: &[(f32, u32)], reach: f32) -> &[(f32, u32)] {
    &sorted[..sorted.partition_point(|&(phi, _)| phi <= reach)]
}

/// True if either body has a sample inside the other.
pub fn overlap(first: Placed, second: Placed) -> bool {
    deepest(first, second).is_some()
}

/// Signed distance of the deepest sample of either body in the other [m]; `None` without samples
/// inside.
pub fn deepest(first: Placed, second: Placed) -> Option<f32> {
    let relative = second_from_first(first, second);
    let mut least = f32::INFINITY;
    visit_inside(first.shape, second.shape, &relative, 0.0, None, |_, phi| least = least.min(phi));
    visit_inside(second.shape, first.shape, &relative.inverse(), 0.0, None, |_, phi| {
        least = least.min(phi)
    });
    (least <= 0.0).then_some(least)
}

/// Calls `visit(sample index, signed distance)` for samples of `body` with a signed distance of at
/// most `contour` [m] to `other`; limited to `near`, if given.
fn visit_inside(
    body: &Shape,
    other: &Shape,
    other_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[(f32, u32)]>,
    mut visit: impl FnMut(u32, f32),
) {
    if near.is_some_and(<[_]>::is_empty) {
        return;
    }
    if let Some(radius) = ball_radius(body) {
        let (distance, _) = other.distance_and_gradient(other_from_body.translation);
        let phi = (distance - radius) as f32;
        if phi <= contour {
            visit(0, phi);
        }
        return;
    }
    // The ball's own sample tells its contact with any body.
    if ball_radius(other).is_some() || body.samples().is_empty() {
        return;
    }
    let grid_from_body = other.body_from_grid.inverse().after(other_from_body);
    match &other.geometry {
        Geometry::Grid(solid) => {
            visit_inside_grid(body, solid, &grid_from_body, contour, near, visit);
        }
        Geometry::ClosedForm(form) => {
            let distance = |point: DVec3, _: f64| form.distance(point);
            visit_inside_exact(body, distance, &grid_from_body, contour, near, visit);
        }
        Geometry::Hull(hull) => {
            let distance = |point: DVec3, most: f64| hull.distance_up_to(point, most);
            visit_inside_exact(body, distance, &grid_from_body, contour, near, visit);
        }
        Geometry::Compound(compound) => {
            let distance = |point: DVec3, most: f64| compound.distance_up_to(point, most);
            visit_inside_exact(body, distance, &grid_from_body, contour, near, visit);
        }
        Geometry::Solid(_) => {
            let distance = |point: DVec3, most: f64| match (&other.hull, &other.compound) {
                (Some(hull), _) => hull.distance_up_to(point, most),
                (None, Some(compound)) => compound.distance_up_to(point, most),
                (None, None) => other.distance_and_gradient(point).0,
            };
            visit_inside_exact(body, distance, other_from_body, contour, near, visit);
        }
        Geometry::Mesh(mesh) => {
            let distance = |point: DVec3, most: f64| mesh.distance_up_to(point, most);
            visit_inside_exact(body, distance, &grid_from_body, contour, near, visit);
        }
    }
}

/// Inner loop over a sampled level set, in lattice units and single precision: body-relative
/// coordinates are small.
fn visit_inside_grid(
    body: &Shape,
    solid: &GridSolid,
    grid_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[(f32, u32)]>,
    mut visit: impl FnMut(u32, f32),
) {
    let grid = solid.grid();
    let lattice_from_body = (grid_from_body.matrix() * (1.0 / grid.spacing)).as_mat3();
    let shift = grid.lattice_from_point(grid_from_body.translation).as_vec3();

    // Box of the grid, enlarged by the contour.
    let beyond = Vec3::splat((contour / grid.spacing as f32).max(0.0));
    let top =
        Vec3::new((grid.dims[0] - 1) as f32, (grid.dims[1] - 1) as f32, (grid.dims[2] - 1) as f32);
    let (low, high) = (-beyond, top + beyond);
    let inside_box = |lattice: Vec3, slack: f32| {
        lattice.cmpge(low - slack).all() && lattice.cmple(high + slack).all()
    };
    let samples = body.samples();
    let mut test = |index: u32| {
        let lattice = lattice_from_body * samples[index as usize] + shift;
        if inside_box(lattice, 0.0) {
            let phi = solid.value_at_lattice(lattice, contour);
            if phi <= contour {
                visit(index, phi);
            }
        }
    };
    if let Some(near) = near {
        near.iter().for_each(|&(_, index)| test(index));
        return;
    }
    if apart(body, lattice_from_body, shift, low, high) {
        return;
    }
    for cluster in body.sample_clusters() {
        let center = lattice_from_body * cluster.center + shift;
        let reach = contour + STEEPEST as f32 * cluster.radius;
        if inside_box(center, cluster.radius / grid.spacing as f32)
            && solid.value_at_lattice(center, reach) <= reach
        {
            (cluster.first..cluster.first + cluster.count).for_each(&mut test);
        }
    }
}

/// True if the box of a body's samples misses the box from `low` to `high` along an axis of the
/// latter.
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

/// The same loop over an exact distance, accurate up to its second argument.
fn visit_inside_exact(
    body: &Shape,
    distance: impl Fn(DVec3, f64) -> f64,
    form_from_body: &RigidTransform,
    contour: f32,
    near: Option<&[(f32, u32)]>,
    mut visit: impl FnMut(u32, f32),
) {
    let matrix = form_from_body.matrix();
    let samples = body.samples();
    let mut test = |index: u32| {
        let sample = samples[index as usize].as_dvec3();
        let phi = distance(matrix * sample + form_from_body.translation, f64::from(contour)) as f32;
        if phi <= contour {
            visit(index, phi);
        }
    };
    if let Some(near) = near {
        near.iter().for_each(|&(_, index)| test(index));
        return;
    }
    for cluster in body.sample_clusters() {
        let center = form_from_body.point(cluster.center.as_dvec3());
        let reach = f64::from(contour + cluster.radius);
        if distance(center, reach) <= reach {
            (cluster.first..cluster.first + cluster.count).for_each(&mut test);
        }
    }
}

/// Radius of a ball that is a closed form [m]. Among surface samples an elastic ball found spin, and
/// lost half its height in 30 s.
fn ball_radius(shape: &Shape) -> Option<f64> {
    match shape.geometry {
        Geometry::ClosedForm(ClosedForm::Sphere { radius }) => Some(radius),
        _ => None,
    }
}

/// Point and normal of a penetration at the given poses, possibly other than at its detection.
pub fn contact_point(first: Placed, second: Placed, penetration: &Penetration) -> ContactPoint {
    let (body, other) = if penetration.sample_of_first { (first, second) } else { (second, first) };
    let (sample, radius) = match ball_radius(body.shape) {
        Some(radius) => (DVec3::ZERO, radius),
        None => (body.shape.samples()[penetration.sample as usize].as_dvec3(), 0.0),
    };
    let sample_world = body.pose.world_from_body().point(sample);
    let other_from_world = other.pose.world_from_body().inverse();
    let (_, gradient) = other.shape.distance_and_gradient(other_from_world.point(sample_world));
    let outward = other.pose.orientation * gradient;
    let point = sample_world - radius * outward;
    ContactPoint { point, normal: if penetration.sample_of_first { outward } else { -outward } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::Pose;
    use frangible_geometry::{ClosedForm, HalfSpace, Hull};
    use glam::DQuat;
    use proptest::prelude::*;

    fn shapes() -> [Shape; 4] {
        let ground = ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: 0.0 });
        let brick = ClosedForm::Box { half: DVec3::new(0.5, 0.2, 0.3) };
        let corners = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(0.6, 0.5, 0.4)];
        [
            Shape::closed_form(ground, 1.0),
            Shape::closed_form(brick, 0.1),
            Shape::closed_form(ClosedForm::Sphere { radius: 0.4 }, 0.1),
            Shape::convex(Hull::of_points(&corners).unwrap(), 0.1).unwrap(),
        ]
    }

    fn at<'a>(shape: &'a Shape, pose: &'a Pose) -> Placed<'a> {
        Placed { shape, pose }
    }

    fn pose() -> impl Strategy<Value = Pose> {
        let numbers = prop::array::uniform3(-0.4..0.4f64);
        (numbers.clone(), numbers).prop_map(|(position, turn)| Pose {
            position: DVec3::from_array(position),
            orientation: DQuat::from_scaled_axis(DVec3::from_array(turn)),
        })
    }

    proptest! {
        /// Near samples are complete for any motion of the pair, and with either body as the
        /// ground.
        #[test]
        fn near_samples_miss_nothing(
            pair in prop::sample::select(vec![(0, 1), (1, 0), (0, 2), (1, 2), (2, 1), (0, 3), (3, 1), (2, 3)]),
            start in pose(),
            moves in prop::collection::vec((pose(), -4..0_i32), 1..6),
        ) {
            let shapes = shapes();
            let still = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
            let (first, second) = (&shapes[pair.0], &shapes[pair.1]);
            let mut pose = start;
            // Move the body other than the ground.
            let place = |pose: &Pose| if pair.1 == 0 { (*pose, still) } else { (still, *pose) };
            let (a, b) = place(&pose);
            let mut near = NearSamples::gather(at(first, &a), at(second, &b), 0.0);
            for (step, exponent) in moves {
                let size = 10_f64.powi(exponent);
                pose.position += size * step.position;
                pose.orientation = (pose.orientation * DQuat::IDENTITY.slerp(step.orientation, size)).normalize();
                let (a, b) = place(&pose);
                let mut found = Vec::new();
                near.find_penetrations(at(first, &a), at(second, &b), 0.0, &mut found);
                let mut all = Vec::new();
                NearSamples::gather(at(first, &a), at(second, &b), 0.0)
                    .find_penetrations(at(first, &a), at(second, &b), 0.0, &mut all);
                let key = |p: &Penetration| (p.sample_of_first, p.sample);
                found.sort_by_key(key);
                all.sort_by_key(key);
                prop_assert_eq!(&found, &all);
                prop_assert_eq!(found.is_empty(), !overlap(at(first, &a), at(second, &b)));
            }
        }
    }
}
