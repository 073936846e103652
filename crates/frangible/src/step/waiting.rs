//! Bodies that wait: static until a frame, or until something hits them.
//!
//! A hit is looked for before the frame, so that the blow meets a dynamic body and does to it what
//! it does to any other. What is reached only through others is seen after the frame, by its contact
//! impulses; the frame is then done again.

pub(crate) mod passed_on;
pub(crate) mod state;

use crate::report::StepReport;
use crate::report::books::Totals;
use crate::step::waiting::state::Starts;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, Frame, Motion, Pair, Pose, Velocity, predict};
use frangible_collision::{ImpulseCache, ManifoldFinder, ManifoldPoint, find_swept_pairs};
use frangible_dynamics::upcoming_impact;
use glam::DVec3;

/// An approach is a hit above the smaller one of a speed [m/s] and a share of what gravity gives
/// in a frame [1], gravity's own gain in the frame not counted: that of a fall by half a millimetre.
/// Resting bodies come slower: a mesh that is set down on a waiting one at 9 mm/s, a stack of ten
/// cubes at 14 mm/s, the free half of a wall of bricks at the waiting half at 53 mm/s.
const HIT_SPEED: f64 = 0.1;
const HIT_SHARE: f64 = 0.3;

/// A kinematic body hits with any speed above rounding [m/s]: it would go through.
const LEAST_DRIVEN: f64 = 1e-9;

/// Waiting bodies touch if they are no further apart than this share of the smaller one's radius
/// [1]: bricks of a wall whose courses were laid by eye.
const TOUCHING: f64 = 0.01;

/// A blow reaches waiting bodies in a frame through others so many times at most [1]; those beyond
/// start in the next frame.
const MOST_PASSED_ON: usize = 16;

/// Starts the bodies that are due and advances the world. `advance` also says which waiting bodies
/// were hit nevertheless: these start, and the frame is done again.
pub(crate) fn start_and_advance(
    world: &mut World,
    frame: &Frame,
    advance: impl Fn(&mut World, &Frame) -> (StepReport, Vec<BodyId>),
) -> StepReport {
    if world.labels.iter().all(|label| label.waiting.is_none()) {
        return advance(world, frame).0;
    }
    let energy = |world: &World| Totals::of(&world.bodies, frame).energy();
    let at_start = energy(world);
    let may_reach_others = start_due(world, frame);
    let mut passed_on = 0;
    loop {
        let started = energy(world) - at_start;
        let undo = (may_reach_others && passed_on < MOST_PASSED_ON).then(|| world.clone());
        let (mut report, hit) = advance(world, frame);
        match undo {
            Some(undo) if !hit.is_empty() => {
                *world = undo;
                let hit: Vec<usize> =
                    hit.into_iter().filter_map(|id| world.bodies.index_of(id)).collect();
                start_with_touching(world, &hit, frame);
                passed_on += 1;
            }
            _ => {
                report.energy.started = started;
                return report;
            }
        }
    }
}

/// Starts the bodies whose frame has come, and those that are hit in this frame, with the ones that
/// touch them. True if a blow may reach further waiting bodies through others.
fn start_due(world: &mut World, frame: &Frame) -> bool {
    let now = world.frame;
    for i in 0..world.bodies.len() {
        let starts = world.labels[i].waiting.map(|waiting| waiting.starts);
        if matches!(starts, Some(Starts::AtFrame(start)) if start <= now) {
            world.start_at(i);
        }
    }
    let wait: Vec<bool> = world.labels.iter().map(Label::waits_for_blow).collect();
    if !wait.contains(&true) {
        return false;
    }
    let bodies = &world.bodies;
    let predicted = predict(bodies, frame);
    let pairs = find_swept_pairs(bodies, &predicted, frame.speculative_margin(), frame);
    let least = HIT_SPEED.min(HIT_SHARE * frame.gravity.length() * frame.dt);
    let mut finder = ManifoldFinder::default();
    let mut hit = hit_by_driven(bodies, &wait, &mut finder, frame);
    for &pair in pairs.iter().filter(|pair| wait[pair.first] || wait[pair.second]) {
        if hit_speed(bodies, pair, &predicted, &mut finder, frame) > least {
            hit.push(if wait[pair.first] { pair.first } else { pair.second });
        }
    }
    let is_free = |i: usize| wait[i] || !bodies.inertias[i].is_infinite();
    let meets = |pair: &Pair| is_free(pair.first) && is_free(pair.second);
    let goes_on = !hit.is_empty() || pairs.iter().any(meets);
    start_with_touching(world, &hit, frame);
    goes_on
}

