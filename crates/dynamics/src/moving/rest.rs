//! Bodies at rest. Once in a frame, what is calm comes to rest: from then on gravity and its contacts are taken to be in balance, so that it goes on
//! as it moves, until something moves it. Nothing acts there without passes that settle it, so nothing builds up.

use super::shared_lines::SharedLines;
use super::{Build, MASS, Movers, Moving, PACE, Seen, TRAVEL, is_mobile, tensor_of, velocity_of};
use crate::contact_rows::Stage;
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Numbers};
use crate::threads;
use crate::{Bodies, Frame, Velocity};
use glam::DVec3;
use std::sync::atomic::{AtomicBool, Ordering};

/// Speed [m/s] of which a body is calm if it is slower, its centre and what its turning adds at its rim together. What slides down a slope begins to
/// after a few frames at it. It does not scale with the scene.
const CALM: f64 = 1e-4;

/// Speed [m/s] from which on what holds a body at rest has to act again: in what is left of a frame it comes some hundredths of a millimetre far at it.
const QUIET: f64 = 1e-3;

/// Bodies that a thread lets fall together: some microseconds of work.
const SHARE: usize = 1024;

/// How fast a body is.
#[derive(Clone, Copy, PartialEq)]
pub(super) enum Pace {
    /// See [`CALM`].
    Calm,
    /// See [`QUIET`].
    Quiet,
    Fast,
}

/// What takes a body's weight.
#[derive(Clone, Copy, PartialEq)]
enum Weight {
    /// Gravity acts on it, and all of its contacts do.
    Falls,
    /// Some of its contacts are at rest: they and gravity are in balance with what the others gave when these came to rest, or the others got up.
    Leans,
    /// All of its contacts are at rest, in balance with gravity.
    Rests,
    /// None of its contacts is at rest any more, since gravity's last kick.
    Rises,
}

/// What is at rest among the bodies of a cluster.
pub(super) struct Rest {
    /// Whether each was calm at the frame's start.
    began_calm: Vec<bool>,
    /// Whether each could come to rest when what is calm did.
    may_rest: Vec<bool>,
    weights: SharedLines<Weight>,
    /// In how many batches at rest each is.
    batches: SharedLines<u32>,
    /// What gravity and contacts at rest give to those that lean, before and after the drift: an impulse, and its moment about where the centre of
    /// mass was at the frame's start [N s, N m s].
    held: [SharedLines<Numbers>; 2],
    /// Those that fall and nothing else, others that do not rest, the sums over those that do, and whether they are others by now.
    falling: Vec<u32>,
    awake: Vec<u32>,
    asleep: Asleep,
    is_stale: AtomicBool,
    pub(super) given: Held,
}

/// Sums over bodies that rest.
#[derive(Clone, Copy)]
struct Asleep {
    /// [kg]
    mass: f64,
    /// Of mass times position [kg m].
    moment: DVec3,
    /// [kg m/s]
    momentum: DVec3,
}

/// What holds bodies at rest has given, from outside.
#[derive(Clone, Copy)]
pub(crate) struct Held {
    /// [N s]
    pub(crate) impulse: DVec3,
    /// About the world's origin [N m s].
    pub(crate) moment: DVec3,
    /// [J]
    pub(crate) energy: f64,
}

impl Pace {
    /// By what is seen of a body: how fast it was when impulses last acted on it. What has fallen since is fast; what impulses do not move is calm.
    #[inline(always)]
    fn of_seen(seen: &Seen) -> Self {
        let squared = seen.0[PACE];
        if squared < (CALM * CALM) as f32 {
            Self::Calm
        } else if squared < (QUIET * QUIET) as f32 {
            Self::Quiet
        } else {
            Self::Fast
        }
    }
}

