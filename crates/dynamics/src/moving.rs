//! The bodies of a cluster as the substeps' solver moves them: velocities, and how they answer impulses.

mod drift;
mod rest;
mod shared_lines;
mod sides;

use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Numbers, Single, Single3, Singles, Symmetric, Three};
use crate::rotation::rotation_by;
use crate::threads;
use crate::vector::Turn;
use crate::{Bodies, Frame, Motion, Pose, Velocity};
use frangible_geometry::RigidTransform;
use glam::{DMat3, DQuat, DVec3};
use rest::Rest;
pub(crate) use rest::{can_rest, fastest, is_calm};
use shared_lines::SharedLines;
pub(crate) use sides::{Rates, Sides};

/// A body's linear velocity [m/s], angular momentum [kg m^2/s], inverse mass [1/kg], and 1 if it falls, in double precision: what impulses give to one
/// body they take from another one. All zero for a static or kinematic body, whose motion is in the rows' drives.
type Moving = Numbers;

/// The same as contacts see it, in single precision: linear velocity [m/s], angular velocity [rad/s], inverse mass [1/kg], and how fast it is
/// [m^2/s^2]. All zero as above.
type Seen = Singles;

/// Inverse of a body's inertia tensor in the world frame, its diagonal and the entries yz, xz and xy [1/(kg m^2)], in single precision. Zero as above.
type Answer = Singles;

/// How a body has moved since the frame's start: translation [m], rotation as a quaternion, and how far any of its points can have moved,
/// relative to its size.
type Moved = Numbers;

