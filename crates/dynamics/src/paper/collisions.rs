//! Collisions: bodies about to overlap in this frame bounce beforehand [GBF03 sec. 4].
//!
//! Contact points, normals, levers and angular velocities belong to the predicted poses x^{n+1};
//! the impulses change v^n and are clamped against (x^n, v^n) [Su09 sec. 3.2, "Collision
//! Clamping"]. Blows above a body's strength are reported, and the engine breaks the body [Su09
//! sec. 4.2].

use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::impacts::blows::{Blow, blows_of};
use crate::impulse::pair_impulse::{Approach, PairImpulse, deepest_approach, impulse_for};
use frangible_bodies::{Bodies, BodyId, Frame, Pair, Pose, evolve, half_fallen, predict};
use frangible_collision::{NearSamples, Penetration, find_pairs, first_contact, placed};
use std::collections::HashMap;

/// Result of one pass over all pairs.
#[derive(Clone, Debug, Default)]
pub struct Pass {
    /// True if any impulse was applied.
    pub any: bool,
    /// Blows that break a body, in order of the pairs.
    pub blows: Vec<Blow>,
}

/// Allowed response to a collision.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Bodies bounce, and break above their strength.
    BounceAndBreak,
    /// Bodies bounce, regardless of strength.
    Bounce,
}

/// The collisions of one frame, pass by pass.
#[derive(Clone, Debug)]
pub struct Collisions {
    /// x^{n+1} by the present velocities.
    pub predicted: Vec<Pose>,
    /// Impulses and work of static and kinematic bodies.
    pub accounts: FrameAccounts,
    /// Number of re-evolutions of each body.
    moves: Vec<u32>,
    /// Re-evolution counts of both bodies at a pair's last visit: unmoved pairs are skipped.
    seen: HashMap<(BodyId, BodyId), (u32, u32)>,
    penetrations: Vec<Penetration>,
}

impl Collisions {
    /// Begins the frame.
    pub fn new(bodies: &Bodies, frame: &Frame) -> Self {
        Self {
            predicted: predict(bodies, frame),
            accounts: FrameAccounts::default(),
            moves: vec![0; bodies.len()],
            seen: HashMap::new(),
            penetrations: Vec::new(),
        }
    }

    /// Continues after a break: `new_index` maps old dense indices; fragments follow at the end.
    pub fn rebase(&mut self, bodies: &Bodies, new_index: &[Option<usize>], frame: &Frame) {
        let mut moves = vec![0; bodies.len()];
        for (old, new) in new_index.iter().enumerate() {
            if let Some(new) = *new {
                moves[new] = self.moves[old];
            }
        }
        self.moves = moves;
        self.predicted = predict(bodies, frame);
    }

    /// One pass over all pairs. A broken body is skipped for the rest of the pass.
    /// Of an impulse on a glued body acts the share that `bonds` says; if there is one, the bonds of
    /// that body have given way.
    pub fn pass(
        &mut self,
        bodies: &mut Bodies,
        response: Response,
        mut bonds: impl FnMut(&Bodies, &Approach, &PairImpulse, (Pair, &[Pose])) -> Option<f64>,
        frame: &Frame,
    ) -> Pass {
        let mut pass = Pass::default();
        let mut broken = vec![false; bodies.len()];
        for pair in find_pairs(bodies, &self.predicted, 0.0) {
            if self.unmoved_since_seen(bodies, pair) {
                continue;
            }
            let (first, second) = placed(bodies, pair, &self.predicted);
            let mut near = NearSamples::gather(first, second, 0.0);
            for _ in 0..frame.settings.collision_pair_iterations {
                if broken[pair.first] || broken[pair.second] {
                    break;
                }
                let next = self.next_impulse(bodies, pair, &mut near, frame);
                let Some((approach, impulse)) = next else { break };
                let blows = match response {
                    Response::BounceAndBreak => self.blows(bodies, pair, &approach, &impulse),
                    Response::Bounce => [None; 2],
                };
                let borne = blows
                    .iter()
                    .flatten()
                    .map(|blow| blow.borne / blow.impulse)
                    .fold(1.0, f64::min);
                let is_glued = pair.both().into_iter().any(|i| bodies.surfaces[i].glued);
                let part = if is_glued && matches!(response, Response::BounceAndBreak) {
                    bonds(bodies, &approach, &impulse, (pair, &self.predicted))
                } else {
                    None
                };
                pair.both().into_iter().for_each(|i| broken[i] |= part.is_some());
                let borne = borne.min(part.unwrap_or(1.0));
                self.apply(bodies, pair, &approach, &impulse.scaled(borne), frame);
                pass.any = true;
                for (blow, i) in blows.into_iter().zip([pair.first, pair.second]) {
                    broken[i] |= blow.is_some();
                    pass.blows.extend(blow);
                }
            }
            // A pair with a blow is visited again: by the fragments, or by an unsplittable body.
            if !broken[pair.first] && !broken[pair.second] {
                self.remember(bodies, pair);
            }
        }
        pass
    }