impl Rest {
    /// None of some bodies rests, with room for so many.
    pub(super) fn new(bodies: &Bodies, who: &[usize], lines: usize) -> Self {
        let mut began_calm = vec![true; lines];
        who.iter().zip(&mut began_calm).for_each(|(&i, calm)| *calm = begins_calm(bodies, i));
        Self {
            began_calm,
            may_rest: vec![false; lines],
            weights: SharedLines::new(Weight::Falls, lines),
            batches: SharedLines::new(0, lines),
            held: [0, 1].map(|_| SharedLines::new(Numbers::ZERO, lines)),
            falling: Vec::new(),
            awake: Vec::new(),
            asleep: Asleep { mass: 0.0, moment: DVec3::ZERO, momentum: DVec3::ZERO },
            is_stale: AtomicBool::new(true),
            given: Held { impulse: DVec3::ZERO, moment: DVec3::ZERO, energy: 0.0 },
        }
    }

    /// Who rests now.
    fn look(&mut self, moving: &[Moving], poses: &[Numbers], builds: &[Build]) {
        let weights = self.weights.as_mut_slice();
        self.falling.clear();
        self.awake.clear();
        self.asleep = Asleep { mass: 0.0, moment: DVec3::ZERO, momentum: DVec3::ZERO };
        for (local, moving) in moving.iter().enumerate().filter(|(_, moving)| is_mobile(moving)) {
            match weights[local] {
                Weight::Rests => {
                    let mass = builds[local].0[MASS];
                    self.asleep.mass += mass;
                    self.asleep.moment += mass * position(&poses[local]);
                    self.asleep.momentum += mass * velocity_of(moving).linear;
                }
                Weight::Falls => self.falling.push(local as u32),
                Weight::Leans | Weight::Rises => self.awake.push(local as u32),
            }
        }
    }
}

impl Movers {
    /// Half a substep of gravity, with what holds bodies at rest.
    pub(crate) fn kick(&mut self, step: &Frame, stage: Stage) {
        let gain = 0.5 * step.dt * step.gravity;
        let is_stale = std::mem::take(self.rest.is_stale.get_mut());
        if is_stale {
            let Self { moving, rest, poses, builds, .. } = self;
            rest.look(moving.as_mut_slice(), poses, builds);
        }

        // Gravity acts on all, and what holds bodies at rest takes that back where it does not go on to act.
        self.gravity.0 += self.mass * gain;
        self.gravity.1 += self.moment_of_mass.cross(gain);
        let Rest { asleep, given, .. } = &mut self.rest;
        given.impulse -= asleep.mass * gain;
        given.moment -= asleep.moment.cross(gain);
        given.energy -= asleep.momentum.dot(gain);
        // Each body is in the list once.
        let mut falling: Vec<&[u32]> = self.rest.falling.chunks(SHARE).collect();
        threads::for_each(&mut falling, self.rest.falling.len(), |locals| {
            locals.iter().for_each(|&local| self.fall(local as usize, gain));
        });
        let mut given = self.rest.given;
        for local in self.rest.awake.iter().map(|&local| local as usize) {
            let weight = self.rest.weights.read(local);
            if weight == Weight::Rises {
                self.rest.weights.write(local, Weight::Falls);
                // What has got up since the kick before the drift has not had that one, whose energy this one's is to be taken from.
                if stage == Stage::AfterDrift {
                    given.energy += 0.5 * self.builds[local].0[MASS] * gain.length_squared();
                }
            }
            if weight == Weight::Leans {
                self.hold(local, (gain, stage), &mut given);
            } else {
                self.fall(local, gain);
            }
        }
        self.rest.given = given;
        if is_stale {
            self.note_kicked();
        }
    }

    /// Gravity's kick makes one body so much faster [m/s].
    fn fall(&self, local: usize, gain: DVec3) {
        let mut moving = self.moving.read(local);
        let Numbers([x, y, z, ..]) = &mut moving;
        (*x, *y, *z) = (*x + gain.x, *y + gain.y, *z + gain.z);
        self.moving.write(local, moving);
        let mut seen = self.seen.read(local);
        show_linear(&mut seen, velocity_of(&moving).linear);
        seen.0[PACE] = f32::INFINITY;
        self.seen.write(local, seen);
        self.kicked.write(local, seen);
    }

