//! Rehearsal of a frame's blows on bonds.
//!
//! An anchored body has infinite mass: in the solver a striker would lose all momentum to it,
//! although the bonds around the impact bear less. Bonds are therefore tested before contact is
//! solved. Strikers and overloaded glued bodies run through the frame in short steps, in a copy of
//! the world: a freed piece takes its own part of the blow, and the striker hits its next obstacle
//! with the rest. The world then adopts the broken bonds and the borne impulses, and solves the
//! frame as usual.

use crate::report::books::Books;
use crate::report::id_from_number;
use crate::step::bonds::blows::{Blows, Cut, Felt};
use crate::step::bonds::fall_apart::field_in_pieces;
use crate::step::bonds::fall_apart::{Broken, fall_apart};
use crate::step::bonds::state::IMPACT_TIME;
use crate::world::{Label, World};
use frangible_bodies::{Bodies, BodyId, Frame, NewBody, Pair, accelerate, predict};
use frangible_collision::find_swept_pairs;
use frangible_dynamics::{FrameAccounts, UpcomingImpact, pass_on, upcoming_impact};
use frangible_fracture::PointLoad;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

/// A striker moves by no more of its radius in a short step [1], up to so many steps in a frame.
const STEP: f64 = 0.1;
const MOST_STEPS: usize = 24;

/// Blows of a frame that are rehearsed.
const MOST_BLOWS: usize = 1024;

/// The blows of a frame that break bonds.
pub(super) fn rehearse(world: &World, frame: &Frame) -> Blows {
    let (mut members, steps) = members(world, frame);
    if members.is_empty() {
        return Blows::default();
    }
    members.sort_unstable();
    members.dedup();
    let mut stage = Stage::new(world, &members);
    let short = Frame { dt: frame.dt / steps as f64, ..*frame };
    for _ in 0..steps {
        for _ in 0..frame.settings.breaking_passes {
            if !stage.strike(&short, at_rest(frame)) {
                break;
            }
        }
        let bodies = &mut stage.world.bodies;
        let ends = predict(bodies, &short);
        bodies.velocities = accelerate(bodies, &bodies.velocities, short.dt, &short);
        bodies.poses = ends;
    }
    stage.blows
}

/// A body that approaches no faster than gravity sets it in motion within a frame rests: its
/// weight is no blow [m/s].
fn at_rest(frame: &Frame) -> f64 {
    frame.gravity.length() * frame.dt
}

/// Glued bodies that a blow overstrains in a frame, their strikers, and what is in the strikers'
/// way; and how many short steps their ways take.
fn members(world: &World, frame: &Frame) -> (Vec<usize>, usize) {
    let (mut members, mut steps) = (Vec::new(), 1);
    let is_glued = |i: usize| world.labels[i].may_lose_bonds();
    if !(0..world.bodies.len()).any(is_glued) {
        return (members, steps);
    }
    let bodies = &world.bodies;
    let predicted = predict(bodies, frame);
    let pairs = find_swept_pairs(bodies, &predicted, 2.0 * at_rest(frame) * frame.dt, frame);
    let mut strikers = BTreeSet::new();
    for &pair in &pairs {
        let sides = [pair.first, pair.second];
        if !sides.iter().any(|&i| is_glued(i)) {
            continue;
        }
        let Some(impact) = upcoming_impact(bodies, pair, &predicted, frame) else { continue };
        if speed(&impact) <= at_rest(frame) {
            continue;
        }
        let overstrains = |side: usize| {
            let Some(bonds) = &world.labels[sides[side]].bonds else { return false };
            let (loads, field) = loads(world, sides[side], &impact, side, frame);
            let mut glued = bonds.glued.clone();
            let loads = glued.spread(loads);
            let strains = glued.strains(&loads, field, bodies.densities[sides[side]]);
            strains.into_iter().any(|strain| strain > 1.0)
        };
        if overstrains(0) || overstrains(1) {
            members.extend(sides);
            strikers.extend(sides.into_iter().filter(|&i| !bodies.inertias[i].is_infinite()));
            let radius = bodies.radii[pair.first].min(bodies.radii[pair.second]);
            let way = sides.map(|i| fastest(bodies, i)).iter().sum::<f64>() * frame.dt;
            steps = steps.max((way / (STEP * radius)).ceil() as usize).min(MOST_STEPS);
        }
    }
    for pair in pairs {
        if strikers.contains(&pair.first) || strikers.contains(&pair.second) {
            members.extend([pair.first, pair.second]);
        }
    }
    (members, steps)
}

