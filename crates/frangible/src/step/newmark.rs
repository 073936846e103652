//! The paper's step: collisions, then a Newmark step in two updates, each with contact [SSF08],
//! [Su09].

use crate::report::Fracture;
use crate::report::books::{Totals, gravity_impulse};
use crate::step::bonds::blows::{BlowOnBonds, Overstrained};
use crate::step::break_bodies::break_and_book;
use crate::step::closing::Opening;
use crate::step::moved::Moved;
use crate::step::quarantine::Before;
use crate::step::stage_clock::StageClock;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, Frame, Pair, Pose, accelerate};
use frangible_collision::{ContactPoint, find_pairs};
use frangible_dynamics::{
    Approach, Collisions, Contact, ContactFreeState, PairImpulse, Phase, PointImpulse, Response,
    contact_graph, propagate_shock, push_out,
};

/// The paper's way from x^n, v^n to x^{n+1}, v^{n+1}: collisions, and two updates, each with
/// contact [SSF08].
pub(crate) fn move_by_newmark(
    world: &mut World,
    opening: &mut Opening,
    frame: &Frame,
    clock: &mut StageClock,
) -> Moved {
    // Collide and break [Su09 sec. 3.2, 4.2]: impulses come from the split state (x^{n+1}, v^n),
    // change v^n, and are clamped against (x^n, v^n).
    let mut collisions = Collisions::new(&world.bodies, frame);
    let fractures = collide_and_break(world, &mut collisions, opening, frame, clock);
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
        short_of_impacts: 0,
        borne: None,
        quarantined: Vec::new(),
        before,
        hit: Vec::new(),
    }
}

/// Passes over all colliding pairs; what a pass broke is replaced by its fragments before the next
/// one.
fn collide_and_break(
    world: &mut World,
    collisions: &mut Collisions,
    opening: &mut Opening,
    frame: &Frame,
    clock: &mut StageClock,
) -> Vec<Fracture> {
    let mut fractures = Vec::new();
    let mut breaking_passes = 0;
    let mut passes = 0;
    while passes < frame.settings.collision_passes {
        let may_break = breaking_passes < frame.settings.breaking_passes;
        let response = if may_break { Response::BounceAndBreak } else { Response::Bounce };
        let mut overstrained = Overstrained::default();
        let World { bodies, labels, .. } = &mut *world;
        let bonds =
            |bodies: &Bodies, approach: &Approach, impulse: &PairImpulse, at: (Pair, &[Pose])| {
                strain(&mut overstrained, (bodies, labels), (approach, impulse), at, frame)
            };
        let pass = collisions.pass(bodies, response, bonds, frame);
        clock.lap("collisions");
        let has_broken_bonds = overstrained.any_falls_apart();
        let (broken, new_index) = overstrained.fall_apart(world, opening, frame);
        fractures.extend(broken);
        if has_broken_bonds {
            collisions.rebase(&world.bodies, &new_index, frame);
        }
        if !pass.blows.is_empty() {
            let (broken, new_index) =
                break_and_book(world, &pass.blows, &mut collisions.accounts, frame);
            collisions.rebase(&world.bodies, &new_index, frame);
            fractures.extend(broken);
        }
        if has_broken_bonds || !pass.blows.is_empty() {
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

/// Loads bonds with a collision, but with one no faster than gravity sets a body in motion within a
/// frame: its weight is no blow. Returns the part that acts if pieces come free [1].
fn strain(
    overstrained: &mut Overstrained,
    (bodies, labels): (&Bodies, &[Label]),
    (approach, impulse): (&Approach, &PairImpulse),
    (pair, predicted): (Pair, &[Pose]),
    frame: &Frame,
) -> Option<f64> {
    let ContactPoint { point, normal } = approach.contact;
    if -approach.relative_velocity.dot(normal) <= frame.gravity.length() * frame.dt {
        return None;
    }
    let poses = pair.both().map(|i| predicted[i]);
    let at = poses.map(|pose| pose.world_from_body().inverse().point(point));
    let impulse = impulse.at_contact;
    let parts = &[PointImpulse { at, impulse }];
    let blow = BlowOnBonds { pair, poses, parts, impulse, point };
    overstrained.strain(bodies, labels, &blow, frame)
}

/// Twice as far as bodies fall in one frame from rest [m]: bounds that come this close may belong
/// to resting contacts of the paper's method, which looks at where they will be.
fn reach(frame: &Frame) -> f64 {
    frame.gravity.length() * frame.dt * frame.dt
}
