//! Blows: impacts above a body's strength [Su09 sec. 4.2].

use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::impulse::pair_impulse::{
    Approach, PairImpulse, approach_at, deepest_approach, impulse_for,
};
use frangible_bodies::{BallisticPath, Bodies, BodyId, Frame, Pair, Pose};
use frangible_collision::{
    ContactPoint, ImpulseCache, ManifoldFinder, ManifoldPoint, NearSamples, PairMotion,
    first_contact, placed,
};
use glam::DVec3;

/// An impact above a body's strength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// The breaking body.
    pub body: BodyId,
    /// The other body.
    pub striker: BodyId,
    /// Point of impact, body frame [m].
    pub point_body: DVec3,
    /// Unit vector out of the body and towards the striker, body frame.
    pub normal_body: DVec3,
    /// First touch on the way to x^{n+1}, world frame [m].
    pub point_world: DVec3,
    /// Point of the impulse at the present poses, world frame [m].
    pub acts_at: DVec3,
    /// Impulse that would have stopped the collision [N s].
    pub impulse: f64,
    /// Impulse up to the strength, passed on before the break [N s].
    pub borne: f64,
}

/// How much stronger a body, by dense index, is at a point of its frame [m] than where it is
/// weakest; at least 1.
pub type LocalStrength<'a> = &'a dyn Fn(usize, DVec3) -> f64;

/// First contact point of a pair, and the poses of both bodies at first touch.
pub(crate) type Touch = (ContactPoint, [Pose; 2]);

/// Blows of a pair, one per body, if an impulse at `acts_at` of `size` [N s] exceeds the smaller
/// strength [Su09 sec. 4.2]. The weaker body breaks. It passes on no more than its strength, hence
/// the stronger body breaks only at equal strength.
pub(crate) fn blows_of(
    bodies: &Bodies,
    pair: Pair,
    (acts_at, size): (DVec3, f64),
    local: LocalStrength,
    first_touch: impl FnOnce() -> Touch,
) -> [Option<Blow>; 2] {
    if size <= smaller_strength(bodies, pair) {
        return [None; 2];
    }
    let (contact, [pose_first, pose_second]) = first_touch();
    let strength = |i: usize, pose: Pose| {
        let strength = strength(bodies, i);
        let point = || pose.world_from_body().inverse().point(contact.point);
        if strength.is_finite() { strength * local(i, point()) } else { strength }
    };
    let borne = strength(pair.first, pose_first).min(strength(pair.second, pose_second));
    if size <= borne {
        return [None; 2];
    }
    let blow = |body: usize, striker: usize, pose: Pose, outward: DVec3| {
        let body_from_world = pose.world_from_body().inverse();
        (strength(body, pose) == borne).then(|| Blow {
            body: bodies.ids[body],
            striker: bodies.ids[striker],
            point_body: body_from_world.point(contact.point),
            normal_body: body_from_world.direction(outward),
            point_world: contact.point,
            acts_at,
            impulse: size,
            borne,
        })
    };
    let normal = contact.normal;
    [
        blow(pair.first, pair.second, pose_first, -normal),
        blow(pair.second, pair.first, pose_second, normal),
    ]
}

/// Strength of a body where it is weakest: the largest impulse before it breaks [N s].
fn strength(bodies: &Bodies, i: usize) -> f64 {
    if bodies.inertias[i].is_infinite() { f64::INFINITY } else { bodies.surfaces[i].strength }
}

/// Smaller strength of a pair: the largest impulse through its contact [N s].
fn smaller_strength(bodies: &Bodies, pair: Pair) -> f64 {
    strength(bodies, pair.first).min(strength(bodies, pair.second))
}

/// Finds the blows of a frame before any motion: for each pair, the impulse that would stop the
/// first touch on the way to `predicted`. Both bodies receive an impulse up to the smaller strength
/// at once. A broken body takes no further blows.
pub fn strike(
    bodies: &mut Bodies,
    pairs: &[Pair],
    predicted: &[Pose],
    local: LocalStrength,
    frame: &Frame,
    accounts: &mut FrameAccounts,
) -> Vec<Blow> {
    let mut blows = Vec::new();
    // Without breakable bodies skip all pairs; a heap has tens of thousands.
    if (0..bodies.len()).all(|i| strength(bodies, i).is_infinite()) {
        return blows;
    }
    let mut broken = vec![false; bodies.len()];
    let mut finder = ManifoldFinder::default();
    for &pair in pairs {
        if broken[pair.first] || broken[pair.second] || withstands_all(bodies, pair, frame) {
            continue;
        }
        let Some((approach, touch)) = next_touch(bodies, pair, predicted, &mut finder, frame)
        else {
            continue;
        };
        let surfaces = bodies.pair_surface(pair.first, pair.second);
        let impulse = impulse_for(pair, &approach, &bodies.poses, &bodies.inertias, surfaces);
        let acts = (approach.contact.point, impulse.at_contact.length());
        let of_pair = blows_of(bodies, pair, acts, local, || {
            first_contact(bodies, pair, predicted).unwrap_or(touch)
        });
        let Some(borne) =
            of_pair.iter().flatten().map(|blow| blow.borne / blow.impulse).reduce(f64::min)
        else {
            continue;
        };

        // Apply the impulse up to the smaller strength.
        pass_on(bodies, pair, &approach, &impulse.scaled(borne), frame, accounts);
        for (blow, i) in of_pair.into_iter().zip([pair.first, pair.second]) {
            broken[i] |= blow.is_some();
            blows.extend(blow);
        }
    }
    blows
}