/// No point of a body is faster [m/s].
fn fastest(bodies: &Bodies, i: usize) -> f64 {
    let (pose, velocity) = (&bodies.poses[i], &bodies.velocities[i]);
    let spin = bodies.spin(i, pose, velocity).length();
    bodies.point_velocity(i, pose, velocity, DVec3::ZERO).length()
        + if spin > 0.0 { spin * bodies.radii[i] } else { 0.0 }
}

/// Closing speed of a pair [m/s].
fn speed(impact: &UpcomingImpact) -> f64 {
    -impact.approach.relative_velocity.dot(impact.approach.contact.normal)
}

/// A blow as it is to one side of its pair: a load at each point in the frame of its pieces, and
/// gravity there.
fn loads(
    world: &World,
    body: usize,
    impact: &UpcomingImpact,
    side: usize,
    frame: &Frame,
) -> (Vec<PointLoad>, DVec3) {
    let pieces_from_body = world.bodies.shapes[body].body_from_grid.inverse();
    let in_body = impact.poses[side].world_from_body().inverse();
    let impulse = if side == 0 { impact.impulse.at_contact } else { -impact.impulse.at_contact };
    let share = 1.0 / impact.points.len() as f64;
    let load = |&point: &DVec3| PointLoad {
        point: pieces_from_body.point(in_body.point(point)),
        force: pieces_from_body.direction(in_body.direction(share * impulse / IMPACT_TIME)),
    };
    (impact.points.iter().map(load).collect(), field_in_pieces(world, body, frame))
}

/// A few bodies of a world, beside it.
struct Stage {
    world: World,
    /// Of each body of the world, and of its islands, the former's id.
    origins: BTreeMap<BodyId, BodyId>,
    /// Bodies also present in the world.
    old: BTreeSet<BodyId>,
    blows: Blows,
    count: usize,
}

impl Stage {
    fn new(world: &World, members: &[usize]) -> Self {
        let mut stage = World {
            bodies: Bodies::default(),
            labels: Vec::new(),
            frame: world.frame,
            dt: world.dt,
            gravity: world.gravity,
            settings: world.settings,
            books: Books::default(),
            ledger: Default::default(),
            method: world.method,
            warm: Default::default(),
            recent_impacts: Default::default(),
            contact_cache: Default::default(),
            fits: Default::default(),
            spared: Vec::new(),
            born_of_pieces: 0,
            note: String::new(),
            hand: Default::default(),
            clock: None,
        };
        let bodies = &world.bodies;
        let mut origins = BTreeMap::new();
        for &i in members {
            let body = NewBody {
                shape: bodies.shapes[i].clone(),
                density: bodies.densities[i],
                motion: bodies.motions[i],
                pose: bodies.poses[i],
                velocity: bodies.velocities[i],
                surface: bodies.surfaces[i],
            };
            let Label { look, bonds, waiting, .. } = world.labels[i].clone();
            let bonds = if waiting.is_some() { None } else { bonds };
            let label = Label {
                name: String::new(),
                parent: None,
                look,
                breaking: None,
                bonds,
                path: None,
                waiting: None,
            };
            origins.insert(stage.spawn(body, label), bodies.ids[i]);
        }
        let old = origins.keys().copied().collect();
        Self { world: stage, origins, old, blows: Blows::default(), count: 0 }
    }