const UNMOVED: Moved = Numbers([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);

/// What a body is like, and how far it has come, as a line: inverse principal moments of inertia, and the largest of them
/// [1/(kg m^2)]; how far any of its points can have moved since the frame's start [m]; its mass if impulses move it [kg]; 1 if it is driven.
type Build = Numbers;

/// Place of how fast a body is in what is [seen](Seen) of its motion.
const PACE: usize = 7;

/// Places in a [`Build`].
const TRAVEL: usize = 4;
const MASS: usize = 5;

/// The bodies of a cluster.
pub(crate) struct Movers {
    /// Dense indices.
    pub(crate) who: Vec<usize>,
    /// In the same order, and then one that never moves, for the lanes that hold none.
    moving: SharedLines<Moving>,
    seen: SharedLines<Seen>,
    answers: Vec<Answer>,
    moved: Vec<Moved>,
    /// What was seen of their motion after gravity's last kick, before contacts acted.
    kicked: SharedLines<Seen>,
    rest: Rest,
    /// Positions and orientations, now and at the frame's start; in the line of the start also the radius of a ball around the centre of
    /// mass that holds the body, 0 if it is infinite [m].
    poses: Vec<Numbers>,
    starts: Vec<Numbers>,
    builds: Vec<Build>,
    /// Of those that impulses move: sum of the masses [kg], and of the masses times their positions [kg m].
    mass: f64,
    moment_of_mass: DVec3,
    /// Impulse and angular impulse about the world's origin that gravity gave.
    pub(crate) gravity: (DVec3, DVec3),
}

/// One side of several pairs, as their rows see it, in single precision.
#[derive(Clone, Copy)]
pub(crate) struct Side<I> {
    pub(crate) linear: Single3<I>,
    /// [rad/s]
    pub(crate) angular: Single3<I>,
    pub(crate) inverse_mass: Single<I>,
    pub(crate) inverse_tensor: Symmetric<Single<I>>,
    /// 1 for what falls, else 0.
    pub(crate) falls: Single<I>,
}

/// What is given to one side of several pairs: an impulse [N s], and its moment about the centre of mass [N m s].
#[derive(Clone, Copy)]
pub(crate) struct Push<I: Instructions> {
    pub(crate) impulse: Lanes3<I>,
    pub(crate) moment: Lanes3<I>,
}

/// How some bodies began the frame.
pub(crate) struct Start<I: Instructions> {
    /// Centre of mass [m].
    pub(crate) centre: Lanes3<I>,
    pub(crate) orientation: Turn<Lanes3<I>>,
    /// Radius of a ball around the centre of mass that holds the body [m]; 0 if it is infinite.
    pub(crate) size: Lanes<I>,
}

/// How some bodies have moved since the frame's start.
pub(crate) struct Shift<I: Instructions> {
    pub(crate) translation: Lanes3<I>,
    pub(crate) rotation: Turn<Single3<I>>,
    /// How far any of their points can have moved, relative to their sizes [1].
    pub(crate) stirred: Lanes<I>,
}

impl Movers {
    /// Of bodies that have not moved yet in this frame.
    pub(crate) fn new<I: Instructions>(bodies: &Bodies, who: Vec<usize>) -> Self {
        let lines = (who.len() + 1).next_multiple_of(LANES);
        let still = line_of(&Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY });
        // All memory is written once before anything is known of them, which takes as long as what follows.
        let ((rest, moving, [seen, kicked]), (answers, moved, [poses, starts], builds)) = threads::join(
            who.len(),
            || {
                let seen = [0, 1].map(|_| SharedLines::new(Singles::ZERO, lines));
                (Rest::new(bodies, &who, lines), SharedLines::new(Numbers::ZERO, lines), seen)
            },
            || {
                let poses = [0, 1].map(|_| vec![still; lines]);
                (vec![Singles::ZERO; lines], vec![UNMOVED; lines], poses, vec![Numbers::ZERO; lines])
            },
        );
        let mut movers = Self {
            moving,
            seen,
            answers,
            moved,
            kicked,
            rest,
            poses,
            starts,
            builds,
            mass: 0.0,
            moment_of_mass: DVec3::ZERO,
            who,
            gravity: (DVec3::ZERO, DVec3::ZERO),
        };
        movers.begin::<I>(bodies);
        movers.note_kicked();
        movers.mass = movers.builds.iter().map(|build| build.0[MASS]).sum();
        movers
    }

    /// Of all that impulses move [kg].
    pub(crate) fn mass(&self) -> f64 {
        self.mass
    }

    /// Stands for no body.
    pub(crate) fn nobody(&self) -> u32 {
        self.who.len() as u32
    }

    /// How far two points of two bodies can have moved relative to each other since the frame's start [m].
    pub(crate) fn travel(&self, pair: [u32; 2]) -> f64 {
        pair.into_iter().map(|local| self.builds[local as usize].0[TRAVEL]).sum()
    }

    /// The bodies get the poses and velocities that they have here.
    pub(crate) fn hand_back(&self, bodies: &mut Bodies) {
        for (local, &i) in self.who.iter().enumerate() {
            if bodies.motions[i] == Motion::Dynamic {
                bodies.poses[i] = self.pose(local as u32);
            }
            let moving = self.moving.read(local);
            if is_mobile(&moving) {
                bodies.velocities[i] = velocity_of(&moving);
            }
        }
    }

    /// By how much the energy of all that impulses move has changed since the frame's start, and that of their motion then, now, and of what gravity gives in
    /// the frame from rest [J].
    pub(crate) fn gained(&self, bodies: &Bodies, frame: &Frame) -> [f64; 2] {
        let (gravity, fall) = (frame.gravity, frame.dt * frame.gravity);
        let of = |local: usize| {
            let (i, moving) = (self.who[local], self.moving.read(local));
            if !is_mobile(&moving) {
                return [0.0; 2];
            }
            let (start, end) = (bodies.poses[i], self.pose(local as u32));
            let (before, after) = (bodies.velocities[i], velocity_of(&moving));
            let turning = |pose: &Pose, velocity: &Velocity| {
                bodies.inertias[i].rotational_energy(pose.orientation, velocity.angular_momentum)
            };
            let flight = 0.5 * (after.linear - before.linear).dot(after.linear + before.linear)
                - gravity.dot(end.position - start.position);
            let (turned, turns) = (turning(&start, &before), turning(&end, &after));
            let squares =
                before.linear.length_squared() + after.linear.length_squared() + fall.length_squared();
            let mass = bodies.masses[i];
            [mass * flight + (turns - turned), 0.5 * mass * squares + turned + turns]
        };
        let add = |[gain, motion]: [f64; 2], [more, other]: [f64; 2]| [gain + more, motion + other];
        threads::list(self.who.len(), of).into_iter().fold([0.0; 2], add)
    }

    /// Where a body is now, and its velocity.
    pub(crate) fn state(&self, bodies: &Bodies, local: u32) -> (Pose, Velocity) {
        let moving = self.moving.read(local as usize);
        let velocity = bodies.velocities[self.who[local as usize]];
        (self.pose(local), if is_mobile(&moving) { velocity_of(&moving) } else { velocity })
    }

    /// Linear velocity [m/s] and angular velocity [rad/s]; zero of static and kinematic bodies, whose motion is in [`Bodies`].
    pub(crate) fn rates(&self, local: u32) -> (DVec3, DVec3) {
        let Velocity { linear, angular_momentum } = velocity_of(&self.moving.read(local as usize));
        (linear, tensor_of(&self.answers[local as usize]) * angular_momentum)
    }

    /// Where a body is now.
    pub(crate) fn pose(&self, local: u32) -> Pose {
        pose_of(&self.poses[local as usize])
    }

    #[inline(always)]
    pub(crate) fn load<I: Instructions>(&self, locals: &[u32; LANES]) -> Side<I> {
        let mut seen = [Singles::ZERO; LANES];
        let mut answers = [Singles::ZERO; LANES];
        for lane in 0..LANES {
            seen[lane] = self.seen.read(locals[lane] as usize);
            answers[lane] = self.answers[locals[lane] as usize];
        }
        let [x, y, z, wx, wy, wz, inverse_mass, _] = Single::transposed(seen);
        let [xx, yy, zz, yz, xz, xy, ..] = Single::transposed(answers);
        Side {
            linear: Three { x, y, z },
            angular: Three { x: wx, y: wy, z: wz },
            inverse_mass,
            inverse_tensor: Symmetric {
                diagonal: Three { x: xx, y: yy, z: zz },
                off: Three { x: yz, y: xz, z: xy },
            },
            falls: falls(inverse_mass),
        }
    }

    /// How the sides of some pairs move.
    #[inline(always)]
    pub(crate) fn rates_of<I: Instructions>(&self, locals: &[[u32; LANES]; 2]) -> Rates<I> {
        let mut seen = [[Singles::ZERO; LANES]; 2];
        for side in 0..2 {
            for lane in 0..LANES {
                seen[side][lane] = self.seen.read(locals[side][lane] as usize);
            }
        }
        rates(seen).0
    }

    /// The same, as fast as gravity's last kick left them, whatever contacts have done since; and 1 for pairs of which only the first body falls, -1 if only the second does.
    #[inline(always)]
    pub(crate) fn kicked_rates_of<I: Instructions>(
        &self,
        locals: &[[u32; LANES]; 2],
    ) -> (Rates<I>, Single<I>) {
        let mut seen = [[Singles::ZERO; LANES]; 2];
        for side in 0..2 {
            for lane in 0..LANES {
                seen[side][lane] = self.kicked.read(locals[side][lane] as usize);
            }
        }
        rates(seen)
    }

    /// Notes how fast all bodies are.
    fn note_kicked(&mut self) {
        self.kicked.as_mut_slice().copy_from_slice(self.seen.as_mut_slice());
    }

    /// Asks for some bodies that will be loaded.
    #[inline(always)]
    pub(crate) fn prefetch<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch_one(self.seen.all(), local);
            I::prefetch_one(&self.answers, local);
        }
    }

    /// Asks for the exact motion of some bodies.
    #[inline(always)]
    pub(crate) fn prefetch_motions<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch_one(self.moving.all(), local);
        }
    }

    /// Asks for how fast gravity left some bodies.
    #[inline(always)]
    pub(crate) fn prefetch_kicked<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch_one(self.kicked.all(), local);
        }
    }

    /// Asks for how some bodies have moved.
    #[inline(always)]
    pub(crate) fn prefetch_shifts<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch_one(&self.moved, local);
        }
    }

    /// Asks for how some bodies began the frame.
    #[inline(always)]
    pub(crate) fn prefetch_starts<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch_one(&self.starts, local);
        }
    }

    /// Asks for where the bodies of a pair are, where they began the frame, and how far they have come.
    #[inline(always)]
    pub(crate) fn prefetch_paths<I: Instructions>(&self, locals: [u32; 2]) {
        for local in locals {
            I::prefetch_one(&self.builds, local);
            I::prefetch_one(&self.poses, local);
            I::prefetch_one(&self.starts, local);
        }
    }

    /// Shows some bodies as fast as they are now, by the radii of balls around their centres of mass that hold them [m]. No body that can move is in two lanes,
    /// or is read or written by another thread.
    #[inline(always)]
    pub(crate) fn show<I: Instructions>(&self, locals: &[u32; LANES], side: &Side<I>, size: Single<I>) {
        let Side { linear: v, angular: w, inverse_mass, .. } = *side;
        let pace = v.dot(v) + w.dot(w) * (size * size);
        let lines = Single::rows([v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, pace]);
        let is_mobile = inverse_mass.above(Single::ZERO);
        for lane in 0..LANES {
            if is_mobile.get(lane) {
                self.seen.write(locals[lane] as usize, lines[lane]);
            }
        }
    }

    /// Gives some bodies what they were pushed with, by their inverse masses [1/kg]. As above.
    #[inline(always)]
    pub(crate) fn push<I: Instructions>(
        &self,
        locals: &[u32; LANES],
        (push, inverse_mass): (&Push<I>, Single<I>),
    ) {
        let Push { impulse: j, moment: m } = *push;
        let pushes = Lanes::rows([j.x, j.y, j.z, m.x, m.y, m.z, Lanes::ZERO, Lanes::ZERO]);
        let is_mobile = inverse_mass.above(Single::ZERO);
        for lane in 0..LANES {
            if is_mobile.get(lane) {
                let at = locals[lane] as usize;
                let mut moving = self.moving.read(at);
                let by = moving.0[6];
                let answers = [by, by, by, 1.0, 1.0, 1.0, 0.0, 0.0];
                for number in 0..LANES {
                    moving.0[number] += answers[number] * pushes[lane].0[number];
                }
                self.moving.write(at, moving);
            }
        }
    }

    /// How they began the frame.
    #[inline(always)]
    pub(crate) fn starts<I: Instructions>(&self, locals: &[u32; LANES]) -> Start<I> {
        let mut starts = [Numbers::ZERO; LANES];
        for lane in 0..LANES {
            starts[lane] = self.starts[locals[lane] as usize];
        }
        let [x, y, z, qx, qy, qz, scalar, size] = Lanes::transposed(starts);
        let vector = Lanes3 { x: qx, y: qy, z: qz };
        Start { centre: Lanes3 { x, y, z }, orientation: Turn { vector, scalar }, size }
    }

    /// How they have moved since the frame's start.
    #[inline(always)]
    pub(crate) fn shifts<I: Instructions>(&self, locals: &[u32; LANES]) -> Shift<I> {
        let mut shifts = [Numbers::ZERO; LANES];
        for lane in 0..LANES {
            shifts[lane] = self.moved[locals[lane] as usize];
        }
        let [x, y, z, qx, qy, qz, qw, stirred] = Lanes::transposed(shifts);
        Shift {
            translation: Lanes3 { x, y, z },
            rotation: Turn { vector: Three { x: qx, y: qy, z: qz }.single(), scalar: qw.single() },
            stirred,
        }
    }

    /// Whether impulses move a body.
    pub(crate) fn is_mobile(&self, local: u32) -> bool {
        is_mobile(&self.moving.read(local as usize))
    }

    /// `second_from_first` of a pair at the frame's start.
    pub(crate) fn start_second_from_first(&self, [first, second]: [u32; 2]) -> RigidTransform {
        self.start(second).world_from_body().inverse().after(&self.start(first).world_from_body())
    }

    /// Where a body was at the frame's start.
    pub(crate) fn start(&self, local: u32) -> Pose {
        pose_of(&self.starts[local as usize])
    }
}

