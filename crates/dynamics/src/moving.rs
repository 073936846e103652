//! The bodies of a cluster as the substeps' solver moves them: velocities, and how they answer impulses.

use crate::detection::radius;
use crate::evolve::evolve;
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Numbers, SymmetricLanes};
use crate::rotation::rotation_by;
use crate::{Bodies, Frame, Motion, Pose, Velocity};
use frangible_geometry::RigidTransform;
use glam::{DMat3, DQuat, DVec3};

/// A body, in lines that are loaded for several bodies at once.
#[derive(Clone, Copy)]
struct Moving {
    /// Linear velocity [m/s], angular momentum [kg m^2/s], inverse mass [1/kg], and 1 if it falls. All zero for a static or kinematic
    /// body, whose motion is in the rows' drives.
    motion: Numbers,
    /// Inverse of the inertia tensor in the world frame, its diagonal and the entries yz, xz and xy [1/(kg m^2)]. Zero as above.
    answer: Numbers,
    /// How it has moved since the frame's start: translation [m], rotation as a quaternion, and how far any of its points can have
    /// moved, relative to its size.
    shift: Numbers,
}

/// The bodies of a cluster.
pub(crate) struct Movers {
    /// Dense indices.
    pub(crate) who: Vec<usize>,
    /// In the same order, and then one that never moves, for the lanes that hold none.
    moving: Vec<Moving>,
    /// Poses at the frame's start.
    starts: Vec<Pose>,
    /// Radii of balls around the centres of mass that hold them [m].
    sizes: Vec<f64>,
    /// How far any of their points can have moved since the frame's start [m].
    travel: Vec<f64>,
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
    pub(crate) inverse_tensor: SymmetricLanes<I>,
    /// 1 for what falls, else 0.
    pub(crate) falls: Lanes<I>,
}

/// How some bodies have moved since the frame's start.
#[derive(Clone, Copy)]
pub(crate) struct Shift<I> {
    pub(crate) translation: Lanes3<I>,
    /// A quaternion's vector and scalar parts.
    pub(crate) rotation: (Lanes3<I>, Lanes<I>),
    /// How far any of their points can have moved, relative to their sizes [1].
    pub(crate) stirred: Lanes<I>,
}

impl Movers {
    /// Of bodies that have not moved yet in this frame.
    pub(crate) fn new(bodies: &Bodies, who: Vec<usize>) -> Self {
        let mut movers = Self {
            moving: vec![Moving::NONE; who.len() + 1],
            starts: who.iter().map(|&i| bodies.poses[i]).collect(),
            sizes: who.iter().map(|&i| radius(&bodies.shapes[i])).collect(),
            travel: vec![0.0; who.len()],
            who,
            gravity: (DVec3::ZERO, DVec3::ZERO),
        };
        for (moving, &i) in movers.moving.iter_mut().zip(&movers.who) {
            if !bodies.inertias[i].is_infinite() {
                let Velocity { linear: v, angular_momentum: l } = bodies.velocities[i];
                let inverse_mass = bodies.inertias[i].inverse_mass;
                moving.motion = Numbers([v.x, v.y, v.z, l.x, l.y, l.z, inverse_mass, 1.0]);
                moving.turn_tensor(bodies, i);
            }
        }
        movers
    }

    /// Stands for no body.
    pub(crate) fn nobody(&self) -> u32 {
        self.who.len() as u32
    }

    /// Half a substep of gravity.
    pub(crate) fn kick(&mut self, bodies: &Bodies, step: &Frame) {
        let gain = 0.5 * step.dt * step.gravity;
        for (moving, &i) in self.moving.iter_mut().zip(&self.who) {
            if moving.is_mobile() {
                let Numbers([x, y, z, ..]) = &mut moving.motion;
                (*x, *y, *z) = (*x + gain.x, *y + gain.y, *z + gain.z);
                self.gravity.0 += bodies.masses[i] * gain;
                self.gravity.1 += bodies.poses[i].position.cross(bodies.masses[i] * gain);
            }
        }
    }

    /// All bodies along their velocities for one substep.
    pub(crate) fn drift(&mut self, bodies: &mut Bodies, step: &Frame) {
        for (local, &i) in self.who.iter().enumerate() {
            let moving = &mut self.moving[local];
            let velocity = moving.velocity();
            let pose = evolve(bodies, i, &bodies.poses[i], &velocity, step);
            bodies.poses[i] = pose;
            let (speed, spin) = match bodies.motions[i] {
                Motion::Static => continue,
                Motion::Kinematic { linear, angular } => (linear.length(), angular.length()),
                Motion::Dynamic => {
                    moving.turn_tensor(bodies, i);
                    let fastest = bodies.inertias[i].inverse_moments.max_element();
                    (velocity.linear.length(), fastest * velocity.angular_momentum.length())
                }
            };
            let size = self.sizes[local];
            let turning = if spin > 0.0 { spin * size } else { 0.0 };
            self.travel[local] += step.dt * (speed + turning);
            let stirred = if size.is_finite() { self.travel[local] / size } else { 0.0 };
            moving.shift_to(&pose, &self.starts[local], stirred);
        }
    }

    /// How far two points of two bodies can have moved relative to each other since the frame's start [m].
    pub(crate) fn travel(&self, pair: [u32; 2]) -> f64 {
        pair.into_iter().map(|local| self.travel[local as usize]).sum()
    }

    /// The bodies get the velocities that they have here.
    pub(crate) fn hand_back(&self, bodies: &mut Bodies) {
        for local in 0..self.who.len() {
            self.hand_back_one(bodies, local as u32);
        }
    }

