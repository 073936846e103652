//! Where a pair touches, or may touch within the frame: a few points, found once at the frame's
//! start. Balls and convex polyhedra have ways of their own; everything else meets by the samples
//! of each body in the level set of the other [GBF03 sec. 3].

pub(crate) mod found;

use crate::ball_contact::BallContact;
use crate::compound_contact::{compound_points, few};
use crate::detection::{ContactPoint, NearSamples, Penetration, Placed, contact_point};
use crate::encounter::Encounter;
use crate::hull_contact::Room;
use crate::hull_contact::approach::hull_points;
use crate::plane_contact::plane_points;
use crate::warm_start::WarmStart;
pub(crate) use found::Found;
pub use found::Manifolds;
use frangible_bodies::{Bodies, Flight, Frame, Pair, Pose};
use frangible_geometry::{ClosedForm, Geometry, HalfSpace, Hull, Shape};
use glam::DVec3;

/// One point of contact: a point on each body's surface, that coincide when the gap is closed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ManifoldPoint {
    /// In the first body's frame [m].
    pub anchor_first: DVec3,
    /// In the second body's frame [m].
    pub anchor_second: DVec3,
    /// Distances from the anchors to the surfaces along the normal [m]: a ball's anchor is its
    /// centre, so that it need not turn with it.
    pub rounding: [f64; 2],
    /// Unit, world frame, from the second body to the first.
    pub normal: DVec3,
    /// Which sample or feature this is, and whether of the first body, to find it again in the next
    /// frame.
    pub sample: (bool, u64),
    /// Speed at which the surfaces will meet, or at which they close now if they touch already
    /// [m/s]; zero if they separate, and for points that are kept from frame to frame also if it
    /// cannot be a [strike](crate::struck).
    pub approach: f64,
    /// Between the surfaces, where the bodies were when it was found or seen again [m].
    pub gap: f64,
}

impl ManifoldPoint {
    /// Where it is on the two surfaces, in the world [m].
    pub fn on_surfaces(&self, bodies: &Bodies, pair: Pair) -> [DVec3; 2] {
        self.on_surfaces_at([&bodies.poses[pair.first], &bodies.poses[pair.second]])
    }

    /// The same for bodies at these poses.
    pub(crate) fn on_surfaces_at(&self, poses: [&Pose; 2]) -> [DVec3; 2] {
        let first = poses[0].world_from_body().point(self.anchor_first);
        let second = poses[1].world_from_body().point(self.anchor_second);
        [first - self.rounding[0] * self.normal, second + self.rounding[1] * self.normal]
    }

    /// Where it acts, in the world [m]: between the surfaces, beside the corner that slides along
    /// the other body.
    pub(crate) fn middle(&self, bodies: &Bodies, pair: Pair) -> DVec3 {
        let [on_first, on_second] = self.on_surfaces(bodies, pair);
        let half = 0.5 * (on_first - on_second).dot(self.normal) * self.normal;
        if self.sample.0 { on_first - half } else { on_second + half }
    }
}

/// The points of a pair.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Manifold<'a> {
    /// Who.
    pub pair: Pair,
    /// At most [`MOST_POINTS`].
    pub points: &'a [ManifoldPoint],
}

/// Points of a pair that are kept: a face on a face needs four, a concave body in a corner some
/// more.
pub(crate) const MOST_POINTS: usize = 8;

/// Pairs of edges of two hulls, above which samples are found faster than separating axes.
pub(crate) const MOST_EDGE_PAIRS: usize = 1 << 16;

/// The manifolds of all pairs that may touch within the frame, in the order of the pairs. Points
/// that are in `warm` carried in the last frame.
pub fn find_manifolds(
    bodies: &Bodies,
    pairs: &[Pair],
    warm: &WarmStart,
    frame: &Frame,
) -> Manifolds {
    let (mut finder, mut found) = (ManifoldFinder::default(), Found::default());
    for &pair in pairs {
        if let Some(manifold) = finder.find(bodies, pair, warm, frame) {
            found.add(pair, manifold.points.iter().copied());
        }
    }
    Manifolds { parts: vec![found] }
}

/// Finds manifolds one by one, in room that it keeps; what it finds does not depend on what it
/// found before.
#[derive(Clone, Debug, Default)]
pub struct ManifoldFinder {
    pub(crate) room: Room,
    pub(crate) points: Vec<ManifoldPoint>,
}

