//! Hits on waiting bodies, as they are to be expected before a frame.

use crate::step::waiting::state::least_hit;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pair, Pose, Velocity, predict};
use frangible_collision::{ImpulseCache, ManifoldFinder, ManifoldPoint, find_swept_pairs};
use frangible_dynamics::touch_by_rotation;
use glam::DVec3;

/// Touches that are no further apart in time than this share of a frame are at once [1].
const AT_ONCE: f64 = 0.01;

/// A kinematic body hits with any speed above rounding [m/s]: it would go through.
const LEAST_DRIVEN: f64 = 1e-9;

/// Hits that are to be expected in a frame.
#[derive(Default)]
pub(super) struct Upcoming {
    /// Bodies that wait for a blow.
    pub(super) hit: Vec<BodyId>,
    /// True if a blow may reach further ones through others.
    pub(super) may_reach_others: bool,
}

/// Bodies that wait for a blow and that another one flies into.
pub(super) fn upcoming_hits(world: &World, frame: &Frame) -> Upcoming {
    let wait: Vec<bool> = world.labels.iter().map(Label::waits_for_blow).collect();
    if !wait.contains(&true) {
        return Upcoming::default();
    }
    let bodies = &world.bodies;
    let predicted = predict(bodies, frame);
    let pairs = find_swept_pairs(bodies, &predicted, frame.speculative_margin(), frame);
    let least = least_hit(frame);
    let mut finder = ManifoldFinder::default();
    let mut hit = hit_by_driven(bodies, &wait, &mut finder, frame);
    let mut blows: Vec<(usize, usize, f64)> = Vec::new();
    for &pair in pairs.iter().filter(|pair| wait[pair.first] || wait[pair.second]) {
        let Hit { speed, time } = hit_of(bodies, pair, &predicted, &mut finder, frame);
        if speed > least {
            let Pair { first, second } = pair;
            blows.push(if wait[first] { (first, second, time) } else { (second, first, time) });
        }
    }
    // A striker may not reach those that it would hit later on its way.
    let mut earliest = vec![f64::INFINITY; bodies.len()];
    blows.iter().for_each(|&(_, by, time)| earliest[by] = earliest[by].min(time));
    let is_first =
        |&&(_, by, time): &&(usize, usize, f64)| time <= earliest[by] + AT_ONCE * frame.dt;
    hit.extend(blows.iter().filter(is_first).map(|&(body, ..)| body));
    let is_free = |i: usize| wait[i] || !bodies.inertias[i].is_infinite();
    let may_reach_others = pairs.iter().any(|pair| is_free(pair.first) && is_free(pair.second));
    Upcoming { hit: hit.into_iter().map(|i| bodies.ids[i]).collect(), may_reach_others }
}

/// Bodies that wait for a blow and are met by a kinematic body that moves.
fn hit_by_driven(
    bodies: &Bodies,
    wait: &[bool],
    finder: &mut ManifoldFinder,
    frame: &Frame,
) -> Vec<usize> {
    let is_driven = |motion: &Motion| match *motion {
        Motion::Kinematic { linear, angular } => linear != DVec3::ZERO || angular != DVec3::ZERO,
        Motion::Static | Motion::Dynamic => false,
    };
    if !bodies.motions.iter().any(is_driven) {
        return Vec::new();
    }
    // Two bodies of infinite mass are no pair: those that wait move here, but do not fall.
    let frame = &Frame { gravity: DVec3::ZERO, ..*frame };
    let bodies = &all_dynamic(bodies, wait);
    let predicted = predict(bodies, frame);
    let pairs = find_swept_pairs(bodies, &predicted, frame.speculative_margin(), frame);
    let mut hit = Vec::new();
    for pair in pairs {
        for (body, other) in [(pair.first, pair.second), (pair.second, pair.first)] {
            if wait[body]
                && is_driven(&bodies.motions[other])
                && hit_of(bodies, pair, &predicted, finder, frame).speed > LEAST_DRIVEN
            {
                hit.push(body);
            }
        }
    }
    hit
}

/// A copy in which the bodies that wait are dynamic and at rest: no contacts are sought between
/// bodies of infinite mass.
pub(super) fn all_dynamic(bodies: &Bodies, wait: &[bool]) -> Bodies {
    let mut bodies = bodies.clone();
    for i in (0..bodies.len()).filter(|&i| wait[i]) {
        bodies.make_dynamic(i, Velocity::default());
    }
    bodies
}

/// The meeting of a pair within a frame.
#[derive(Clone, Copy)]
struct Hit {
    /// Largest closing speed, as the frame begins, at the points that meet [m/s].
    speed: f64,
    /// Of the first touch, from the frame's start [s].
    time: f64,
}

impl Hit {
    const NONE: Self = Self { speed: 0.0, time: f64::INFINITY };
}

fn hit_of(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    finder: &mut ManifoldFinder,
    frame: &Frame,
) -> Hit {
    let closing = |point: DVec3, normal: DVec3| {
        let [first, second] = [pair.first, pair.second].map(|i| {
            let (pose, velocity) = (&bodies.poses[i], &bodies.velocities[i]);
            bodies.point_velocity(i, pose, velocity, point - pose.position)
        });
        (second - first).dot(normal)
    };
    let time = |point: &ManifoldPoint| point.gap.max(0.0) / point.approach;
    let is_due = |point: &&ManifoldPoint| point.approach > 0.0 && time(point) <= frame.dt;
    let manifold = finder.find(bodies, pair, &ImpulseCache::default(), frame);
    let mut points = manifold.iter().flat_map(|manifold| manifold.points);
    let is_touching = points.any(|point| point.gap <= 0.0);
    let points = manifold.iter().flat_map(|manifold| manifold.points).filter(is_due);
    let hits = points.map(|point| Hit {
        speed: closing(point.middle(bodies, pair), point.normal),
        time: time(point),
    });
    let both = |a: Hit, b: Hit| Hit { speed: a.speed.max(b.speed), time: a.time.min(b.time) };
    if let Some(hit) = hits.reduce(both) {
        return hit;
    }
    // Fast rotation may bring a contact that no point of the start has.
    let contact =
        if is_touching { None } else { touch_by_rotation(bodies, pair, predicted, finder) };
    contact.map_or(Hit::NONE, |contact| Hit {
        speed: closing(contact.point, contact.normal),
        time: frame.dt,
    })
}