/// Starts bodies, and those that wait for a blow and touch them, or touch these in turn.
fn start_with_touching(world: &mut World, hit: &[usize], frame: &Frame) {
    if hit.is_empty() {
        return;
    }
    let wait: Vec<bool> = world.labels.iter().map(Label::waits_for_blow).collect();
    let bodies = all_dynamic(&world.bodies, &wait);
    let mut neighbours: Vec<Vec<usize>> = vec![Vec::new(); bodies.len()];
    let mut finder = ManifoldFinder::default();
    for pair in find_swept_pairs(&bodies, &bodies.poses, frame.speculative_margin(), frame) {
        let Pair { first, second } = pair;
        if !(wait[first] && wait[second]) {
            continue;
        }
        let near = TOUCHING * bodies.radii[first].min(bodies.radii[second]);
        let manifold = finder.find(&bodies, pair, &ImpulseCache::default(), frame);
        if manifold.is_some_and(|manifold| manifold.points.iter().any(|point| point.gap <= near)) {
            neighbours[first].push(second);
            neighbours[second].push(first);
        }
    }
    let mut reached = vec![false; bodies.len()];
    let mut open = hit.to_vec();
    while let Some(i) = open.pop() {
        if !std::mem::replace(&mut reached[i], true) {
            open.extend(&neighbours[i]);
        }
    }
    (0..bodies.len()).filter(|&i| reached[i]).for_each(|i| world.start_at(i));
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
            // However slowly it comes: it would go through.
            if wait[body]
                && is_driven(&bodies.motions[other])
                && hit_speed(bodies, pair, &predicted, finder, frame) > LEAST_DRIVEN
            {
                hit.push(body);
            }
        }
    }
    hit
}

/// Of some bodies that wait, copies that move, at rest: contacts are sought between such.
fn all_dynamic(bodies: &Bodies, wait: &[bool]) -> Bodies {
    let mut bodies = bodies.clone();
    for i in (0..bodies.len()).filter(|&i| wait[i]) {
        bodies.make_dynamic(i, Velocity::default());
    }
    bodies
}

/// Largest closing speed, as the frame begins, at the points of a pair that meet within the frame
/// [m/s].
fn hit_speed(
    bodies: &Bodies,
    pair: Pair,
    predicted: &[Pose],
    finder: &mut ManifoldFinder,
    frame: &Frame,
) -> f64 {
    let closing = |point: DVec3, normal: DVec3| {
        let [first, second] = [pair.first, pair.second].map(|i| {
            let (pose, velocity) = (&bodies.poses[i], &bodies.velocities[i]);
            bodies.point_velocity(i, pose, velocity, point - pose.position)
        });
        (second - first).dot(normal)
    };
    let is_due = |point: &&ManifoldPoint| {
        point.approach > 0.0 && point.gap.max(0.0) <= frame.dt * point.approach
    };
    let manifold = finder.find(bodies, pair, &ImpulseCache::default(), frame);
    let points = manifold.iter().flat_map(|manifold| manifold.points).filter(is_due);
    let speeds = points.map(|point| closing(point.middle(bodies, pair), point.normal));
    if let Some(fastest) = speeds.reduce(f64::max) {
        return fastest;
    }
    // Fast rotation may bring a contact that no point of the start has.
    upcoming_impact(bodies, pair, predicted, frame).map_or(0.0, |impact| {
        let contact = impact.approach.contact;
        closing(contact.point, contact.normal)
    })
}
