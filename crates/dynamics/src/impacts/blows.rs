//! Blows: impacts above a body's strength [Su09 sec. 4.2].

use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::frame_rate::impact_log::Impact;
use crate::impulse::pair_impulse::{PairImpulse, approach_at, deepest_approach};
use frangible_bodies::{Bodies, BodyId, Frame, Pair, Pose};
use frangible_collision::{ContactPoint, ManifoldFinder, NearSamples, first_contact, placed};
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

/// Strength of a body, by dense index, at a point of its frame [m]: the largest impulse before it
/// breaks [N s]. At least its strength where it is weakest, `bodies.surfaces[i].strength`, and asked
/// of breakable bodies for impulses above that alone.
pub type LocalStrength<'a> = &'a dyn Fn(&Bodies, usize, DVec3) -> f64;

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
        let strength = bodies.strength(i);
        let point = || pose.world_from_body().inverse().point(contact.point);
        if strength.is_finite() { local(bodies, i, point()) } else { strength }
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

/// Smaller strength of a pair: the largest impulse through its contact [N s].
fn smaller_strength(bodies: &Bodies, pair: Pair) -> f64 {
    bodies.strength(pair.first).min(bodies.strength(pair.second))
}

/// An impact above the strength of a body.
#[derive(Clone, Copy, Debug)]
pub struct Strike {
    /// The two that meet.
    pub pair: Pair,
    /// Start of the substep in which they do, from the frame's start [s].
    pub time: f64,
    /// Contact at the frame's start, with the normal towards the first body.
    pub contact: ContactPoint,
    /// Part of the impact up to the smaller strength that has not acted yet, on the first body
    /// [N s].
    pub impulse: DVec3,
    /// One for each body that breaks.
    pub blows: [Option<Blow>; 2],
}

/// Sorts impacts by their times.
pub fn in_order(impacts: &mut [Impact]) {
    impacts.sort_by(|a, b| {
        let rest = |impact: &Impact| (impact.number, impact.pair.both());
        a.time.total_cmp(&b.time).then_with(|| rest(a).cmp(&rest(b)))
    });
}

/// Impacts of a frame above the strength of a body, in their order; `bodies` are those of the
/// frame's start.
pub fn strikes(bodies: &Bodies, impacts: &[Impact], local: LocalStrength) -> Vec<Strike> {
    let mut strikes = Vec::new();
    for impact in impacts {
        let Impact { pair, time, impulse, earlier, contact, acts_at, .. } = *impact;
        let size = impulse.length();
        let blows = blows_of(bodies, pair, (acts_at, size), local, || touch(bodies, impact));
        let Some(borne) = blows.iter().flatten().map(|blow| blow.borne).reduce(f64::min) else {
            continue;
        };
        let contact = ContactPoint { point: acts_at, normal: contact.normal };
        let left = impulse * (borne / size) - earlier;
        // Where the body is weaker than where it was struck before, more acted than it bears here.
        let impulse = if left.dot(impulse) > 0.0 { left } else { DVec3::ZERO };
        strikes.push(Strike { pair, time, contact, impulse, blows });
    }
    strikes
}

/// A blow, and what bears it.
#[derive(Clone, Copy, Debug)]
pub struct Bearing {
    /// The body that may break, and what strikes it, by dense index.
    pub body: usize,
    /// See `body`.
    pub striker: usize,
    /// Where, in the world [m].
    pub point: DVec3,
    /// [N s]
    pub impulse: f64,
    /// What the body bears [N s]: there if the blow is above the weakest place's, else at least.
    pub bears: f64,
}

/// The impact that is largest relative to what its body bears; `bodies` are those of the frame's
/// start.
pub fn hardest_blow(bodies: &Bodies, impacts: &[Impact], local: LocalStrength) -> Option<Bearing> {
    let bearing = |impact: &Impact, side: usize| {
        let both = impact.pair.both();
        let (body, striker) = (both[side], both[1 - side]);
        let (least, impulse) = (bodies.strength(body), impact.impulse.length());
        let point = impact.contact.point;
        let point_body = || impact.poses[side].world_from_body().inverse().point(point);
        let bears = if impulse > least { local(bodies, body, point_body()) } else { least };
        bears.is_finite().then_some(Bearing { body, striker, point, impulse, bears })
    };
    let all = impacts.iter().flat_map(|impact| [0, 1].map(|side| bearing(impact, side)));
    all.flatten().max_by(|a, b| (a.impulse / a.bears).total_cmp(&(b.impulse / b.bears)))
}

impl Strike {
    /// Applies what the weaker body bears to both bodies at the frame's start, clamped to the
    /// available energy, and books it.
    pub fn pass_on(&self, bodies: &mut Bodies, frame: &Frame, accounts: &mut FrameAccounts) {
        pass_on(bodies, self.pair, self.contact, self.impulse, frame, accounts);
    }
}

/// Applies an impulse on the first body, and its opposite on the second, at the frame's start,
/// clamped to the available energy, and books it.
pub fn pass_on(
    bodies: &mut Bodies,
    pair: Pair,
    contact: ContactPoint,
    impulse: DVec3,
    frame: &Frame,
    accounts: &mut FrameAccounts,
) {
    if impulse == DVec3::ZERO {
        return;
    }
    let approach = approach_at(bodies, pair, contact, &bodies.poses, &bodies.velocities);
    let mut impulse = PairImpulse::new(&approach, impulse);
    if frame.settings.impulse_clamp {
        impulse = impulse.clamped_to_energy(
            bodies,
            pair,
            &approach,
            &bodies.velocities,
            &mut accounts.clamps,
        );
    }
    accounts.book_impulse(
        bodies,
        pair,
        &approach,
        &impulse,
        (&bodies.velocities, Cause::Collision),
    );
    impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
}

/// Point and poses of an impact. A contact at one point is detected as its substep begins: look
/// for the exact touch from there, no farther away than the bodies move.
fn touch(bodies: &Bodies, impact: &Impact) -> Touch {
    let Impact { pair, contact, poses, poses_past, is_at_point, .. } = impact;
    let way = |side: usize| poses[side].position.distance(poses_past[side].position);
    let reach = way(0) + way(1);
    let is_near = |(found, _): &Touch| *is_at_point && found.point.distance(contact.point) <= reach;
    let exact = first_contact(bodies, *pair, [poses, poses_past]);
    exact.filter(is_near).unwrap_or((*contact, *poses))
}

/// The contact at the frame's end of a pair that nothing brings together at its start but rotation.
pub fn touch_by_rotation(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    finder: &mut ManifoldFinder,
) -> Option<ContactPoint> {
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
    approaches.then_some(seen.contact)
}
