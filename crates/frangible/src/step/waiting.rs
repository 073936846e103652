//! Bodies that wait: static until a frame, or until something hits them.
//!
//! A hit is looked for before the frame, so that the blow meets a dynamic body and does to it what
//! it does to any other. Bodies that are reached only through others, or passed by, are seen after
//! the frame, by its contact impulses; the frame is then done again.

mod hits;
pub(crate) mod passed_on;
pub(crate) mod state;

use crate::report::StepReport;
use crate::report::books::Totals;
use crate::step::waiting::hits::{Upcoming, all_dynamic, upcoming_hits};
use crate::step::waiting::state::Starts;
use crate::world::{Label, World};
use frangible_bodies::{BodyId, Frame, Motion, Pair};
use frangible_collision::{ImpulseCache, ManifoldFinder, find_swept_pairs};
use std::collections::{BTreeMap, BTreeSet};

/// Waiting bodies touch if they are no further apart than this share of the smaller one's radius
/// [1]: bricks of a wall whose courses were laid by eye.
const TOUCHING: f64 = 0.01;

/// A frame is done again so many times at most [1]: waiting bodies that a blow reaches through more
/// others start in the next frame.
const MOST_REDONE: usize = 16;

/// Pairs that touched in a frame.
pub(crate) struct Contacts {
    /// Waiting bodies that a blow reached through others.
    pub(crate) hit: Vec<BodyId>,
    /// Pairs with impulses, and broken bodies with their fragments.
    pub(crate) links: Vec<(BodyId, BodyId)>,
}

/// Starts the bodies that are due and advances the world. If the contacts of the frame say that
/// other waiting bodies were hit than was thought before, the frame is done again with those.
pub(crate) fn start_and_advance(
    world: &mut World,
    frame: &Frame,
    advance: impl Fn(&mut World, &Frame) -> (StepReport, Contacts),
) -> StepReport {
    if world.labels.iter().all(|label| label.waiting.is_none()) {
        return advance(world, frame).0;
    }
    let energy = |world: &World| Totals::of(&world.bodies, frame).energy();
    let at_start = energy(world);
    start_due(world);
    let Upcoming { mut hit, may_reach_others } = upcoming_hits(world, frame);
    let mut missed = BTreeSet::new();
    let mut redone = 0;
    loop {
        let may_redo = (may_reach_others || !hit.is_empty()) && redone < MOST_REDONE;
        let undo = may_redo.then(|| world.clone());
        start_with_touching(world, &hit, frame);
        let started = energy(world) - at_start;
        let (mut report, contacts) = advance(world, frame);
        // Frames in which bodies were taken out tell nothing.
        if let Some(undo) = undo.filter(|_| report.quarantined.is_empty()) {
            let touched = touched(&undo, world, &contacts.links);
            let is_missed = |id: &BodyId| !touched.contains(id) && !missed.contains(id);
            let now_missed: Vec<BodyId> = hit.iter().copied().filter(is_missed).collect();
            if !contacts.hit.is_empty() || !now_missed.is_empty() {
                *world = undo;
                hit.retain(|id| !now_missed.contains(id));
                hit.extend(contacts.hit);
                missed.extend(now_missed);
                redone += 1;
                continue;
            }
        }
        report.energy.started = started;
        return report;
    }
}

/// Starts the bodies whose frame has come.
fn start_due(world: &mut World) {
    for i in 0..world.bodies.len() {
        let starts = world.labels[i].waiting.map(|waiting| waiting.starts);
        if matches!(starts, Some(Starts::AtFrame(start)) if start <= world.frame) {
            world.start_at(i);
        }
    }
}

/// Bodies that something moving reaches through contacts: by impulses of one that moved before the
/// frame, or of one that it has reached. Broken ones are reached.
fn touched(before: &World, after: &World, links: &[(BodyId, BodyId)]) -> BTreeSet<BodyId> {
    let moved = |id: &BodyId| {
        let dense = before.bodies.index_of(*id);
        dense.is_none_or(|i| before.bodies.motions[i] != Motion::Static)
    };
    let passes_on = |id: &BodyId| {
        let dense = after.bodies.index_of(*id);
        dense.is_none_or(|i| after.bodies.motions[i] != Motion::Static)
    };
    let mut neighbours: BTreeMap<BodyId, Vec<BodyId>> = BTreeMap::new();
    for &(a, b) in links {
        neighbours.entry(a).or_default().push(b);
        neighbours.entry(b).or_default().push(a);
    }
    let mut open: Vec<BodyId> = neighbours.keys().copied().filter(moved).collect();
    let mut touched = BTreeSet::new();
    while let Some(id) = open.pop() {
        if passes_on(&id) && touched.insert(id) {
            open.extend(neighbours.get(&id).into_iter().flatten());
        }
    }
    touched
}

/// Starts bodies, and those that wait for a blow and touch them, or touch these in turn.
fn start_with_touching(world: &mut World, hit: &[BodyId], frame: &Frame) {
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
    let mut open: Vec<usize> = hit.iter().filter_map(|&id| bodies.index_of(id)).collect();
    while let Some(i) = open.pop() {
        if !std::mem::replace(&mut reached[i], true) {
            open.extend(&neighbours[i]);
        }
    }
    (0..bodies.len()).filter(|&i| reached[i]).for_each(|i| world.start_at(i));
}
