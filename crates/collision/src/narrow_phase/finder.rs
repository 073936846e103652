//! Contact points of a pair, found once at the frame's start. Balls and convex polyhedra have exact
//! methods; all other shapes use samples of each body in the level set of the other [GBF03 sec. 3].

use crate::manifold::list::{Found, Manifolds};
use crate::manifold::{MOST_POINTS, Manifold, ManifoldPoint};
use crate::narrow_phase::compound::{compound_points, few};
use crate::narrow_phase::convex_pairs::exact_points;
use crate::narrow_phase::core::core_point;
use crate::narrow_phase::encounter::Encounter;
use crate::narrow_phase::hull_hull::room::Room;
use crate::narrow_phase::samples::{ContactPoint, NearSamples, Penetration, contact_point};
use crate::narrow_phase::solid::Solid;
use crate::penetration::penetration;
use crate::relative_motion::Placed;
use crate::warm_start::WarmStart;
use frangible_bodies::{Bodies, Flight, Frame, Pair, Pose};
use frangible_geometry::Geometry;
use glam::DVec3;

/// Manifolds of all pairs that may touch within the frame, in the order of the pairs. Points in
/// `warm` had an impulse in the last frame.
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

/// Finds manifolds with reused memory; results do not depend on earlier calls.
#[derive(Clone, Debug, Default)]
pub struct ManifoldFinder {
    pub(crate) room: Room,
    pub(crate) points: Vec<ManifoldPoint>,
}

impl ManifoldFinder {
    /// Manifold of a pair that may touch within the frame. Points in `warm` had an impulse in the
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

    /// Manifold of a pair that may touch in its motion. Samples with a cached impulse are kept.
    pub fn of_encounter(
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
        // Balls, polyhedra and planes need no samples; all other shapes have samples.
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
        core_point(encounter, solids, points);
        (!points.is_empty()).then_some(Manifold { pair, points })
    }

    /// Penetration depth of a pair at the given poses [m]; `None` without overlap.
    pub fn penetration(&mut self, bodies: &Bodies, pair: Pair, poses: &[Pose]) -> Option<f64> {
        penetration(bodies, pair, poses, &mut self.room)
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
        // Skip separating samples and samples beyond reach.
        let touches = phi <= 0.0 || phi < frame.dt * closing + encounter.near;
        let touches = touches && !encounter.is_beside(sample.0, &contact);
        touches.then_some(Candidate { sample, contact, phi, approach })
    };
    penetrations.iter().filter_map(candidate).collect()
}

/// True if a closed form is further than `reach` [m] from the bounding ball of another body.
fn is_out_of_reach(of: Placed, other: Placed, reach: f64) -> bool {
    let Geometry::ClosedForm(form) = &of.shape.geometry else { return false };
    let grid_from_world = of.pose.world_from_body().after(&of.shape.body_from_grid).inverse();
    form.distance(grid_from_world.point(other.pose.position)) > other.shape.radius() + reach
}

/// Indices of the kept candidates: the deepest, then candidates with a cached impulse, then
/// repeatedly the candidate furthest from all kept.
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
    /// Contact point between the sample and its foot on the other body.
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
