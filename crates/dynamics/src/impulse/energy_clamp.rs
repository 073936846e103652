//! Impulses scaled so that they never raise the kinetic energy of the pair they act on [Su09 sec. 3.2].

use crate::impulse::collision_impulse::Impulse;
use frangible_bodies::{Inertia, Velocity};
use glam::{DQuat, DVec3};

/// One body of a pair just before an impulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ClampSide {
    /// Has finite mass.
    Dynamic {
        /// Finite.
        inertia: Inertia,
        /// `world_from_body` of the non-split state.
        orientation: DQuat,
        /// Of the non-split state, with all earlier impulses.
        velocity: Velocity,
        /// About to act, computed in the split state.
        impulse: Impulse,
    },
    /// Static or kinematic: no impulse moves it.
    Prescribed {
        /// Of its point at the contact [m/s]; zero if static.
        point_velocity: DVec3,
    },
}

/// How much of an impulse may act.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// All of it: the energy does not rise, to rounding.
    Whole,
    /// This fraction, in (0, 1): the energy stays as it is.
    Scaled(f64),
    /// None: any part of it would raise the energy.
    Blocked,
}

/// Impulses that would have raised the kinetic energy [Su09 sec. 3.2].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clamps {
    /// Shortened.
    pub shortened: u64,
    /// Dropped, because no length of them would have kept the kinetic energy.
    pub dropped: u64,
    /// Energy that those would have made and did not [J].
    pub withheld: f64,
}

impl Clamps {
    /// Adds others.
    pub(crate) fn add(&mut self, other: Self) {
        self.shortened += other.shortened;
        self.dropped += other.dropped;
        self.withheld += other.withheld;
    }
}

impl Clamp {
    /// The fraction that may act, in [0, 1].
    pub fn scale(self) -> f64 {
        match self {
            Self::Whole => 1.0,
            Self::Scaled(scale) => scale,
            Self::Blocked => 0.0,
        }
    }
}

/// An energy-neutral fraction this near to 1 is 1 up to rounding, as every elastic impulse without
/// friction has it.
const WHOLE: f64 = 1.0 - 1e-13;

/// How much of the two bodies' impulses leaves the kinetic energy of the pair in the non-split
/// state no higher than it is.
///
/// Against a kinematic body the energy is that in the frame that moves with the body's point, so
/// that a lift can lift. Nothing is to be scaled between two prescribed bodies: `Whole`.
pub fn clamp_impulse(a: &ClampSide, b: &ClampSide) -> Clamp {
    let (slope, curvature) = pair_energy_change(a, b);
    if curvature == 0.0 {
        return Clamp::Whole;
    }

    // It is zero again at eps; beyond, it is positive.
    let neutral = -2.0 * slope / curvature;
    if neutral >= WHOLE {
        Clamp::Whole
    } else if neutral > 0.0 {
        Clamp::Scaled(neutral)
    } else {
        Clamp::Blocked
    }
}

/// What both impulses in full add to the same energy [J].
pub(crate) fn energy_given(a: &ClampSide, b: &ClampSide) -> f64 {
    let (slope, curvature) = pair_energy_change(a, b);
    slope + 0.5 * curvature
}

/// The change of the pair's energy is  slope eps + curvature eps^2 / 2  if a fraction eps of its
/// impulses acts [J].
fn pair_energy_change(a: &ClampSide, b: &ClampSide) -> (f64, f64) {
    let frame_velocity = |other: &ClampSide| match other {
        ClampSide::Dynamic { .. } => DVec3::ZERO,
        ClampSide::Prescribed { point_velocity } => *point_velocity,
    };
    let (slope_a, curvature_a) = energy_change(a, frame_velocity(b));
    let (slope_b, curvature_b) = energy_change(b, frame_velocity(a));
    (slope_a + slope_b, curvature_a + curvature_b)
}

/// First and second derivative of a body's kinetic energy with respect to the fraction of the
/// impulse that acts, at fraction zero [J].
fn energy_change(side: &ClampSide, frame_velocity: DVec3) -> (f64, f64) {
    let ClampSide::Dynamic { inertia, orientation, velocity, impulse } = side else {
        return (0.0, 0.0);
    };
    // Rotation, in the body frame: there a thin body's energy does not drown in the rounding of its
    // tensor.
    let body_from_world = orientation.conjugate();
    let angular_impulse = body_from_world * impulse.angular;
    let angular_answer = inertia.inverse_moments * angular_impulse;
    let angular_slope = angular_answer.dot(body_from_world * velocity.angular_momentum);

    let slope = impulse.linear.dot(velocity.linear - frame_velocity) + angular_slope;
    (
        slope,
        inertia.inverse_mass * impulse.linear.length_squared()
            + angular_impulse.dot(angular_answer),
    )
}
