//! Energy and momentum of all dynamic bodies, and what the outside has to do with their change.

use crate::report::{Causes, Energy, Momentum};
use frangible_bodies::{Bodies, Frame, Pose};
use frangible_dynamics::FrameAccounts;
use frangible_math::check::{Check, Checked, finite, finite_vector};
use frangible_math::threads;
use glam::DVec3;
use serde::{Deserialize, Serialize};
use std::ops::Range;

/// Bodies that a thread sums up together: some ten microseconds of work.
const SHARE: usize = 512;

/// Motion by less than this share of a body's size in a frame is no scale for errors of momentum:
/// contacts solve
/// for positions, and those of a body at rest are rounded.
const LEAST_SHARE: f64 = 1e-3;

/// Sums over all dynamic bodies at one instant.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Totals {
    /// [kg]
    pub(crate) mass: f64,
    /// [J]
    pub(crate) kinetic: f64,
    /// Relative to the world's origin [J].
    pub(crate) potential: f64,
    /// [kg m/s]
    pub(crate) momentum: DVec3,
    /// About the world's origin [kg m^2/s].
    pub(crate) angular_momentum: DVec3,
    /// Sum of the lengths of the bodies' momenta, of what gravity gives them in one frame, and of
    /// what moves each by a share of its size in one, as rounded positions do [kg m/s].
    pub(crate) momentum_scale: f64,
    /// The same for angular momentum, orbital and spin; the levers of gravity and size reach to the
    /// far side of the body [kg m^2/s].
    pub(crate) angular_scale: f64,
}

impl Totals {
    /// Sums over the bodies at their present poses.
    pub(crate) fn of(bodies: &Bodies, frame: &Frame) -> Self {
        Self::at(bodies, &bodies.poses, frame)
    }

    /// Sums with the present velocities at other poses.
    pub(crate) fn at(bodies: &Bodies, poses: &[Pose], frame: &Frame) -> Self {
        let share = |begin: usize| begin..(begin + SHARE).min(bodies.len());
        let shares = (0..bodies.len()).step_by(SHARE).map(share).collect();
        let parts =
            threads::map(shares, bodies.len(), |share| Self::of_some(bodies, share, poses, frame));
        parts.into_iter().fold(Self::default(), Self::plus)
    }

    /// Sums over a range of bodies.
    pub(crate) fn of_some(
        bodies: &Bodies,
        some: Range<usize>,
        poses: &[Pose],
        frame: &Frame,
    ) -> Self {
        let mut sum = Self::default();
        for i in some {
            let (inertia, pose, velocity) = (&bodies.inertias[i], &poses[i], &bodies.velocities[i]);
            if inertia.is_infinite() {
                continue;
            }
            let mass = bodies.masses[i];
            let weight = frame.dt * mass * frame.gravity;
            let (low, high) = bodies.shapes[i].bounds;
            let size = (high - low).length();
            let reach = pose.position.length() + 0.5 * size;
            let least = weight.length() + mass * LEAST_SHARE * size / frame.dt;
            let momentum = mass * velocity.linear;
            let orbital = pose.position.cross(momentum);
            let spin = velocity.angular_momentum;
            sum.mass += mass;
            sum.kinetic += 0.5 * momentum.dot(velocity.linear)
                + inertia.rotational_energy(pose.orientation, spin);
            sum.potential -= mass * frame.gravity.dot(pose.position);
            sum.momentum += momentum;
            sum.angular_momentum += orbital + spin;
            sum.momentum_scale += momentum.length() + least;
            sum.angular_scale += orbital.length() + spin.length() + reach * least;
        }
        sum
    }

    pub(crate) fn plus(self, other: Self) -> Self {
        Self {
            mass: self.mass + other.mass,
            kinetic: self.kinetic + other.kinetic,
            potential: self.potential + other.potential,
            momentum: self.momentum + other.momentum,
            angular_momentum: self.angular_momentum + other.angular_momentum,
            momentum_scale: self.momentum_scale + other.momentum_scale,
            angular_scale: self.angular_scale + other.angular_scale,
        }
    }

    /// Kinetic and potential energy [J].
    pub(crate) fn energy(&self) -> f64 {
        self.kinetic + self.potential
    }
}

/// Gravity's impulse and angular impulse about the world's origin in one frame of ballistic flight.
///
/// Called between position update and velocity update: with x^{n+1} and the velocity v* after
/// collisions, `m g dt` at x^{n+1} and the displacement `g dt^2/2` at v* together are the exact
/// integral along the parabola.
pub(crate) fn gravity_impulse(bodies: &Bodies, frame: &Frame) -> (DVec3, DVec3) {
    let mut sums = (DVec3::ZERO, DVec3::ZERO);
    for i in (0..bodies.len()).filter(|&i| !bodies.inertias[i].is_infinite()) {
        let impulse = frame.dt * bodies.masses[i] * frame.gravity;
        sums.0 += impulse;
        sums.1 += bodies.poses[i].position.cross(impulse);
        sums.1 += (0.5 * frame.dt) * impulse.cross(bodies.velocities[i].linear);
    }
    sums
}

/// The books from the first frame on.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub(crate) struct Books {
    unexplained: DVec3,
    unexplained_angular: DVec3,
    momentum_scale: f64,
    angular_scale: f64,
}

impl Check for Books {
    fn check(&self) -> Checked {
        finite_vector(self.unexplained)?;
        finite_vector(self.unexplained_angular)?;
        finite(self.momentum_scale)?;
        finite(self.angular_scale)
    }
}

impl Books {
    /// Closes a frame that went from `before` to `after` received `gravity` and what `accounts`
    /// says, and put `banked` [J] aside.
    pub(crate) fn close(
        &mut self,
        before: &Totals,
        after: &Totals,
        gravity: (DVec3, DVec3),
        banked: f64,
        accounts: &FrameAccounts,
    ) -> (Energy, Momentum) {
        let change = after.energy() - before.energy();
        let energy = Energy {
            kinetic: after.kinetic,
            potential: after.potential,
            total: after.energy(),
            work: accounts.causes.work + accounts.recovery,
            started: 0.0,
            banked,
            gain: change + banked - accounts.causes.work - accounts.recovery,
            causes: Causes::of(&accounts.causes, change),
        };

        // Residual without gravity and outside impulses.
        self.unexplained += after.momentum - before.momentum - gravity.0 - accounts.outside_impulse;
        self.unexplained_angular += after.angular_momentum
            - before.angular_momentum
            - gravity.1
            - accounts.outside_angular_impulse;
        self.momentum_scale =
            self.momentum_scale.max(before.momentum_scale).max(after.momentum_scale);
        self.angular_scale = self.angular_scale.max(before.angular_scale).max(after.angular_scale);
        let relative =
            |error: DVec3, scale: f64| if scale > 0.0 { error.length() / scale } else { 0.0 };
        let momentum = Momentum {
            linear: after.momentum.to_array(),
            angular: after.angular_momentum.to_array(),
            linear_error: relative(self.unexplained, self.momentum_scale),
            angular_error: relative(self.unexplained_angular, self.angular_scale),
        };
        (energy, momentum)
    }
}