/// True if no impulse between a pair within the frame can exceed its smaller strength. An impulse
/// without energy gain satisfies `|u + K j| <= |u|` in the norm of the pair's K, hence never
/// exceeds twice the reduced mass times the relative speed.
fn withstands_all(bodies: &Bodies, pair: Pair, frame: &Frame) -> bool {
    let borne = smaller_strength(bodies, pair);
    let answer =
        bodies.inertias[pair.first].inverse_mass + bodies.inertias[pair.second].inverse_mass;
    if borne.is_infinite() {
        return true;
    }
    let [first, second] = BallisticPath::of_pair(bodies, pair, frame);
    borne * answer >= 2.0 * PairMotion::new(bodies, pair, [&first, &second], frame).most_speed
}

/// A collision within the frame.
#[derive(Clone, Copy, Debug)]
pub struct UpcomingImpact {
    /// Relative motion at the contact, at the frame's start.
    pub approach: Approach,
    /// Impulse that would stop the approach.
    pub impulse: PairImpulse,
    /// Point of first touch, world frame [m].
    pub point: DVec3,
    /// Poses of both bodies at first touch.
    pub poses: [Pose; 2],
}

/// The next collision of a pair on the way to `predicted`, if any.
pub fn upcoming_impact(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    frame: &Frame,
) -> Option<UpcomingImpact> {
    let finder = &mut ManifoldFinder::default();
    let (approach, (contact, poses)) = next_touch(bodies, pair, predicted, finder, frame)?;
    let surfaces = bodies.pair_surface(pair.first, pair.second);
    let impulse = impulse_for(pair, &approach, &bodies.poses, &bodies.inertias, surfaces);
    Some(UpcomingImpact { approach, impulse, point: contact.point, poses })
}

/// Applies an impulse to a pair before the frame's motion, clamped to the available energy, and
/// books it.
pub fn pass_on(
    bodies: &mut Bodies,
    pair: Pair,
    approach: &Approach,
    impulse: &PairImpulse,
    frame: &Frame,
    accounts: &mut FrameAccounts,
) {
    let impulse = if frame.settings.impulse_clamp {
        impulse.clamped_to_energy(bodies, pair, approach, &bodies.velocities, &mut accounts.clamps)
    } else {
        *impulse
    };
    accounts.book_impulse(bodies, pair, approach, &impulse, (&bodies.velocities, Cause::Collision));
    impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
}

/// Relative motion at the first touch within the frame, at the frame's start, and the touch.
fn next_touch(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    finder: &mut ManifoldFinder,
    frame: &Frame,
) -> Option<(Approach, Touch)> {
    // Find the manifold point with the earliest time of impact.
    let manifold = finder.find(bodies, pair, &ImpulseCache::default(), frame);
    let due = |point: &ManifoldPoint| {
        let [on_first, on_second] = point.on_surfaces(bodies, pair);
        let time = (on_first - on_second).dot(point.normal).max(0.0) / point.approach;
        (point.approach > 0.0 && time <= frame.dt).then_some(time)
    };
    let points = manifold.iter().flat_map(|manifold| manifold.points);
    let first =
        points.filter_map(|point| Some((due(point)?, point))).min_by(|a, b| a.0.total_cmp(&b.0));
    if let Some((time, point)) = first {
        let contact = ContactPoint { point: point.middle(bodies, pair), normal: point.normal };
        let mut approach = approach_at(bodies, pair, contact, &bodies.poses, &bodies.velocities);
        // Gravity adds to the approach speed.
        let speed = approach.relative_velocity.dot(point.normal);
        approach.relative_velocity -= (speed + point.approach) * point.normal;
        let poses = [pair.first, pair.second]
            .map(|i| between(&bodies.poses[i], &predicted[i], time / frame.dt));
        let anchor_world = poses[0].world_from_body().point(point.anchor_first);
        let point_world = anchor_world - point.rounding[0] * point.normal;
        return Some((
            approach,
            (ContactPoint { point: point_world, normal: point.normal }, poses),
        ));
    }

    // Fast rotation may cause a contact without an approaching point: test the end of the frame.
    finder.penetration(bodies, pair, predicted)?;
    let (first, second) = placed(bodies, pair, predicted);
    let mut penetrations = Vec::new();
    NearSamples::gather(first, second, 0.0).find_penetrations(
        first,
        second,
        0.0,
        &mut penetrations,
    );
    let seen = deepest_approach(bodies, pair, &mut penetrations, predicted, &bodies.velocities)?;
    let approach = approach_at(bodies, pair, seen.contact, &bodies.poses, &bodies.velocities);
    let approaches = approach.relative_velocity.dot(seen.contact.normal) < 0.0;
    approaches
        .then_some((approach, (seen.contact, [predicted[pair.first], predicted[pair.second]])))
}

/// Linear interpolation of a pose by `part`, spherical for the orientation.
fn between(from: &Pose, to: &Pose, part: f64) -> Pose {
    Pose {
        position: from.position.lerp(to.position, part),
        orientation: from.orientation.slerp(to.orientation, part),
    }
}
