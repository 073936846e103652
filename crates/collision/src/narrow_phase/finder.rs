//! Contact points of a pair, found once at the frame's start. Balls, convex polyhedra, bodies of
//! revolution and static triangles have exact methods; all other shapes use samples of each body in
//! the level set of the other [GBF03 sec. 3].

use crate::impulse_cache::ImpulseCache;
use crate::manifold::list::{Found, Manifolds};
use crate::manifold::{FeatureId, MOST_POINTS, Manifold, ManifoldPoint};
use crate::narrow_phase::compound::compound_points;
use crate::narrow_phase::convex_pairs::exact_points;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::core::{core_points, turns_far};
use crate::narrow_phase::fixed_neighbours::FixedNeighbours;
use crate::narrow_phase::flat_contacts::few;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::pierced::{Pierced, pierced};
use crate::narrow_phase::samples::{ContactPoint, NearSamples, Penetration, contact_point};
use crate::narrow_phase::seam_contacts::mend_seams;
use crate::penetration::penetration;
use crate::relative_motion::Placed;
use frangible_bodies::{BallisticPath, Bodies, Frame, Pair, Pose};
use frangible_geometry::Geometry;
use glam::DVec3;

/// Manifolds of all pairs that may touch within the frame, in the order of the pairs. Points in
/// `warm` had an impulse in the last frame.
pub fn find_manifolds(
    bodies: &Bodies,
    pairs: &[Pair],
    warm: &ImpulseCache,
    frame: &Frame,
) -> Manifolds {
    let (mut finder, mut found) = (ManifoldFinder::default(), Found::default());
    let neighbours = FixedNeighbours::of_pairs(bodies, pairs.iter().copied());
    for &pair in pairs {
        let [first, second] = BallisticPath::of_pair(bodies, pair, frame);
        let has_carried = |feature| warm.get(bodies, pair, feature).is_some();
        let pair_motion = PairMotion::new(bodies, pair, [&first, &second], frame);
        if let Some(manifold) = finder.of_motion(&pair_motion.among(&neighbours), has_carried) {
            found.add(pair, manifold.points.iter().copied());
        }
    }
    Manifolds { parts: vec![found], neighbours, ..Manifolds::default() }
}

/// Finds manifolds with reused memory; results do not depend on earlier calls.
#[derive(Clone, Debug, Default)]
pub struct ManifoldFinder {
    pub(crate) scratch: Scratch,
    pub(crate) points: Vec<ManifoldPoint>,
}

impl ManifoldFinder {
    /// Manifold of a pair that may touch within the frame, without what stands beside it. Points in
    /// `warm` had an impulse in the last frame.
    pub fn find(
        &mut self,
        bodies: &Bodies,
        pair: Pair,
        warm: &ImpulseCache,
        frame: &Frame,
    ) -> Option<Manifold<'_>> {
        let [first, second] = BallisticPath::of_pair(bodies, pair, frame);
        let has_carried = |feature| warm.get(bodies, pair, feature).is_some();
        self.of_motion(&PairMotion::new(bodies, pair, [&first, &second], frame), has_carried)
    }

    /// Manifold of a pair that may touch in its motion. Samples with a cached impulse are kept.
    pub fn of_motion(
        &mut self,
        pair_motion: &PairMotion,
        has_carried: impl Fn(FeatureId) -> bool,
    ) -> Option<Manifold<'_>> {
        let PairMotion { bodies, pair, .. } = *pair_motion;
        let Self { scratch, points } = self;
        points.clear();
        if pair_motion.is_out_of_reach() {
            return None;
        }
        // Balls, polyhedra, planes and static triangles need no samples of their own; all other
        // shapes have samples.
        let convex_shapes = [
            ConvexShape::of(&bodies.shapes[pair.first]),
            ConvexShape::of(&bodies.shapes[pair.second]),
        ];
        // The parts of compounds mend their own seams.
        let is_compound = compound_points(pair_motion, scratch, points);
        if !is_compound && exact_points(pair_motion, convex_shapes, scratch, points) {
            mend_seams(pair_motion, convex_shapes, scratch, points);
        } else if !is_compound {
            let candidates = find_candidates(pair_motion);
            let chosen = choose(&candidates, has_carried);
            let chosen: Vec<ManifoldPoint> =
                chosen.into_iter().map(|index| candidates[index].point(pair_motion)).collect();
            points.extend(few(pair_motion, &chosen, scratch));
        }
        core_points(pair_motion, convex_shapes, points);
        (!points.is_empty()).then_some(Manifold { pair, points })
    }

    /// Penetration depth of a pair at the given poses [m]; `None` without overlap.
    pub fn penetration(&mut self, bodies: &Bodies, pair: Pair, poses: &[Pose]) -> Option<f64> {
        penetration(bodies, pair, poses)
    }
}

/// A sample that may touch within the frame.
struct Candidate {
    feature: FeatureId,
    contact: ContactPoint,
    /// Signed distance from the other body at the frame's start [m].
    phi: f64,
    /// See [`ManifoldPoint::approach`].
    approach: f64,
}

/// Candidates whose normals have at least this cosine press the same side: 45 degrees.
const SAME_SIDE: f64 = 0.7;

