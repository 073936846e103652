//! The frame-rate method: one detection at x^n, then substeps ([Cat24], [Mac19]; adr/010).

use crate::report::{BorneBlow, Fracture, id_number};
use crate::step::bonds::blows::{BlowOnBonds, Overstrained};
use crate::step::bonds::{glued_contact_forces, note_carried};
use crate::step::break_bodies::break_by_strikes;
use crate::step::closing::Opening;
use crate::step::local_strength::bears_at;
use crate::step::moved::Moved;
use crate::step::quarantine::{Before, take_out_faulty};
use crate::step::stage_clock::StageClock;
use crate::step::waiting::passed_on::{hit_through_others, waiting_contacts};
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, Frame, Pair, predict};
use frangible_collision::{ContactPoint, ImpulseCache, Manifold, Swept};
use frangible_dynamics::{
    Bearing, ContactForce, ContactFreeState, FrameAccounts, Impact, Solved, Strike,
    find_impact_chain, hardest_blow, in_order, pass_on, solve, strikes,
};
use glam::DVec3;
use std::collections::BTreeSet;

/// Pairs near each other up to which a frame in which something broke may break more: where the
/// crowds are larger, the next frame does. With all passes 400 pieces of three generations, as they
/// burst, took 4 s for a frame.
const MOST_AGAIN: usize = 4096;

/// Moves all bodies from x^n, v^n to x^{n+1}, v^{n+1}. What the impacts of the frame break, breaks at
/// its start [Su09 sec. 4.2], and the frame is done again: fragments meet their striker in the
/// frame that made them, and break in turn.
pub(crate) fn move_by_substeps(
    world: &mut World,
    opening: &mut Opening,
    frame: &Frame,
    clock: &mut StageClock,
) -> Moved {
    let (mut accounts, mut quarantined) = (FrameAccounts::default(), Vec::new());
    let mut fractures: Vec<Fracture> = Vec::new();
    let mut borne = None;
    let mut passes = 0;
    let mut may_break_more = true;
    loop {
        take_out_faulty(world, &mut quarantined);
        let may_break =
            may_break_more && passes < frame.settings.breaking_passes && world.may_break();
        let start = may_break.then(|| FrameStart::of(world));
        let mut solved = solve_frame(world, &fractures, &accounts, frame, clock);
        let impacts = std::mem::take(&mut solved.impacts);
        let (mut blows, mut recent) = world.recent_impacts.blows(&world.bodies, impacts, frame.dt);
        if let (0, Some(start)) = (passes, &start) {
            borne = nearest_to_break(world, &start.bodies, &blows);
        }
        in_order(&mut blows);
        let broken = start
            .and_then(|start| break_struck(world, start, &blows, (&mut accounts, opening), frame));
        clock.lap("break_bodies");
        if let Some(broken) = broken {
            fractures.extend(broken);
            passes += 1;
            may_break_more = solved.pairs <= MOST_AGAIN;
            continue;
        }

        recent.keep(&world.bodies);
        world.recent_impacts = recent;
        note_carried(world, &solved.glued_forces);
        accounts.add(solved.accounts);
        return Moved {
            contact_free: solved.contact_free,
            gravity: solved.gravity,
            accounts,
            left_out: solved.left_out,
            short_of_substeps: solved.short_of_substeps,
            short_of_impacts: solved.short_of_impacts,
            quarantined,
            before: solved.before,
            borne: borne.filter(|blow| fractures.iter().all(|broken| broken.body != blow.body)),
            fractures,
            hit: solved.hit,
        };
    }
}

/// Of the blows to bodies that may break the one that is largest relative to what its body bears.
fn nearest_to_break(world: &World, start: &Bodies, blows: &[Impact]) -> Option<BorneBlow> {
    let local = |bodies: &Bodies, i, at| bears_at(bodies, &world.labels, i, at);
    let Bearing { body, striker, point, impulse, bears } = hardest_blow(start, blows, &local)?;
    Some(BorneBlow {
        body: id_number(start.ids[body]),
        name: world.labels[body].name.clone(),
        striker: world.labels[striker].name.clone(),
        point: point.to_array(),
        impulse,
        bears,
    })
}

/// What the substeps change, at the frame's start.
struct FrameStart {
    bodies: Bodies,
    warm: ImpulseCache,
}

impl FrameStart {
    fn of(World { bodies, warm, .. }: &World) -> Self {
        Self { bodies: bodies.clone(), warm: warm.clone() }
    }
}

/// A frame that may have to be done again.
struct SolvedFrame {
    contact_free: ContactFreeState,
    gravity: (DVec3, DVec3),
    accounts: FrameAccounts,
    left_out: usize,
    short_of_substeps: usize,
    short_of_impacts: usize,
    before: Before,
    hit: Vec<BodyId>,
    /// Loads of bonds in the next frame.
    glued_forces: Vec<ContactForce>,
    impacts: Vec<Impact>,
    /// Number of pairs near each other.
    pairs: usize,
}

