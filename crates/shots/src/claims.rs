//! What the paper and we promise, measured: one source for the tests and for `frangible verify`.
//!
//! A claim builds its own small scenes, runs them and says what it found. A finding without bounds
//! stands beside the others.

mod bounce;
mod carried;
mod cradle;
mod energy;
mod fitting;
mod flight;
mod heap;
mod incline;
mod pillar;
mod random_scene;
mod rolling;
mod rotation;
mod scenes;
mod settled;
mod stacks;
mod standing;
mod swarm;
mod top;

pub use pillar::{Spread, pillar_spread};

use crate::ShotError;
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
    measure: fn() -> Result<Vec<Finding>, Obstacle>,
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

/// All claims.
pub const CLAIMS: &[Claim] = &[
    rotation::EXACT,
    rotation::MILLION,
    rotation::FLIP,
    rotation::COST,
    flight::FREE_BOX,
    top::TOP,
    energy::RANDOM_SCENES,
    energy::ALL_SHOTS,
    energy::SAFEGUARDS,
    pillar::SPREAD,
    pillar::UNCORRECTED,
    incline::INCLINE,
    bounce::BOUNCES,
    stacks::STACK,
    stacks::ZIGZAG,
    carried::ELEVATOR,
    carried::TURNTABLE,
    carried::CONVEYOR,
    swarm::SWARM,
    settled::SETTLED_PILE,
    heap::HEAP,
    settled::LOSSLESS,
    rolling::ROLLING,
    rolling::ROLLING_FRICTION,
    standing::TOWERS,
    standing::ARCH,
    standing::LOAD,
    fitting::SLAB,
    fitting::PLATE,
    fitting::NUT,
    cradle::CRADLE,
    standing::CARD_HOUSE,
];

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

impl Claim {
    /// The claim of a name.
    ///
    /// # Errors
    /// If there is none.
    pub fn find(name: &str) -> Result<&'static Self, UnknownClaim> {
        let known = || {
            let names: Vec<&str> = CLAIMS.iter().map(|claim| claim.name).collect();
            names.join(", ") + &frangible::nearest(name, &names)
        };
        CLAIMS
            .iter()
            .find(|claim| claim.name == name)
            .ok_or_else(|| UnknownClaim { name: name.into(), known: known() })
    }

    /// Runs its scenes and says what it found. A scene that cannot be set up is a finding
    /// that does not hold.
    pub fn check(&self) -> Vec<Finding> {
        (self.measure)().unwrap_or_else(|obstacle| {
            vec![Finding::at_most(obstacle.to_string(), "1", f64::NAN, 0.0)]
        })
    }
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

    fn between(
        quantity: impl Into<String>,
        unit: &'static str,
        measured: f64,
        low: f64,
        high: f64,
    ) -> Self {
        Self { quantity: quantity.into(), unit, measured, low, high }
    }

    fn at_most(quantity: impl Into<String>, unit: &'static str, measured: f64, high: f64) -> Self {
        Self::between(quantity, unit, measured, f64::NEG_INFINITY, high)
    }

    fn at_least(quantity: impl Into<String>, unit: &'static str, measured: f64, low: f64) -> Self {
        Self::between(quantity, unit, measured, low, f64::INFINITY)
    }

    /// Without bounds.
    fn beside(quantity: impl Into<String>, unit: &'static str, measured: f64) -> Self {
        Self::between(quantity, unit, measured, f64::NEG_INFINITY, f64::INFINITY)
    }
}

/// The largest of some values; not a number if one of them is none.
fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(f64::NEG_INFINITY, |most, value| {
        if most.is_nan() || value <= most { most } else { value }
    })
}
