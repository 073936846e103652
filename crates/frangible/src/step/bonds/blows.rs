//! Effects of a frame's blows on glued bodies.

use crate::report::{Fracture, id_from_number, id_number};
use crate::step::bonds::fall_apart::{Broken, fall_apart};
use crate::world::World;
use frangible_bodies::{Bodies, BodyId, Frame, Pair};
use frangible_collision::ContactPoint;
use frangible_dynamics::{Approach, FrameAccounts, PairImpulse, pass_on};
use glam::DVec3;
use std::collections::BTreeSet;

/// Broken bonds per body, and impulses on strikers.
#[derive(Default)]
pub(crate) struct Blows {
    /// One entry per body with lost bonds, in order of impact.
    pub(super) cuts: Vec<Cut>,
    /// Impulses in order of action.
    pub(super) felt: Vec<Felt>,
}

/// Lost bonds of a body.
pub(super) struct Cut {
    pub(super) body: BodyId,
    /// Their names in [`frangible_fracture::Glued::name_of`].
    pub(super) bonds: BTreeSet<[u32; 2]>,
    /// Of the first blow: who strikes, where in the world [m], the impulse that would have stopped
    /// it, and what bonds bore before the struck piece came free [N s].
    pub(super) striker: BodyId,
    pub(super) point: DVec3,
    pub(super) impulse: f64,
    pub(super) borne: f64,
}

/// An impulse borne by bonds.
pub(super) struct Felt {
    /// Its opposite acts on the second.
    pub(super) pair: [BodyId; 2],
    /// On the first body, in the world frame [N s].
    pub(super) impulse: DVec3,
    /// Point of action: index of a movable body of the pair, and offset from its centre of mass
    /// [m].
    pub(super) at: (usize, DVec3),
}

impl Blows {
    /// Adds bonds to those that a body loses.
    pub(super) fn cut(&mut self, cut: Cut) {
        match self.cuts.iter_mut().find(|known| known.body == cut.body) {
            Some(known) => known.bonds.extend(cut.bonds),
            None => self.cuts.push(cut),
        }
    }

    /// Replaces anchored bodies with lost bonds by their remaining parts; the impulses act on the
    /// part still anchored.
    pub(super) fn break_anchored(&mut self, world: &mut World) -> Vec<Fracture> {
        let fractures = self.break_some(world, true);
        for fracture in &fractures {
            let parts = fracture.fragments.iter().map(|&part| id_from_number(part));
            let is_fixed = |id: &BodyId| {
                world.bodies.index_of(*id).is_some_and(|i| world.bodies.inertias[i].is_infinite())
            };
            let Some(fixed) = parts.into_iter().find(is_fixed) else { continue };
            for id in self.felt.iter_mut().flat_map(|felt| &mut felt.pair) {
                if id_number(*id) == fracture.body {
                    *id = fixed;
                }
            }
        }
        fractures
    }

    /// Lets act what bonds bore, where both bodies of the pair are alive.
    pub(super) fn act(&self, world: &mut World, frame: &Frame, accounts: &mut FrameAccounts) {
        for Felt { pair, impulse, at } in &self.felt {
            let [Some(a), Some(b)] = pair.map(|id| world.bodies.index_of(id)) else { continue };
            let (side, lever) = *at;
            let point = world.bodies.poses[[a, b][side]].position + lever;
            let (pair, at_contact) = if a < b {
                (Pair { first: a, second: b }, *impulse)
            } else {
                (Pair { first: b, second: a }, -*impulse)
            };
            let Some(normal) = at_contact.try_normalize() else { continue };
            let approach = approach(&world.bodies, pair, ContactPoint { point, normal });
            let impulse = PairImpulse::new(&approach, at_contact);
            pass_on(&mut world.bodies, pair, &approach, &impulse, frame, accounts);
        }
    }

    /// Replaces bodies that move freely and lose bonds by their islands.
    pub(super) fn break_free(&self, world: &mut World) -> Vec<Fracture> {
        self.break_some(world, false)
    }

    fn break_some(&self, world: &mut World, anchored: bool) -> Vec<Fracture> {
        let mut broken = Vec::new();
        for Cut { body, bonds, striker, point, impulse, borne } in &self.cuts {
            let Some(i) = world.bodies.index_of(*body) else { continue };
            if world.bodies.inertias[i].is_infinite() != anchored {
                continue;
            }
            if let Some(of_body) = &mut world.labels[i].bonds {
                of_body.glued.cut(bonds);
            }
            let striker = world.bodies.index_of(*striker).unwrap_or(i);
            let (point, impulse, borne) = (*point, *impulse, *borne);
            broken.push(Broken { body: i, striker, point, impulse, borne });
        }
        fall_apart(world, &broken)
    }
}

/// Relative motion of a pair at a point.
fn approach(bodies: &Bodies, pair: Pair, contact: ContactPoint) -> Approach {
    let sides = [pair.first, pair.second];
    let levers = sides.map(|i| contact.point - bodies.poses[i].position);
    let [first, second] = [0, 1].map(|side| {
        let i = sides[side];
        bodies.point_velocity(i, &bodies.poses[i], &bodies.velocities[i], levers[side])
    });
    Approach { contact, levers, relative_velocity: first - second }
}