    /// One pass over the impacts of a short step; each body takes part in at most one. `false`
    /// without impacts.
    fn strike(&mut self, short: &Frame, at_rest: f64) -> bool {
        let bodies = &self.world.bodies;
        let predicted = predict(bodies, short);
        let pairs = find_swept_pairs(bodies, &predicted, 2.0 * at_rest * short.dt, short);
        let mut taken = vec![false; bodies.len()];
        let mut broken = Vec::new();
        for pair in pairs {
            let sides = [pair.first, pair.second];
            if self.count == MOST_BLOWS || sides.iter().any(|&i| taken[i]) {
                continue;
            }
            let impact = upcoming_impact(&self.world.bodies, pair, &predicted, short);
            let Some(impact) = impact else { continue };
            if speed(&impact) <= at_rest {
                continue;
            }
            sides.iter().for_each(|&i| taken[i] = true);
            self.count += 1;
            self.blow(pair, &impact, short, &mut broken);
        }
        for fracture in fall_apart(&mut self.world, &broken) {
            let origin = self.origins[&id_from_number(fracture.body)];
            let parts = fracture.fragments.iter().map(|&part| (id_from_number(part), origin));
            self.origins.extend(parts);
        }
        taken.contains(&true)
    }

    /// A blow acts: all of it, or what bonds bear before the struck pieces come free.
    fn blow(
        &mut self,
        pair: Pair,
        impact: &UpcomingImpact,
        short: &Frame,
        broken: &mut Vec<Broken>,
    ) {
        let sides = [pair.first, pair.second];
        let bodies = &self.world.bodies;
        let whole = impact.impulse.at_contact.length();
        // A breaking body passes on no more than its strength.
        let bears = sides.map(|i| bodies.surfaces[i].strength);
        let most = (bears[0].min(bears[1]) / whole).min(1.0);
        let ids = sides.map(|i| self.origins[&bodies.ids[i]]);
        let mut bore = most;
        let mut breaks = [false; 2];
        for side in [0, 1] {
            let (mut loads, field) = loads(&self.world, sides[side], impact, side, short);
            loads.iter_mut().for_each(|load| load.force *= most);
            let middle = loads.iter().map(|load| load.point).sum::<DVec3>() / loads.len() as f64;
            let density = self.world.bodies.densities[sides[side]];
            let Some(bonds) = &mut self.world.labels[sides[side]].bonds else { continue };
            let loads = bonds.glued.spread(loads);
            let gave = bonds.glued.give_way(&loads, field, density);
            if gave.broken.is_empty() {
                continue;
            }
            let names = gave.broken.iter().map(|bond| bonds.glued.name_of(bond)).collect();
            breaks[side] = bonds.glued.comes_free(middle);
            if breaks[side] {
                bore = bore.min(gave.bore * most);
            }
            let (body, striker) = (sides[side], sides[1 - side]);
            let (point, impulse, borne) = (impact.point, whole, bore * whole);
            broken.push(Broken { body, striker, point, impulse, borne });
            let (body, striker) = (ids[side], ids[1 - side]);
            self.blows.cut(Cut { body, bonds: names, striker, point, impulse, borne });
        }
        let impulse = impact.impulse.scaled(bore);
        // A piece that has come free in this frame is not in the world yet.
        let World { bodies, labels, .. } = &self.world;
        let is_known = |&i: &usize| labels[i].bonds.is_some() || self.old.contains(&bodies.ids[i]);
        if breaks.contains(&true) && ids[0] != ids[1] && sides.iter().all(is_known) {
            let side = usize::from(bodies.inertias[sides[0]].is_infinite());
            let lever = impact.point - impact.poses[side].position;
            let impulse = impulse.at_contact;
            self.blows.felt.push(Felt { pair: ids, impulse, at: (side, lever) });
        }
        let accounts = &mut FrameAccounts::default();
        pass_on(&mut self.world.bodies, pair, &impact.approach, &impulse, short, accounts);
    }
}
