//! Containment: the core of a body, a ball inside it, does not pass through another body within a
//! frame, however fast the body leaves its contacts and turns. Contacts stop nearly all bodies
//! before.

use crate::energy::frame_accounts::{FrameAccounts, kinematic_work};
use crate::impulse::pair_impulse::{PairImpulse, approach_at, pair_contact_matrix};
use frangible_bodies::{Bodies, Frame, Motion, Pair, Pose, Substeps, evolve};
use frangible_collision::{ContactPoint, Manifold};
use frangible_geometry::{Geometry, Part, Shape};
use glam::DVec3;

/// Distance from another body at which a core's centre stops, relative to the core's radius [1]: a
/// body at rest is further away.
const STOPS_AT: f64 = 0.25;

/// Least way of a core in a frame, relative to its body's radius [1], that is looked at: bodies at
/// rest and slow ones cost nothing.
const LEAST_WAY: f64 = 0.05;

/// Least relative way of two bodies, relative to the smaller one's radius [1]: with a quarter of it
/// the solver takes a tenth longer in a deep pile.
const LEAST_WAY_OF_PAIR: f64 = 0.2;

/// Maximum number of steps along a straight part of a core's way [1]. Towards a convex body each
/// goes to the plane that is next to the core: three arrive. Along a surface of any other kind a
/// step is no longer than the distance from it: a ball of 5 cm along a wall of triangles at 200 m/s
/// and 30 Hz takes 180; with 64 steps such balls, pushed off their ways by others, left rooms of
/// triangles: one of 150 in a second.
const MOST_STEPS: u32 = 1024;

/// Maximum turn of the two bodies along a part of the way that is taken to be straight [rad]: an
/// arm's end strays from it by a thousandth of the arm.
const STRAIGHT: f64 = 0.1;

/// Maximum number of meetings of a body in a frame [1]: as many cores of a spinning compound may be
/// beyond a plate.
const MOST_STOPS: u32 = 8;

/// Fraction of the stopping distance at which a core has arrived [1].
const ARRIVED: f64 = 1e-3;

/// A ball inside a body.
struct Core {
    /// Body frame [m].
    center: DVec3,
    /// [m]
    radius: f64,
}

impl Core {
    /// One about the middle of each part of a compound; one about the centre of mass of another
    /// shape, if that lies inside.
    fn all_of(shape: &Shape) -> Vec<Self> {
        if let Some(compound) = &shape.compound {
            let of_part = |part: &Part| {
                let vertices = part.hull.vertices();
                let center = vertices.iter().sum::<DVec3>() / vertices.len() as f64;
                Self { center, radius: -part.hull.distance_and_gradient(center).0 }
            };
            return compound.parts().iter().map(of_part).collect();
        }
        let radius = -shape.distance_and_gradient(DVec3::ZERO).0;
        if radius > 0.0 { vec![Self { center: DVec3::ZERO, radius }] } else { Vec::new() }
    }
}

/// The place where a core meets another body first.
struct Meeting {
    other: usize,
    /// Centre of the core, body frame [m].
    center: DVec3,
    /// Fraction of the core's way [1].
    fraction: f64,
    /// Its place seen from the other body, in the world at the frame's end [m].
    position: DVec3,
    /// Unit, world frame, out of the other body.
    normal: DVec3,
}

/// Stops the cores that went through another body since the frame's start, where they met it, and
/// takes their velocity into it. Bodies without contacts keep to their paths, which the broad phase
/// knows. Fixed bodies are tested against all cores, the larger body of each manifold against those
/// of the smaller one.
pub(super) fn contain(
    bodies: &mut Bodies,
    manifolds: &[Manifold],
    (starts, substeps): (&[Pose], &[Substeps]),
    frame: &Frame,
    accounts: &mut FrameAccounts,
) {
    let fixed: Vec<usize> =
        (0..bodies.len()).filter(|&i| bodies.inertias[i].is_infinite()).collect();
    let moves =
        |bodies: &Bodies, i: usize| bodies.motions[i] == Motion::Dynamic && substeps[i].count > 0;
    for body in 0..bodies.len() {
        let way = bodies.poses[body].position.distance(starts[body].position);
        if moves(bodies, body) && way > LEAST_WAY * bodies.radii[body] {
            stop(bodies, body, &fixed, (starts, frame), accounts);
        }
    }
    for Manifold { pair, .. } in manifolds {
        if pair.both().iter().all(|&i| moves(bodies, i)) && may_pass(bodies, *pair, starts) {
            let [first, second] = pair.both();
            let is_first = bodies.radii[first] <= bodies.radii[second];
            let (body, other) = if is_first { (first, second) } else { (second, first) };
            stop(bodies, body, &[other], (starts, frame), accounts);
        }
    }
    keep_enclosed(bodies, starts, moves, frame, accounts);
}

