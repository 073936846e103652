//! The frame-rate method: one detection at x^n, then substeps ([Cat24], [Mac19]; adr/010).

use crate::report::{Fracture, Quarantined, id_number};
use crate::step::bonds::{glued_contact_forces, note_carried};
use crate::step::break_bodies::break_and_book;
use crate::step::local_strength::LocalStrengths;
use crate::step::moved::Moved;
use crate::step::quarantine::{Before, take_out_faulty};
use crate::step::stage_clock::StageClock;
use crate::step::waiting::passed_on::{hit_through_others, waiting_contacts};
use crate::world::{Label, World};
use frangible_bodies::{Frame, Pair, Pose, predict};
use frangible_collision::{Manifold, Swept};
use frangible_dynamics::{
    ContactFreeState, FrameAccounts, Solved, find_impact_chain, solve, strike,
};
use std::collections::BTreeSet;

/// Moves all bodies from x^n, v^n to x^{n+1}, v^{n+1}.
pub(crate) fn move_by_substeps(world: &mut World, frame: &Frame, clock: &mut StageClock) -> Moved {
    // Bodies hit above their strength break before any motion, fragments too [Su09 sec. 4.2].
    let (mut accounts, mut quarantined) = (FrameAccounts::default(), Vec::new());
    let Struck { fractures, predicted, swept } =
        strike_and_break(world, &mut accounts, &mut quarantined, frame, clock);

    // Contact manifolds of the pairs near each other's paths [Gregorius13], and of those that an
    // impact may bring together. Fragments that overlap at birth keep their overlap.
    let World { bodies, warm, contact_cache, labels, fits, hand, .. } = world;
    let found = contact_cache.find_manifolds(bodies, &swept.pairs, warm, frame);
    clock.lap("find_manifolds");
    find_impact_chain(bodies, &predicted, &swept, (found, warm), frame);
    clock.lap("impact_chain");
    let broken: BTreeSet<u64> =
        fractures.iter().chain(&hand.handled.fractures).map(|fracture| fracture.body).collect();
    fits.forgive(bodies, found, |pair| are_newborn_siblings(labels, &broken, pair));
    let manifolds: Vec<Manifold> = found.iter().collect();
    clock.lap("find_manifolds");

    // Substeps: soft contacts, restitution, friction [Cat24].
    let contact_free = ContactFreeState::new(bodies, predicted, &accounts, frame);
    let before = Before::of(bodies);
    let pressed_before = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let Solved { accounts: solver_accounts, gravity, short_of_substeps, confirmed } =
        solve(bodies, (&manifolds, &found.neighbours), warm, frame);
    accounts.add(solver_accounts);

    // Impulses of the frame: blows on waiting bodies, and loads of bonds in the next frame.
    let with_confirmed = |Manifold { pair, points }| Manifold {
        pair,
        points: confirmed.get(&pair).map_or(points, Vec::as_slice),
    };
    let manifolds: Vec<Manifold> = manifolds.into_iter().map(with_confirmed).collect();
    let pressed_after = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let hit = hit_through_others(bodies, &manifolds, (&pressed_before, &pressed_after), frame);
    let forces = glued_contact_forces(bodies, labels, &manifolds, warm);
    note_carried(world, &forces);
    clock.lap("solve");
    Moved {
        fractures,
        contact_free,
        gravity,
        accounts,
        left_out: swept.left_out,
        short_of_substeps,
        quarantined,
        before,
        hit,
    }
}

/// True for two fragments of one body that broke in this frame.
fn are_newborn_siblings(labels: &[Label], broken: &BTreeSet<u64>, pair: Pair) -> bool {
    let [first, second] = pair.both().map(|i| labels[i].parent);
    first == second && first.is_some_and(|parent| broken.contains(&id_number(parent)))
}

/// The state of a frame once nothing breaks any more.
struct Struck {
    fractures: Vec<Fracture>,
    /// Ballistic, at the frame's end.
    predicted: Vec<Pose>,
    /// The pairs that come near each other on the way there.
    swept: Swept,
}

/// Strikes until nothing breaks. Bodies with bad numbers are taken out before contacts are sought.
fn strike_and_break(
    world: &mut World,
    accounts: &mut FrameAccounts,
    quarantined: &mut Vec<Quarantined>,
    frame: &Frame,
    clock: &mut StageClock,
) -> Struck {
    let mut fractures = Vec::new();
    let mut passes = 0;
    loop {
        take_out_faulty(world, quarantined);
        let predicted = predict(&world.bodies, frame);
        let swept = Swept::new(&world.bodies, &predicted, frame.speculative_margin(), frame);
        clock.lap("find_pairs");
        let may_break = passes < frame.settings.breaking_passes;
        let blows = if may_break {
            let (local, bodies) = (LocalStrengths::of(world), &mut world.bodies);
            strike(bodies, &swept.pairs, &predicted, &|i, at| local.at(i, at), frame, accounts)
        } else {
            Vec::new()
        };
        clock.lap("strike");
        if blows.is_empty() {
            return Struck { fractures, predicted, swept };
        }
        fractures.extend(break_and_book(world, &blows, accounts, frame).0);
        passes += 1;
        clock.lap("break_bodies");
    }
}
