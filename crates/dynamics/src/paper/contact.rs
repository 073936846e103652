//! Contact: impulses that keep touching bodies from interpenetrating [GBF03 sec. 6].
//!
//! The position phase and the velocity phase are the same computation at two points in time.
//! Penetrations are searched at the *proposed* poses; normals, levers and velocities belong to the
//! *old* poses.

use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::energy::island::pair_energy;
use crate::impulse::pair_impulse::{Approach, PairImpulse, deepest_approach, impulse_for};
use crate::paper::contact_graph::{ContactGraph, Level};
use crate::paper::displacements::{Displacements, Push};
use frangible_bodies::{
    Bodies, Frame, Inertia, Pair, PairSurface, Pose, Velocity, evolve, evolve_all,
};
use frangible_collision::{NearSamples, Penetration, placed};
use std::collections::HashMap;

/// Samples up to this far outside count as penetrating [m]: an allowance for round-off, as in the
/// authors' code.
const CONTOUR: f32 = 1e-6;

/// Use of a phase's impulses.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// Impulses affect only the poses. Unclamped: no non-split state exists to clamp against
    /// [Su09 sec. 3.2, "Contact Clamping"].
    Position,
    /// Impulses stay in the velocities; clamped against (x^{n+1}, v^{n+1}) [Su09 sec. 3.2].
    Velocity,
}

/// One phase of contact: old poses, proposed poses, and the velocities between them.
pub struct Contact<'a> {
    /// Bodies at the phase's old time level, the source of normals, levers and angular velocities.
    pub bodies: &'a Bodies,
    /// Duration, gravity, settings.
    pub frame: &'a Frame,
    /// Position or velocity phase.
    pub phase: Phase,
    /// Velocities to correct.
    pub velocities: Vec<Velocity>,
    /// Old poses evolved by one frame with `velocities`.
    pub proposed: Vec<Pose>,
    /// Shock propagation freezes bodies by an infinite inertia.
    pub inertias: Vec<Inertia>,
    /// Impulses and work of static and kinematic bodies.
    pub accounts: FrameAccounts,
    /// Displacements of the position phase off the paths of the velocities, per pair.
    pub displacements: Displacements,
    near: HashMap<Pair, NearSamples>,
    penetrations: Vec<Penetration>,
}

impl<'a> Contact<'a> {
    /// Begins a phase at the poses of `bodies`, with the velocities for its motion.
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
            accounts: FrameAccounts::default(),
            displacements: Displacements::default(),
            near: HashMap::new(),
            penetrations: Vec::new(),
        }
    }

    /// Passes over the graph, level by level, until no pair approaches. Negative restitution
    /// ("epsilon scaling") makes the first passes stop only a part of each approach; the schedule
    /// follows the authors' code. Returns the graph of pairs with impulses.
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

    /// One sweep over the pairs of a level; returns true for each pair with an impulse.
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

    /// One impulse on a pair; false without an approach, or if the impulse is zero.
    fn stop_deepest(&mut self, pair: Pair, restitution: f64) -> bool {
        // Find penetrations at the proposed poses.
        let (first, second) = placed(self.bodies, pair, &self.proposed);
        let near =
            self.near.entry(pair).or_insert_with(|| NearSamples::gather(first, second, CONTOUR));
        near.find_penetrations(first, second, CONTOUR, &mut self.penetrations);

        // Take the deepest approaching penetration, at the old poses.
        let (old, penetrations) = (&self.bodies.poses, &mut self.penetrations);
        let Some(approach) =
            deepest_approach(self.bodies, pair, penetrations, old, &self.velocities)
        else {
            return false;
        };
        let surfaces =
            PairSurface { restitution, ..self.bodies.pair_surface(pair.first, pair.second) };
        let mut impulse = impulse_for(pair, &approach, old, &self.inertias, surfaces);
        if self.phase == Phase::Velocity && self.frame.settings.impulse_clamp {
            let (velocities, accounts) = (&self.velocities, &mut self.accounts);
            impulse = impulse.clamped_to_energy(
                self.bodies,
                pair,
                &approach,
                velocities,
                &mut accounts.clamps,
            );
        }
        if impulse.is_zero() {
            return false;
        }
        self.apply(pair, &approach, &impulse);
        true
    }

    /// Applies an impulse, re-evolves both bodies and books the outside's share.
    fn apply(&mut self, pair: Pair, approach: &Approach, impulse: &PairImpulse) {
        if self.phase == Phase::Velocity {
            let before = (&self.velocities[..], Cause::Contact);
            self.accounts.book_impulse(self.bodies, pair, approach, impulse, before);
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

    /// Energy of a pair at the proposed poses, with its final velocities [J].
    fn pair_energy(&self, pair: Pair) -> f64 {
        pair_energy(self.bodies, pair, &self.proposed, self.frame.gravity)
    }
}

/// Pairs of a graph with impulses to date.
struct Fired(Vec<Vec<bool>>);

impl Fired {
    fn new(graph: &ContactGraph) -> Self {
        Self(graph.levels.iter().map(|level| vec![false; level.pairs.len()]).collect())
    }

    /// Adds one sweep's record; returns true if any pair had an impulse.
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
