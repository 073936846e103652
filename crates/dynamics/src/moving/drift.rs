//! Bodies drift: those that turn slowly side by side, the others one after the other.

use super::{Answer, Build, Moved, Movers, Moving, PACE, Seen, TRAVEL, line_of, pose_of, velocity_of};
use crate::evolve::evolve;
use crate::exact_rotation::rotate_slow_ones;
use crate::lanes::{Instructions, LANES, Lanes, Lanes3, Mask, Numbers, Single, Symmetric};
use crate::threads;
use crate::vector::{Turn, Vector};
use crate::{Bodies, Frame, Motion, Rotation, Velocity};
use glam::DVec3;

/// Bodies that go to a thread together, a multiple of [`LANES`]: a hundred kilobytes.
const STRETCH: usize = 256;

/// Some of the bodies of a cluster.
struct Stretch<'a> {
    who: &'a [usize],
    moving: &'a mut [Moving],
    seen: &'a mut [Seen],
    answers: &'a mut [Answer],
    moved: &'a mut [Moved],
    poses: &'a mut [Numbers],
    starts: &'a mut [Numbers],
    builds: &'a mut [Build],
    /// See [`Movers`].
    moment_of_mass: DVec3,
}

impl Movers {
    /// All bodies along their velocities for one substep.
    pub(crate) fn drift<I: Instructions>(&mut self, bodies: &Bodies, step: &Frame) {
        self.rest_drifts(step.dt);
        self.for_each_stretch(|stretch| {
            I::run(
                #[inline(always)]
                || stretch.drift::<I>(bodies, step),
            );
        });
    }

    /// All bodies are as they are at the frame's start.
    pub(super) fn begin<I: Instructions>(&mut self, bodies: &Bodies) {
        self.for_each_stretch(|stretch| {
            stretch.begin(bodies);
            I::run(
                #[inline(always)]
                || stretch.follow_all_poses::<I>(),
            );
        });
    }

    fn for_each_stretch(&mut self, visit: impl Fn(&mut Stretch) + Send + Sync) {
        let lines = self.poses.chunks_mut(STRETCH).zip(self.starts.chunks_mut(STRETCH));
        let lines = lines.zip(self.builds.chunks_mut(STRETCH));
        let seen = self.seen.as_mut_slice().chunks_mut(STRETCH).zip(self.answers.chunks_mut(STRETCH));
        let lines = lines.zip(seen);
        let moving = self.moving.as_mut_slice().chunks_mut(STRETCH).zip(self.moved.chunks_mut(STRETCH));
        let mut stretches: Vec<Stretch> = moving
            .zip(lines)
            .enumerate()
            .map(|(number, ((moving, moved), (((poses, starts), builds), (seen, answers))))| {
                let begin = (number * STRETCH).min(self.who.len());
                let end = (begin + STRETCH).min(self.who.len());
                let who = &self.who[begin..end];
                Stretch {
                    who,
                    moving,
                    seen,
                    answers,
                    moved,
                    poses,
                    starts,
                    builds,
                    moment_of_mass: DVec3::ZERO,
                }
            })
            .collect();
        threads::for_each(&mut stretches, self.who.len(), visit);
        self.moment_of_mass = stretches.iter().map(|stretch| stretch.moment_of_mass).sum();
    }
}

