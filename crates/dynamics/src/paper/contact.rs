//! Contact: impulses that keep what touches from moving into each other [GBF03 sec. 6].
//!
//! The position phase and the velocity phase are the same computation at two places in time. What
//! would penetrate is looked for at the *proposed* poses; normals, levers and velocities are taken
//! at the *old* ones.

use crate::energy::island::pair_energy;
use crate::energy::tally::{Cause, Tally};
use crate::impulse::pair_impulse::{Approach, PairImpulse, deepest_approach, impulse_for};
use crate::paper::contact_graph::{ContactGraph, Level};
use crate::paper::displacements::{Displacements, Push};
use frangible_bodies::{
    Bodies, Frame, Inertia, Pair, PairContactant, Pose, Velocity, evolve, evolve_all,
};
use frangible_collision::{NearSamples, Penetration, placed};
use std::collections::HashMap;

/// Samples this far outside still count as penetrating [m]: an allowance for round-off, as in the
/// authors' code.
const CONTOUR: f32 = 1e-6;

/// What becomes of the impulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Only their effect on the poses stays. Not clamped: there is no non-split state to clamp
    /// against [Su09 sec. 3.2, "Contact Clamping"].
    Position,
    /// They stay; clamped against (x^{n+1}, v^{n+1}) [Su09 sec. 3.2].
    Velocity,
}

/// One phase of contact: where bodies are, where they would get to, and the velocities that take
/// them there.
pub struct Contact<'a> {
    /// At the phase's old time level: normals, levers and angular velocities are taken there.
    pub bodies: &'a Bodies,
    /// Duration, gravity, settings.
    pub frame: &'a Frame,
    /// What becomes of the impulses.
    pub phase: Phase,
    /// The velocities that the phase corrects.
    pub velocities: Vec<Velocity>,
    /// The old poses evolved by one frame with `velocities`.
    pub proposed: Vec<Pose>,
    /// Who can be moved; shock propagation holds bodies still by making their inertia infinite.
    pub inertias: Vec<Inertia>,
    /// What static and kinematic bodies contributed.
    pub tally: Tally,
    /// How far the position phase moved pairs off the paths of their velocities.
    pub displacements: Displacements,
    near: HashMap<Pair, NearSamples>,
    penetrations: Vec<Penetration>,
}

impl<'a> Contact<'a> {
    /// Begins a phase at the poses of `bodies`, with the velocities that would carry them on.
    pub fn new(
        bodies: &'a Bodies,
        velocities: Vec<Velocity>,
        phase: Phase,
        frame: &'a Frame,
    ) -> Self {
        let proposed = evolve_all(bodies, &bodies.poses, &velocities, frame);
        let inertias = bodies.inertias.clone();
        Self {
            bodies,
            frame,
            phase,
            velocities,
            proposed,
            inertias,
            tally: Tally::default(),
            displacements: Displacements::default(),
            near: HashMap::new(),
            penetrations: Vec::new(),
        }
    }

    /// Passes over the graph, level by level, until nothing approaches. Restitution below 0
    /// ("epsilon scaling") lets the first passes stop a part of each approach only; the schedule is
    /// that of the authors' code. Returns the graph of what fired.
    pub fn resolve(&mut self, graph: &ContactGraph) -> ContactGraph {
        let settings = self.frame.settings;
        let full = f64::from(settings.contact_passes * settings.contact_level_iterations);
        let mut fired = Fired::new(graph);
        for pass in 1..=settings.contact_passes {
            let mut any = false;
            for (index, level) in graph.levels.iter().enumerate() {
                for sweep in 1..=settings.contact_level_iterations {
                    let restitution = f64::from(pass * sweep) / full - 1.0;
                    let hit =
                        self.sweep_level(level, restitution, settings.contact_pair_iterations);
                    any |= fired.record(index, &hit);
                }
            }
            if !any {
                break;
            }
        }
        fired.into_graph(graph)
    }

