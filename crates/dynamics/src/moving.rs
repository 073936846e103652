//! The bodies of a cluster as the substeps' solver moves them: velocities, and how they answer impulses.

mod drift;
mod rest;
mod shared_lines;

use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Numbers, Single, Single3, Symmetric, Three};
use crate::rotation::rotation_by;
use crate::vector::Turn;
use crate::{Bodies, Motion, Pose, Velocity};
use frangible_geometry::RigidTransform;
use glam::{DMat3, DQuat, DVec3};
use rest::{Pace, Rest};
pub(crate) use rest::{begins_calm, can_rest};
use shared_lines::SharedLines;

/// A body, in lines that are loaded for several bodies at once.
#[derive(Clone, Copy)]
#[repr(align(128))]
struct Moving {
    /// Linear velocity [m/s], angular momentum [kg m^2/s], inverse mass [1/kg], and 1 if it falls. All zero for a static or kinematic
    /// body, whose motion is in the rows' drives.
    motion: Numbers,
    /// Inverse of the inertia tensor in the world frame, its diagonal and the entries yz, xz and xy [1/(kg m^2)]. Zero as above.
    answer: Numbers,
}

/// How a body has moved since the frame's start: translation [m], rotation as a quaternion, and how far any of its points can have moved,
/// relative to its size.
type Moved = Numbers;

