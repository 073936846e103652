//! A promise that can be checked, and what was found.

use crate::shot::ShotError;
use frangible::BuildError;
use thiserror::Error;

/// A promise that can be checked.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// On the command line.
    pub name: &'static str,
    /// What is promised, in one line.
    pub says: &'static str,
    /// Who says so: the paper's section, mechanics, or a record in `docs/adr`.
    pub source: &'static str,
    pub(super) measure: fn() -> Result<Vec<Finding>, Obstacle>,
}

/// One measured number and the bounds that it is held to.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// What was measured.
    pub quantity: String,
    /// SI; `1` for a ratio.
    pub unit: &'static str,
    /// In `unit`.
    pub measured: f64,
    /// The least that holds; minus infinity for no bound.
    pub low: f64,
    /// The most that holds; infinity for no bound.
    pub high: f64,
}

/// No claim has that name.
#[derive(Debug, Error)]
#[error("unknown claim '{name}', must be one of: {known}")]
pub struct UnknownClaim {
    /// As given.
    pub name: String,
    /// All there are.
    pub known: String,
}

/// Why a claim's scene could not be set up.
#[derive(Debug, Error)]
pub enum Obstacle {
    /// It breaks a rule.
    #[error("{0}")]
    Build(#[from] BuildError),
    /// No such shot, or it lacks a file.
    #[error("{0}")]
    Shot(#[from] ShotError),
}

impl Finding {
    /// Whether the bounds hold; what is not a number does not.
    pub fn holds(&self) -> bool {
        self.low <= self.measured && self.measured <= self.high
    }

    /// Whether it is held to anything.
    pub fn is_bounded(&self) -> bool {
        self.low > f64::NEG_INFINITY || self.high < f64::INFINITY
    }

    pub(super) fn between(
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
        low: f64,
        high: f64,
    ) -> Self {
        Self { quantity: quantity.into(), unit, measured, low, high }
    }

    pub(super) fn at_most(
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
        high: f64,
    ) -> Self {
        Self::between(quantity, unit, measured, f64::NEG_INFINITY, high)
    }

    pub(super) fn at_least(
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
        low: f64,
    ) -> Self {
        Self::between(quantity, unit, measured, low, f64::INFINITY)
    }

    /// Without bounds.
    pub(super) fn beside(quantity: impl Into<String>, unit: &'static str, measured: f64) -> Self {
        Self::between(quantity, unit, measured, f64::NEG_INFINITY, f64::INFINITY)
    }
}

/// The largest of some values; not a number if one of them is none.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, |most, value| {
        if most.is_nan() || value <= most { most } else { value }
    })
}
