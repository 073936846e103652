//! One frame.

pub(crate) mod body_path;
pub(crate) mod bonds;
pub(crate) mod break_bodies;
mod follow_paths;
pub(crate) mod local_strength;
pub(crate) mod quarantine;
mod stage_clock;
pub(crate) mod waiting;

use crate::hand::grip::pull_held;
use crate::hand::state::Handled;
use crate::report::books::{Totals, gravity_impulse};
use crate::report::{Fracture, Impulses, Quarantined, StepReport, id_number};
use crate::scene::desc::Method;
use crate::step::bonds::{Freed, free_overloaded, note_carried, strike_bonds};
use crate::step::break_bodies::break_bodies;
use crate::step::follow_paths::follow_paths;
use crate::step::local_strength::LocalStrengths;
use crate::step::quarantine::{Before, contain, take_out, take_out_faulty};
use crate::step::stage_clock::StageClock;
use crate::step::waiting::passed_on::{hit_through_others, waiting_contacts};
use crate::step::waiting::{Contacts, start_and_advance};
use crate::world::World;
use frangible_bodies::{BodyId, Frame, Pose, accelerate, predict};
use frangible_collision::{Manifold, Swept, find_pairs};
use frangible_dynamics::{
    Blow, Collisions, Contact, ContactFreeState, EnergyAtStart, FrameAccounts, Phase, Response,
    Solved, contact_forces, contact_graph, find_impact_chain, propagate_shock, push_out, solve,
    strike,
};
use glam::DVec3;
use std::collections::BTreeSet;

/// Advances a world by one frame: collide and break, move by the scene's method, balance, report
/// (docs/the_step.md). n is the frame's start. Cannot fail: what goes bad is quarantined and
/// reported.
pub fn step(world: &mut World) -> StepReport {
    // Many bodies are shared among the threads of the pool that this is called in, or of the global
    // one; the bits are the same.
    if world.bodies.len() > FEW && rayon::current_num_threads() > 1 {
        rayon::scope(|_| advance(world))
    } else {
        advance(world)
    }
}

/// Fewer bodies than this are not worth the way into the pool.
const FEW: usize = 256;

/// [`step`] on this thread, and on those of its pool if it has one.
fn advance(world: &mut World) -> StepReport {
    let frame = world.frame_constants();

    // Kinematic bodies are where their paths say, and bodies that wait start.
    follow_paths(world);
    pull_held(world);
    start_and_advance(world, &frame, advance_started)
}

/// [`advance`] once all have started that are known to be due; beside the report, who touched
/// whom.
fn advance_started(world: &mut World, frame: &Frame) -> (StepReport, Contacts) {
    let mut clock = StageClock::new(world.clock);

    // Overloaded bonds break.
    let Freed { fractures: freed, blows } = free_overloaded(world, frame);
    clock.lap("free_overloaded");

    // Open the books.
    let before = Totals::of(&world.bodies, frame);
    let energy_at_start = EnergyAtStart::new(&world.bodies, frame);
    let bank = world.ledger.bank();

    // Bonds give way to blows.
    let (mut broken, bond_accounts) = strike_bonds(world, &blows, frame);
    clock.lap("strike_bonds");

    // Break what does not bear its blows, and move: collisions, contact, positions. Fragments meet
    // their striker in the frame that made them.
    let moved = match world.method {
        Method::Paper => move_by_newmark(world, frame, &mut clock),
        Method::FrameRate => move_by_substeps(world, frame, &mut clock),
    };
    let Moved {
        fractures,
        contact_free,
        gravity,
        mut accounts,
        left_out,
        short_of_substeps,
        mut quarantined,
        before: solved_from,
        hit,
    } = moved;
    world.end_sparing();
    accounts.add(bond_accounts);
    broken.extend(fractures);
    let culprits = contain(world, &solved_from, &mut accounts);

    // The caller's deeds before the frame are part of its report.
    let Handled { work: by_hand, fractures: mut all } = std::mem::take(&mut world.hand.handled);
    all.extend(freed);

    // Balance the energy of every island.
    accounts.links.extend(broken.iter().flat_map(Fracture::links));
    let balance = world.ledger.balance(
        &mut world.bodies,
        &energy_at_start,
        &contact_free,
        frame,
        &mut accounts,
    );
    clock.lap("balance_energy");

    // Close the books.
    take_out(world, &culprits);
    quarantined.extend(culprits);
    take_out_faulty(world, &mut quarantined);
    let after = Totals::of(&world.bodies, frame);
    let before = Totals { kinetic: before.kinetic - by_hand, ..before };
    accounts.causes.work += by_hand;
    let banked = world.ledger.bank() - bank;
    // Frames with removed bodies have no comparable sums.
    let (energy, momentum) = if quarantined.is_empty() {
        world.books.close(&before, &after, gravity, banked, &accounts)
    } else {
        accounts = FrameAccounts::default();
        world.books.close(&after, &after, Default::default(), 0.0, &accounts)
    };
    world.frame += 1;
    clock.lap("report");
    let report = StepReport {
        frame: world.frame,
        time: world.time(),
        bodies: world.bodies.len(),
        pairs_left_out: left_out,
        short_of_substeps,
        asleep: world.bodies.ids.iter().filter(|&&id| world.is_asleep(id)).count(),
        waiting: world.labels.iter().filter(|label| label.waiting.is_some()).count(),
        mass: after.mass,
        energy,
        momentum,
        balance: balance.into(),
        impulses: Impulses {
            applied: accounts.impulses,
            clamped: accounts.clamps.shortened,
            discarded: accounts.clamps.dropped,
            withheld: accounts.clamps.withheld,
        },
        fractures: {
            all.extend(broken);
            all
        },
        quarantined,
        stages: clock.laps,
    };
    (report, Contacts { hit, links: accounts.links })
}