/// How both sides of several pairs are seen to move; and 1 for those of which only the first body falls, -1 if only the second does.
#[inline(always)]
fn rates<I: Instructions>([seen, other]: [[Seen; LANES]; 2]) -> (Rates<I>, Single<I>) {
    let [x, y, z, wx, wy, wz, inverse_mass, _] = Single::transposed(seen);
    let [ox, oy, oz, owx, owy, owz, other_inverse_mass, _] = Single::transposed(other);
    let apart = Three { x: x - ox, y: y - oy, z: z - oz };
    let spins = [Three { x: wx, y: wy, z: wz }, Three { x: owx, y: owy, z: owz }];
    (Rates { apart, spins }, falls(inverse_mass) - falls(other_inverse_mass))
}

/// 1 for what falls, else 0.
#[inline(always)]
fn falls<I: Instructions>(inverse_mass: Single<I>) -> Single<I> {
    inverse_mass.above(Single::ZERO).select(Single::splat(1.0), Single::ZERO)
}

/// In the world frame [1/(kg m^2)].
fn tensor_of(&Singles([xx, yy, zz, yz, xz, xy, ..]): &Answer) -> DMat3 {
    DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz].map(f64::from))
}

/// Whether impulses move a body.
#[inline(always)]
fn is_mobile(moving: &Moving) -> bool {
    moving.0[7] != 0.0
}

