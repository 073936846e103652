//! End of the frame: poses and velocities in double precision, exact momentum, energy by cause.

use super::contact_batch::ContactBatch;
use super::group::Group;
use super::impact_log::Impact;
use crate::energy::frame_accounts::{Cause, FrameAccounts};
use crate::energy::island::energy;
use crate::energy::islands::root;
use frangible_bodies::evolve;
use frangible_bodies::{Bodies, Frame, Inertia, Motion, Pair, Pose, Substeps, Velocity};
use frangible_collision::{
    CachedImpulse, FeatureId, ImpulseChunk, Manifold, ManifoldPoint, PointImpulse,
};
use frangible_math::{Instructions, LANES};
use glam::{DMat3, DVec3};
use std::collections::BTreeMap;

/// Results of the substeps besides the motion of the bodies.
pub struct Solved {
    /// Momentum from static and kinematic bodies, and energy by cause.
    pub accounts: FrameAccounts,
    /// Gravity's impulse and its angular impulse about the world origin.
    pub gravity: (DVec3, DVec3),
    /// Number of islands with fewer substeps than their accuracy needs, limited by `most_substeps`
    /// or by the work of a frame.
    pub short_of_substeps: usize,
    /// Number of groups of islands in which later impacts were stopped without bouncing, or later
    /// contacts acted as they were first seen, as those before took the time of the frame.
    pub short_of_impacts: usize,
    /// Points of the pairs that were detected again within the frame.
    pub confirmed: BTreeMap<Pair, Vec<ManifoldPoint>>,
    /// Impacts of bodies that may break.
    pub impacts: Vec<Impact>,
}

/// Poses and velocities of all bodies at the frame's start.
pub(super) struct FrameStart {
    poses: Vec<Pose>,
    velocities: Vec<Velocity>,
}

impl FrameStart {
    pub(super) fn of(bodies: &Bodies) -> Self {
        Self { poses: bodies.poses.clone(), velocities: bodies.velocities.clone() }
    }

    pub(super) fn poses(&self) -> &[Pose] {
        &self.poses
    }

    fn energy(&self, bodies: &Bodies, i: usize, gravity: DVec3) -> f64 {
        energy(bodies, i, &self.poses[i], &self.velocities[i], gravity)
    }
}

/// Change of each line's momentum by contact in a frame.
struct LineMomenta {
    /// [N s]
    changes: Vec<DVec3>,
    /// True for lines with a contact that acted.
    is_touched: Vec<bool>,
}

impl LineMomenta {
    fn new(lines: usize) -> Self {
        Self { changes: vec![DVec3::ZERO; lines], is_touched: vec![false; lines] }
    }

    /// An impulse acts on both lines with opposite signs, in double precision. Linear momentum is
    /// exact despite the single-precision velocities.
    fn exchange(&mut self, lines: [u32; 2], impulse: DVec3) {
        let [first, second] = lines.map(|line| line as usize);
        self.changes[first] -= impulse;
        self.changes[second] += impulse;
        self.is_touched[first] = true;
        self.is_touched[second] = true;
    }
}

impl<I: Instructions> Group<I> {
    /// Writes the solved poses and velocities to the bodies, books impulses and energy, and returns
    /// the impulse cache for the next frame.
    pub(super) fn write_back(
        mut self,
        bodies: &mut Bodies,
        manifolds: &[Manifold],
        frame: &Frame,
        solved: &mut Solved,
    ) -> ImpulseChunk {
        for (&manifold, points) in &self.speculative.points {
            solved.confirmed.insert(manifolds[manifold as usize].pair, points.clone());
        }
        solved.impacts.append(&mut self.impacts);
        let accounts = &mut solved.accounts;
        let (momenta, cache) = self.book_contacts(bodies, manifolds, frame.dt, accounts);
        for line in 0..self.bodies.lines.len() {
            let Some(i) = self.bodies.body_of[line] else { continue };
            if bodies.motions[i] != Motion::Dynamic {
                continue;
            }
            if momenta.is_touched[line] {
                let gravity = frame.dt * bodies.masses[i] * frame.gravity;
                self.bodies.write_back(bodies, (line, i), momenta.changes[line] + gravity);
            } else {
                fall(bodies, i, frame);
            }
        }
        cache
    }

