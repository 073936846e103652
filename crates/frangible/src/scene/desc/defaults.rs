//! Values of what a description leaves out: the only place where a default is written.

pub(crate) fn most_substeps() -> u32 {
    128
}

pub(crate) fn recovery_speed() -> f64 {
    3.0
}

pub(crate) fn gravity() -> [f64; 3] {
    [0.0, -9.81, 0.0]
}
pub(crate) fn frames_per_second() -> f64 {
    30.0
}
pub(crate) fn orientation() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}
pub(crate) fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}
/// Concrete [kg/m^3].
pub(crate) fn density() -> f64 {
    2400.0
}
pub(crate) fn half() -> f64 {
    0.5
}
pub(crate) fn one() -> f64 {
    1.0
}
/// Of brittle materials that are made with some care (a ratio).
pub(crate) fn weibull_modulus() -> f64 {
    10.0
}
pub(crate) fn generations() -> u32 {
    1
}

pub(super) fn is_zero(number: &f64) -> bool {
    *number == 0.0
}
