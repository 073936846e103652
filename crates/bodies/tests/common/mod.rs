//! Random bodies, the same in each run.
#![allow(dead_code, reason = "each test binary uses a part")]

use frangible_bodies::{Inertia, Velocity};
use glam::{DMat3, DQuat, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

/// A seeded source of random bodies.
pub(crate) struct Random(Pcg64Mcg);

/// Which inertia tensors to draw.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Tensors {
    /// Moments within a factor of 2.
    Mild,
    /// Moments that a mass distribution can have (the triangle inequality), their ratio up to 1e6.
    Physical,
    /// Any moments with ratio up to 1e6.
    Arbitrary,
    /// Two moments equal to within 1e-12 to 1e-1, the third of the rest down to 1e-6 (rods) or near
    /// the sum (plates).
    NearSymmetric,
}

impl Tensors {
    pub(crate) const ALL: [Self; 4] =
        [Self::Mild, Self::Physical, Self::Arbitrary, Self::NearSymmetric];
}

impl Random {
    pub(crate) fn new(seed: u64) -> Self {
        Self(Pcg64Mcg::seed_from_u64(seed))
    }

    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0.random_range(low..high)
    }

    pub(crate) fn log_uniform(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.uniform(libm::log(low), libm::log(high)))
    }

    /// Each component in [-1, 1].
    pub(crate) fn vector(&mut self) -> DVec3 {
        DVec3::new(self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0), self.uniform(-1.0, 1.0))
    }

    /// Uniform on the sphere.
    pub(crate) fn direction(&mut self) -> DVec3 {
        loop {
            let v = self.vector();
            if (0.01..1.0).contains(&v.length_squared()) {
                return v.normalize();
            }
        }
    }

    /// Uniform over all rotations.
    pub(crate) fn orientation(&mut self) -> DQuat {
        loop {
            let q = self.vector().extend(self.uniform(-1.0, 1.0));
            if (0.01..1.0).contains(&q.length_squared()) {
                return DQuat::from_vec4(q.normalize());
            }
        }
    }

    /// Principal moments [kg m^2], in random order.
    pub(crate) fn moments(&mut self, tensors: Tensors) -> DVec3 {
        let size = self.log_uniform(1e-6, 1e6);
        let sorted = match tensors {
            Tensors::Mild => 1.5 + 0.5 * self.vector() / 1.5,
            Tensors::Physical => {
                let [x, y, z] = [0; 3].map(|_| self.log_uniform(1e-6, 1.0));
                DVec3::new(y + z, z + x, x + y)
            }
            Tensors::Arbitrary => DVec3::from_array([0; 3].map(|_| self.log_uniform(1e-6, 1.0))),
            Tensors::NearSymmetric => {
                let split = self.log_uniform(1e-12, 1e-1);
                if self.uniform(0.0, 1.0) < 0.5 {
                    DVec3::new(self.log_uniform(1e-6, 1.0), 1.0, 1.0 + split)
                } else {
                    DVec3::new(
                        1.0,
                        1.0 + split,
                        (2.0 + split) * (1.0 - self.log_uniform(1e-6, 1e-1)),
                    )
                }
            }
        };
        let shift = self.0.random_range(0..3usize);
        size * DVec3::new(sorted[shift], sorted[(shift + 1) % 3], sorted[(shift + 2) % 3])
    }

    /// Angular momentum in a random direction with `|omega| dt` log-uniform in [1e-3, 100].
    pub(crate) fn angular_momentum(
        &mut self,
        orientation: DQuat,
        inertia: &Inertia,
        dt: f64,
    ) -> DVec3 {
        let direction = self.direction();
        let turn = self.log_uniform(1e-3, 100.0);
        turn / (dt * inertia.angular_velocity(orientation, direction).length()) * direction
    }
}

/// A body that touches something at `lever`, with the orientation that the impulse is computed at.
pub(crate) struct Toucher {
    pub(crate) inertia: Inertia,
    pub(crate) orientation: DQuat,
    /// From the centre of mass to the contact, world frame [m].
    pub(crate) lever: DVec3,
    pub(crate) velocity: Velocity,
}

impl Toucher {
    pub(crate) fn random(random: &mut Random, tensors: Tensors) -> Self {
        // A body of about a metre, so that the lever and the moments fit together.
        let moments = random.moments(tensors);
        let mass = random.log_uniform(1.0, 100.0);
        let inertia = Inertia::new(mass, mass * moments / moments.max_element());
        let orientation = random.orientation();
        let angular_momentum = random.direction() * mass * random.log_uniform(1e-2, 10.0);
        let velocity = Velocity { linear: 10.0 * random.vector(), angular_momentum };
        Self { inertia, orientation, lever: random.vector(), velocity }
    }

    pub(crate) fn inverse_tensor(&self) -> DMat3 {
        self.inertia.inverse_tensor(self.orientation)
    }

    /// Velocity of the contact point [m/s].
    pub(crate) fn point_velocity(&self, velocity: &Velocity) -> DVec3 {
        velocity.linear + (self.inverse_tensor() * velocity.angular_momentum).cross(self.lever)
    }

    /// Kinetic energy [J] of the body with the given velocity, at the given orientation.
    pub(crate) fn kinetic_energy(&self, velocity: &Velocity, orientation: DQuat) -> f64 {
        0.5 * velocity.linear.length_squared() / self.inertia.inverse_mass
            + self.inertia.rotational_energy(orientation, velocity.angular_momentum)
    }
}
