//! The energy islands of a frame: who exchanged impulses, what each may keep, and who holds it.

use crate::energy::frame_accounts::FrameAccounts;
use crate::energy::island::{Anchor, Island, work_on};
use crate::energy::islands::Islands;
use frangible_bodies::{Bodies, BodyId, Inertia, PerBody};
use frangible_math::threads;

/// Islands of a frame, each with its allowance from the bodies' energies at its `start` and their
/// `bank` [J]. Broken bodies connect their fragments.
pub(crate) fn find_islands(
    bodies: &Bodies,
    start: &PerBody<f64>,
    bank: &PerBody<f64>,
    accounts: &FrameAccounts,
) -> Vec<Island> {
    let are_immobile: Vec<bool> = bodies.inertias.iter().map(Inertia::is_infinite).collect();
    let is_immobile = |id: BodyId| bodies.index_of(id).is_some_and(|i| are_immobile[i]);
    let mut islands = Islands::new(bodies);
    let anchored = link_bodies(bodies, accounts, &mut islands, is_immobile);
    let members = islands.members(bodies);
    let anchors = find_anchors(&islands, &anchored, members.len());

    // Energy that contacts gave goes to the island of the pair's mobile body.
    let mut number_of = |ids: &[BodyId; 2]| {
        let mobile = *ids.iter().find(|&&id| !is_immobile(id))?;
        let node = islands.node(bodies, mobile);
        islands.number(node)
    };
    let mut gains = vec![Vec::new(); members.len()];
    for (index, gain) in accounts.gains.iter().enumerate() {
        if let Some(number) = number_of(&gain.ids) {
            gains[number].push(index);
        }
    }
    let mut recovered = vec![0.0; members.len()];
    let mut recoveries = vec![Vec::new(); members.len()];
    for (index, (ids, energy)) in accounts.recovered.iter().enumerate() {
        // Most pairs recover nothing.
        if *energy != 0.0
            && let Some(number) = number_of(ids)
        {
            recovered[number] += energy;
            recoveries[number].push(index);
        }
    }

    let island = |number: usize| {
        let ids = &members[number];
        Island {
            members: ids.iter().filter_map(|&id| bodies.index_of(id)).collect(),
            anchor: anchors[number].anchor(bodies),
            recovered: recovered[number].max(0.0),
            recoveries: recoveries[number].clone(),
            allowance: sum(start, ids) + work_on(&accounts.work, ids),
            bank: sum(bank, ids),
            gains: gains[number].clone(),
        }
    };
    let mut all = threads::list(members.len(), island);
    all.retain(|island| !island.members.is_empty());
    all
}

/// Unites mobile bodies that are linked. Returns the nodes of each mobile body linked to an
/// immobile one, and of this one.
fn link_bodies(
    bodies: &Bodies,
    accounts: &FrameAccounts,
    islands: &mut Islands,
    is_immobile: impl Fn(BodyId) -> bool,
) -> Vec<(u32, u32)> {
    let mut anchored = Vec::new();
    for &(a, b) in &accounts.links {
        match (is_immobile(a), is_immobile(b)) {
            (false, false) => {
                let [a, b] = [a, b].map(|id| islands.node(bodies, id));
                islands.link(a, b);
            }
            (false, true) => anchored.push((a, b)),
            (true, false) => anchored.push((b, a)),
            (true, true) => {}
        }
    }
    let nodes = |(id, by)| {
        let [node, by] = [id, by].map(|id| islands.node(bodies, id));
        islands.join(node);
        (node, by)
    };
    anchored.into_iter().map(nodes).collect()
}

/// Immobile bodies in contact with an island.
#[derive(Clone, Copy)]
enum AnchorKind {
    Free,
    /// One body, by dense index.
    One(u32),
    Many,
}

impl AnchorKind {
    /// A single kinematic body carries an island; otherwise it is fixed.
    fn anchor(self, bodies: &Bodies) -> Anchor {
        match self {
            Self::Free => Anchor::Free,
            Self::One(i) => Anchor::of(bodies, i as usize),
            Self::Many => Anchor::Fixed,
        }
    }
}

/// The anchor of each of `count` islands.
fn find_anchors(islands: &Islands, anchored: &[(u32, u32)], count: usize) -> Vec<AnchorKind> {
    let mut anchors = vec![AnchorKind::Free; count];
    for &(node, by) in anchored {
        let Some(number) = islands.number(node) else { continue };
        let anchor = &mut anchors[number];
        *anchor = match *anchor {
            AnchorKind::Free => AnchorKind::One(by),
            AnchorKind::One(other) if other == by => AnchorKind::One(by),
            AnchorKind::One(_) | AnchorKind::Many => AnchorKind::Many,
        };
    }
    anchors
}

fn sum(amounts: &PerBody<f64>, ids: &[BodyId]) -> f64 {
    ids.iter().filter_map(|&id| amounts.get(id)).sum()
}