    /// Books each manifold's impulses of a frame of `dt` [s]: momenta of both bodies, work and
    /// energy by cause, and the impulse cache.
    fn book_contacts(
        &self,
        bodies: &Bodies,
        manifolds: &[Manifold],
        dt: f64,
        accounts: &mut FrameAccounts,
    ) -> (LineMomenta, ImpulseChunk) {
        let Self { selections, batches, speculative, .. } = self;
        let mut momenta = LineMomenta::new(self.bodies.lines.len());
        let mut cache = ImpulseChunk::with_room(selections.len(), 4 * selections.len());
        let mut numbers = 0..selections.len() as u32;
        let mut features = Vec::new();
        for of_manifold in selections.chunk_by(|a, b| a.manifold == b.manifold) {
            let manifold = of_manifold[0].manifold as usize;
            let Manifold { pair, points, .. } = &manifolds[manifold];
            let mut is_acting = false;
            let mut recovered = 0.0;
            for (selection, number) in of_manifold.iter().zip(&mut numbers) {
                let place = speculative.place(number);
                let (batch, lane) = (&batches[place.batch()], place.lane());
                if !batch.acted.get(lane) {
                    continue;
                }
                is_acting = true;
                let replaced = speculative.replaced(number);
                let given = replaced.map_or(DVec3::ZERO, |replaced| replaced.given);
                let impulse = batch.impulse_of_frame(lane) + given;
                momenta.exchange(selection.lines, impulse);
                let work = batch.driven_work.get(lane);
                let [first, second] = pair.both();
                accounts.book_outside(bodies, [first, second], (-impulse, DVec3::ZERO), work);
                accounts.book_outside(bodies, [second, first], (impulse, DVec3::ZERO), work);
                recovered += batch.recovery.get(lane);
                accounts.causes.add(Cause::Friction, batch.friction_work.get(lane));
                features.clear();
                match replaced {
                    Some(replaced) => features.extend_from_slice(&replaced.features),
                    None => features.extend(selection.points().map(|at| points[at].feature)),
                }
                carry(&mut cache, &features, (batch, lane, impulse), (self.h, dt));
            }
            cache.end_pair(manifold, *pair);
            if is_acting {
                accounts.link(bodies, *pair);
                accounts.impulses += 1;
                accounts.recover(bodies, *pair, recovered);
            }
        }
        (momenta, cache)
    }
}

/// Appends the impulses of a lane to the cache, as world-frame forces: the last substep's and the
/// frame's mean.
fn carry<I: Instructions>(
    part: &mut ImpulseChunk,
    features: &[FeatureId],
    (batch, lane, of_frame): (&ContactBatch<I>, usize, DVec3),
    (h, dt): (f64, f64),
) {
    debug_assert!(lane < LANES);
    let [normal, tangent, other] = batch.frame_of(lane);
    let impulses = batch.normal_impulses(lane);
    let total: f64 = impulses.iter().sum();
    let friction = batch.friction[0].get(lane) * tangent + batch.friction[1].get(lane) * other;
    let mut torque = batch.twist.get(lane) * normal;
    if let Some(rolling) = &batch.rolling {
        let [along, across] = &rolling.impulse;
        torque += along.get(lane) * tangent + across.get(lane) * other;
    }
    // An impact before the last substep leaves no final impulse: its mean acts equally at all
    // points.
    let equal = 1.0 / features.len() as f64;
    for (&feature, impulse) in features.iter().zip(impulses) {
        let share = if total > 0.0 { impulse / total } else { equal };
        if share > 0.0 {
            let force = PointImpulse {
                normal: (impulse / h) as f32,
                force: (-(impulse * normal + share * friction) / h).as_vec3(),
                twist: (-(share / h) * torque).as_vec3(),
                mean: (-(share / dt) * of_frame).as_vec3(),
            };
            part.points.push(CachedImpulse { feature, force });
        }
    }
}

/// An island of bodies that exchanged impulses in this frame.
#[derive(Default)]
struct ActedIsland {
    members: Vec<usize>,
    /// True if a member touched a static or kinematic body.
    is_held: bool,
}

/// Closes the accounts of each island: angular momentum, and energy by cause.
pub(super) fn close_islands(
    bodies: &mut Bodies,
    start: &FrameStart,
    substeps: &[Substeps],
    frame: &Frame,
    solved: &mut Solved,
) {
    let is_fixed: Vec<bool> = bodies.inertias.iter().map(Inertia::is_infinite).collect();
    let mut given = 0.0;
    for ActedIsland { members, is_held } in acted_islands(bodies, substeps, &solved.accounts) {
        debug_assert!(members.iter().all(|&i| !is_fixed[i]));
        let unexplained = angular_change(bodies, start, &members, frame, solved);
        if is_held {
            solved.accounts.outside_angular_impulse += unexplained;
        } else if unexplained != DVec3::ZERO {
            turn_back(bodies, &members, unexplained);
        }
        for &i in &members {
            given += energy(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame.gravity)
                - start.energy(bodies, i, frame.gravity);
        }
    }
    let FrameAccounts { causes, .. } = &mut solved.accounts;
    let known = causes.work + causes.friction;
    causes.add(Cause::Contact, given - known);
}

