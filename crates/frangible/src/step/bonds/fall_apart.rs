//! Bodies with lost bonds separate into islands of intact bonds.

use super::state::Bonds;
use crate::report::at_rest::at_rest;
use crate::report::{Fracture, Imbalance, id_number};
use crate::step::break_bodies::{fragment_body, imbalance};
use crate::world::{Label, World};
use frangible_bodies::{Bodies, Frame, Motion, NewBody};
use frangible_fracture::{Fragment, Glued};
use glam::DVec3;

/// A body with lost bonds.
pub(crate) struct Broken {
    pub(crate) body: usize,
    pub(crate) striker: usize,
    pub(crate) point: DVec3,
    pub(crate) impulse: f64,
    pub(crate) borne: f64,
}

/// Replaces bodies with lost bonds by their islands, in place and with their motion. A single
/// island only updates its bonds. Also returns the new dense index of each old one.
pub(crate) fn fall_apart(
    world: &mut World,
    broken: &[Broken],
) -> (Vec<Fracture>, Vec<Option<usize>>) {
    let mut gone = vec![false; world.bodies.len()];
    let mut born: Vec<(NewBody, Label)> = Vec::new();
    let mut fractures = Vec::new();
    for Broken { body, striker, point, impulse, borne } in broken {
        let Some(bonds) = &world.labels[*body].bonds else { continue };
        let islands = bonds.glued.islands();
        if islands.len() < 2 {
            continue;
        }
        gone[*body] = true;
        let first = born.len();
        let islands = islands.into_iter().enumerate();
        born.extend(islands.filter_map(|(index, island)| island_body(world, *body, index, island)));
        let pieces = || born[first..].iter().map(|(body, _)| body);
        let (rest_poses, contacts) = at_rest(&world.bodies, *body, pieces());
        fractures.push(Fracture {
            time: world.time(),
            body: id_number(world.bodies.ids[*body]),
            striker: id_number(world.bodies.ids[*striker]),
            point: point.to_array(),
            impulse: *impulse,
            borne: *borne,
            energy: 0.0,
            wanted: None,
            counted: None,
            fragments: vec![0; born.len() - first],
            rest_poses,
            contacts,
            imbalance: if world.bodies.inertias[*body].is_infinite() {
                Imbalance::default()
            } else {
                imbalance(&world.bodies, *body, pieces())
            },
        });
    }
    let new_index = world.remove(&gone);
    let mut born = born.into_iter();
    for fracture in &mut fractures {
        for (id, (body, label)) in fracture.fragments.iter_mut().zip(&mut born) {
            *id = id_number(world.spawn(body, label));
        }
    }
    (fractures, new_index)
}

/// Body of an island of pieces. Pieces always have volume, hence so does the body.
fn island_body(
    world: &World,
    parent: usize,
    index: usize,
    glued: Glued,
) -> Option<(NewBody, Label)> {
    let sample_spacing = world.labels[parent].bonds.as_ref()?.sample_spacing;
    let shape = glued.shape(sample_spacing).ok()?;
    let is_anchored = glued.is_anchored();
    let holds = glued.can_break();
    let bonds = holds.then(|| Box::new(Bonds { glued, carried: Vec::new(), sample_spacing }));
    let label = Label {
        name: format!("{}.{index}", world.labels[parent].name),
        parent: Some(world.bodies.ids[parent]),
        whole: world.labels[parent].whole.or(Some(world.bodies.ids[parent])),
        look: world.labels[parent].look,
        breaking: None,
        bonds,
        path: None,
        waiting: None,
    };
    let mut body = fragment_body(
        &world.bodies,
        parent,
        Fragment::new(&world.bodies.shapes[parent], shape, index as u32),
        &label,
    );
    if is_anchored {
        body.motion = Motion::Static;
    }
    Some((body, label))
}

/// Gravity in the frame of a body's pieces [m/s^2].
pub(super) fn field_in_pieces(bodies: &Bodies, body: usize, frame: &Frame) -> DVec3 {
    let in_body = bodies.poses[body].orientation.conjugate() * frame.gravity;
    bodies.shapes[body].body_from_grid.inverse().direction(in_body)
}
