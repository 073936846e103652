//! Parameters of generators: validation, and random values.

use crate::pattern::error::PatternError;
use glam::DVec3;
use rand::RngExt;
use rand_pcg::Pcg64Mcg;

/// Checks that a parameter is within its range; also false for NaN.
pub(crate) fn require(
    holds: bool,
    parameter: &'static str,
    value: f64,
    rule: &'static str,
) -> Result<(), PatternError> {
    if holds { Ok(()) } else { Err(PatternError::Parameter { parameter, value, rule }) }
}

/// Uniform in [-1/2, 1/2).
pub(crate) fn deviation(random: &mut Pcg64Mcg) -> f64 {
    random.random::<f64>() - 0.5
}

/// Checks the shape of a pattern's box.
pub(crate) fn require_box(half_extent: DVec3) -> Result<(), PatternError> {
    let positive = half_extent.is_finite() && half_extent.min_element() > 0.0;
    require(positive, "half_extent", half_extent.min_element(), "positive and finite")?;
    // Flatter or longer than this, faces get lost in rounding.
    let ratio = half_extent.max_element() / half_extent.min_element();
    require(ratio <= 1000.0, "half_extent", ratio, "at most 1000 times as long as it is wide")
}

/// Checks a count against memory limits.
pub(crate) fn require_count(count: usize, parameter: &'static str) -> Result<(), PatternError> {
    require((1..=MOST_CELLS).contains(&count), parameter, count as f64, "from 1 to 10000")
}

/// Maximum number of cells in a pattern.
pub const MOST_CELLS: usize = 10_000;

/// A direction, each as likely as another.
pub(crate) fn direction(random: &mut Pcg64Mcg) -> DVec3 {
    loop {
        let place = 2.0 * DVec3::new(deviation(random), deviation(random), deviation(random));
        let length = place.length();
        if length > 1e-3 && length < 1.0 {
            return place / length;
        }
    }
}
