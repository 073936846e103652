//! Rules that values must keep which were read, and which the engine relies on.

use glam::{DQuat, DVec3, Vec3};

/// The rule that a value breaks, as the end of a sentence that begins with "must be".
pub type Checked = Result<(), &'static str>;

/// Values of which not every combination of bytes is a valid one.
pub trait Check {
    /// Whether the value keeps its rules; those of the [shared](crate::shared) values in it were
    /// checked when they were read.
    ///
    /// # Errors
    /// The first rule that is broken.
    fn check(&self) -> Checked;
}

/// `Ok` if a rule is kept.
///
/// # Errors
/// The rule, if it is not.
#[inline]
pub fn require(is_kept: bool, rule: &'static str) -> Checked {
    if is_kept { Ok(()) } else { Err(rule) }
}

/// Largest length of a vector, of any unit, that a world may hold: its square and cube stay finite.
const MOST: f64 = 1e30;

/// A unit quaternion may be off by this much in its squared length: it is normalized again and
/// again while a body turns.
const UNIT: f64 = 1e-6;

/// `Ok` for a number that is finite, and far from overflow.
///
/// # Errors
/// If it is not.
#[inline]
pub fn finite(number: f64) -> Checked {
    require(number.abs() <= MOST, "a finite number")
}

/// As [`finite`], for all three components.
///
/// # Errors
/// If one is not.
#[inline]
pub fn finite_vector(vector: DVec3) -> Checked {
    require(vector.abs().max_element() <= MOST && !vector.is_nan(), "a finite vector")
}

/// As [`finite_vector`].
///
/// # Errors
/// If one component is not finite.
#[inline]
pub fn finite_singles(vector: Vec3) -> Checked {
    require(vector.is_finite(), "a finite vector")
}

/// `Ok` for a unit quaternion.
///
/// # Errors
/// If it is none.
#[inline]
pub fn unit_quaternion(quaternion: DQuat) -> Checked {
    require((quaternion.length_squared() - 1.0).abs() <= UNIT, "a unit quaternion")
}