    /// What holds a body that leans acts, instead of gravity's kick. It is as fast as that makes it, as what it is in balance with has not acted yet, and may
    /// act no more.
    fn hold(&self, local: usize, (gain, stage): (DVec3, Stage), given: &mut Held) {
        let Numbers([x, y, z, mx, my, mz, ..]) = self.rest.held[stage.at()].read(local);
        let (impulse, about_start) = (DVec3::new(x, y, z), DVec3::new(mx, my, mz));
        let (answer, moving) = (tensor_of(&self.answers[local]), self.moving.read(local));
        let Velocity { linear, angular_momentum } = velocity_of(&moving);
        let position = position(&self.poses[local]);
        let turn = about_start - (position - self::position(&self.starts[local])).cross(impulse);
        let Numbers([.., inverse_mass, _]) = moving;
        let (next, next_momentum) = (linear + inverse_mass * impulse, angular_momentum + turn);
        let DVec3 { x, y, z } = next;
        let DVec3 { x: lx, y: ly, z: lz } = next_momentum;
        self.moving.write(local, Numbers([x, y, z, lx, ly, lz, inverse_mass, 1.0]));
        let (spin, mut seen) = (answer * next_momentum, self.seen.read(local));
        show_linear(&mut seen, next);
        seen.0[3..6].copy_from_slice(&spin.as_vec3().to_array());

        // Before the drift its other half is still to come: see `Beat::new`.
        let weight = self.builds[local].0[MASS] * gain;
        let ahead = if stage == Stage::BeforeDrift { gain } else { DVec3::ZERO };
        let turned = 0.5 * (answer * (angular_momentum + next_momentum)).dot(turn);
        given.energy += (0.5 * (linear + next) - ahead).dot(impulse) + turned - weight.dot(linear);
        given.impulse += impulse - weight;
        given.moment += position.cross(impulse - weight) + turn;

        let Numbers([.., size]) = self.starts[local];
        seen.0[PACE] = (next.length_squared() + spin.length_squared() * size * size) as f32;
        self.seen.write(local, seen);
        self.kicked.write(local, seen);
    }

    /// What rests has drifted for some time [s].
    pub(super) fn rest_drifts(&mut self, dt: f64) {
        let asleep = &mut self.rest.asleep;
        asleep.moment += dt * asleep.momentum;
    }

    /// What held bodies at rest.
    pub(crate) fn held(&self) -> Held {
        self.rest.given
    }

    /// Finds who may come to rest: which bodies are calm after a frame's first substep, of `dt` [s], have been so in its drift, in which overlaps close, and were so
    /// before it: nothing that falls is, not even at its highest.
    pub(crate) fn find_who_may_rest(&mut self, dt: f64) {
        let Rest { began_calm, may_rest, .. } = &mut self.rest;
        for (at, may_rest) in may_rest.iter_mut().enumerate() {
            *may_rest = Pace::of_seen(&self.seen.read(at)) == Pace::Calm
                && began_calm[at]
                && self.builds[at].0[TRAVEL] <= CALM * dt;
        }
    }

    /// Whether all of some bodies may come to rest.
    #[inline(always)]
    pub(crate) fn may_rest(&self, locals: &[u32; LANES]) -> bool {
        locals.iter().all(|&local| self.rest.may_rest[local as usize])
    }

    /// Those that could come to rest in this frame, by dense index.
    pub(crate) fn who_may_rest(&self) -> impl Iterator<Item = usize> {
        self.who.iter().zip(&self.rest.may_rest).filter(|(_, may_rest)| **may_rest).map(|(&i, _)| i)
    }

    /// Whether all that impulses move rests.
    pub(crate) fn all_rest(&self) -> bool {
        (0..self.who.len())
            .all(|at| self.rest.weights.read(at) == Weight::Rests || !is_mobile(&self.moving.read(at)))
    }

