//! Where bodies get to in one frame at a given velocity.

use crate::bodies::{Bodies, Motion};
use crate::frame::{Frame, Rotation};
use crate::free_flight::exact_rotation::rotate_slow_ones;
use crate::free_flight::rotation;
use crate::state::{Pose, Velocity};
use frangible_math::{
    Instructions, Kernel, LANES, Lanes, Lanes3, Numbers, Turn, threads, with_widest,
};
use glam::{DQuat, DVec3};

/// Pose of body `i` one frame after `pose`, at a constant linear velocity and torque-free [Su09
/// sec. 2].
#[inline]
pub fn evolve(bodies: &Bodies, i: usize, pose: &Pose, velocity: &Velocity, frame: &Frame) -> Pose {
    match bodies.motions[i] {
        Motion::Static => *pose,
        Motion::Kinematic { linear, angular } => Pose {
            position: pose.position + frame.dt * linear,
            orientation: (rotation::rotation_by(frame.dt * angular) * pose.orientation).normalize(),
        },
        Motion::Dynamic => rotation::advance(
            pose,
            velocity,
            &bodies.inertias[i],
            frame.dt,
            frame.settings.rotation,
        ),
    }
}

/// Bodies that a thread evolves together, a multiple of [`LANES`]: some microseconds of work.
const SHARE: usize = 256;

/// [`evolve`] for all bodies: `poses` and `velocities` may belong to different time levels.
pub fn evolve_all(
    bodies: &Bodies,
    poses: &[Pose],
    velocities: &[Velocity],
    frame: &Frame,
) -> Vec<Pose> {
    let all: Vec<usize> = (0..bodies.len()).collect();
    evolve_these(bodies, &all, (poses, velocities), frame)
}

/// [`evolve`] for some bodies.
pub fn evolve_these(
    bodies: &Bodies,
    body_indices: &[usize],
    (poses, velocities): (&[Pose], &[Velocity]),
    frame: &Frame,
) -> Vec<Pose> {
    let of_share = |body_indices: &[usize]| {
        let kernel = EvolveSome { bodies, body_indices, poses, velocities, frame };
        with_widest(frame.settings.width, kernel)
    };
    threads::map(body_indices.chunks(SHARE).collect(), body_indices.len(), of_share).concat()
}

/// [`evolve`] for some bodies, those that turn slowly side by side.
struct EvolveSome<'a> {
    bodies: &'a Bodies,
    body_indices: &'a [usize],
    poses: &'a [Pose],
    velocities: &'a [Velocity],
    frame: &'a Frame,
}

impl Kernel for EvolveSome<'_> {
    type Output = Vec<Pose>;

    fn compute<I: Instructions>(self) -> Vec<Pose> {
        let Self { bodies, body_indices, poses, velocities, frame } = self;
        let mut ends: Vec<Pose> = body_indices.iter().map(|&i| poses[i]).collect();
        I::run(
            #[inline(always)]
            || {
                for (ends, body_indices) in ends.chunks_mut(LANES).zip(body_indices.chunks(LANES)) {
                    // Bodies that do not turn, in the lanes that hold none.
                    let (mut motions, mut turns) = ([Numbers::ZERO; LANES], [Numbers::ZERO; LANES]);
                    for (lane, (pose, &i)) in ends.iter().zip(body_indices).enumerate() {
                        let (l, q) = (velocities[i].angular_momentum, pose.orientation);
                        let m = bodies.inertias[i].inverse_moments;
                        motions[lane] =
                            Numbers([l.x, l.y, l.z, m.x, m.y, m.z, m.max_element(), 0.0]);
                        turns[lane] = Numbers([q.x, q.y, q.z, q.w, 0.0, 0.0, 0.0, 0.0]);
                    }
                    let [x, y, z, mx, my, mz, fastest, _] = Lanes::<I>::transposed(motions);
                    let [qx, qy, qz, scalar, ..] = Lanes::transposed(turns);
                    let orientation = Turn { vector: Lanes3 { x: qx, y: qy, z: qz }, scalar };
                    let moments = (Lanes3 { x: mx, y: my, z: mz }, fastest);
                    let (turned, is_slow) =
                        rotate_slow_ones(orientation, Lanes3 { x, y, z }, moments, frame.dt);
                    let Lanes3 { x: qx, y: qy, z: qz } = turned.vector;
                    let zero = Lanes::ZERO;
                    let turned = Lanes::rows([qx, qy, qz, turned.scalar, zero, zero, zero, zero]);
                    let is_exact = frame.settings.rotation == Rotation::Exact;
                    for (lane, (end, &i)) in ends.iter_mut().zip(body_indices).enumerate() {
                        let Numbers([x, y, z, w, ..]) = turned[lane];
                        if is_exact && is_slow.get(lane) && bodies.motions[i] == Motion::Dynamic {
                            let position = end.position + frame.dt * velocities[i].linear;
                            *end = Pose { position, orientation: DQuat::from_xyzw(x, y, z, w) };
                        } else {
                            *end = evolve(bodies, i, end, &velocities[i], frame);
                        }
                    }
                }
            },
        );
        ends
    }
}

/// Velocities after `duration` [s] of gravity alone; bodies of infinite mass do not fall.
pub fn accelerate(
    bodies: &Bodies,
    velocities: &[Velocity],
    duration: f64,
    frame: &Frame,
) -> Vec<Velocity> {
    velocities
        .iter()
        .zip(&bodies.inertias)
        .map(|(velocity, inertia)| {
            let gain = if inertia.is_infinite() { DVec3::ZERO } else { duration * frame.gravity };
            Velocity { linear: velocity.linear + gain, ..*velocity }
        })
        .collect()
}

/// x^{n+1} at v^{n+1/2}: half of the frame's gravity, which is what the position update feels
/// [SSF08].
pub fn predict(bodies: &Bodies, frame: &Frame) -> Vec<Pose> {
    let half = accelerate(bodies, &bodies.velocities, 0.5 * frame.dt, frame);
    evolve_all(bodies, &bodies.poses, &half, frame)
}

/// A velocity after half of the frame's gravity.
#[inline]
pub fn half_fallen(velocity: Velocity, frame: &Frame) -> Velocity {
    Velocity { linear: velocity.linear + 0.5 * frame.dt * frame.gravity, ..velocity }
}
