//! Both sides of several pairs, as their rows see them.

use super::Side;
use crate::lanes::{Instructions, Single, Single3, Symmetric};

/// How both sides of several pairs move.
#[derive(Clone, Copy)]
pub(crate) struct Rates<I> {
    /// Velocity of the first centre of mass less that of the second one [m/s].
    pub(crate) apart: Single3<I>,
    /// [rad/s]
    pub(crate) spins: [Single3<I>; 2],
}

/// Both sides of several pairs.
#[derive(Clone, Copy)]
pub(crate) struct Sides<I> {
    pub(crate) rates: Rates<I>,
    /// The sum of both [1/kg].
    pub(crate) inverse_mass: Single<I>,
    pub(crate) inverse_tensors: [Symmetric<Single<I>>; 2],
}

impl<I: Instructions> Sides<I> {
    #[inline(always)]
    pub(crate) fn of([first, second]: &[Side<I>; 2]) -> Self {
        Self {
            rates: Rates { apart: first.linear - second.linear, spins: [first.angular, second.angular] },
            inverse_mass: first.inverse_mass + second.inverse_mass,
            inverse_tensors: [first.inverse_tensor, second.inverse_tensor],
        }
    }

    /// After an impulse on the first bodies at levers from both centres of mass, and its opposite on the second ones.
    #[inline(always)]
    pub(crate) fn push(&mut self, [angular_impulse, opposite]: [Single3<I>; 2], impulse: Single3<I>) {
        self.rates.apart = self.rates.apart + impulse * self.inverse_mass;
        self.turn([angular_impulse, opposite]);
    }

    /// An angular impulse on the first bodies, and the opposite of another one on the second ones.
    #[inline(always)]
    pub(crate) fn turn(&mut self, [on_first, off_second]: [Single3<I>; 2]) {
        self.rates.spins[0] = self.rates.spins[0] + self.inverse_tensors[0] * on_first;
        self.rates.spins[1] = self.rates.spins[1] - self.inverse_tensors[1] * off_second;
    }
}
