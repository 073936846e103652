//! Where a pair touches, or may touch within the frame: a few points, found once at the frame's start. Balls and convex polyhedra
//! have ways of their own; everything else meets by the samples of each body in the level set of the other [GBF03 sec. 3].

use crate::ball_contact::BallContact;
use crate::compound_contact::compound_points;
use crate::detection::{ContactPoint, NearSamples, Penetration, contact_point, radius};
use crate::flight::Flight;
use crate::hull_contact::hull_points;
use crate::pair::{Pair, placed};
use crate::plane_contact::plane_points;
use crate::warm_start::{WarmStart, sample_key};
use crate::{Bodies, Frame};
use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, Shape};
use glam::DVec3;

/// One point of contact: a point on each body's surface, that coincide when the gap is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// In the first body's frame [m].
    pub anchor_first: DVec3,
    /// In the second body's frame [m].
    pub anchor_second: DVec3,
    /// Distances from the anchors to the surfaces along the normal [m]: a ball's anchor is its centre, so that it need not turn with it.
    pub rounding: [f64; 2],
    /// Unit, world frame, from the second body to the first.
    pub normal: DVec3,
    /// Which sample or feature this is, and whether of the first body, to find it again in the next frame.
    pub sample: (bool, u64),
    /// Speed at which the surfaces will meet, or at which they close now if they touch already [m/s]; zero if they separate.
    pub approach: f64,
}

impl ManifoldPoint {
    /// Where it is on the two surfaces, in the world [m].
    pub fn on_surfaces(&self, bodies: &Bodies, pair: Pair) -> [DVec3; 2] {
        let [first, second] = [(pair.first, self.anchor_first), (pair.second, self.anchor_second)]
            .map(|(i, anchor)| bodies.poses[i].world_from_body().point(anchor));
        [first - self.rounding[0] * self.normal, second + self.rounding[1] * self.normal]
    }
}

/// The points of a pair.
#[derive(Clone, Debug, PartialEq)]
pub struct Manifold {
    /// Who.
    pub pair: Pair,
    /// At most [`MOST_POINTS`].
    pub points: Vec<ManifoldPoint>,
}

/// Points of a pair that are kept: a face on a face needs four, a concave body in a corner some more.
const MOST_POINTS: usize = 8;

/// Pairs of edges of two hulls, above which samples are found faster than separating axes.
pub(crate) const MOST_EDGE_PAIRS: usize = 1 << 16;

/// The manifolds of all pairs that may touch within the frame, in the order of the pairs. Points that are in `warm` carried
/// in the last frame.
pub fn find_manifolds(bodies: &Bodies, pairs: &[Pair], warm: &WarmStart, frame: &Frame) -> Vec<Manifold> {
    let manifold = |&pair: &Pair| {
        let points = find_points(bodies, pair, warm, frame);
        (!points.is_empty()).then_some(Manifold { pair, points })
    };
    pairs.iter().filter_map(manifold).collect()
}

fn find_points(bodies: &Bodies, pair: Pair, warm: &WarmStart, frame: &Frame) -> Vec<ManifoldPoint> {
    // Balls, polyhedra and planes need no samples.
    let (first, second) = placed(bodies, pair, &bodies.poses);
    if let Some(points) = compound_points(bodies, pair, frame) {
        return points;
    }
    if let Some(points) = exact_points(bodies, pair, [Solid::of(first.shape), Solid::of(second.shape)], frame)
    {
        return points;
    }
    // Everything else has samples.
    let candidates = find_candidates(bodies, pair, frame);
    choose(bodies, pair, &candidates, warm)
        .into_iter()
        .map(|index| candidates[index].point(bodies, pair))
        .collect()
}

