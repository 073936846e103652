//! The bodies of a cluster as the substeps' solver moves them: velocities, and how they answer impulses.

use crate::detection::radius;
use crate::evolve::evolve;
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, SymmetricLanes};
use crate::rotation::rotation_by;
use crate::{Bodies, Frame, Motion, Velocity};
use glam::{DMat3, DVec3};

/// A body's velocities, and how they answer impulses at its present pose. All zero for a static or kinematic body, whose motion is
/// in the rows' drives.
#[derive(Clone, Copy, Default)]
#[repr(C, align(64))]
pub(crate) struct Moving {
    /// [m/s]
    linear: DVec3,
    /// [kg m^2/s]
    angular_momentum: DVec3,
    /// Inverse of the inertia tensor in the world frame, its diagonal and the entries yz, xz and xy [1/(kg m^2)].
    inverse_tensor: [DVec3; 2],
    /// [1/kg]
    inverse_mass: f64,
    /// Whether impulses move it.
    is_mobile: bool,
}

/// The bodies of a cluster.
pub(crate) struct Movers {
    /// Dense indices.
    pub(crate) who: Vec<usize>,
    /// In the same order, and then one that never moves, for the lanes that hold none.
    moving: Vec<Moving>,
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

impl Movers {
    pub(crate) fn new(bodies: &Bodies, who: Vec<usize>) -> Self {
        let mut movers = Self {
            moving: vec![Moving::default(); who.len() + 1],
            travel: vec![0.0; who.len()],
            who,
            gravity: (DVec3::ZERO, DVec3::ZERO),
        };
        for (moving, &i) in movers.moving.iter_mut().zip(&movers.who) {
            if !bodies.inertias[i].is_infinite() {
                let Velocity { linear, angular_momentum } = bodies.velocities[i];
                let inverse_mass = bodies.inertias[i].inverse_mass;
                *moving =
                    Moving { linear, angular_momentum, inverse_mass, is_mobile: true, ..Moving::default() };
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
            if moving.is_mobile {
                moving.linear += gain;
                self.gravity.0 += bodies.masses[i] * gain;
                self.gravity.1 += bodies.poses[i].position.cross(bodies.masses[i] * gain);
            }
        }
    }

    /// All bodies along their velocities for one substep.
    pub(crate) fn drift(&mut self, bodies: &mut Bodies, step: &Frame) {
        for ((moving, travel), &i) in self.moving.iter_mut().zip(&mut self.travel).zip(&self.who) {
            let velocity = moving.velocity();
            bodies.poses[i] = evolve(bodies, i, &bodies.poses[i], &velocity, step);
            let (speed, spin) = match bodies.motions[i] {
                Motion::Static => continue,
                Motion::Kinematic { linear, angular } => (linear.length(), angular.length()),
                Motion::Dynamic => {
                    moving.turn_tensor(bodies, i);
                    let fastest = bodies.inertias[i].inverse_moments.max_element();
                    (velocity.linear.length(), fastest * velocity.angular_momentum.length())
                }
            };
            let turning = if spin > 0.0 { spin * radius(&bodies.shapes[i]) } else { 0.0 };
            *travel += step.dt * (speed + turning);
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
        if moving.is_mobile {
            bodies.velocities[self.who[local as usize]] = moving.velocity();
        }
    }

    #[inline(always)]
    pub(crate) fn load<I: Instructions>(&self, locals: &[u32; LANES]) -> Side<I> {
        let of = |lane: usize| &self.moving[locals[lane] as usize];
        let angular_momentum = Lanes3::of(|lane| of(lane).angular_momentum);
        let inverse_tensor = SymmetricLanes {
            diagonal: Lanes3::of(|lane| of(lane).inverse_tensor[0]),
            off: Lanes3::of(|lane| of(lane).inverse_tensor[1]),
        };
        Side {
            linear: Lanes3::of(|lane| of(lane).linear),
            angular: inverse_tensor * angular_momentum,
            angular_momentum,
            inverse_mass: Lanes::of(|lane| of(lane).inverse_mass),
            inverse_tensor,
            falls: Lanes::of(|lane| f64::from(u8::from(of(lane).is_mobile))),
        }
    }

    /// No body that can move is in two lanes.
    #[inline(always)]
    pub(crate) fn store<I: Instructions>(&mut self, locals: &[u32; LANES], side: &Side<I>) {
        for lane in 0..LANES {
            let moving = &mut self.moving[locals[lane] as usize];
            if moving.is_mobile {
                moving.linear = side.linear.get(lane);
                moving.angular_momentum = side.angular_momentum.get(lane);
            }
        }
    }
}

impl Moving {
    fn velocity(&self) -> Velocity {
        Velocity { linear: self.linear, angular_momentum: self.angular_momentum }
    }

    fn turn_tensor(&mut self, bodies: &Bodies, i: usize) {
        let tensor = bodies.inertias[i].inverse_tensor(bodies.poses[i].orientation);
        let [x, y, z] = [tensor.x_axis, tensor.y_axis, tensor.z_axis];
        self.inverse_tensor = [DVec3::new(x.x, y.y, z.z), DVec3::new(z.y, z.x, y.x)];
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

    /// Change of the velocity at a lever along `axis` per impulse along it, times the axis' length squared [1/kg].
    #[inline(always)]
    pub(crate) fn answer(&self, lever: Lanes3<I>, axis: Lanes3<I>) -> Lanes<I> {
        let turn = lever.cross(axis);
        self.inverse_mass * axis.dot(axis) + turn.dot(self.inverse_tensor * turn)
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