/// Connected components of the exchanged impulses, ordered by their first body.
fn acted_islands(
    bodies: &Bodies,
    substeps: &[Substeps],
    accounts: &FrameAccounts,
) -> Vec<ActedIsland> {
    let mut parent: Vec<u32> = (0..bodies.len() as u32).collect();
    let is_movable = |i: usize| !bodies.inertias[i].is_infinite();
    let mut links = Vec::with_capacity(accounts.links.len());
    for &(a, b) in &accounts.links {
        if let (Some(a), Some(b)) = (bodies.index_of(a), bodies.index_of(b)) {
            links.push([a, b]);
            if is_movable(a) && is_movable(b) {
                let [a, b] = [a, b].map(|i| root(&mut parent, i as u32));
                parent[a.max(b) as usize] = a.min(b);
            }
        }
    }
    let mut number_of = vec![usize::MAX; bodies.len()];
    let mut islands: Vec<ActedIsland> = Vec::new();
    for i in (0..bodies.len()).filter(|&i| substeps[i].count > 0 && is_movable(i)) {
        let root = root(&mut parent, i as u32) as usize;
        if number_of[root] == usize::MAX {
            number_of[root] = islands.len();
            islands.push(ActedIsland::default());
        }
        number_of[i] = number_of[root];
        islands[number_of[i]].members.push(i);
    }
    for [a, b] in links {
        for (on, by) in [(a, b), (b, a)] {
            if is_movable(on) && !is_movable(by) {
                let island = &mut islands[number_of[on]];
                island.is_held = true;
            }
        }
    }
    islands
}

/// Books gravity's impulses. Returns the change of angular momentum about the world origin minus
/// gravity's contribution.
fn angular_change(
    bodies: &Bodies,
    start: &FrameStart,
    members: &[usize],
    frame: &Frame,
    solved: &mut Solved,
) -> DVec3 {
    let mut unexplained = DVec3::ZERO;
    for &i in members {
        let (before, after) = (&start.poses[i], &bodies.poses[i]);
        let (old, new) = (&start.velocities[i], &bodies.velocities[i]);
        let mass = bodies.masses[i];
        let weight = frame.dt * mass * frame.gravity;
        let turn = (0.5 * (before.position + after.position)).cross(weight);
        solved.gravity.0 += weight;
        solved.gravity.1 += turn;
        unexplained += after.position.cross(mass * new.linear) + new.angular_momentum
            - before.position.cross(mass * old.linear)
            - old.angular_momentum
            - turn;
    }
    unexplained
}

/// Subtracts `angular_momentum` from an island by a rigid rotation. Linear momentum is unchanged.
fn turn_back(bodies: &mut Bodies, members: &[usize], angular_momentum: DVec3) {
    let mass: f64 = members.iter().map(|&i| bodies.masses[i]).sum();
    let weighted = |&i: &usize| bodies.masses[i] * bodies.poses[i].position;
    let center = members.iter().map(weighted).sum::<DVec3>() / mass;
    let mut inertia = DMat3::ZERO;
    for &i in members {
        let arm = bodies.poses[i].position - center;
        let outer = DMat3::from_cols(arm * arm.x, arm * arm.y, arm * arm.z);
        let offset = arm.length_squared() * DMat3::IDENTITY - outer;
        inertia +=
            bodies.inertias[i].tensor(bodies.poses[i].orientation) + bodies.masses[i] * offset;
    }
    let spin = inertia.inverse() * -angular_momentum;
    for &i in members {
        let tensor = bodies.inertias[i].tensor(bodies.poses[i].orientation);
        bodies.velocities[i].linear += spin.cross(bodies.poses[i].position - center);
        bodies.velocities[i].angular_momentum += tensor * spin;
    }
}

/// Integrates a body without contacts over the frame, exactly.
pub(super) fn fall(bodies: &mut Bodies, i: usize, frame: &Frame) {
    let half = 0.5 * frame.dt * frame.gravity;
    bodies.velocities[i].linear += half;
    bodies.poses[i] = evolve(bodies, i, &bodies.poses[i], &bodies.velocities[i], frame);
    bodies.velocities[i].linear += half;
}