    /// One sweep over the pairs of a level; tells for each whether an impulse was applied.
    pub(crate) fn sweep_level(
        &mut self,
        level: &Level,
        restitution: f64,
        pair_iterations: u32,
    ) -> Vec<bool> {
        let stop = |&pair: &Pair| {
            let mut fired = false;
            for _ in 0..pair_iterations {
                if !self.stop_deepest(pair, restitution) {
                    break;
                }
                fired = true;
            }
            fired
        };
        level.pairs.iter().map(stop).collect()
    }

    /// One impulse on one pair; false if nothing approaches or the impulse comes to nothing.
    fn stop_deepest(&mut self, pair: Pair, restitution: f64) -> bool {
        // Look for what would penetrate, at the proposed poses.
        let (first, second) = placed(self.bodies, pair, &self.proposed);
        let near =
            self.near.entry(pair).or_insert_with(|| NearSamples::gather(first, second, CONTOUR));
        near.find_penetrations(first, second, CONTOUR, &mut self.penetrations);

        // The deepest that approaches, as seen at the old poses.
        let (old, penetrations) = (&self.bodies.poses, &mut self.penetrations);
        let Some(approach) =
            deepest_approach(self.bodies, pair, penetrations, old, &self.velocities)
        else {
            return false;
        };
        let surfaces =
            PairContactant { restitution, ..self.bodies.pair_contactant(pair.first, pair.second) };
        let mut impulse = impulse_for(pair, &approach, old, &self.inertias, surfaces);
        if self.phase == Phase::Velocity && self.frame.settings.impulse_clamp {
            let (velocities, tally) = (&self.velocities, &mut self.tally);
            impulse = impulse.clamped_to_energy(
                self.bodies,
                pair,
                &approach,
                velocities,
                &mut tally.clamps,
            );
        }
        if impulse.is_zero() {
            return false;
        }
        self.apply(pair, &approach, &impulse);
        true
    }

    /// Applies an impulse, re-evolves both bodies and books what came from outside.
    fn apply(&mut self, pair: Pair, approach: &Approach, impulse: &PairImpulse) {
        if self.phase == Phase::Velocity {
            let before = (&self.velocities[..], Cause::Contact);
            self.tally.book_impulse(self.bodies, pair, approach, impulse, before);
        }
        let energy_before = self.pair_energy(pair);
        impulse.apply(pair, &self.inertias, &mut self.velocities);
        for i in [pair.first, pair.second] {
            if !self.inertias[i].is_infinite() {
                self.proposed[i] =
                    evolve(self.bodies, i, &self.bodies.poses[i], &self.velocities[i], self.frame);
            }
        }
        if self.phase == Phase::Position {
            let energy = self.pair_energy(pair) - energy_before;
            let amount = self.frame.dt * impulse.at_contact;
            let push = Push { point: approach.contact.point, amount, energy };
            self.displacements.book(self.bodies, pair, &push, &self.inertias);
        }
    }

    /// Of a pair at the proposed poses, with the velocities that it keeps [J].
    fn pair_energy(&self, pair: Pair) -> f64 {
        pair_energy(self.bodies, pair, &self.proposed, self.frame.gravity)
    }
}

/// Which pairs of a graph fired so far.
struct Fired(Vec<Vec<bool>>);

impl Fired {
    fn new(graph: &ContactGraph) -> Self {
        Self(graph.levels.iter().map(|level| vec![false; level.pairs.len()]).collect())
    }

    /// Adds one sweep's record; tells whether any pair fired in it.
    fn record(&mut self, level: usize, hit: &[bool]) -> bool {
        self.0[level].iter_mut().zip(hit).for_each(|(sum, &now)| *sum |= now);
        hit.contains(&true)
    }

    fn into_graph(self, graph: &ContactGraph) -> ContactGraph {
        let levels = graph.levels.iter().zip(self.0).map(|(level, fired)| Level {
            bodies: level.bodies.clone(),
            pairs: level
                .pairs
                .iter()
                .zip(fired)
                .filter_map(|(&pair, hit)| hit.then_some(pair))
                .collect(),
        });
        ContactGraph { levels: levels.filter(|level| !level.pairs.is_empty()).collect() }
    }
}