/// Detects contacts and runs the substeps. `fractures` and `accounts` are those of the frame so far.
fn solve_frame(
    world: &mut World,
    fractures: &[Fracture],
    accounts: &FrameAccounts,
    frame: &Frame,
    clock: &mut StageClock,
) -> SolvedFrame {
    let predicted = predict(&world.bodies, frame);
    let swept = Swept::new(&world.bodies, &predicted, frame.speculative_margin(), frame);
    let World { bodies, labels, .. } = &mut *world;
    bodies.note_enclosures(&swept.pairs, frame.dt, |i| labels[i].parent);
    clock.lap("find_pairs");

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
    let contact_free = ContactFreeState::new(bodies, predicted, accounts, frame);
    let before = Before::of(bodies);
    let pressed_before = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let Solved { accounts, gravity, short_of_substeps, short_of_impacts, confirmed, impacts } =
        solve(bodies, (&manifolds, &found.neighbours), warm, frame);

    // Impulses of the frame: blows on waiting bodies, and loads of bonds in the next frame.
    let with_confirmed = |Manifold { pair, points }| Manifold {
        pair,
        points: confirmed.get(&pair).map_or(points, Vec::as_slice),
    };
    let manifolds: Vec<Manifold> = manifolds.into_iter().map(with_confirmed).collect();
    let pressed_after = waiting_contacts(bodies, labels, &manifolds, warm, frame);
    let hit = hit_through_others(bodies, &manifolds, (&pressed_before, &pressed_after), frame);
    let glued_forces = glued_contact_forces(bodies, labels, &manifolds, warm);
    clock.lap("solve");
    let left_out = swept.left_out;
    let pairs = manifolds.len();
    SolvedFrame {
        contact_free,
        gravity,
        accounts,
        left_out,
        short_of_substeps,
        short_of_impacts,
        before,
        hit,
        glued_forces,
        impacts,
        pairs,
    }
}

/// Breaks at the frame's `start` what its blows break, bonds first. If nothing comes off, the frame
/// stays as it is.
fn break_struck(
    world: &mut World,
    start: FrameStart,
    blows: &[Impact],
    (accounts, opening): (&mut FrameAccounts, &mut Opening),
    frame: &Frame,
) -> Option<Vec<Fracture>> {
    let local = |bodies: &Bodies, i, at| bears_at(bodies, &world.labels, i, at);
    let strikes = strikes(&start.bodies, blows, &local);
    let (overstrained, felt) = strain_bonds(world, &start.bodies, blows, &strikes, frame);
    if overstrained.any_falls_apart() {
        (world.bodies, world.warm) = (start.bodies, start.warm);
        for (blow, impulse) in felt {
            let contact = ContactPoint { point: blow.acts_at, normal: blow.contact.normal };
            pass_on(&mut world.bodies, blow.pair, contact, impulse, frame, accounts);
        }
        return Some(overstrained.fall_apart(world, opening, frame).0);
    }
    if strikes.is_empty() {
        overstrained.fall_apart(world, opening, frame);
        return None;
    }
    let mut solved = FrameStart {
        bodies: std::mem::replace(&mut world.bodies, start.bodies),
        warm: std::mem::replace(&mut world.warm, start.warm),
    };
    let fractures = break_by_strikes(world, &strikes, accounts, frame);
    if !fractures.is_empty() {
        return Some(fractures);
    }
    // Strengths stay, of what cannot split.
    std::mem::swap(&mut solved.bodies.surfaces, &mut world.bodies.surfaces);
    (world.bodies, world.warm) = (solved.bodies, solved.warm);
    None
}

/// Loads bonds with blows, in their order. A blow is known if neither body was turned off its way
/// before, by `strikes` that may break it or by bonds that gave way. Returns the blows that bring
/// pieces free, with the part that bonds bore and that has not acted yet, on the first body [N s].
fn strain_bonds<'a>(
    world: &World,
    start: &Bodies,
    blows: &'a [Impact],
    strikes: &[Strike],
    frame: &Frame,
) -> (Overstrained, Vec<(&'a Impact, DVec3)>) {
    let mut is_known_until = vec![f64::INFINITY; start.len()];
    for strike in strikes {
        for i in strike.pair.both() {
            is_known_until[i] = is_known_until[i].min(strike.time);
        }
    }
    let (mut overstrained, mut felt) = (Overstrained::default(), Vec::new());
    for blow in blows.iter().filter(|blow| !blow.parts.is_empty()) {
        let Impact { pair, poses, parts, impulse, contact, earlier, time, .. } = blow;
        let both = pair.both();
        if both.into_iter().any(|i| *time > is_known_until[i]) {
            continue;
        }
        let on_bonds = BlowOnBonds {
            pair: *pair,
            poses: *poses,
            parts,
            impulse: *impulse,
            point: contact.point,
        };
        if let Some(bore) = overstrained.strain(start, &world.labels, &on_bonds, frame) {
            let left = bore * *impulse - *earlier;
            felt.push((blow, if left.dot(*impulse) > 0.0 { left } else { DVec3::ZERO }));
            for i in both.into_iter().filter(|&i| !start.inertias[i].is_infinite()) {
                is_known_until[i] = *time;
            }
        }
    }
    (overstrained, felt)
}

/// True for two fragments of one body that broke in this frame.
fn are_newborn_siblings(labels: &[Label], broken: &BTreeSet<u64>, pair: Pair) -> bool {
    let [first, second] = pair.both().map(|i| labels[i].parent);
    first == second && first.is_some_and(|parent| broken.contains(&id_number(parent)))
}