impl Stretch<'_> {
    /// Each body is where it is, as fast as it is.
    fn begin(&mut self, bodies: &Bodies) {
        for (local, &i) in self.who.iter().enumerate() {
            let (inertia, size) = (&bodies.inertias[i], bodies.radii[i]);
            let size = if size.is_finite() { size } else { 0.0 };
            self.poses[local] = line_of(&bodies.poses[i]);
            self.starts[local] = self.poses[local];
            self.starts[local].0[7] = size;
            let DVec3 { x, y, z } = inertia.inverse_moments;
            let mut mass = 0.0;
            if !inertia.is_infinite() {
                let Velocity { linear: v, angular_momentum: l } = bodies.velocities[i];
                self.moving[local] = Numbers([v.x, v.y, v.z, l.x, l.y, l.z, inertia.inverse_mass, 1.0]);
                mass = bodies.masses[i];
            }
            let is_driven = f64::from(u8::from(matches!(bodies.motions[i], Motion::Kinematic { .. })));
            self.builds[local] = Numbers([x, y, z, x.max(y).max(z), 0.0, mass, is_driven, 0.0]);
        }
    }

    /// Moves all bodies, group by group, while their lines are at hand.
    #[inline(always)]
    fn drift<I: Instructions>(&mut self, bodies: &Bodies, step: &Frame) {
        let mut moment_of_mass = Lanes3::<I>::ZERO;
        for begin in (0..self.poses.len()).step_by(LANES) {
            let others = self.drift_slowly::<I>(begin, step);
            if others.any() {
                self.drift_others((begin, others), bodies, step);
            }
            moment_of_mass = moment_of_mass + self.follow_poses(begin, step.dt);
        }
        self.moment_of_mass = moment_of_mass.sum();
    }

    /// What depends on the poses, at the frame's start.
    #[inline(always)]
    fn follow_all_poses<I: Instructions>(&mut self) {
        let mut moment_of_mass = Lanes3::<I>::ZERO;
        for begin in (0..self.poses.len()).step_by(LANES) {
            moment_of_mass = moment_of_mass + self.follow_poses(begin, 0.0);
        }
        self.moment_of_mass = moment_of_mass.sum();
    }

    /// Moves those of a group that turn slowly, by [`rotate_slow_ones`]; which the others are.
    #[inline(always)]
    fn drift_slowly<I: Instructions>(&mut self, begin: usize, step: &Frame) -> Mask {
        let [x, y, z, lx, ly, lz, ..] = lanes_of::<I>(self.moving, begin);
        let [px, py, pz, qx, qy, qz, qw, _] = lanes_of::<I>(self.poses, begin);
        let [ix, iy, iz, fastest, _, _, is_driven, _] = lanes_of::<I>(self.builds, begin);
        let orientation = Turn { vector: Lanes3 { x: qx, y: qy, z: qz }, scalar: qw };
        let momentum = Lanes3 { x: lx, y: ly, z: lz };
        let moments = Lanes3 { x: ix, y: iy, z: iz };
        let (turned, is_slow) = rotate_slow_ones(orientation, momentum, (moments, fastest), step.dt);

        // The others wait.
        let is_exact = step.settings.rotation == Rotation::Exact;
        let goes = if is_exact { is_slow.and(is_driven.above(Lanes::ZERO).not()) } else { Mask::NONE };
        let Lanes3 { x: tx, y: ty, z: tz } = goes.select(turned.vector, orientation.vector);
        let (linear, position) = (Lanes3 { x, y, z }, Lanes3 { x: px, y: py, z: pz });
        let Lanes3 { x: px, y: py, z: pz } = goes.select(position + linear * Lanes::splat(step.dt), position);
        let poses = Lanes::rows([px, py, pz, tx, ty, tz, goes.select(turned.scalar, qw), Lanes::ZERO]);
        self.poses[begin..begin + LANES].copy_from_slice(&poses);
        goes.not()
    }

    /// Moves those of a group that turn fast, or as they are told.
    #[cold]
    fn drift_others(&mut self, (begin, others): (usize, Mask), bodies: &Bodies, step: &Frame) {
        let end = (begin + LANES).min(self.who.len());
        for local in (begin..end).filter(|local| others.get(local - begin)) {
            let (i, velocity) = (self.who[local], velocity_of(&self.moving[local]));
            let pose = evolve(bodies, i, &pose_of(&self.poses[local]), &velocity, step);
            self.poses[local] = line_of(&pose);
            if let Motion::Kinematic { linear, angular } = bodies.motions[i] {
                let turning = if angular == DVec3::ZERO { 0.0 } else { angular.length() * bodies.radii[i] };
                self.builds[local].0[TRAVEL] += step.dt * (linear.length() + turning);
            }
        }
    }

    /// What depends on the poses of a group, `dt` [s] after they were others; its moment of mass.
    #[inline(always)]
    fn follow_poses<I: Instructions>(&mut self, begin: usize, dt: f64) -> Lanes3<I> {
        let [x, y, z, lx, ly, lz, inverse_mass, _] = lanes_of::<I>(self.moving, begin);
        let [px, py, pz, qx, qy, qz, qw, _] = lanes_of::<I>(self.poses, begin);
        let [sx, sy, sz, rx, ry, rz, rw, size] = lanes_of::<I>(self.starts, begin);
        let [ix, iy, iz, fastest, travel, mass, ..] = lanes_of::<I>(self.builds, begin);
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
        let tensor = Symmetric {
            diagonal: Lanes3 { x: by_x.dot(row_x), y: by_y.dot(row_y), z: by_z.dot(row_z) },
            off: Lanes3 { x: by_y.dot(row_z), y: by_x.dot(row_z), z: by_x.dot(row_y) },
        };

        // What contacts see.
        let (linear, momentum) = (Lanes3 { x, y, z }, Lanes3 { x: lx, y: ly, z: lz });
        let (v, w) = (linear.single(), (tensor * momentum).single());
        let Symmetric { diagonal: d, off } = tensor.single();
        let (inverse_mass, pace, none) = (inverse_mass.single(), self.paces(begin), Single::ZERO);
        let seen = Single::rows([v.x, v.y, v.z, w.x, w.y, w.z, inverse_mass, pace]);
        let answers = Single::rows([d.x, d.y, d.z, off.x, off.y, off.z, none, none]);

        // How far it has come.
        let speed = linear.dot(linear).sqrt() + fastest * momentum.dot(momentum).sqrt() * size;
        let travel = travel + Lanes::splat(dt) * speed;
        let stirred = size.above(Lanes::ZERO).select(travel / size, Lanes::ZERO);
        let turned = orientation.after(start.back());
        let Lanes3 { x: tx, y: ty, z: tz } = turned.vector;
        let shifts = Lanes::rows([px - sx, py - sy, pz - sz, tx, ty, tz, turned.scalar, stirred]);
        for lane in 0..LANES {
            self.seen[begin + lane] = seen[lane];
            self.answers[begin + lane] = answers[lane];
            self.moved[begin + lane] = shifts[lane];
            self.builds[begin + lane].0[TRAVEL] = travel.get(lane);
        }
        Lanes3 { x: px, y: py, z: pz } * mass
    }

    /// How fast those of a group are seen to be.
    #[inline(always)]
    fn paces<I: Instructions>(&self, begin: usize) -> Single<I> {
        let mut paces = Single::ZERO;
        for lane in 0..LANES {
            paces.set(lane, f64::from(self.seen[begin + lane].0[PACE]));
        }
        paces
    }
}

