//! The bodies of a cluster as the substeps' solver moves them: velocities, and how they answer impulses.

use crate::detection::radius;
use crate::evolve::evolve;
use crate::exact_rotation::{NO_MOMENTUM, NO_TURN, SLOW, rotate_slowly};
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask, Numbers, SymmetricLanes};
use crate::rotation::rotation_by;
use crate::vector::{Turn, Vector};
use crate::{Bodies, Frame, Motion, Pose, Rotation, Velocity};
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

/// What a body is like, and how far it has come, as a line: inverse principal moments of inertia, and the largest of them
/// [1/(kg m^2)]; radius of a ball around the centre of mass that holds it, 0 if it is infinite [m]; how far any of its points can have moved
/// since the frame's start [m]; its mass if impulses move it [kg].
type Build = Numbers;

/// Places in a [`Build`].
const FASTEST: usize = 3;
const SIZE: usize = 4;
const TRAVEL: usize = 5;

/// The bodies of a cluster.
pub(crate) struct Movers {
    /// Dense indices.
    pub(crate) who: Vec<usize>,
    /// In the same order, and then one that never moves, for the lanes that hold none.
    moving: Vec<Moving>,
    /// Positions and orientations, now and at the frame's start.
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
    pub(crate) inverse_tensor: SymmetricLanes<I>,
    /// 1 for what falls, else 0.
    pub(crate) falls: Lanes<I>,
}

/// How some bodies have moved since the frame's start.
pub(crate) struct Shift<I: Instructions> {
    pub(crate) translation: Lanes3<I>,
    pub(crate) rotation: Turn<Lanes3<I>>,
    /// How far any of their points can have moved, relative to their sizes [1].
    pub(crate) stirred: Lanes<I>,
}

impl Movers {
    /// Of bodies that have not moved yet in this frame.
    pub(crate) fn new<I: Instructions>(bodies: &Bodies, who: Vec<usize>) -> Self {
        let lines = (who.len() + 1).next_multiple_of(LANES);
        let still = line_of(&Pose { position: DVec3::ZERO, orientation: DQuat::IDENTITY });
        let mut movers = Self {
            moving: vec![Moving::NONE; lines],
            poses: vec![still; lines],
            starts: Vec::new(),
            builds: vec![Numbers::ZERO; lines],
            mass: 0.0,
            moment_of_mass: DVec3::ZERO,
            who,
            gravity: (DVec3::ZERO, DVec3::ZERO),
        };
        for (local, &i) in movers.who.iter().enumerate() {
            let (inertia, size) = (&bodies.inertias[i], radius(&bodies.shapes[i]));
            let size = if size.is_finite() { size } else { 0.0 };
            movers.poses[local] = line_of(&bodies.poses[i]);
            let DVec3 { x, y, z } = inertia.inverse_moments;
            let mut mass = 0.0;
            if !inertia.is_infinite() {
                let Velocity { linear: v, angular_momentum: l } = bodies.velocities[i];
                movers.moving[local].motion =
                    Numbers([v.x, v.y, v.z, l.x, l.y, l.z, inertia.inverse_mass, 1.0]);
                mass = bodies.masses[i];
                movers.mass += mass;
            }
            movers.builds[local] = Numbers([x, y, z, x.max(y).max(z), size, 0.0, mass, 0.0]);
        }
        movers.starts.clone_from(&movers.poses);
        I::run(
            #[inline(always)]
            || movers.follow_poses::<I>(0.0),
        );
        movers
    }

    /// Stands for no body.
    pub(crate) fn nobody(&self) -> u32 {
        self.who.len() as u32
    }

    /// Half a substep of gravity.
    pub(crate) fn kick(&mut self, step: &Frame) {
        let gain = 0.5 * step.dt * step.gravity;
        for moving in &mut self.moving {
            if moving.is_mobile() {
                let Numbers([x, y, z, ..]) = &mut moving.motion;
                (*x, *y, *z) = (*x + gain.x, *y + gain.y, *z + gain.z);
            }
        }
        self.gravity.0 += self.mass * gain;
        self.gravity.1 += self.moment_of_mass.cross(gain);
    }