/// State of a frame before its energy is balanced.
struct Moved {
    /// Fractures of the frame.
    fractures: Vec<Fracture>,
    /// The frame without contact.
    contact_free: ContactFreeState,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    gravity: (DVec3, DVec3),
    /// Impulses and work of static and kinematic bodies.
    accounts: FrameAccounts,
    /// Number of pairs left out in crowds.
    left_out: usize,
    /// Number of islands with fewer substeps than needed.
    short_of_substeps: usize,
    /// Bodies removed before the solver.
    quarantined: Vec<Quarantined>,
    /// State at the solver's start.
    before: Before,
    /// Waiting bodies that a blow reached.
    hit: Vec<BodyId>,
}

/// The paper's way from x^n, v^n to x^{n+1}, v^{n+1}: collisions, and two updates, each with
/// contact [SSF08].
fn move_by_newmark(world: &mut World, frame: &Frame, clock: &mut StageClock) -> Moved {
    // Collide and break [Su09 sec. 3.2, 4.2]: impulses come from the split state (x^{n+1}, v^n),
    // change v^n, and are clamped against (x^n, v^n).
    let mut collisions = Collisions::new(&world.bodies, frame);
    let fractures = collide_and_break(world, &mut collisions, frame, clock);
    let Collisions { predicted, mut accounts, .. } = collisions;
    let before = Before::of(&world.bodies);

    // Position update, x^n to x^{n+1}: contact on velocities at n+1/2 that are then dropped.
    let bodies = &mut world.bodies;
    let candidates = find_pairs(bodies, &predicted, reach(frame));
    let graph = contact_graph(bodies, &candidates, frame);
    clock.lap("contact_graph");
    let half = accelerate(bodies, &bodies.velocities, 0.5 * frame.dt, frame);
    let mut contact = Contact::new(bodies, half, Phase::Position, frame);
    let contact_free = ContactFreeState::new(bodies, contact.proposed.clone(), &accounts, frame);
    let touching = contact.resolve(&graph);
    clock.lap("position_contact");
    propagate_shock(&mut contact, &graph);
    clock.lap("shock_propagation");
    let Contact { mut proposed, mut displacements, .. } = contact;
    push_out(bodies, &mut proposed, &graph, &mut displacements, frame);
    let flown = Totals::at(bodies, &contact_free.poses, frame).energy();
    bodies.poses = proposed;
    clock.lap("push_out");

    // Velocity update, v^n to v^{n+1}: contact seen at (x^{n+2}, v^{n+1}), clamped against
    // (x^{n+1}, v^{n+1}). The displacements took angular momentum from the pairs; gravity's share
    // of x^{n+1} is booked before it is restored.
    let gravity = gravity_impulse(bodies, frame);
    displacements.restore_angular_momentum(bodies, &mut accounts);
    accounts.causes.projection += Totals::of(bodies, frame).energy() - flown;
    clock.lap("restore_momentum");
    bodies.velocities = accelerate(bodies, &bodies.velocities, frame.dt, frame);
    let mut contact = Contact::new(bodies, bodies.velocities.clone(), Phase::Velocity, frame);
    contact.resolve(&touching);
    let Contact { velocities, accounts: velocity_accounts, .. } = contact;
    bodies.velocities = velocities;
    accounts.add(velocity_accounts);
    clock.lap("velocity_contact");
    Moved {
        fractures,
        contact_free,
        gravity,
        accounts,
        left_out: 0,
        short_of_substeps: 0,
        quarantined: Vec::new(),
        before,
        hit: Vec::new(),
    }
}

