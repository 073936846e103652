//! Blows that reach waiting bodies through others, known by the contact impulses of a frame.

use crate::step::waiting::state::least_hit;
use crate::world::Label;
use frangible_bodies::{Bodies, BodyId, Frame, Pair};
use frangible_collision::{ImpulseCache, Manifold};
use frangible_dynamics::contact_forces;
use frangible_math::DisjointSets;
use glam::DVec3;

/// A contact with a waiting body passes a blow on if its impulse is more than so many times what
/// the weight of all that touches there, and the contact in the frame before, account for [1].
const BLOW_FACTOR: f64 = 2.0;

/// A contact of a free body with one that waits for a blow, and its impulse in a frame.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WaitingContact {
    /// The one that waits.
    waiting: BodyId,
    pair: Pair,
    /// On either of the pair [N s].
    impulse: f64,
}

/// The contacts of free bodies with waiting ones that had an impulse in the last solved frame.
pub(crate) fn waiting_contacts(
    bodies: &Bodies,
    labels: &[Label],
    manifolds: &[Manifold],
    carried: &ImpulseCache,
    frame: &Frame,
) -> Vec<WaitingContact> {
    let wait: Vec<bool> = labels.iter().map(Label::waits_for_blow).collect();
    if !wait.contains(&true) {
        return Vec::new();
    }
    let of_waiting = |manifold: &Manifold| wait[manifold.pair.first] || wait[manifold.pair.second];
    let manifolds = manifolds.iter().copied().filter(of_waiting);
    let contacts = manifolds.filter_map(|manifold| {
        let pair = manifold.pair;
        let forces = contact_forces(bodies, std::iter::once(manifold), carried);
        let force: DVec3 = forces.iter().map(|force| force.force).sum();
        let waiting = if wait[pair.first] { pair.first } else { pair.second };
        let impulse = frame.dt * force.length();
        (impulse > 0.0).then_some(WaitingContact { waiting: bodies.ids[waiting], pair, impulse })
    });
    contacts.collect()
}

/// Those waiting bodies whose contacts gave more in a frame than weight explains: `after` is what
/// acted in it, `before` what acted in the one before it.
pub(crate) fn hit_through_others(
    bodies: &Bodies,
    manifolds: &[Manifold],
    (before, after): (&[WaitingContact], &[WaitingContact]),
    frame: &Frame,
) -> Vec<BodyId> {
    if after.is_empty() {
        return Vec::new();
    }
    let masses = masses_of_islands(bodies, manifolds);
    let is_blow = |now: &&WaitingContact| {
        let carried = before.iter().find(|then| then.pair == now.pair);
        let free = now.pair.both().into_iter().find(|&i| !bodies.inertias[i].is_infinite());
        let Some(free) = free else { return false };
        let weight = masses[free] * frame.gravity.length() * frame.dt;
        let rests = carried.map_or(0.0, |then| then.impulse) + weight;
        now.impulse > BLOW_FACTOR * rests + least_hit(frame) * bodies.masses[free]
    };
    after.iter().filter(is_blow).map(|now| now.waiting).collect()
}

/// For each free body, the mass of all free bodies that may touch it, or these in turn [kg].
fn masses_of_islands(bodies: &Bodies, manifolds: &[Manifold]) -> Vec<f64> {
    let is_free = |i: usize| !bodies.inertias[i].is_infinite();
    let mut islands = DisjointSets::new(bodies.len());
    for Manifold { pair, .. } in manifolds.iter().filter(|of| !of.points.is_empty()) {
        if is_free(pair.first) && is_free(pair.second) {
            islands.unite(pair.first as u32, pair.second as u32);
        }
    }
    let roots: Vec<usize> = (0..bodies.len()).map(|i| islands.root(i as u32) as usize).collect();
    let mut masses = vec![0.0; bodies.len()];
    for i in (0..bodies.len()).filter(|&i| is_free(i)) {
        masses[roots[i]] += bodies.masses[i];
    }
    roots.into_iter().map(|root| masses[root]).collect()
}
