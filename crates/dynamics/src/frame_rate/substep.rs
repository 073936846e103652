//! Constants of a substep, and the coefficients of soft constraints.

use frangible_math::{Instructions, Single};

/// Constants of a substep, common to all batches.
pub(super) struct Substep<I> {
    /// [s]
    pub(super) h: Single<I>,
    /// [1/s]
    pub(super) per_second: Single<I>,
    pub(super) soft: Softness<I>,
    /// Fraction of the overlap beyond the load's spring deflection that closes per second [1/s].
    /// The value does not depend on the substep count: a tower must not jump when its substeps
    /// increase.
    pub(super) recovery_rate: Single<I>,
    /// Maximum speed of penetration recovery [m/s].
    pub(super) recovery_speed: Single<I>,
    /// Threshold velocity of restitution, negative: a faster approach bounces [m/s].
    pub(super) bounce_velocity: Single<I>,
}

/// Soft-constraint coefficients [Cat24].
pub(super) struct Softness<I> {
    /// Velocity per overlap [1/s].
    pub(super) rate: Single<I>,
    /// Scale of the effective mass [1].
    pub(super) mass: Single<I>,
    /// Fraction of the accumulated impulse to remove [1].
    pub(super) impulse: Single<I>,
    /// Velocity at which a loaded spring yields, in units of K times its impulse [1].
    pub(super) yielding: Single<I>,
}

impl<I: Instructions> Softness<I> {
    /// Spring with a frequency [Hz] and a damping ratio, in substeps of `h` [s].
    pub(super) fn new(frequency: f64, damping_ratio: f64, h: f64) -> Self {
        let omega = std::f64::consts::TAU * frequency;
        let a = 2.0 * damping_ratio + h * omega;
        let b = h * omega * a;
        let mass = b / (1.0 + b);
        Self {
            rate: Single::splat(omega / a * mass),
            mass: Single::splat(mass),
            impulse: Single::splat(1.0 / (1.0 + b)),
            yielding: Single::splat(1.0 / b),
        }
    }
}