    /// Whether none of some bodies is fast.
    #[inline(always)]
    pub(crate) fn are_quiet(&self, locals: &[u32; LANES]) -> bool {
        locals.iter().all(|&local| Pace::of_seen(&self.seen.read(local as usize)) != Pace::Fast)
    }

    /// Whether any of some bodies is in a batch at rest.
    #[inline(always)]
    pub(crate) fn any_rests(&self, locals: &[u32; LANES]) -> bool {
        locals.iter().any(|&local| self.rest.batches.read(local as usize) > 0)
    }

    /// Some bodies are in one batch at rest more.
    #[inline(always)]
    pub(crate) fn lie_down(&self, locals: &[u32; LANES]) {
        self.rest.is_stale.store(true, Ordering::Relaxed);
        for at in locals.map(|local| local as usize) {
            if is_mobile(&self.moving.read(at)) {
                self.rest.batches.write(at, self.rest.batches.read(at) + 1);
                self.rest.weights.write(at, Weight::Rests);
            }
        }
    }

    /// Some bodies are in one batch at rest less.
    #[inline(always)]
    pub(crate) fn get_up(&self, locals: &[u32; LANES]) {
        self.rest.is_stale.store(true, Ordering::Relaxed);
        for at in locals.map(|local| local as usize) {
            if is_mobile(&self.moving.read(at)) {
                let left = self.rest.batches.read(at) - 1;
                self.rest.batches.write(at, left);
                if left == 0 {
                    self.rest.weights.write(at, Weight::Rises);
                }
            }
        }
    }

    /// Those of some bodies that are in batches at rest also have contacts that act, and that they are in balance with: these give them an
    /// impulse, and its moment about where their centres of mass were at the frame's start, before and after the drift.
    #[inline(always)]
    pub(crate) fn lean<I: Instructions>(&self, locals: &[u32; LANES], given: [(Lanes3<I>, Lanes3<I>); 2]) {
        for (held, (Lanes3 { x, y, z }, Lanes3 { x: mx, y: my, z: mz })) in self.rest.held.iter().zip(given) {
            let rows = Lanes::rows([x, y, z, mx, my, mz, Lanes::ZERO, Lanes::ZERO]);
            for lane in 0..LANES {
                let at = locals[lane] as usize;
                if self.rest.batches.read(at) > 0 {
                    let mut line = held.read(at);
                    for (sum, more) in line.0.iter_mut().zip(rows[lane].0) {
                        *sum -= more;
                    }
                    held.write(at, line);
                    self.rest.weights.write(at, Weight::Leans);
                }
            }
        }
    }
}

/// A body is seen as fast as it moves [m/s].
#[inline(always)]
fn show_linear(seen: &mut Seen, linear: DVec3) {
    seen.0[..3].copy_from_slice(&linear.as_vec3().to_array());
}

fn position(pose: &Numbers) -> DVec3 {
    let Numbers([x, y, z, ..]) = *pose;
    DVec3::new(x, y, z)
}

/// Whether gravity moves what nothing holds so much in a step that it is not calm at both of its ends. So what is, is held from outside.
pub(crate) fn can_rest(step: &Frame) -> bool {
    step.gravity.length() * step.dt > 10.0 * CALM
}

/// Whether a body is calm as the frame begins.
fn begins_calm(bodies: &Bodies, i: usize) -> bool {
    is_calm(fastest(bodies, i))
}

/// Whether a body is calm none of whose points is faster than this [m/s].
pub(crate) fn is_calm(fastest: f64) -> bool {
    fastest < CALM
}

/// As the frame begins no point of a body is faster, as far as impulses move it [m/s].
pub(crate) fn fastest(bodies: &Bodies, i: usize) -> f64 {
    let inertia = &bodies.inertias[i];
    if inertia.is_infinite() {
        return 0.0;
    }
    let Velocity { linear, angular_momentum } = bodies.velocities[i];
    linear.length() + inertia.inverse_moments.max_element() * bodies.radii[i] * angular_momentum.length()
}