/// All samples of a pair that may touch within the frame.
fn find_candidates(pair_motion: &PairMotion) -> Vec<Candidate> {
    let (ahead, [first, second]) = (pair_motion.ahead, pair_motion.placed());
    if is_out_of_reach(first, second, pair_motion.reach)
        || is_out_of_reach(second, first, pair_motion.reach)
    {
        return Vec::new();
    }
    let reach = pair_motion.reach as f32;
    let turns = pair_motion.paths.iter().any(|path| turns_far(path, pair_motion));
    let mut penetrations = Vec::new();
    NearSamples::gather(first, second, reach).find_penetrations(
        first,
        second,
        reach,
        &mut penetrations,
    );
    let candidate = |penetration: &Penetration| {
        let is_of_first = penetration.sample_of_first;
        let seen = (contact_point(first, second, penetration), f64::from(penetration.phi));
        // Bodies that turn far may touch with another side than they have there now.
        let own = || pair_motion.seen_from_own(is_of_first, seen.0, seen.1);
        let (contact, phi) = if turns { Some(seen) } else { own() }?;
        let [of_first, of_second] = pair_motion.paths.map(|path| path.velocity(contact.point, 0.0));
        let closing = (of_second - of_first).dot(contact.normal);
        let approach = pair_motion.surface_speed(contact.normal, closing, phi);
        let feature = FeatureId { is_of_first, index: penetration.sample.into() };
        // Skip separating samples and samples beyond reach.
        let touches = phi <= 0.0 || phi < ahead * closing + pair_motion.near;
        touches.then_some(Candidate { feature, contact, phi, approach })
    };
    let mut candidates: Vec<Candidate> = penetrations.iter().filter_map(candidate).collect();
    if penetrations.is_empty() {
        return candidates;
    }
    for side in [0, 1] {
        let [body, other] = if side == 0 { [first, second] } else { [second, first] };
        if let Some(pierced) = pierced(body, other) {
            push_back(pair_motion, side == 0, &pierced, &mut candidates);
        }
    }
    candidates
}

/// Replaces the candidates of a body that has come through the other one by those that push it back
/// to the side of its centre.
fn push_back(
    pair_motion: &PairMotion,
    is_of_first: bool,
    pierced: &Pierced,
    candidates: &mut Vec<Candidate>,
) {
    let normal = if is_of_first { pierced.outward } else { -pierced.outward };
    candidates.retain(|candidate| {
        candidate.feature.is_of_first == is_of_first
            && candidate.contact.normal.dot(normal) >= SAME_SIDE
            && !pierced
                .samples
                .iter()
                .any(|&(sample, _)| u64::from(sample) == candidate.feature.index)
    });
    let body = pair_motion.placed()[usize::from(!is_of_first)];
    let world_from_body = body.pose.world_from_body();
    candidates.extend(pierced.samples.iter().map(|&(sample, phi)| {
        let point = world_from_body.point(body.shape.samples()[sample as usize].as_dvec3());
        let [of_first, of_second] = pair_motion.paths.map(|path| path.velocity(point, 0.0));
        let closing = (of_second - of_first).dot(normal);
        Candidate {
            feature: FeatureId { is_of_first, index: sample.into() },
            contact: ContactPoint { point, normal },
            phi,
            approach: pair_motion.surface_speed(normal, closing, phi),
        }
    }));
}

/// True if a closed form is further than `reach` [m] from the bounding ball of another body.
fn is_out_of_reach(of: Placed, other: Placed, reach: f64) -> bool {
    let Geometry::ClosedForm(form) = &of.shape.geometry else { return false };
    let grid_from_world = of.pose.world_from_body().after(&of.shape.body_from_grid).inverse();
    form.distance(grid_from_world.point(other.pose.position)) > other.shape.radius() + reach
}

/// Indices of the kept candidates: the deepest, then candidates with a cached impulse, then
/// repeatedly the candidate furthest beyond all kept. A candidate that lies higher above a kept one
/// than beside it touches later, and is left out.
fn choose(candidates: &[Candidate], has_carried: impl Fn(FeatureId) -> bool) -> Vec<usize> {
    let beyond = |a: usize, b: usize| candidates[a].beyond(&candidates[b]);
    let deepest =
        (0..candidates.len()).min_by(|&a, &b| candidates[a].phi.total_cmp(&candidates[b].phi));
    let Some(deepest) = deepest else { return Vec::new() };
    let mut chosen = vec![deepest];
    let mut away: Vec<f64> = (0..candidates.len()).map(|index| beyond(index, deepest)).collect();
    let mut keep = |next: usize, away: &mut Vec<f64>| {
        // Candidates left out stay out.
        for (index, away) in away.iter_mut().enumerate().filter(|(_, away)| **away > 0.0) {
            *away = away.min(beyond(index, next));
        }
        away[next] = 0.0;
        chosen.push(next);
        chosen.len() < MOST_POINTS
    };
    away[deepest] = 0.0;

    let mut room = true;
    for (index, candidate) in candidates.iter().enumerate() {
        if room && away[index] > 0.0 && has_carried(candidate.feature) {
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
    /// How much further this lies beside another candidate than above it [m]. A wall's points do
    /// not lie above a floor's: of different normals the distance counts.
    fn beyond(&self, other: &Self) -> f64 {
        let between = self.contact.point - other.contact.point;
        let normal = other.contact.normal;
        if normal.dot(self.contact.normal) < SAME_SIDE {
            return between.length();
        }
        let across = between - between.dot(normal) * normal;
        across.length() - (self.phi - other.phi)
    }

    /// Contact point between the sample and its foot on the other body.
    fn point(&self, pair_motion: &PairMotion) -> ManifoldPoint {
        let ContactPoint { point, normal } = self.contact;
        let [on_first, on_second] = if self.feature.is_of_first {
            [point, point - self.phi * normal]
        } else {
            [point + self.phi * normal, point]
        };
        let into_body = |side: usize, point: DVec3| {
            pair_motion.paths[side].start.world_from_body().inverse().point(point)
        };
        ManifoldPoint {
            anchor_first: into_body(0, on_first),
            anchor_second: into_body(1, on_second),
            rounding: [0.0; 2],
            normal,
            feature: self.feature,
            approach: self.approach,
            gap: self.phi,
        }
    }
}