/// Puts bodies back that have left the space which a closed sheet bounds, to where its surface is
/// nearest, and takes their velocity into it.
fn keep_enclosed(
    bodies: &mut Bodies,
    starts: &[Pose],
    moves: impl Fn(&Bodies, usize) -> bool,
    frame: &Frame,
    accounts: &mut FrameAccounts,
) {
    for [sheet, body] in bodies.enclosed() {
        let [own, shape] = [sheet, body].map(|i| bodies.shapes[i].clone());
        let Geometry::Mesh(mesh) = &own.geometry else { continue };
        let center = bodies.point_inside(body);
        for _ in 0..MOST_STOPS {
            let end = end_of(bodies, sheet, starts, frame).world_from_body();
            let point = end.inverse().point(bodies.poses[body].world_from_body().point(center));
            let seen = bodies.seen_by(mesh, sheet, body);
            let (distance, outward) = seen.distance_and_gradient(point);
            if distance >= 0.0 || !moves(bodies, body) {
                break;
            }
            let inside = STOPS_AT * inner_radius(&shape, center);
            let position = end.point(point + (inside - distance) * outward);
            let normal = end.direction(outward);
            let meeting = Meeting { other: sheet, center, fraction: 1.0, position, normal };
            part(bodies, body, &meeting, accounts);
        }
    }
}

/// Of a ball inside of a body, around a point that [`Bodies::point_inside`] found [m].
fn inner_radius(shape: &Shape, center: DVec3) -> f64 {
    let depth = |part: &Part| -part.hull.distance_and_gradient(center).0;
    let depth = match &shape.compound {
        Some(compound) => compound.parts().iter().map(depth).fold(0.0, f64::max),
        None => -shape.distance_and_gradient(center).0,
    };
    depth.max(0.0)
}

/// Pose of a body at the frame's end.
fn end_of(bodies: &Bodies, body: usize, starts: &[Pose], frame: &Frame) -> Pose {
    match bodies.motions[body] {
        Motion::Kinematic { .. } => {
            evolve(bodies, body, &starts[body], &bodies.velocities[body], frame)
        }
        Motion::Static | Motion::Dynamic => bodies.poses[body],
    }
}

/// True if two bodies moved far enough relative to each other.
fn may_pass(bodies: &Bodies, pair: Pair, starts: &[Pose]) -> bool {
    let [first, second] = pair.both().map(|i| bodies.poses[i].position - starts[i].position);
    let least = pair.both().map(|i| bodies.radii[i]).into_iter().fold(f64::INFINITY, f64::min);
    let way = (first - second).length();
    way > LEAST_WAY_OF_PAIR * least
}

/// Poses of two bodies on their way through a frame.
struct Way {
    starts: [Pose; 2],
    ends: [Pose; 2],
}

impl Way {
    /// A point of the first body, seen from the second, at a fraction of the way.
    fn seen(&self, point: DVec3, fraction: f64) -> DVec3 {
        let [body, other] = [0, 1].map(|side| {
            let (start, end) = (&self.starts[side], &self.ends[side]);
            let position = start.position.lerp(end.position, fraction);
            let orientation = start.orientation.slerp(end.orientation, fraction);
            Pose { position, orientation }.world_from_body()
        });
        other.inverse().point(body.point(point))
    }

    /// Number of parts of the way of a point of the first body that are straight, seen from the
    /// second [1].
    fn straight_parts(&self, point: DVec3) -> u32 {
        let turn =
            |side: usize| self.starts[side].orientation.angle_between(self.ends[side].orientation);
        let of_body = if point == DVec3::ZERO { 0.0 } else { turn(0) };
        ((of_body + turn(1)) / STRAIGHT).ceil().max(1.0) as u32
    }
}

/// Where a core of a body meets another body.
fn meeting(
    bodies: &Bodies,
    (starts, frame): (&[Pose], &Frame),
    [body, other]: [usize; 2],
    core: &Core,
) -> Option<Meeting> {
    let end = end_of(bodies, other, starts, frame);
    let way = Way { starts: [starts[body], starts[other]], ends: [bodies.poses[body], end] };
    let shape = &*bodies.shapes[other];
    let (fraction, point, gradient) = match &shape.compound {
        Some(compound) => {
            let of_part = |part: &Part| {
                first_meeting(&|point| part.hull.distance_and_gradient(point), true, &way, core)
            };
            let meetings = compound.parts().iter().filter_map(of_part);
            meetings.reduce(|a, b| if b.0 < a.0 { b } else { a })
        }
        None => {
            let is_convex =
                shape.hull.is_some() || matches!(shape.geometry, Geometry::ClosedForm(_));
            let mesh = match &shape.geometry {
                Geometry::Mesh(mesh) => Some(bodies.seen_by(mesh, other, body)),
                _ => None,
            };
            let is_mesh = mesh.is_some();
            let of_shape = |point| match mesh {
                Some(mesh) => mesh.distance_and_gradient(point),
                None => shape.distance_and_gradient(point),
            };
            let is_behind = |point| of_shape(point).0 <= 0.0;
            if is_mesh && is_behind(way.seen(core.center, 0.0)) {
                return None;
            }
            // A body past the border of an open mesh has not gone through it, whichever side of its
            // rim's planes it is on.
            let distance = |point| match of_shape(point) {
                (distance, outward) if is_mesh && distance < 0.0 => (-distance, -outward),
                in_front => in_front,
            };
            first_meeting(&distance, is_convex, &way, core)
        }
    }?;
    Some(Meeting {
        other,
        center: core.center,
        fraction,
        position: end.world_from_body().point(point),
        normal: end.orientation * gradient,
    })
}