const UNMOVED: Moved = Numbers([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);

/// What a body is like, and how far it has come, as a line: inverse principal moments of inertia, and the largest of them
/// [1/(kg m^2)]; how far any of its points can have moved since the frame's start [m]; its mass if impulses move it [kg]; 1 if it is driven.
type Build = Numbers;

/// Places in a [`Build`].
const TRAVEL: usize = 4;
const MASS: usize = 5;

/// The bodies of a cluster.
pub(crate) struct Movers {
    /// Dense indices.
    pub(crate) who: Vec<usize>,
    /// In the same order, and then one that never moves, for the lanes that hold none.
    moving: SharedLines<Moving>,
    moved: Vec<Moved>,
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

/// One side of several pairs.
#[derive(Clone, Copy)]
pub(crate) struct Side<I> {
    pub(crate) linear: Lanes3<I>,
    pub(crate) angular_momentum: Lanes3<I>,
    /// [rad/s]
    pub(crate) angular: Lanes3<I>,
    pub(crate) inverse_mass: Lanes<I>,
    pub(crate) inverse_tensor: Symmetric<Lanes<I>>,
    /// 1 for what falls, else 0.
    pub(crate) falls: Lanes<I>,
}

/// Both sides of several pairs as their rows see them, in single precision: velocities that both have in common make no difference there.
#[derive(Clone, Copy)]
pub(crate) struct Sides<I> {
    /// Velocity of the first centre of mass less that of the second one [m/s].
    pub(crate) apart: Single3<I>,
    /// [rad/s]
    pub(crate) spins: [Single3<I>; 2],
    /// The sum of both [1/kg].
    pub(crate) inverse_mass: Single<I>,
    pub(crate) inverse_tensors: [Symmetric<Single<I>>; 2],
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
        let mut movers = Self {
            moving: SharedLines::new(Moving::NONE, lines),
            moved: vec![UNMOVED; lines],
            rest: Rest::new(bodies, &who, lines),
            poses: vec![still; lines],
            starts: vec![still; lines],
            builds: vec![Numbers::ZERO; lines],
            mass: 0.0,
            moment_of_mass: DVec3::ZERO,
            who,
            gravity: (DVec3::ZERO, DVec3::ZERO),
        };
        movers.begin::<I>(bodies);
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
            if moving.is_mobile() {
                bodies.velocities[i] = moving.velocity();
            }
        }
    }

    /// Where a body is now, and its velocity.
    pub(crate) fn state(&self, bodies: &Bodies, local: u32) -> (Pose, Velocity) {
        let moving = self.moving.read(local as usize);
        let velocity = bodies.velocities[self.who[local as usize]];
        (self.pose(local), if moving.is_mobile() { moving.velocity() } else { velocity })
    }

    /// Linear velocity [m/s] and angular velocity [rad/s]; zero of static and kinematic bodies, whose motion is in [`Bodies`].
    pub(crate) fn rates(&self, local: u32) -> (DVec3, DVec3) {
        let moving = self.moving.read(local as usize);
        let Velocity { linear, angular_momentum } = moving.velocity();
        (linear, moving.inverse_tensor() * angular_momentum)
    }

    /// Where a body is now.
    pub(crate) fn pose(&self, local: u32) -> Pose {
        pose_of(&self.poses[local as usize])
    }

    #[inline(always)]
    pub(crate) fn load<I: Instructions>(&self, locals: &[u32; LANES]) -> Side<I> {
        let (mut motions, mut answers) = ([Numbers::ZERO; LANES], [Numbers::ZERO; LANES]);
        for lane in 0..LANES {
            let moving = self.moving.read(locals[lane] as usize);
            (motions[lane], answers[lane]) = (moving.motion, moving.answer);
        }
        let [x, y, z, lx, ly, lz, inverse_mass, falls] = Lanes::transposed(motions);
        let [xx, yy, zz, yz, xz, xy, ..] = Lanes::transposed(answers);
        let angular_momentum = Lanes3 { x: lx, y: ly, z: lz };
        let inverse_tensor =
            Symmetric { diagonal: Lanes3 { x: xx, y: yy, z: zz }, off: Lanes3 { x: yz, y: xz, z: xy } };
        Side {
            linear: Lanes3 { x, y, z },
            angular: inverse_tensor * angular_momentum,
            angular_momentum,
            inverse_mass,
            inverse_tensor,
            falls,
        }
    }

    /// Asks for some bodies that will be loaded.
    #[inline(always)]
    pub(crate) fn prefetch<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch(self.moving.at(local as usize));
        }
    }

    /// Asks for how some bodies have moved.
    #[inline(always)]
    pub(crate) fn prefetch_shifts<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch(&self.moved[local as usize..][..1]);
        }
    }

    /// Asks for how some bodies began the frame.
    #[inline(always)]
    pub(crate) fn prefetch_starts<I: Instructions>(&self, locals: &[u32]) {
        for &local in locals {
            I::prefetch(&self.starts[local as usize..][..1]);
        }
    }

    /// Asks for where the bodies of a pair are, where they began the frame, and how far they have come.
    #[inline(always)]
    pub(crate) fn prefetch_paths<I: Instructions>(&self, locals: [u32; 2]) {
        for at in locals.map(|local| local as usize) {
            I::prefetch(&self.builds[at..][..1]);
            I::prefetch(&self.poses[at..][..1]);
            I::prefetch(&self.starts[at..][..1]);
        }
    }

    /// Gives some bodies their velocities, by the radii of balls around their centres of mass that hold them [m]. No body that can move is in two lanes, or
    /// is read or written by another thread.
    #[inline(always)]
    pub(crate) fn store<I: Instructions>(&self, locals: &[u32; LANES], side: &Side<I>, size: Lanes<I>) {
        let Side { linear: v, angular_momentum: l, angular: w, inverse_mass, falls, .. } = *side;
        let paces = Pace::of_lanes(v.dot(v) + w.dot(w) * (size * size));
        let motions = Lanes::rows([v.x, v.y, v.z, l.x, l.y, l.z, inverse_mass, falls]);
        for lane in 0..LANES {
            let at = locals[lane] as usize;
            let moving = self.moving.read(at);
            if moving.is_mobile() {
                self.moving.write(at, Moving { motion: motions[lane], ..moving });
                self.rest.paces.write(at, paces[lane]);
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
        self.moving.read(local as usize).is_mobile()
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

impl Moving {
    const NONE: Self = Self { motion: Numbers::ZERO, answer: Numbers::ZERO };

    /// Whether impulses move it.
    #[inline(always)]
    fn is_mobile(&self) -> bool {
        self.motion.0[7] != 0.0
    }

    /// In the world frame [1/(kg m^2)].
    fn inverse_tensor(&self) -> DMat3 {
        let Numbers([xx, yy, zz, yz, xz, xy, ..]) = self.answer;
        DMat3::from_cols_array(&[xx, xy, xz, xy, yy, yz, xz, yz, zz])
    }

    fn velocity(&self) -> Velocity {
        let Numbers([x, y, z, lx, ly, lz, ..]) = self.motion;
        Velocity { linear: DVec3::new(x, y, z), angular_momentum: DVec3::new(lx, ly, lz) }
    }
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

impl<I: Instructions> Side<I> {
    /// After an impulse and an angular impulse about the centre of mass.
    #[inline(always)]
    pub(crate) fn pushed(&self, impulse: Lanes3<I>, angular_impulse: Lanes3<I>) -> Self {
        Self {
            linear: self.linear + impulse * self.inverse_mass,
            angular_momentum: self.angular_momentum + angular_impulse,
            angular: self.angular + self.inverse_tensor * angular_impulse,
            ..*self
        }
    }
}

impl<I: Instructions> Sides<I> {
    #[inline(always)]
    pub(crate) fn of([first, second]: &[Side<I>; 2]) -> Self {
        Self {
            apart: (first.linear - second.linear).single(),
            spins: [first.angular.single(), second.angular.single()],
            inverse_mass: (first.inverse_mass + second.inverse_mass).single(),
            inverse_tensors: [first.inverse_tensor.single(), second.inverse_tensor.single()],
        }
    }

    /// After an impulse on the first bodies at levers from both centres of mass, and its opposite on the second ones.
    #[inline(always)]
    pub(crate) fn push(&mut self, [angular_impulse, opposite]: [Single3<I>; 2], impulse: Single3<I>) {
        self.apart = self.apart + impulse * self.inverse_mass;
        self.turn([angular_impulse, opposite]);
    }

    /// An angular impulse on the first bodies, and the opposite of another one on the second ones.
    #[inline(always)]
    pub(crate) fn turn(&mut self, [on_first, off_second]: [Single3<I>; 2]) {
        self.spins[0] = self.spins[0] + self.inverse_tensors[0] * on_first;
        self.spins[1] = self.spins[1] - self.inverse_tensors[1] * off_second;
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