    /// See [`Self::hand_back`].
    pub(crate) fn hand_back_one(&self, bodies: &mut Bodies, local: u32) {
        let moving = &self.moving[local as usize];
        if moving.is_mobile() {
            bodies.velocities[self.who[local as usize]] = moving.velocity();
        }
    }

    #[inline(always)]
    pub(crate) fn load<I: Instructions>(&self, locals: &[u32; LANES]) -> Side<I> {
        let (mut motions, mut answers) = ([Numbers::ZERO; LANES], [Numbers::ZERO; LANES]);
        for lane in 0..LANES {
            let moving = &self.moving[locals[lane] as usize];
            (motions[lane], answers[lane]) = (moving.motion, moving.answer);
        }
        let [x, y, z, lx, ly, lz, inverse_mass, falls] = Lanes::transposed(motions);
        let [xx, yy, zz, yz, xz, xy, ..] = Lanes::transposed(answers);
        let angular_momentum = Lanes3 { x: lx, y: ly, z: lz };
        let inverse_tensor =
            SymmetricLanes { diagonal: Lanes3 { x: xx, y: yy, z: zz }, off: Lanes3 { x: yz, y: xz, z: xy } };
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
    pub(crate) fn prefetch<I: Instructions>(&self, locals: &[u32; LANES]) {
        for &local in locals {
            I::prefetch(&self.moving[local as usize..][..1]);
        }
    }

    /// No body that can move is in two lanes.
    #[inline(always)]
    pub(crate) fn store<I: Instructions>(&mut self, locals: &[u32; LANES], side: &Side<I>) {
        let Side { linear: v, angular_momentum: l, inverse_mass, falls, .. } = *side;
        let motions = Lanes::rows([v.x, v.y, v.z, l.x, l.y, l.z, inverse_mass, falls]);
        for lane in 0..LANES {
            let moving = &mut self.moving[locals[lane] as usize];
            if moving.is_mobile() {
                moving.motion = motions[lane];
            }
        }
    }

    /// How they have moved since the frame's start.
    #[inline(always)]
    pub(crate) fn shifts<I: Instructions>(&self, locals: &[u32; LANES]) -> Shift<I> {
        let mut shifts = [Numbers::ZERO; LANES];
        for lane in 0..LANES {
            shifts[lane] = self.moving[locals[lane] as usize].shift;
        }
        let [x, y, z, qx, qy, qz, qw, stirred] = Lanes::transposed(shifts);
        Shift { translation: Lanes3 { x, y, z }, rotation: (Lanes3 { x: qx, y: qy, z: qz }, qw), stirred }
    }

    /// Whether impulses move a body.
    pub(crate) fn is_mobile(&self, local: u32) -> bool {
        self.moving[local as usize].is_mobile()
    }

    /// Radius of a ball around a body's centre of mass that holds it [m].
    pub(crate) fn size(&self, local: u32) -> f64 {
        self.sizes[local as usize]
    }

    /// `second_from_first` of a pair at the frame's start.
    pub(crate) fn start_second_from_first(&self, [first, second]: [u32; 2]) -> RigidTransform {
        self.start(second).world_from_body().inverse().after(&self.start(first).world_from_body())
    }

    /// Where a body was at the frame's start.
    pub(crate) fn start(&self, local: u32) -> Pose {
        self.starts[local as usize]
    }
}

impl Moving {
    const NONE: Self = Self {
        motion: Numbers::ZERO,
        answer: Numbers::ZERO,
        shift: Numbers([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
    };

    /// Whether impulses move it.
    #[inline(always)]
    fn is_mobile(&self) -> bool {
        self.motion.0[7] != 0.0
    }

    fn velocity(&self) -> Velocity {
        let Numbers([x, y, z, lx, ly, lz, ..]) = self.motion;
        Velocity { linear: DVec3::new(x, y, z), angular_momentum: DVec3::new(lx, ly, lz) }
    }

    fn turn_tensor(&mut self, bodies: &Bodies, i: usize) {
        let tensor = bodies.inertias[i].inverse_tensor(bodies.poses[i].orientation);
        let [x, y, z] = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
        self.answer = Numbers([x.x, y.y, z.z, z.y, z.x, y.x, 0.0, 0.0]);
    }

    fn shift_to(&mut self, pose: &Pose, start: &Pose, stirred: f64) {
        let translation = pose.position - start.position;
        let DQuat { x, y, z, w } = pose.orientation * start.orientation.conjugate();
        self.shift = Numbers([translation.x, translation.y, translation.z, x, y, z, w, stirred]);
    }
}

impl<I: Instructions> Shift<I> {
    /// What the rotation adds to a lever.
    #[inline(always)]
    pub(crate) fn turn(&self, lever: Lanes3<I>) -> Lanes3<I> {
        let (axis, w) = self.rotation;
        let twice = axis.cross(lever) * Lanes::splat(2.0);
        twice * w + axis.cross(twice)
    }
}

impl<I: Instructions> Side<I> {
    /// Velocity of the material at a lever from the centre of mass [m/s].
    #[inline(always)]
    pub(crate) fn at(&self, lever: Lanes3<I>) -> Lanes3<I> {
        self.linear + self.angular.cross(lever)
    }

    /// An impulse at a lever from the centre of mass.
    #[inline(always)]
    pub(crate) fn push(&mut self, lever: Lanes3<I>, impulse: Lanes3<I>) {
        self.linear = self.linear + impulse * self.inverse_mass;
        self.turn(lever.cross(impulse));
    }

    /// An angular impulse.
    #[inline(always)]
    pub(crate) fn turn(&mut self, angular_impulse: Lanes3<I>) {
        self.angular_momentum = self.angular_momentum + angular_impulse;
        self.angular = self.angular + self.inverse_tensor * angular_impulse;
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