#[inline(always)]
fn lanes_of<I: Instructions>(lines: &[Numbers], begin: usize) -> [Lanes<I>; LANES] {
    let mut group = [Numbers::ZERO; LANES];
    group.copy_from_slice(&lines[begin..begin + LANES]);
    Lanes::transposed(group)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::evolve::evolve_all;
    use crate::exact_rotation::SLOW;
    use crate::instructions::Scalar;
    use crate::lanes::Singles;
    use crate::{Contactant, NewBody, Pose, StepSettings, Velocity, Width};
    use frangible_geometry::{ClosedForm, Shape};
    use glam::DQuat;
    use std::sync::Arc;

    /// Bodies go the same way side by side as one after the other, to the bit, whether they turn slowly, fast, or as they are told; and
    /// their tensors and shifts are those of their poses.
    #[test]
    fn bodies_go_as_each_would_alone() {
        let settings = StepSettings { rotation: Rotation::Exact, ..StepSettings::default() };
        let frame = Frame { dt: 1.0 / 240.0, gravity: -9.81 * DVec3::Y, settings };
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
        let alone = &bodies;
        for width in [Width::Scalar, Width::Sse2, Width::Avx2, Width::Avx512] {
            let frame = Frame { settings: StepSettings { width, ..frame.settings }, ..frame };
            let ends = evolve_all(alone, &alone.poses, &alone.velocities, &frame);
            for (i, end) in ends.iter().enumerate() {
                assert_eq!(*end, evolve(alone, i, &alone.poses[i], &alone.velocities[i], &frame), "{i}");
            }
        }
        let mut movers = Movers::new::<Scalar>(&bodies, (0..bodies.len()).collect());
        for _ in 0..3 {
            movers.drift::<Scalar>(&bodies, &frame);
        }
        let mut fast = 0;
        for i in 0..bodies.len() {
            let velocity = alone.velocities[i];
            let end = (0..3).fold(alone.poses[i], |pose, _| evolve(alone, i, &pose, &velocity, &frame));
            assert_eq!(movers.pose(i as u32), end, "body {i}");
            let rate = alone.inertias[i].inverse_moments.max_element() * velocity.angular_momentum.length();
            fast += usize::from(frame.dt * rate > SLOW);

            let tensor = alone.inertias[i].inverse_tensor(end.orientation);
            let Singles([xx, yy, zz, yz, xz, xy, ..]) = movers.answers[i];
            let scale = 1e-7 * alone.inertias[i].inverse_moments.max_element();
            let entries = [(xx, 0, 0), (yy, 1, 1), (zz, 2, 2), (yz, 1, 2), (xz, 0, 2), (xy, 0, 1)];
            for (entry, row, column) in entries {
                assert!((f64::from(entry) - tensor.col(column)[row]).abs() <= scale, "body {i}");
            }
            let is_mobile = alone.motions[i] == Motion::Dynamic;
            let spin = alone.inertias[i].angular_velocity(end.orientation, velocity.angular_momentum);
            let expected = if is_mobile { (velocity.linear, spin) } else { (DVec3::ZERO, DVec3::ZERO) };
            let rates = movers.rates(i as u32);
            assert_eq!(rates.0, expected.0, "body {i}");
            assert!((rates.1 - expected.1).length() <= 2e-7 * spin.length(), "body {i}");
            let lever = DVec3::new(0.1, 0.2, 0.3);
            let Numbers([x, y, z, qx, qy, qz, qw, _]) = movers.moved[i];
            let moved = DVec3::new(x, y, z) + DQuat::from_xyzw(qx, qy, qz, qw) * lever;
            let turn = end.orientation * alone.poses[i].orientation.conjugate();
            let expected = end.position - alone.poses[i].position + turn * lever;
            assert!((moved - expected).length() < 1e-13, "body {i}");
        }
        assert!(fast > 2 && fast < 12, "{fast} turn fast");
    }
}