    /// All bodies along their velocities for one substep: those that turn slowly side by side, the others one after the other.
    pub(crate) fn drift<I: Instructions>(&mut self, bodies: &mut Bodies, step: &Frame) {
        I::run(
            #[inline(always)]
            || self.drift_slowly::<I>(step),
        );
        for (local, &i) in self.who.iter().enumerate() {
            let is_driven = matches!(bodies.motions[i], Motion::Kinematic { .. });
            let momentum = self.moving[local].velocity().angular_momentum;
            let angle = step.dt * self.builds[local].0[FASTEST] * momentum.length();
            let is_slow = step.settings.rotation == Rotation::Exact && angle < SLOW;
            if is_driven || !is_slow {
                let pose =
                    evolve(bodies, i, &pose_of(&self.poses[local]), &self.moving[local].velocity(), step);
                self.poses[local] = line_of(&pose);
            }
            if let Motion::Kinematic { linear, angular } = bodies.motions[i] {
                let turning =
                    if angular == DVec3::ZERO { 0.0 } else { angular.length() * radius(&bodies.shapes[i]) };
                self.builds[local].0[TRAVEL] += step.dt * (linear.length() + turning);
            }
            if bodies.motions[i] != Motion::Static {
                bodies.poses[i] = pose_of(&self.poses[local]);
            }
        }
        I::run(
            #[inline(always)]
            || self.follow_poses::<I>(step.dt),
        );
    }

    /// Moves bodies that turn slowly, by [`rotate_slowly`].
    #[inline(always)]
    fn drift_slowly<I: Instructions>(&mut self, step: &Frame) {
        let (dt, one) = (Lanes::<I>::splat(step.dt), Lanes::splat(1.0));
        let is_exact = step.settings.rotation == Rotation::Exact;
        for begin in (0..self.poses.len()).step_by(LANES) {
            let [x, y, z, lx, ly, lz, ..] = self.motions::<I>(begin);
            let [px, py, pz, qx, qy, qz, qw, _] = lanes_of::<I>(&self.poses, begin);
            let [ix, iy, iz, fastest, ..] = lanes_of::<I>(&self.builds, begin);
            let momentum = Lanes3 { x: lx, y: ly, z: lz };
            let magnitude = momentum.dot(momentum).sqrt();
            let angle = dt * fastest * magnitude;
            let rests = Lanes::splat(NO_TURN).above(angle).or(Lanes::splat(NO_MOMENTUM).above(magnitude));
            let direction = momentum * (one / magnitude);
            let rates = Lanes3 { x: ix, y: iy, z: iz } * (one / fastest);
            let orientation = Turn { vector: Lanes3 { x: qx, y: qy, z: qz }, scalar: qw };
            let Turn { vector, scalar } = rotate_slowly(orientation, (direction, rates), angle);
            let turned = rests.select3(orientation.vector, vector);
            let scalar = rests.select(qw, scalar);

            // The others wait.
            let goes = if is_exact { Lanes::splat(SLOW).above(angle) } else { Mask::NONE };
            let Lanes3 { x: tx, y: ty, z: tz } = goes.select3(turned, orientation.vector);
            let (linear, position) = (Lanes3 { x, y, z }, Lanes3 { x: px, y: py, z: pz });
            let Lanes3 { x: px, y: py, z: pz } = goes.select3(position + linear * dt, position);
            let poses = Lanes::rows([px, py, pz, tx, ty, tz, goes.select(scalar, qw), Lanes::ZERO]);
            self.poses[begin..begin + LANES].copy_from_slice(&poses);
        }
    }

