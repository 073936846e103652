//! Blows: what a body does not bear [Su09 sec. 4.2].

use crate::energy::tally::{Cause, Tally};
use crate::impulse::pair_impulse::{
    Approach, PairImpulse, approach_at, deepest_approach, impulse_for,
};
use frangible_bodies::{Bodies, BodyId, Flight, Frame, Pair, Pose};
use frangible_collision::{
    ContactPoint, Encounter, ManifoldFinder, ManifoldPoint, NearSamples, WarmStart, first_contact,
    placed,
};
use glam::DVec3;

/// A collision that a body does not bear.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Blow {
    /// Who breaks.
    pub body: BodyId,
    /// Who struck.
    pub striker: BodyId,
    /// Where, in the body's frame [m].
    pub point_body: DVec3,
    /// Unit, out of the body and towards the striker, in the body's frame.
    pub normal_body: DVec3,
    /// Where they first touched on their way to x^{n+1}, in the world frame [m].
    pub point_world: DVec3,
    /// Where the impulse acts, with the bodies where they are now, in the world frame [m].
    pub acts_at: DVec3,
    /// The impulse that would have stopped the collision [N s].
    pub impulse: f64,
    /// The part that the body bore and passed on before it broke [N s].
    pub borne: f64,
}

/// Where a pair first touches, with the poses of its bodies then.
pub(crate) type Touch = (ContactPoint, [Pose; 2]);

/// For each body of the pair, the blow if an impulse at `acts_at` of `size` [N s] is more than it
/// bears [Su09 sec. 4.2]. The weaker one breaks; the stronger feels no more than the weaker can
/// pass on, so it breaks only if they are equally strong.
pub(crate) fn blows_of(
    bodies: &Bodies,
    pair: Pair,
    (acts_at, size): (DVec3, f64),
    first_touch: impl FnOnce() -> Touch,
) -> [Option<Blow>; 2] {
    let borne = borne_by(bodies, pair);
    if size <= borne {
        return [None; 2];
    }
    let (contact, [pose_first, pose_second]) = first_touch();
    let blow = |body: usize, striker: usize, pose: Pose, outward: DVec3| {
        let body_from_world = pose.world_from_body().inverse();
        (strength(bodies, body) == borne).then(|| Blow {
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

/// What a body bears [N s].
fn strength(bodies: &Bodies, i: usize) -> f64 {
    if bodies.inertias[i].is_infinite() { f64::INFINITY } else { bodies.contactants[i].strength }
}

/// What the weaker one of a pair bears, and so the most that passes through their contact [N s].
fn borne_by(bodies: &Bodies, pair: Pair) -> f64 {
    strength(bodies, pair.first).min(strength(bodies, pair.second))
}

/// The blows of a frame before anything has moved: for each pair, the impulse that would stop it
/// where it first touches on its way to `predicted`. Both bodies receive at once what the weaker
/// one bears. A body that breaks is left alone from then on.
pub fn strike(
    bodies: &mut Bodies,
    pairs: &[Pair],
    predicted: &[Pose],
    frame: &Frame,
    tally: &mut Tally,
) -> Vec<Blow> {
    let mut blows = Vec::new();
    // Where all bear everything no pair has to be looked at, and a heap has tens of thousands.
    if (0..bodies.len()).all(|i| strength(bodies, i).is_infinite()) {
        return blows;
    }
    let mut broken = vec![false; bodies.len()];
    let mut finder = ManifoldFinder::default();
    for &pair in pairs {
        if broken[pair.first] || broken[pair.second] || bears_all(bodies, pair, frame) {
            continue;
        }
        let Some((approach, touch)) = next_touch(bodies, pair, predicted, &mut finder, frame)
        else {
            continue;
        };
        let surfaces = bodies.pair_contactant(pair.first, pair.second);
        let impulse = impulse_for(pair, &approach, &bodies.poses, &bodies.inertias, surfaces);
        let acts = (approach.contact.point, impulse.at_contact.length());
        let of_pair = blows_of(bodies, pair, acts, || {
            first_contact(bodies, pair, predicted).unwrap_or(touch)
        });
        let Some(borne) =
            of_pair.iter().flatten().map(|blow| blow.borne / blow.impulse).reduce(f64::min)
        else {
            continue;
        };

        // What is borne acts.
        pass_on(bodies, pair, &approach, &impulse.scaled(borne), frame, tally);
        for (blow, i) in of_pair.into_iter().zip([pair.first, pair.second]) {
            broken[i] |= blow.is_some();
            blows.extend(blow);
        }
    }
    blows
}

/// Whether both bodies of a pair bear whatever happens between them within the frame: no impulse
/// that makes no energy, and so lets `|u + K j| <= |u|` in the measure of the pair's K, is larger
/// than twice the reduced mass times their speed.
fn bears_all(bodies: &Bodies, pair: Pair, frame: &Frame) -> bool {
    let borne = borne_by(bodies, pair);
    let answer =
        bodies.inertias[pair.first].inverse_mass + bodies.inertias[pair.second].inverse_mass;
    if borne.is_infinite() {
        return true;
    }
    let [first, second] = Flight::of_pair(bodies, pair, frame);
    borne * answer >= 2.0 * Encounter::new(bodies, pair, [&first, &second], frame).most_speed
}

/// A collision within the frame.
#[derive(Clone, Copy, Debug)]
pub struct Coming {
    /// As seen at the frame's start.
    pub approach: Approach,
    /// What would stop it.
    pub impulse: PairImpulse,
    /// Where the two touch, in the world frame [m], and where they are then.
    pub point: DVec3,
    /// See `point`.
    pub poses: [Pose; 2],
}

/// The collision that a pair is about to have on its way to `predicted`, if any.
pub fn coming(bodies: &Bodies, pair: Pair, predicted: &[Pose], frame: &Frame) -> Option<Coming> {
    let finder = &mut ManifoldFinder::default();
    let (approach, (contact, poses)) = next_touch(bodies, pair, predicted, finder, frame)?;
    let surfaces = bodies.pair_contactant(pair.first, pair.second);
    let impulse = impulse_for(pair, &approach, &bodies.poses, &bodies.inertias, surfaces);
    Some(Coming { approach, impulse, point: contact.point, poses })
}

/// Lets an impulse act on a pair before the frame moves it, and books it: no more of it than the
/// energy allows.
pub fn pass_on(
    bodies: &mut Bodies,
    pair: Pair,
    approach: &Approach,
    impulse: &PairImpulse,
    frame: &Frame,
    tally: &mut Tally,
) {
    let impulse = if frame.settings.impulse_clamp {
        impulse.clamped_to_energy(bodies, pair, approach, &bodies.velocities, &mut tally.clamps)
    } else {
        *impulse
    };
    tally.book_impulse(bodies, pair, approach, &impulse, (&bodies.velocities, Cause::Collision));
    impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
}

/// How a pair approaches where it will touch first within the frame, seen at its start, and the
/// touch itself.
fn next_touch(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    finder: &mut ManifoldFinder,
    frame: &Frame,
) -> Option<(Approach, Touch)> {
    // Of the points of its manifold, the one whose gap closes first.
    let manifold = finder.find(bodies, pair, &WarmStart::default(), frame);
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
        // Gravity adds to the speed on the way.
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

    // What turns fast may touch though no point of it approaches now: look at the frame's end.
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

/// A part of the way from one pose to another.
fn between(from: &Pose, to: &Pose, part: f64) -> Pose {
    Pose {
        position: from.position.lerp(to.position, part),
        orientation: from.orientation.slerp(to.orientation, part),
    }
}
