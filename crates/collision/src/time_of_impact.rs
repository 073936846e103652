//! First touch of two bodies on their way through a frame: the centre of a fracture
//! [Su09 sec. 4.1].
//!
//! Collisions are found with samples at the predicted poses, where a fast body may be deep inside
//! another and the deepest sample lies beside the line of impact. The first touch on the way,
//! searched along the surface, is the visible point of impact.

use crate::narrow_phase::samples::{ContactPoint, NearSamples, contact_point, overlap};
use crate::relative_motion::Placed;
use frangible_bodies::{Bodies, Pair, Pose};
use glam::DVec3;

/// Number of intervals tested along the way, to find bodies passing through each other.
const PARTS: u32 = 16;

/// Bisections of the first interval with overlap: to 1/65536 of the way.
const HALVINGS: u32 = 12;

/// Maximum number of steps along the surface; a failed step halves the next.
const SLIDES: u32 = 60;

/// First step along the surface, relative to the smaller body's size: about the sample spacing.
const FIRST_SLIDE: f64 = 0.1;

/// Point and normal of the first touch of a pair on the way from the poses of both bodies to others,
/// with their poses there; `None` if they touch from the beginning, or never.
pub fn first_contact(
    bodies: &Bodies,
    pair: Pair,
    [from, to]: [&[Pose; 2]; 2],
) -> Option<(ContactPoint, [Pose; 2])> {
    let at = |part: f64| {
        [0, 1].map(|side| Pose {
            position: from[side].position.lerp(to[side].position, part),
            orientation: from[side].orientation.slerp(to[side].orientation, part),
        })
    };
    let shapes = [&*bodies.shapes[pair.first], &*bodies.shapes[pair.second]];
    let touch = |poses: &[Pose; 2]| {
        overlap(
            Placed { shape: shapes[0], pose: &poses[0] },
            Placed { shape: shapes[1], pose: &poses[1] },
        )
    };

    // Find the first interval with overlap, then bisect.
    if touch(from) {
        return None;
    }
    let part = |number: u32| f64::from(number) / f64::from(PARTS);
    let reached = (1..=PARTS).find(|&number| touch(&at(part(number))))?;
    let (mut before, mut after) = (part(reached - 1), part(reached));
    for _ in 0..HALVINGS {
        let middle = 0.5 * (before + after);
        if touch(&at(middle)) { after = middle } else { before = middle }
    }

    // The touching sample is the nearest sample; the surface next to it may be nearer.
    let poses = at(after);
    let first = Placed { shape: shapes[0], pose: &poses[0] };
    let second = Placed { shape: shapes[1], pose: &poses[1] };
    let mut penetrations = Vec::new();
    NearSamples::gather(first, second, 0.0).find_penetrations(
        first,
        second,
        0.0,
        &mut penetrations,
    );
    let deepest = penetrations.iter().min_by(|a, b| a.phi.total_cmp(&b.phi))?;
    let touched = contact_point(first, second, deepest);
    let (body, other) = if deepest.sample_of_first { (first, second) } else { (second, first) };
    let point = slide_inwards(body, other, touched.point);
    let outward = distance(other, point).1;
    let normal = if deepest.sample_of_first { outward } else { -outward };
    Some((ContactPoint { point, normal }, poses))
}

/// Deepest point of `body`'s surface in `other`, near `point`: steepest descent along the surface.
fn slide_inwards(body: Placed, other: Placed, mut point: DVec3) -> DVec3 {
    let size = |shape: &frangible_geometry::Shape| (shape.bounds.1 - shape.bounds.0).length();
    let mut step = FIRST_SLIDE * size(body.shape).min(size(other.shape));
    let mut depth = distance(other, point).0;
    for _ in 0..SLIDES {
        let (inward, outward) = (-distance(other, point).1, distance(body, point).1);
        let along = inward - inward.dot(outward) * outward;
        let moved = point + step * along;
        let (off, normal) = distance(body, moved);
        let next = moved - off * normal;
        let depth_next = distance(other, next).0;
        if depth_next < depth {
            (point, depth) = (next, depth_next);
        } else {
            step *= 0.5;
        }
    }
    point
}

/// Signed distance of a world point [m] and its gradient in the world frame.
fn distance(body: Placed, point_world: DVec3) -> (f64, DVec3) {
    let (distance, gradient) =
        body.shape.distance_and_gradient(body.pose.world_from_body().inverse().point(point_world));
    (distance, body.pose.orientation * gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, SurfaceProperties, Velocity};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    fn spawn(bodies: &mut Bodies, form: ClosedForm, spacing: f64, pose: Pose) {
        bodies.spawn(NewBody {
            shape: Arc::new(Shape::closed_form(form, spacing)),
            density: 1000.0,
            motion: Motion::Dynamic,
            pose,
            velocity: Velocity::default(),
            surface: SurfaceProperties::new(0.5, 0.5),
        });
    }

    /// A ball moving through a wall first touches it on the line of its centre, for any sample
    /// spacing.
    #[test]
    fn a_ball_touches_a_wall_on_the_line_of_its_centre() {
        for (y, z) in [(0.5, 1.5), (-0.5, 0.25), (-1.03, -2.07), (0.111, 0.0)] {
            for order in [false, true] {
                let mut bodies = Bodies::default();
                let wall = ClosedForm::Box { half: DVec3::new(0.2, 2.0, 3.0) };
                let still = Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY };
                let ball = Pose {
                    position: DVec3::new(0.9, y, z),
                    orientation: DQuat::from_rotation_y(0.3),
                };
                if order {
                    spawn(&mut bodies, wall, 0.4, still);
                    spawn(&mut bodies, ClosedForm::Sphere { radius: 0.5 }, 0.2, ball);
                } else {
                    spawn(&mut bodies, ClosedForm::Sphere { radius: 0.5 }, 0.2, ball);
                    spawn(&mut bodies, wall, 0.4, still);
                }
                let pair = Pair { first: 0, second: 1 };
                let mut predicted = bodies.poses.clone();
                predicted[usize::from(order)].position.x = 0.1;
                let both = |poses: &[Pose]| [poses[0], poses[1]];
                let (still, ahead) = (both(&bodies.poses), both(&predicted));
                let (contact, _) = first_contact(&bodies, pair, [&still, &ahead]).unwrap();
                // At the time of a sample's touch the ball has moved a little further.
                let off = contact.point - DVec3::new(0.2, y, z);
                assert!(
                    off.with_x(0.0).length() < 1e-3 && off.x.abs() < 0.02,
                    "{off} beside the line"
                );
                let towards_ball = if order { -contact.normal } else { contact.normal };
                assert!((towards_ball - DVec3::X).length() < 1e-3, "{}", contact.normal);
                assert!(first_contact(&bodies, pair, [&still, &still]).is_none(), "nobody moves");
            }
        }
    }
}
