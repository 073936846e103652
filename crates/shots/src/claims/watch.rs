//! Watches the books of every frame that a claim runs.

use crate::claims::claim::{Finding, largest};
use frangible::{Causes, Method, StepReport, World};
use std::cell::Cell;

/// Maximum energy change of a cause in a frame, relative to the energy in play. More indicates a
/// diverging solver, even if the ledger removes the gain.
const MOST_CAUSE: f64 = 10.0;

thread_local! {
    /// Largest value on this thread since the last query; a claim runs on one thread.
    static LARGEST: Cell<f64> = const { Cell::new(f64::NEG_INFINITY) };
}

/// Advances a world by a frame by the frame-rate method or the paper's, and watches the former.
pub(super) fn step(world: &mut World) -> StepReport {
    if world.method() == Method::Paper {
        return frangible::step(world);
    }
    let (at_first, _) = world.energy();
    let report = frangible::step(world);
    let Causes { work, collision, contact, friction, projection, fracture, balance, flight } =
        report.energy.causes;
    let causes = [work, collision, contact, friction, projection, fracture, balance, flight];
    let most = largest(causes.map(f64::abs));
    let in_play =
        at_first.max(report.energy.kinetic) + given_by_gravity(world) + report.energy.work.abs();
    // Nothing may change where nothing is in play.
    let ratio = if most == 0.0 { 0.0 } else { most / in_play };
    LARGEST.with(|seen| seen.set(largest([seen.get(), ratio])));
    report
}

/// Maximum energy from gravity in a frame, for bodies at their present speeds [J].
fn given_by_gravity(world: &World) -> f64 {
    let (bodies, dt) = (world.bodies(), world.dt());
    let gained = dt * world.gravity();
    let of = |i: usize| {
        let speed = bodies.velocities[i].linear.dot(gained).abs();
        bodies.masses[i] * (speed + 0.5 * gained.length_squared())
    };
    (0..bodies.len()).filter(|&i| bodies.masses[i].is_finite()).map(of).sum()
}

/// The largest cause of any frame since this was last asked, if there were any.
pub(super) fn largest_cause() -> Option<Finding> {
    let seen = LARGEST.with(|seen| seen.replace(f64::NEG_INFINITY));
    let quantity = "largest cause of a change of energy in a frame, per energy in play";
    (seen != f64::NEG_INFINITY).then(|| Finding::at_most(quantity, "1", seen, MOST_CAUSE))
}
