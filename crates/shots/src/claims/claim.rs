//! Claims and their findings.

use crate::shot::ShotError;
use frangible::BuildError;
use thiserror::Error;

/// A checkable claim.
#[derive(Clone, Copy, Debug)]
pub struct Claim {
    /// On the command line.
    pub name: &'static str,
    /// The claim in one line.
    pub says: &'static str,
    /// Source: a section of the paper, mechanics, or a record in `docs/adr`.
    pub source: &'static str,
    pub(super) measure: fn() -> Result<Vec<Finding>, Obstacle>,
}

/// A measured number with its bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// Measured quantity.
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

/// Unknown claim name.
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
    /// The scene breaks a rule.
    #[error("{0}")]
    Build(#[from] BuildError),
    /// No such shot, or it lacks a file.
    #[error("{0}")]
    Shot(#[from] ShotError),
}

impl Finding {
    /// True within the bounds; false for NaN.
    pub fn holds(&self) -> bool {
        self.low <= self.measured && self.measured <= self.high
    }

    /// True with any bound.
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

/// Largest of the values; NaN if any is NaN.
pub(super) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, |most, value| {
        if most.is_nan() || value <= most { most } else { value }
    })
}
