//! Impulses scaled to never raise the kinetic energy of the pair [Su09 sec. 3.2].

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
        /// Velocity in the non-split state, with all earlier impulses.
        velocity: Velocity,
        /// Impulse to clamp, computed in the split state.
        impulse: Impulse,
    },
    /// Static or kinematic: immovable by impulses.
    Prescribed {
        /// Velocity of the contact point [m/s]; zero for static bodies.
        point_velocity: DVec3,
    },
}

/// Allowed fraction of an impulse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Clamp {
    /// All of it: the energy does not rise, to rounding.
    Whole,
    /// This fraction, in (0, 1): the energy is unchanged.
    Scaled(f64),
    /// Zero: any fraction would raise the energy.
    Blocked,
}

/// Statistics of impulses that would have raised the kinetic energy [Su09 sec. 3.2].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Clamps {
    /// Number of shortened impulses.
    pub shortened: u64,
    /// Number of dropped impulses: any length would have raised the kinetic energy.
    pub dropped: u64,
    /// Energy gain avoided by both [J].
    pub withheld: f64,
}

impl Clamps {
    /// Adds the statistics of another stage.
    pub(crate) fn add(&mut self, other: Self) {
        self.shortened += other.shortened;
        self.dropped += other.dropped;
        self.withheld += other.withheld;
    }
}

impl Clamp {
    /// Allowed fraction in [0, 1].
    pub fn scale(self) -> f64 {
        match self {
            Self::Whole => 1.0,
            Self::Scaled(scale) => scale,
            Self::Blocked => 0.0,
        }
    }
}

/// Energy-neutral fractions above this limit count as 1: elastic frictionless impulses reach 1 only
/// to rounding.
const WHOLE: f64 = 1.0 - 1e-13;

/// Largest fraction of the pair's impulses without a kinetic energy gain in the non-split state.
///
/// With a kinematic body the energy is measured in the frame of its contact point: a lift can lift.
/// For two prescribed bodies the answer is `Whole`.
pub fn clamp_impulse(a: &ClampSide, b: &ClampSide) -> Clamp {
    let (slope, curvature) = pair_energy_change(a, b);
    if curvature == 0.0 {
        return Clamp::Whole;
    }

    // The energy change vanishes again at this fraction; beyond, it is positive.
    let neutral = -2.0 * slope / curvature;
    if neutral >= WHOLE {
        Clamp::Whole
    } else if neutral > 0.0 {
        Clamp::Scaled(neutral)
    } else {
        Clamp::Blocked
    }
}

/// Energy change by the full impulses [J], in the same frame.
pub(crate) fn energy_given(a: &ClampSide, b: &ClampSide) -> f64 {
    let (slope, curvature) = pair_energy_change(a, b);
    slope + 0.5 * curvature
}

/// Coefficients of the pair's energy change  slope eps + curvature eps^2 / 2  for a fraction eps of
/// its impulses [J].
fn pair_energy_change(a: &ClampSide, b: &ClampSide) -> (f64, f64) {
    let frame_velocity = |other: &ClampSide| match other {
        ClampSide::Dynamic { .. } => DVec3::ZERO,
        ClampSide::Prescribed { point_velocity } => *point_velocity,
    };
    let (slope_a, curvature_a) = energy_change(a, frame_velocity(b));
    let (slope_b, curvature_b) = energy_change(b, frame_velocity(a));
    (slope_a + slope_b, curvature_a + curvature_b)
}

/// First and second derivative of a body's kinetic energy with respect to the impulse fraction, at
/// zero [J].
fn energy_change(side: &ClampSide, frame_velocity: DVec3) -> (f64, f64) {
    let ClampSide::Dynamic { inertia, orientation, velocity, impulse } = side else {
        return (0.0, 0.0);
    };
    // Rotation in the body frame: rounding of a world-frame tensor would swamp a thin body's
    // energy.
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