    /// What depends on the poses, `dt` [s] after they were others.
    #[inline(always)]
    fn follow_poses<I: Instructions>(&mut self, dt: f64) {
        let mut moment_of_mass = Lanes3::<I>::ZERO;
        for begin in (0..self.poses.len()).step_by(LANES) {
            let [x, y, z, lx, ly, lz, ..] = self.motions::<I>(begin);
            let [px, py, pz, qx, qy, qz, qw, _] = lanes_of::<I>(&self.poses, begin);
            let [sx, sy, sz, rx, ry, rz, rw, _] = lanes_of::<I>(&self.starts, begin);
            let [ix, iy, iz, fastest, size, travel, mass, _] = lanes_of::<I>(&self.builds, begin);
            let orientation = Turn { vector: Lanes3 { x: qx, y: qy, z: qz }, scalar: qw };
            let start = Turn { vector: Lanes3 { x: rx, y: ry, z: rz }, scalar: rw };

            // The inverse tensor: a sum over the principal axes in the world.
            let rates = Lanes3 { x: ix, y: iy, z: iz };
            let a = orientation.turn(Lanes3::splat(DVec3::X));
            let b = orientation.turn(Lanes3::splat(DVec3::Y));
            let c = orientation.turn(Lanes3::splat(DVec3::Z));
            let (row_x, row_y, row_z) = (
                Lanes3 { x: a.x, y: b.x, z: c.x },
                Lanes3 { x: a.y, y: b.y, z: c.y },
                Lanes3 { x: a.z, y: b.z, z: c.z },
            );
            let (by_x, by_y, by_z) = (rates.times(row_x), rates.times(row_y), rates.times(row_z));
            let answers = Lanes::rows([
                by_x.dot(row_x),
                by_y.dot(row_y),
                by_z.dot(row_z),
                by_y.dot(row_z),
                by_x.dot(row_z),
                by_x.dot(row_y),
                Lanes::ZERO,
                Lanes::ZERO,
            ]);

            // How far it has come.
            let (linear, momentum) = (Lanes3 { x, y, z }, Lanes3 { x: lx, y: ly, z: lz });
            let speed = linear.dot(linear).sqrt() + fastest * momentum.dot(momentum).sqrt() * size;
            let travel = travel + Lanes::splat(dt) * speed;
            let stirred = size.above(Lanes::ZERO).select(travel / size, Lanes::ZERO);
            let turned = orientation.after(start.back());
            let Lanes3 { x: tx, y: ty, z: tz } = turned.vector;
            let shifts = Lanes::rows([px - sx, py - sy, pz - sz, tx, ty, tz, turned.scalar, stirred]);
            moment_of_mass = moment_of_mass + Lanes3 { x: px, y: py, z: pz } * mass;
            for lane in 0..LANES {
                let moving = &mut self.moving[begin + lane];
                (moving.answer, moving.shift) = (answers[lane], shifts[lane]);
                self.builds[begin + lane].0[TRAVEL] = travel.get(lane);
            }
        }
        self.moment_of_mass = moment_of_mass.sum();
    }

    #[inline(always)]
    fn motions<I: Instructions>(&self, begin: usize) -> [Lanes<I>; LANES] {
        let mut motions = [Numbers::ZERO; LANES];
        for lane in 0..LANES {
            motions[lane] = self.moving[begin + lane].motion;
        }
        Lanes::transposed(motions)
    }

    /// How far two points of two bodies can have moved relative to each other since the frame's start [m].
    pub(crate) fn travel(&self, pair: [u32; 2]) -> f64 {
        pair.into_iter().map(|local| self.builds[local as usize].0[TRAVEL]).sum()
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
        Shift {
            translation: Lanes3 { x, y, z },
            rotation: Turn { vector: Lanes3 { x: qx, y: qy, z: qz }, scalar: qw },
            stirred,
        }
    }

    /// Whether impulses move a body.
    pub(crate) fn is_mobile(&self, local: u32) -> bool {
        self.moving[local as usize].is_mobile()
    }

