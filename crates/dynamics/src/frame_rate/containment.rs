//! Containment: no body's centre passes into a static or kinematic body within a frame, however
//! fast the body leaves its contacts and turns. Contacts stop nearly all bodies before.

use crate::energy::frame_accounts::FrameAccounts;
use frangible_bodies::{Bodies, Frame, Motion, Pair, Pose, Substeps, evolve};
use frangible_geometry::Shape;
use glam::DVec3;

/// Distance from a fixed body at which a centre stops, relative to the largest ball around the
/// centre in its own body [1]: a body at rest is further away.
const STOPS_AT: f64 = 0.25;

/// Least way of a centre in a frame, relative to its body's radius [1], that is looked at: bodies
/// at rest and slow ones cost nothing.
const LEAST_WAY: f64 = 0.05;

/// Maximum number of steps along a centre's way [1]: each covers the distance to the fixed body.
const MOST_STEPS: u32 = 64;

/// Fraction of the stopping distance at which a centre has arrived [1].
const ARRIVED: f64 = 1e-3;

/// A static or kinematic body, with its pose at the frame's end.
struct Fixed {
    body: usize,
    end: Pose,
}

/// The place where a centre meets a fixed body first.
struct Meeting {
    fixed: usize,
    /// Fraction of the centre's way [1].
    fraction: f64,
    /// World frame, at the frame's end [m].
    position: DVec3,
    /// Unit, world frame, out of the fixed body.
    normal: DVec3,
    /// Velocity of the fixed body there [m/s].
    velocity: DVec3,
}

/// Stops the bodies whose centres went through a fixed body since the frame's start, where they
/// met it, and takes their velocity into it. Bodies without contacts keep to their paths, which the
/// broad phase knows.
pub(super) fn contain(
    bodies: &mut Bodies,
    (starts, substeps): (&[Pose], &[Substeps]),
    frame: &Frame,
    accounts: &mut FrameAccounts,
) {
    let end = |body: usize| match bodies.motions[body] {
        Motion::Kinematic { .. } => {
            evolve(bodies, body, &starts[body], &bodies.velocities[body], frame)
        }
        Motion::Static | Motion::Dynamic => starts[body],
    };
    let is_fixed = |&body: &usize| bodies.inertias[body].is_infinite();
    let all_fixed: Vec<Fixed> =
        (0..bodies.len()).filter(is_fixed).map(|body| Fixed { body, end: end(body) }).collect();
    for body in 0..bodies.len() {
        if bodies.motions[body] != Motion::Dynamic || substeps[body].count == 0 {
            continue;
        }
        let way = bodies.poses[body].position.distance(starts[body].position);
        if way <= LEAST_WAY * bodies.radii[body] {
            continue;
        }
        let core = -bodies.shapes[body].distance_and_gradient(DVec3::ZERO).0;
        let meetings =
            all_fixed.iter().filter_map(|fixed| meeting(bodies, starts, fixed, (body, core)));
        let Some(Meeting { fixed, position, normal, velocity, .. }) =
            meetings.reduce(|a, b| if b.fraction < a.fraction { b } else { a })
        else {
            continue;
        };
        let inward = (velocity - bodies.velocities[body].linear).dot(normal).max(0.0);
        let impulse = bodies.masses[body] * inward * normal;
        bodies.poses[body].position = position;
        bodies.velocities[body].linear += inward * normal;
        let work = impulse.dot(velocity);
        accounts.book_outside(bodies, [body, fixed], (impulse, DVec3::ZERO), work);
        accounts.link(bodies, Pair { first: body.min(fixed), second: body.max(fixed) });
    }
}

/// Where the centre of a body with a core [m] meets a fixed body.
fn meeting(
    bodies: &Bodies,
    starts: &[Pose],
    Fixed { body: fixed, end }: &Fixed,
    (body, core): (usize, f64),
) -> Option<Meeting> {
    let from = starts[*fixed].world_from_body().inverse().point(starts[body].position);
    let to = end.world_from_body().inverse().point(bodies.poses[body].position);
    let (fraction, point, gradient) = first_meeting(&bodies.shapes[*fixed], from, to, core)?;
    let position = end.world_from_body().point(point);
    let velocity = match bodies.motions[*fixed] {
        Motion::Kinematic { linear, angular } => linear + angular.cross(position - end.position),
        Motion::Static | Motion::Dynamic => DVec3::ZERO,
    };
    let normal = end.orientation * gradient;
    Some(Meeting { fixed: *fixed, fraction, position, normal, velocity })
}

/// Fraction of a way through the body frame of `shape` at which it comes as near as a core [m] may,
/// the point, and the outward normal there; `None` if it stays further away, or begins inside.
fn first_meeting(shape: &Shape, from: DVec3, to: DVec3, core: f64) -> Option<(f64, DVec3, DVec3)> {
    let length = from.distance(to);
    let direction = (to - from) / length;
    let (start, _) = shape.distance_and_gradient(from);
    let nearest = (STOPS_AT * core).min(0.5 * start);
    let mut along = 0.0;
    for _ in 0..MOST_STEPS {
        let point = from + along * direction;
        let (distance, gradient) = shape.distance_and_gradient(point);
        let left = distance - nearest;
        if left <= ARRIVED * nearest {
            return (start > 0.0).then_some((along / length, point, gradient));
        }
        along += left;
        if along >= length {
            return None;
        }
    }
    None
}