fn velocity_of(moving: &Moving) -> Velocity {
    let Numbers([x, y, z, lx, ly, lz, ..]) = *moving;
    Velocity { linear: DVec3::new(x, y, z), angular_momentum: DVec3::new(lx, ly, lz) }
}

fn line_of(pose: &Pose) -> Numbers {
    let (DVec3 { x, y, z }, q) = (pose.position, pose.orientation);
    Numbers([x, y, z, q.x, q.y, q.z, q.w, 0.0])
}

fn pose_of(line: &Numbers) -> Pose {
    let Numbers([x, y, z, qx, qy, qz, qw, _]) = *line;
    Pose { position: DVec3::new(x, y, z), orientation: DQuat::from_xyzw(qx, qy, qz, qw) }
}

impl<I: Instructions> Shift<I> {
    /// What the rotation adds to a lever.
    #[inline(always)]
    pub(crate) fn turn(&self, lever: Single3<I>) -> Single3<I> {
        let Turn { vector: axis, scalar: w } = self.rotation;
        let twice = axis.cross(lever) * Single::splat(2.0);
        twice * w + axis.cross(twice)
    }
}

/// Velocity of the material of a static or kinematic body at a lever from its centre, on the mean over `chord` [s] if that is given [m/s].
pub(crate) fn drive(motion: &Motion, lever: DVec3, chord: Option<f64>) -> DVec3 {
    match motion {
        Motion::Static | Motion::Dynamic => DVec3::ZERO,
        Motion::Kinematic { linear, angular } => match chord {
            Some(dt) if *angular != DVec3::ZERO => {
                let turned = DMat3::from_quat(rotation_by(dt * *angular)) * lever;
                *linear + (turned - lever) / dt
            }
            _ => *linear + angular.cross(lever),
        },
    }
}

#[cfg(test)]
impl Movers {
    /// Gives a body a velocity [m/s, rad/s], as if impulses had: it is where it was at the frame's start.
    pub(crate) fn set_velocity(&mut self, local: u32, linear: DVec3, angular: DVec3) {
        let at = local as usize;
        let momentum = tensor_of(&self.answers[at]).inverse() * angular;
        let moving = &mut self.moving.as_mut_slice()[at];
        let (DVec3 { x, y, z }, DVec3 { x: lx, y: ly, z: lz }) = (linear, momentum);
        *moving = Numbers([x, y, z, lx, ly, lz, moving.0[6], moving.0[7]]);
        let size = self.starts[at].0[7];
        let seen = &mut self.seen.as_mut_slice()[at];
        seen.0[..3].copy_from_slice(&linear.as_vec3().to_array());
        seen.0[3..6].copy_from_slice(&angular.as_vec3().to_array());
        seen.0[PACE] = (linear.length_squared() + angular.length_squared() * size * size) as f32;
    }
}