/// Fraction of the way at which a core comes as near to a surface as it may, its centre and the
/// outward normal there in the body frame of the surface; `None` if it stays further away, or begins
/// inside. `distance` gives the signed distance and its gradient.
fn first_meeting(
    distance: &impl Fn(DVec3) -> (f64, DVec3),
    is_convex: bool,
    way: &Way,
    core: &Core,
) -> Option<(f64, DVec3, DVec3)> {
    let parts = way.straight_parts(core.center);
    let begin = way.seen(core.center, 0.0);
    let (start, _) = distance(begin);
    if start <= 0.0 {
        return None;
    }
    let nearest = (STOPS_AT * core.radius).min(0.5 * start);
    let mut from = begin;
    for part in 1..=parts {
        let to = way.seen(core.center, f64::from(part) / f64::from(parts));
        if let Some((share, point, normal)) =
            straight_meeting(distance, is_convex, [from, to], nearest)
        {
            return Some(((f64::from(part - 1) + share) / f64::from(parts), point, normal));
        }
        from = to;
    }
    None
}

/// The same along a straight way: its fraction at which the distance has fallen to `nearest` [m].
fn straight_meeting(
    distance: &impl Fn(DVec3) -> (f64, DVec3),
    is_convex: bool,
    [from, to]: [DVec3; 2],
    nearest: f64,
) -> Option<(f64, DVec3, DVec3)> {
    let way = to - from;
    let mut fraction = 0.0;
    for _ in 0..MOST_STEPS {
        let point = from + fraction * way;
        let (gap, gradient) = distance(point);
        let left = gap - nearest;
        if left <= ARRIVED * nearest {
            return Some((fraction, point, gradient));
        }
        // All of a convex body lies behind the plane through its nearest point.
        let closing = if is_convex { -way.dot(gradient) } else { way.length() };
        if left >= (1.0 - fraction) * closing {
            return None;
        }
        fraction += left / closing;
    }
    None
}

/// Stops a body where one of its cores meets one of some other bodies first, until none does.
fn stop(
    bodies: &mut Bodies,
    body: usize,
    others: &[usize],
    start: (&[Pose], &Frame),
    accounts: &mut FrameAccounts,
) {
    let cores = Core::all_of(&bodies.shapes[body]);
    for _ in 0..MOST_STOPS {
        let met = &*bodies;
        let meetings = others.iter().flat_map(|&other| {
            cores.iter().filter_map(move |core| meeting(met, start, [body, other], core))
        });
        let first = meetings.reduce(|a, b| if b.fraction < a.fraction { b } else { a });
        let Some(meeting) = first else { return };
        part(bodies, body, &meeting, accounts);
    }
}

/// Moves a body, and a dynamic body that it met the opposite way by their masses, until the core is
/// where they met; and takes its velocity into the other body by an impulse at the core's centre.
fn part(
    bodies: &mut Bodies,
    body: usize,
    &Meeting { other, center, position, normal, .. }: &Meeting,
    accounts: &mut FrameAccounts,
) {
    let back = position - bodies.poses[body].world_from_body().point(center);
    let [own, of_other] = [body, other].map(|i| bodies.inertias[i].inverse_mass);
    let share = own / (own + of_other);
    bodies.poses[body].position += share * back;
    if of_other > 0.0 {
        bodies.poses[other].position -= (1.0 - share) * back;
    }

    let pair = Pair { first: body, second: other };
    let point = bodies.poses[body].world_from_body().point(center);
    let contact = ContactPoint { point, normal };
    let approach = approach_at(bodies, pair, contact, &bodies.poses, &bodies.velocities);
    let inward = -approach.relative_velocity.dot(normal);
    if inward > 0.0 {
        let k = pair_contact_matrix(pair, approach.levers, &bodies.poses, &bodies.inertias);
        let impulse = PairImpulse::new(&approach, inward / normal.dot(k * normal) * normal);
        impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
        // The island's change of angular momentum is booked as a whole.
        let j = impulse.at_contact;
        for (on, by, j) in [(body, other, j), (other, body, -j)] {
            let work = kinematic_work(bodies, by, j, point.cross(j));
            accounts.book_outside(bodies, [on, by], (j, DVec3::ZERO), work);
        }
    }
    accounts.link(bodies, Pair { first: body.min(other), second: body.max(other) });
}