/// What a body, or a part of one, is to those it meets.
#[derive(Clone, Copy)]
pub(crate) enum Solid<'a> {
    /// Of this radius [m].
    Ball(f64),
    /// In the body frame.
    Hull(&'a Hull),
    /// In the body frame.
    Ground(HalfSpace),
    /// Anything else.
    Other(&'a Shape),
}

impl<'a> Solid<'a> {
    pub(crate) fn of(shape: &'a Shape) -> Self {
        match (&shape.geometry, &shape.hull) {
            (Geometry::ClosedForm(ClosedForm::Sphere { radius }), _) => Self::Ball(*radius),
            (Geometry::ClosedForm(ClosedForm::HalfSpace(half_space)), _) => Self::Ground(*half_space),
            (_, Some(hull)) => Self::Hull(hull),
            _ => Self::Other(shape),
        }
    }

    /// Signed distance [m] and its unit gradient at a point in the body frame [m].
    pub(crate) fn distance_and_gradient(&self, point_body: DVec3) -> (f64, DVec3) {
        match self {
            Self::Ball(radius) => {
                (point_body.length() - radius, point_body.try_normalize().unwrap_or(DVec3::Y))
            }
            Self::Hull(hull) => hull.distance_and_gradient(point_body),
            Self::Ground(half_space) => (half_space.distance(point_body), half_space.normal),
            Self::Other(shape) => shape.distance_and_gradient(point_body),
        }
    }
}

/// The points of a pair of which one is a ball, or that has features; `None` for others.
pub(crate) fn exact_points(
    bodies: &Bodies,
    pair: Pair,
    solids: [Solid; 2],
    frame: &Frame,
) -> Option<Vec<ManifoldPoint>> {
    let ball = |ball_is_first: bool, radius: f64, other: Solid| {
        let surface = &|point: DVec3| other.distance_and_gradient(point);
        BallContact { bodies, pair, ball_is_first, radius, surface }.point(frame).into_iter().collect()
    };
    match solids {
        [Solid::Ball(radius), other] => Some(ball(true, radius, other)),
        [other, Solid::Ball(radius)] => Some(ball(false, radius, other)),
        [Solid::Hull(a), Solid::Hull(b)] if a.edges().len() * b.edges().len() <= MOST_EDGE_PAIRS => {
            Some(hull_points(bodies, pair, [a, b], frame))
        }
        [Solid::Hull(hull), Solid::Ground(ground)] => {
            Some(plane_points(bodies, pair, hull, true, ground, frame))
        }
        [Solid::Ground(ground), Solid::Hull(hull)] => {
            Some(plane_points(bodies, pair, hull, false, ground, frame))
        }
        _ => None,
    }
}

/// A sample that may touch within the frame.
struct Candidate {
    sample: (bool, u64),
    contact: ContactPoint,
    /// Signed distance from the other body at the frame's start [m].
    phi: f64,
    /// See [`ManifoldPoint::approach`].
    approach: f64,
}

/// All samples of a pair that may touch within the frame.
fn find_candidates(bodies: &Bodies, pair: Pair, frame: &Frame) -> Vec<Candidate> {
    let (first, second) = placed(bodies, pair, &bodies.poses);
    let reach = reach(bodies, pair, frame) as f32;
    let mut penetrations = Vec::new();
    NearSamples::gather(first, second, reach).find_penetrations(first, second, reach, &mut penetrations);
    let candidate = |penetration: &Penetration| {
        let contact = contact_point(first, second, penetration);
        let phi = f64::from(penetration.phi);
        let closing = -approach_speed(bodies, pair, contact.point, contact.normal);
        let approach = surface_speed(bodies, pair, contact.normal, closing, phi, frame);
        let sample = (penetration.sample_of_first, penetration.sample.into());
        // What separates, or is too far to get there, is left out.
        let touches = phi <= 0.0 || phi < frame.dt * closing + sag(frame);
        touches.then_some(Candidate { sample, contact, phi, approach })
    };
    penetrations.iter().filter_map(candidate).collect()
}

/// Indices of the candidates that are kept: the deepest, those that carried in the last frame, and then always the one that is
/// furthest from those that are kept.
fn choose(bodies: &Bodies, pair: Pair, candidates: &[Candidate], warm: &WarmStart) -> Vec<usize> {
    let distance =
        |a: usize, b: usize| candidates[a].contact.point.distance_squared(candidates[b].contact.point);
    let deepest = (0..candidates.len()).min_by(|&a, &b| candidates[a].phi.total_cmp(&candidates[b].phi));
    let Some(deepest) = deepest else { return Vec::new() };
    let mut chosen = vec![deepest];
    let mut away: Vec<f64> = (0..candidates.len()).map(|index| distance(index, deepest)).collect();
    let mut keep = |next: usize, away: &mut Vec<f64>| {
        for (index, away) in away.iter_mut().enumerate() {
            *away = away.min(distance(index, next));
        }
        chosen.push(next);
        chosen.len() < MOST_POINTS
    };

    let mut room = true;
    for (index, candidate) in candidates.iter().enumerate() {
        if room && away[index] > 0.0 && warm.contains_key(&sample_key(bodies, pair, candidate.sample)) {
            room = keep(index, &mut away);
        }
    }
    while room {
        let furthest = (0..away.len()).max_by(|&a, &b| away[a].total_cmp(&away[b]).then(b.cmp(&a)));
        room = furthest.is_some_and(|next| away[next] > 0.0 && keep(next, &mut away));
    }
    chosen
}

impl Candidate {
    /// Its anchors: the sample, and the foot of its distance on the other body.
    fn point(&self, bodies: &Bodies, pair: Pair) -> ManifoldPoint {
        let ContactPoint { point, normal } = self.contact;
        let [on_first, on_second] = if self.sample.0 {
            [point, point - self.phi * normal]
        } else {
            [point + self.phi * normal, point]
        };
        ManifoldPoint {
            anchor_first: into_body(bodies, pair.first, on_first),
            anchor_second: into_body(bodies, pair.second, on_second),
            rounding: [0.0; 2],
            normal,
            sample: self.sample,
            approach: self.approach,
        }
    }
}

pub(crate) fn into_body(bodies: &Bodies, i: usize, point_world: DVec3) -> DVec3 {
    bodies.poses[i].world_from_body().inverse().point(point_world)
}

/// Relative normal velocity of the pair's material at a point [m/s]; negative if they approach.
pub(crate) fn approach_speed(bodies: &Bodies, pair: Pair, point: DVec3, normal: DVec3) -> f64 {
    let velocity = |i: usize| {
        let lever = point - bodies.poses[i].position;
        bodies.point_velocity(i, &bodies.poses[i], &bodies.velocities[i], lever)
    };
    (velocity(pair.first) - velocity(pair.second)).dot(normal)
}

/// Speed at which a gap `phi` [m] that closes at `closing` [m/s] will be closed, gravity included [m/s].
pub(crate) fn surface_speed(
    bodies: &Bodies,
    pair: Pair,
    normal: DVec3,
    closing: f64,
    phi: f64,
    frame: &Frame,
) -> f64 {
    let falls = |i: usize| if bodies.inertias[i].is_infinite() { DVec3::ZERO } else { frame.gravity };
    let acceleration = -(falls(pair.first) - falls(pair.second)).dot(normal);
    let squared = closing * closing + 2.0 * acceleration * phi;
    if phi > 0.0 && closing > 0.0 { squared.max(0.0).sqrt() } else { closing.max(0.0) }
}

/// How far apart two surfaces may be and still meet within the frame [m].
pub(crate) fn reach(bodies: &Bodies, pair: Pair, frame: &Frame) -> f64 {
    let speed = |i: usize| {
        let Flight { linear, angular, .. } = Flight::of(bodies, i, frame);
        let spin = angular.length();
        // What has no bounds does not spin.
        (linear, if spin > 0.0 { spin * radius(&bodies.shapes[i]) } else { 0.0 })
    };
    let ((first, spin_first), (second, spin_second)) = (speed(pair.first), speed(pair.second));
    frame.dt * ((first - second).length() + spin_first + spin_second) + sag(frame)
}

/// How far a body falls in one frame from rest, twice over [m].
pub(crate) fn sag(frame: &Frame) -> f64 {
    frame.gravity.length() * frame.dt * frame.dt
}