impl ManifoldFinder {
    /// Where a pair may touch within the frame, if it may. Points that are in `warm` carried in the
    /// last frame.
    pub fn find(
        &mut self,
        bodies: &Bodies,
        pair: Pair,
        warm: &WarmStart,
        frame: &Frame,
    ) -> Option<Manifold<'_>> {
        let [first, second] = Flight::of_pair(bodies, pair, frame);
        let has_carried = |sample| warm.get(bodies, pair, sample).is_some();
        self.of_encounter(&Encounter::new(bodies, pair, [&first, &second], frame), has_carried)
    }

    /// Where a pair may touch on its way, if it may. Samples that have carried are kept.
    pub(crate) fn of_encounter(
        &mut self,
        encounter: &Encounter,
        has_carried: impl Fn((bool, u64)) -> bool,
    ) -> Option<Manifold<'_>> {
        let Encounter { bodies, pair, .. } = *encounter;
        let Self { room, points } = self;
        points.clear();
        if encounter.is_out_of_reach() {
            return None;
        }
        // Balls, polyhedra and planes need no samples; everything else has some.
        let solids =
            [Solid::of(&bodies.shapes[pair.first]), Solid::of(&bodies.shapes[pair.second])];
        if !compound_points(encounter, room, points)
            && !exact_points(encounter, solids, room, points)
        {
            let candidates = find_candidates(encounter);
            let chosen = choose(&candidates, has_carried);
            let chosen: Vec<ManifoldPoint> =
                chosen.into_iter().map(|index| candidates[index].point(encounter)).collect();
            points.extend(few(encounter, &chosen, room));
        }
        (!points.is_empty()).then_some(Manifold { pair, points })
    }
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
    #[inline]
    pub(crate) fn of(shape: &'a Shape) -> Self {
        match (&shape.geometry, &shape.hull) {
            (Geometry::ClosedForm(ClosedForm::Sphere { radius }), _) => Self::Ball(*radius),
            (Geometry::ClosedForm(ClosedForm::HalfSpace(half_space)), _) => {
                Self::Ground(*half_space)
            }
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

/// Adds the points of a pair of which one is a ball, or that has features; `false` for others.
pub(crate) fn exact_points(
    encounter: &Encounter,
    solids: [Solid; 2],
    room: &mut Room,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let ball = |ball_is_first: bool, radius: f64, other: Solid| {
        let surface = &|point: DVec3| other.distance_and_gradient(point);
        BallContact { encounter, ball_is_first, radius, surface }.point()
    };
    match solids {
        [Solid::Ball(radius), other] => points.extend(ball(true, radius, other)),
        [other, Solid::Ball(radius)] => points.extend(ball(false, radius, other)),
        [Solid::Hull(a), Solid::Hull(b)]
            if a.edges().len() * b.edges().len() <= MOST_EDGE_PAIRS =>
        {
            let _ = hull_points(encounter, [a, b], room, points);
        }
        [Solid::Hull(hull), Solid::Ground(ground)] => {
            let _ = plane_points(encounter, hull, true, ground, room, points);
        }
        [Solid::Ground(ground), Solid::Hull(hull)] => {
            let _ = plane_points(encounter, hull, false, ground, room, points);
        }
        _ => return false,
    }
    true
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
fn find_candidates(encounter: &Encounter) -> Vec<Candidate> {
    let (frame, [first, second]) = (encounter.frame, encounter.placed());
    if is_out_of_reach(first, second, encounter.reach)
        || is_out_of_reach(second, first, encounter.reach)
    {
        return Vec::new();
    }
    let reach = encounter.reach as f32;
    let mut penetrations = Vec::new();
    NearSamples::gather(first, second, reach).find_penetrations(
        first,
        second,
        reach,
        &mut penetrations,
    );
    let candidate = |penetration: &Penetration| {
        let contact = contact_point(first, second, penetration);
        let phi = f64::from(penetration.phi);
        let [of_first, of_second] =
            encounter.flights.map(|flight| flight.velocity(contact.point, 0.0));
        let closing = (of_second - of_first).dot(contact.normal);
        let approach = encounter.surface_speed(contact.normal, closing, phi);
        let sample = (penetration.sample_of_first, penetration.sample.into());
        // What separates, or is too far to get there, is left out.
        let touches = phi <= 0.0 || phi < frame.dt * closing + encounter.near;
        let touches = touches && !encounter.is_beside(sample.0, &contact);
        touches.then_some(Candidate { sample, contact, phi, approach })
    };
    penetrations.iter().filter_map(candidate).collect()
}

/// Whether a closed form is further than its reach [m] from a ball around another body.
fn is_out_of_reach(of: Placed, other: Placed, reach: f64) -> bool {
    let Geometry::ClosedForm(form) = &of.shape.geometry else { return false };
    let grid_from_world = of.pose.world_from_body().after(&of.shape.body_from_grid).inverse();
    form.distance(grid_from_world.point(other.pose.position)) > other.shape.radius() + reach
}

/// Indices of the candidates that are kept: the deepest, those that have carried, and then always
/// the one that is furthest from those that are kept.
fn choose(candidates: &[Candidate], has_carried: impl Fn((bool, u64)) -> bool) -> Vec<usize> {
    let distance = |a: usize, b: usize| {
        candidates[a].contact.point.distance_squared(candidates[b].contact.point)
    };
    let deepest =
        (0..candidates.len()).min_by(|&a, &b| candidates[a].phi.total_cmp(&candidates[b].phi));
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
        if room && away[index] > 0.0 && has_carried(candidate.sample) {
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
    fn point(&self, encounter: &Encounter) -> ManifoldPoint {
        let ContactPoint { point, normal } = self.contact;
        let [on_first, on_second] = if self.sample.0 {
            [point, point - self.phi * normal]
        } else {
            [point + self.phi * normal, point]
        };
        let into_body = |side: usize, point: DVec3| {
            encounter.flights[side].start.world_from_body().inverse().point(point)
        };
        ManifoldPoint {
            anchor_first: into_body(0, on_first),
            anchor_second: into_body(1, on_second),
            rounding: [0.0; 2],
            normal,
            sample: self.sample,
            approach: self.approach,
            gap: self.phi,
        }
    }
}
