//! Blows on glued bodies: an impulse loads the bonds for a few milliseconds.

use crate::report::{Fracture, id_number};
use crate::step::bonds::fall_apart::{Broken, fall_apart, field_in_pieces};
use crate::step::bonds::state::IMPACT_TIME;
use crate::step::closing::Opening;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, Frame, Pair, Pose};
use frangible_dynamics::PointImpulse;
use frangible_fracture::{Glued, PointLoad};
use glam::DVec3;

/// A blow on a glued body.
pub(crate) struct BlowOnBonds<'a> {
    pub(crate) pair: Pair,
    pub(crate) poses: [Pose; 2],
    pub(crate) parts: &'a [PointImpulse],
    /// The parts' sum, on the first body [N s].
    pub(crate) impulse: DVec3,
    /// World frame [m].
    pub(crate) point: DVec3,
}

/// Bodies with bonds that gave way to blows.
#[derive(Default)]
pub(crate) struct Overstrained {
    bodies: Vec<OverstrainedBody>,
}

struct OverstrainedBody {
    id: BodyId,
    /// With the bonds that hold.
    glued: Glued,
    /// Of the first blow: striker, point in the world [m], impulse, and the part of it that bonds
    /// bore before the struck piece came free [N s].
    striker: BodyId,
    point: DVec3,
    impulse: f64,
    borne: f64,
}

impl Overstrained {
    /// True if a body falls apart.
    pub(crate) fn any_falls_apart(&self) -> bool {
        self.bodies.iter().any(|body| body.glued.islands().len() > 1)
    }

    /// Loads the bonds of both bodies with a blow, up to what the weaker one bears if it breaks.
    /// If a struck piece comes free, the part of the blow that acts before [1].
    pub(crate) fn strain(
        &mut self,
        bodies: &Bodies,
        labels: &[Label],
        blow: &BlowOnBonds<'_>,
        frame: &Frame,
    ) -> Option<f64> {
        let both = blow.pair.both();
        // Islands of one body fit each other exactly, and jam as they part.
        let [of_first, of_second] = both.map(|i| labels[i].whole);
        if of_first.is_some() && of_first == of_second {
            return None;
        }
        let whole = blow.impulse.length();
        let most = both.map(|i| bodies.strength(i)).into_iter().fold(whole, f64::min) / whole;
        let mut bore = None;
        for (side, i) in both.into_iter().enumerate() {
            let Some(bonds) = &labels[i].bonds else { continue };
            if !labels[i].may_lose_bonds() || blow.parts.is_empty() {
                continue;
            }
            let known = self.bodies.iter().position(|body| body.id == bodies.ids[i]);
            let mut glued = known.map_or(&bonds.glued, |at| &self.bodies[at].glued).clone();
            let loads = loads(bodies, blow, side, most);
            let middle = loads.iter().map(|load| load.point).sum::<DVec3>() / loads.len() as f64;
            let loads = glued.spread(loads);
            let gave =
                glued.give_way(&loads, field_in_pieces(bodies, i, frame), bodies.densities[i]);
            if gave.broken.is_empty() {
                continue;
            }
            if glued.comes_free(middle) {
                bore = Some(bore.unwrap_or(most).min(gave.bore * most));
            }
            if let Some(at) = known {
                self.bodies[at].glued = glued;
            } else {
                let (id, striker) = (bodies.ids[i], bodies.ids[both[1 - side]]);
                let (point, impulse) = (blow.point, whole);
                let borne = bore.unwrap_or(most) * whole;
                self.bodies.push(OverstrainedBody { id, glued, striker, point, impulse, borne });
            }
        }
        bore
    }

    /// Takes the bonds out of the world that gave way, and replaces bodies by their islands. Parts
    /// of anchored bodies start at rest and enter the books. Returns the other fractures, and the
    /// new dense index of each old one.
    pub(crate) fn fall_apart(
        self,
        world: &mut World,
        opening: &mut Opening,
        frame: &Frame,
    ) -> (Vec<Fracture>, Vec<Option<usize>>) {
        let mut broken = Vec::new();
        let mut anchored = Vec::new();
        for OverstrainedBody { id, glued, striker, point, impulse, borne } in self.bodies {
            let Some(body) = world.bodies.index_of(id) else { continue };
            let Some(bonds) = &mut world.labels[body].bonds else { continue };
            bonds.glued = glued;
            if world.bodies.inertias[body].is_infinite() {
                anchored.push(id_number(id));
            }
            let striker = world.bodies.index_of(striker).unwrap_or(body);
            broken.push(Broken { body, striker, point, impulse, borne });
        }
        let (fractures, new_index) = fall_apart(world, &broken);
        let (freed, fractures) =
            fractures.into_iter().partition(|fracture| anchored.contains(&fracture.body));
        opening.admit(world, freed, frame);
        (fractures, new_index)
    }
}

/// Forces of a part of a blow on one of its bodies, in the frame of the pieces.
fn loads(bodies: &Bodies, blow: &BlowOnBonds<'_>, side: usize, part: f64) -> Vec<PointLoad> {
    let pieces_from_body = bodies.shapes[blow.pair.both()[side]].body_from_grid.inverse();
    let in_body = blow.poses[side].world_from_body().inverse();
    let sign = if side == 0 { 1.0 } else { -1.0 };
    let load = |PointImpulse { at, impulse }: &PointImpulse| PointLoad {
        point: pieces_from_body.point(at[side]),
        force: pieces_from_body.direction(in_body.direction(sign * part / IMPACT_TIME * *impulse)),
    };
    blow.parts.iter().map(load).collect()
}
