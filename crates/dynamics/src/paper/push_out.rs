//! Push-out: moves interpenetrating bodies apart, from the ground up [GBF03 sec. 8].

use crate::energy::island::pair_energy;
use crate::impulse::pair_impulse::pair_contact_matrix;
use crate::paper::contact_graph::ContactGraph;
use crate::paper::displacements::{Displacements, Push};
use frangible_bodies::{Bodies, Frame, Inertia, Pair, Pose, rotation_by};
use frangible_collision::{NearSamples, Penetration, contact_point, placed};
use glam::DVec3;

/// Moves and rotates bodies in `poses` until the pairs of the graph do not overlap, or the sweeps
/// end. Velocities and angular momenta stay.
pub fn push_out(
    bodies: &Bodies,
    poses: &mut [Pose],
    graph: &ContactGraph,
    displacements: &mut Displacements,
    frame: &Frame,
) {
    let settings = &frame.settings;
    let mut inertias = bodies.inertias.clone();
    let mut penetrations = Vec::new();
    for level in &graph.levels {
        // Close a growing fraction of each overlap, all of it in the last sweep.
        for sweep in 1..=settings.push_out_level_iterations {
            let part = f64::from(sweep) / f64::from(settings.push_out_level_iterations);
            for &pair in &level.pairs {
                let (first, second) = placed(bodies, pair, poses);
                let mut near = NearSamples::gather(first, second, 0.0);
                for _ in 0..settings.push_out_pair_iterations {
                    let (first, second) = placed(bodies, pair, poses);
                    near.find_penetrations(first, second, 0.0, &mut penetrations);
                    let Some(deepest) = penetrations.iter().min_by(|a, b| a.phi.total_cmp(&b.phi))
                    else {
                        break;
                    };
                    let before = pair_energy(bodies, pair, poses, frame.gravity);
                    let (point, amount) = separate(bodies, poses, &inertias, pair, deepest, part);
                    let energy = pair_energy(bodies, pair, poses, frame.gravity) - before;
                    displacements.book(bodies, pair, &Push { point, amount, energy }, &inertias);
                }
            }
        }
        for &body in &level.bodies {
            inertias[body] = Inertia::INFINITE;
        }
    }
}

/// Separates a pair at its deepest point like an impulse, by `part` of the depth. Returns the
/// point, and the push on the first body [kg m].
fn separate(
    bodies: &Bodies,
    poses: &mut [Pose],
    inertias: &[Inertia],
    pair: Pair,
    deepest: &Penetration,
    part: f64,
) -> (DVec3, DVec3) {
    let (first, second) = placed(bodies, pair, poses);
    let contact = contact_point(first, second, deepest);
    let depth = -f64::from(deepest.phi);

    // The "impulse" whose displacement closes the overlap along the normal.
    let levers = [pair.first, pair.second].map(|i| contact.point - poses[i].position);
    let k = pair_contact_matrix(pair, levers, poses, inertias);
    let softness = contact.normal.dot(k * contact.normal);
    if softness <= 0.0 {
        return (contact.point, DVec3::ZERO);
    }
    let push = (part * depth / softness) * contact.normal;
    for (i, lever, push) in [(pair.first, levers[0], push), (pair.second, levers[1], -push)] {
        move_by(&mut poses[i], &inertias[i], lever, push);
    }
    (contact.point, push)
}

/// Displaces and rotates a body by `push` [kg m] at `lever`.
fn move_by(pose: &mut Pose, inertia: &Inertia, lever: DVec3, push: DVec3) {
    let turn = inertia.angular_velocity(pose.orientation, lever.cross(push));
    pose.position += inertia.inverse_mass * push;
    if turn != DVec3::ZERO {
        pose.orientation = (rotation_by(turn) * pose.orientation).normalize();
    }
}
