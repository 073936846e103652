//! Bodies of glued pieces: one rigid body until a blow, or what they carry, breaks bonds, and
//! islands of pieces from then on.

pub(crate) mod blows;
pub(crate) mod fall_apart;
pub(crate) mod state;

use crate::report::Fracture;
use crate::step::bonds::fall_apart::{Broken, fall_apart, field_in_pieces};
use crate::step::bonds::state::IMPACT_TIME;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, Frame, Pair};
use frangible_collision::{ImpulseCache, Manifold};
use frangible_dynamics::{ContactForce, contact_forces};
use frangible_fracture::PointLoad;

/// Carried loads are forgotten below this part of the largest force [1].
const FAINT: f64 = 1e-2;

/// Breaks bonds overloaded by weight and contacts. What was anchored starts at rest, before the
/// energy accounts open: the static world has no accounts.
pub(crate) fn free_overloaded(world: &mut World, frame: &Frame) -> Vec<Fracture> {
    let mut overloaded = Vec::new();
    for body in 0..world.bodies.len() {
        // Few are glued.
        if !world.labels[body].may_lose_bonds() {
            continue;
        }
        let field = field_in_pieces(&world.bodies, body, frame);
        let density = world.bodies.densities[body];
        let Some(bonds) = &mut world.labels[body].bonds else { continue };
        if !bonds.glued.give_way(&bonds.carried, field, density).broken.is_empty() {
            let point = world.bodies.poses[body].position;
            overloaded.push(Broken { body, striker: body, point, impulse: 0.0, borne: 0.0 });
        }
    }
    fall_apart(world, &overloaded).0
}

/// Contact forces on glued bodies: they load the bonds in the next frame.
pub(crate) fn glued_contact_forces(
    bodies: &Bodies,
    labels: &[Label],
    manifolds: &[Manifold],
    carried: &ImpulseCache,
) -> Vec<ContactForce> {
    let are_glued: Vec<bool> = labels.iter().map(|label| label.bonds.is_some()).collect();
    if !are_glued.contains(&true) {
        return Vec::new();
    }
    let of_glued =
        |Manifold { pair, .. }: &Manifold| are_glued[pair.first] || are_glued[pair.second];
    contact_forces(bodies, manifolds.iter().copied().filter(of_glued), carried)
}

/// Notes what the contacts of glued bodies carry, those of each pair together: their load in the
/// next frame.
pub(crate) fn note_carried(world: &mut World, forces: &[ContactForce]) {
    // In a frame that is shorter than a blow a contact's force may be a part of one.
    let share = (world.dt / IMPACT_TIME).min(1.0);
    for bonds in world.labels.iter_mut().filter_map(|label| label.bonds.as_mut()) {
        bonds.carried.iter_mut().for_each(|load| load.force *= 1.0 - share);
        let most = bonds.carried.iter().map(|load| load.force.length()).fold(0.0, f64::max);
        bonds.carried.retain(|load| load.force.length() > FAINT * most);
    }
    for of_pair in forces.chunk_by(|a, b| a.pair == b.pair) {
        let Some(Pair { first, second }) = of_pair.first().map(|force| force.pair) else {
            continue;
        };
        for (side, i) in [first, second].into_iter().enumerate() {
            let Some(bonds) = &mut world.labels[i].bonds else { continue };
            let pieces_from_body = world.bodies.shapes[i].body_from_grid.inverse();
            let body_from_world = world.bodies.poses[i].world_from_body().inverse();
            let load = |force: &ContactForce| {
                let on_this = share * if side == 0 { force.force } else { -force.force };
                PointLoad {
                    point: pieces_from_body.point(force.points[side]),
                    force: pieces_from_body.direction(body_from_world.direction(on_this)),
                }
            };
            let loads: Vec<PointLoad> = of_pair.iter().map(load).collect();
            bonds.carried.extend(bonds.glued.spread(loads));
        }
    }
}
