//! Collisions: what would meet in this frame bounces before it gets there [GBF03 sec. 4].
//!
//! Contact points, normals, levers and angular velocities are those of the predicted poses x^{n+1};
//! the impulses change v^n and are clamped against (x^n, v^n) [Su09 sec. 3.2, "Collision
//! Clamping"]. A blow above a body's strength is reported, for the engine to break the body [Su09
//! sec. 4.2].

use crate::energy::tally::{Cause, Tally};
use crate::impacts::blows::{Blow, blows_of};
use crate::impulse::pair_impulse::{Approach, PairImpulse, deepest_approach, impulse_for};
use frangible_bodies::{Bodies, BodyId, Frame, Pair, Pose, evolve, half_fallen, predict};
use frangible_collision::{NearSamples, Penetration, find_pairs, first_contact, placed};
use std::collections::HashMap;

/// What one pass over all pairs came to.
#[derive(Clone, Debug, Default)]
pub struct Pass {
    /// Whether any impulse was applied.
    pub any: bool,
    /// What breaks, in order of the pairs.
    pub blows: Vec<Blow>,
}

/// What a collision may do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Response {
    /// Bodies bounce, and break if they do not bear it.
    BounceAndBreak,
    /// Bodies bounce, whatever they bear.
    Bounce,
}

/// The collisions of one frame, pass by pass.
#[derive(Clone, Debug)]
pub struct Collisions {
    /// x^{n+1} as the present velocities would have it.
    pub predicted: Vec<Pose>,
    /// What static and kinematic bodies contributed.
    pub tally: Tally,
    /// How often each body was re-evolved.
    moves: Vec<u32>,
    /// The moves of both bodies when a pair was last looked at: what has not moved since needs no
    /// second look.
    seen: HashMap<(BodyId, BodyId), (u32, u32)>,
    penetrations: Vec<Penetration>,
}

impl Collisions {
    /// Begins the frame.
    pub fn new(bodies: &Bodies, frame: &Frame) -> Self {
        Self {
            predicted: predict(bodies, frame),
            tally: Tally::default(),
            moves: vec![0; bodies.len()],
            seen: HashMap::new(),
            penetrations: Vec::new(),
        }
    }

    /// Goes on after bodies were broken: `new_index` maps old dense indices, and what is new stands
    /// behind.
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

    /// One pass over all pairs. What broke is left alone for the rest of the pass.
    pub fn pass(&mut self, bodies: &mut Bodies, response: Response, frame: &Frame) -> Pass {
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
                self.apply(bodies, pair, &approach, &impulse.scaled(borne), frame);
                pass.any = true;
                for (blow, i) in blows.into_iter().zip([pair.first, pair.second]) {
                    broken[i] |= blow.is_some();
                    pass.blows.extend(blow);
                }
            }
            // A pair with a blow is looked at again: by the fragments, or by a body that could not
            // be split.
            if !broken[pair.first] && !broken[pair.second] {
                self.remember(bodies, pair);
            }
        }
        pass
    }

    /// The blow to each body of the pair; it lands where they first touched, or, if they did
    /// before, where the impulse acts.
    fn blows(
        &self,
        bodies: &Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
    ) -> [Option<Blow>; 2] {
        let predicted = &self.predicted;
        let acts = (approach.contact.point, impulse.at_contact.length());
        blows_of(bodies, pair, acts, || {
            first_contact(bodies, pair, predicted)
                .unwrap_or((approach.contact, [predicted[pair.first], predicted[pair.second]]))
        })
    }

    /// The clamped impulse at the deepest approaching point of a pair, if there is one.
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
        let surfaces = bodies.pair_contactant(pair.first, pair.second);
        let impulse = impulse_for(pair, &approach, predicted, &bodies.inertias, surfaces);
        let mut impulse = impulse.keeping_angular_momentum(bodies, pair);
        if frame.settings.impulse_clamp {
            impulse = impulse.clamped_to_energy(
                bodies,
                pair,
                &approach,
                velocities,
                &mut self.tally.clamps,
            );
        }
        (!impulse.is_zero()).then_some((approach, impulse))
    }

    /// Applies an impulse to v^n, re-evolves both bodies and books what came from outside.
    fn apply(
        &mut self,
        bodies: &mut Bodies,
        pair: Pair,
        approach: &Approach,
        impulse: &PairImpulse,
        frame: &Frame,
    ) {
        self.tally.book_impulse(
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