    /// Radius of a ball around a body's centre of mass that holds it [m]; 0 if it is infinite.
    pub(crate) fn size(&self, local: u32) -> f64 {
        self.builds[local as usize].0[SIZE]
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
}

fn line_of(pose: &Pose) -> Numbers {
    let (DVec3 { x, y, z }, q) = (pose.position, pose.orientation);
    Numbers([x, y, z, q.x, q.y, q.z, q.w, 0.0])
}

fn pose_of(line: &Numbers) -> Pose {
    let Numbers([x, y, z, qx, qy, qz, qw, _]) = *line;
    Pose { position: DVec3::new(x, y, z), orientation: DQuat::from_xyzw(qx, qy, qz, qw) }
}

#[inline(always)]
fn lanes_of<I: Instructions>(lines: &[Numbers], begin: usize) -> [Lanes<I>; LANES] {
    let mut rows = [Numbers::ZERO; LANES];
    rows.copy_from_slice(&lines[begin..begin + LANES]);
    Lanes::transposed(rows)
}

impl<I: Instructions> Shift<I> {
    /// What the rotation adds to a lever.
    #[inline(always)]
    pub(crate) fn turn(&self, lever: Lanes3<I>) -> Lanes3<I> {
        let Turn { vector: axis, scalar: w } = self.rotation;
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instructions::Scalar;
    use crate::{Contactant, NewBody, StepSettings};
    use frangible_geometry::{ClosedForm, Shape};
    use std::sync::Arc;

    /// Bodies go the same way side by side as one after the other, to the bit, whether they turn slowly, fast, or as they are told; and
    /// their tensors and shifts are those of their poses.
    #[test]
    fn bodies_go_as_each_would_alone() {
        let frame = Frame { dt: 1.0 / 240.0, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let mut bodies = Bodies::default();
        for k in 0..21 {
            let s = f64::from(k);
            let motion = match k {
                3 => Motion::Static,
                5 => Motion::Kinematic { linear: DVec3::X, angular: DVec3::new(0.3, 2.0, -1.0) },
                _ => Motion::Dynamic,
            };
            // From rest to 30 rad/s.
            let spin = if k % 4 == 0 { 0.0 } else { 1e-4 * 1.9_f64.powf(s) };
            let half = DVec3::new(0.1, 0.2, 0.3 + 0.01 * s);
            let mass = 8.0 * half.element_product() * 1000.0;
            bodies.spawn(NewBody {
                shape: Arc::new(Shape::closed_form(ClosedForm::Box { half }, 0.1)),
                density: 1000.0,
                motion,
                pose: Pose {
                    position: DVec3::new(s, 0.1 * s * s, 3.0),
                    orientation: DQuat::from_scaled_axis(DVec3::new(0.1 * s, 0.5, -0.2 * s)),
                },
                velocity: Velocity {
                    linear: DVec3::new(0.1 * s, -1.0, 0.3),
                    angular_momentum: mass * 0.05 * spin * DVec3::new(1.0, -0.5, 0.3),
                },
                contactant: Contactant::new(0.0, 0.5),
            });
        }
        let alone = bodies.clone();
        let mut movers = Movers::new::<Scalar>(&bodies, (0..bodies.len()).collect());
        for _ in 0..3 {
            movers.drift::<Scalar>(&mut bodies, &frame);
        }
        let mut fast = 0;
        for i in 0..bodies.len() {
            let velocity = alone.velocities[i];
            let end = (0..3).fold(alone.poses[i], |pose, _| evolve(&alone, i, &pose, &velocity, &frame));
            assert_eq!(bodies.poses[i], end, "body {i}");
            let rate = alone.inertias[i].inverse_moments.max_element() * velocity.angular_momentum.length();
            fast += usize::from(frame.dt * rate > SLOW);

            let tensor = alone.inertias[i].inverse_tensor(end.orientation);
            let Numbers([xx, yy, zz, yz, xz, xy, ..]) = movers.moving[i].answer;
            let scale = 1e-14 * alone.inertias[i].inverse_moments.max_element();
            let entries = [(xx, 0, 0), (yy, 1, 1), (zz, 2, 2), (yz, 1, 2), (xz, 0, 2), (xy, 0, 1)];
            for (entry, row, column) in entries {
                assert!((entry - tensor.col(column)[row]).abs() <= scale, "body {i}");
            }
            let lever = DVec3::new(0.1, 0.2, 0.3);
            let Numbers([x, y, z, qx, qy, qz, qw, _]) = movers.moving[i].shift;
            let moved = DVec3::new(x, y, z) + DQuat::from_xyzw(qx, qy, qz, qw) * lever;
            let turn = end.orientation * alone.poses[i].orientation.conjugate();
            let expected = end.position - alone.poses[i].position + turn * lever;
            assert!((moved - expected).length() < 1e-13, "body {i}");
        }
        assert!(fast > 2 && fast < 12, "{fast} turn fast");
    }
}
