//! Shock propagation: from the ground up, each level comes to rest on the level below and then
//! freezes [GBF03 sec. 7]. Position phase only: its one-sided impulses never reach a final
//! velocity.

use crate::paper::contact::Contact;
use crate::paper::contact_graph::ContactGraph;
use frangible_bodies::Inertia;

/// One sweep from the lowest level to the highest; afterwards all bodies are movable again.
pub fn propagate_shock(contact: &mut Contact, graph: &ContactGraph) {
    let settings = contact.frame.settings;
    for level in &graph.levels {
        // Stop motion into the levels below, which have infinite mass by now.
        for sweep in 1..=settings.shock_level_iterations {
            let restitution = f64::from(sweep) / f64::from(settings.shock_level_iterations) - 1.0;
            contact.sweep_level(level, restitution, settings.shock_pair_iterations);
        }
        for &body in &level.bodies {
            contact.inertias[body] = Inertia::INFINITE;
        }
    }
    contact.inertias.copy_from_slice(&contact.bodies.inertias);
}