    /// Blows to both bodies of the pair, at their first touch, or at the impulse's point if the
    /// bodies already overlap at the start.
    fn blows(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
    ) -> [Option<Blow>; 2] {
        let both = pair.both();
        let (now, ends) = (both.map(|i| bodies.poses[i]), both.map(|i| self.predicted[i]));
        let acts = (approach.contact.point, impulse.at_contact.length());
        blows_of(bodies, pair, acts, &|bodies, i, _| bodies.surfaces[i].strength, || {
            first_contact(bodies, pair, [&now, &ends]).unwrap_or((approach.contact, ends))
        })
    }

    /// Clamped impulse at the deepest approaching point of a pair, if any.
    fn next_impulse(
        &mut self,
        bodies: &Bodies,
        pair: Pair,
        near: &mut NearSamples,
        frame: &Frame,
    ) -> Option<(Approach, PairImpulse)> {
        let (first, second) = placed(bodies, pair, &self.predicted);
        near.find_penetrations(first, second, 0.0, &mut self.penetrations);
        let (predicted, velocities) = (&self.predicted, &bodies.velocities);
        let approach =
            deepest_approach(bodies, pair, &mut self.penetrations, predicted, velocities)?;
        let surfaces = bodies.pair_surface(pair.first, pair.second);
        let impulse = impulse_for(pair, &approach, predicted, &bodies.inertias, surfaces);
        let mut impulse = impulse.keeping_angular_momentum(bodies, pair);
        if frame.settings.impulse_clamp {
            impulse = impulse.clamped_to_energy(
                bodies,
                pair,
                &approach,
                velocities,
                &mut self.accounts.clamps,
            );
        }
        (!impulse.is_zero()).then_some((approach, impulse))
    }

    /// Applies an impulse to v^n, re-evolves both bodies and books the outside's share.
    fn apply(
        &mut self,
        bodies: &mut Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
        frame: &Frame,
    ) {
        self.accounts.book_impulse(
            bodies,
            pair,
            approach,
            impulse,
            (&bodies.velocities, Cause::Collision),
        );
        impulse.apply(pair, &bodies.inertias, &mut bodies.velocities);
        for i in [pair.first, pair.second] {
            if !bodies.inertias[i].is_infinite() {
                let falling = half_fallen(bodies.velocities[i], frame);
                self.predicted[i] = evolve(bodies, i, &bodies.poses[i], &falling, frame);
                self.moves[i] += 1;
            }
        }
    }

    fn unmoved_since_seen(&self, bodies: &Bodies, pair: Pair) -> bool {
        let key = (bodies.ids[pair.first], bodies.ids[pair.second]);
        self.seen.get(&key) == Some(&(self.moves[pair.first], self.moves[pair.second]))
    }

    fn remember(&mut self, bodies: &Bodies, pair: Pair) {
        let key = (bodies.ids[pair.first], bodies.ids[pair.second]);
        self.seen.insert(key, (self.moves[pair.first], self.moves[pair.second]));
    }
}