/// One detection at x^n, then substeps of sequential impulses.
fn move_by_substeps(world: &mut World, frame: &Frame, clock: &mut StageClock) -> Moved {
    // Break bodies hit above their strength, fragments included, before any motion.
    let (mut accounts, mut quarantined) = (FrameAccounts::default(), Vec::new());
    let Struck { fractures, predicted, swept } =
        strike_and_break(world, &mut accounts, &mut quarantined, frame, clock);

    // Pairs near their paths may touch; the solver handles contact.
    let World { bodies, warm, contact_cache, labels, fits, hand, .. } = world;
    let found = contact_cache.find_manifolds(bodies, &swept.pairs, warm, frame);
    clock.lap("find_manifolds");

    find_impact_chain(bodies, &predicted, &swept, (found, warm), frame);
    clock.lap("impact_chain");
    let cut_up = &hand.handled.fractures;
    let broken: BTreeSet<u64> =
        fractures.iter().chain(cut_up).map(|fracture| fracture.body).collect();
    fits.forgive(bodies, found, |pair| {
        let parent = |i: usize| labels[i].parent;
        let is_newborn = |parent| broken.contains(&id_number(parent));
        !broken.is_empty()
            && parent(pair.first) == parent(pair.second)
            && parent(pair.first).is_some_and(is_newborn)
    });
    let manifolds: Vec<Manifold> = found.iter().collect();
    clock.lap("find_manifolds");
    let contact_free = ContactFreeState::new(bodies, predicted, &accounts, frame);
    let before = Before::of(bodies);
    let pressed_before = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let Solved { accounts: solver_accounts, gravity, short_of_substeps, confirmed } =
        solve(bodies, (&manifolds, &found.neighbours), warm, frame);
    accounts.add(solver_accounts);
    let as_solved = |Manifold { pair, points }| Manifold {
        pair,
        points: confirmed.get(&pair).map_or(points, Vec::as_slice),
    };
    let manifolds: Vec<Manifold> = manifolds.into_iter().map(as_solved).collect();
    let pressed_after = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let hit = hit_through_others(bodies, &manifolds, (&pressed_before, &pressed_after), frame);
    // Contact forces load the bonds of glued bodies in the next frame.
    let are_glued: Vec<bool> = labels.iter().map(|label| label.bonds.is_some()).collect();
    if are_glued.contains(&true) {
        let is_of_one =
            |Manifold { pair, .. }: &Manifold| are_glued[pair.first] || are_glued[pair.second];
        let glued = manifolds.iter().copied().filter(is_of_one);
        let forces = contact_forces(bodies, glued, warm);
        note_carried(world, &forces);
    }
    clock.lap("solve");
    let left_out = swept.left_out;
    Moved {
        fractures,
        contact_free,
        gravity,
        accounts,
        left_out,
        short_of_substeps,
        quarantined,
        before,
        hit,
    }
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

/// Passes over all colliding pairs; what a pass broke is replaced by its fragments before the next
/// one.
fn collide_and_break(
    world: &mut World,
    collisions: &mut Collisions,
    frame: &Frame,
    clock: &mut StageClock,
) -> Vec<Fracture> {
    let mut fractures = Vec::new();
    let mut breaking_passes = 0;
    let mut passes = 0;
    while passes < frame.settings.collision_passes {
        let may_break = breaking_passes < frame.settings.breaking_passes;
        let response = if may_break { Response::BounceAndBreak } else { Response::Bounce };
        let pass = collisions.pass(&mut world.bodies, response, frame);
        clock.lap("collisions");
        if !pass.blows.is_empty() {
            let (broken, new_index) =
                break_and_book(world, &pass.blows, &mut collisions.accounts, frame);
            collisions.rebase(&world.bodies, &new_index, frame);
            fractures.extend(broken);
            breaking_passes += 1;
            clock.lap("break_bodies");
            continue;
        }
        if !pass.any {
            break;
        }
        passes += 1;
    }
    fractures
}

/// Breaks bodies and books what it does to the energy.
fn break_and_book(
    world: &mut World,
    blows: &[Blow],
    accounts: &mut FrameAccounts,
    frame: &Frame,
) -> (Vec<Fracture>, Vec<Option<usize>>) {
    let (energy, work) = (Totals::of(&world.bodies, frame).energy(), accounts.causes.work);
    let broken = break_bodies(world, blows, accounts);
    accounts.causes.fracture +=
        Totals::of(&world.bodies, frame).energy() - energy - (accounts.causes.work - work);
    broken
}

/// Twice as far as bodies fall in one frame from rest [m]: bounds that come this close may belong
/// to resting contacts of the paper's method, which looks at where they will be.
fn reach(frame: &Frame) -> f64 {
    frame.gravity.length() * frame.dt * frame.dt
}
