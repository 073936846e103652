//! Checks that answer with the field, the value and the rule.

use frangible_fracture::PatternError;
use frangible_geometry::{MeshError, MeshToLevelSetError};
use glam::{DQuat, DVec3};
use std::fmt::Debug;
use thiserror::Error;

/// Maximum speed of a scene [m/s], [rad/s]: above it, single-precision rounding loses contacts, and
/// bodies with them.
pub(crate) const MOST_SPEED: f64 = 1e5;
pub(crate) const MOST_SPIN: f64 = 1e4;

/// Why a scene cannot be built, or a world changed.
#[derive(Debug, Error)]
pub enum BuildError {
    /// A field breaks a rule.
    #[error("{path}: {value}, must be {rule}")]
    Rule {
        /// Where, as in `bodies[3].density`.
        path: String,
        /// As given.
        value: String,
        /// Rule for the value.
        rule: String,
    },
    /// A mesh cannot be used.
    #[error("{0}")]
    Mesh(#[from] MeshError),
    /// A pattern's file cannot be used.
    #[error("{0}")]
    Pattern(PatternError),
    /// A file that a field names cannot be used.
    #[error("{path}: {error}")]
    File {
        /// Of the field, as in `bodies[3].shape.path`.
        path: String,
        /// Which file, and why.
        error: String,
    },
    /// A mesh cannot be sampled on its grid.
    #[error("{path}: {error}")]
    Sampling {
        /// Of the file, or of the field.
        path: String,
        /// Why.
        error: MeshToLevelSetError,
    },
}

impl BuildError {
    /// Adds the name of the affected body, from the names of all bodies.
    pub(crate) fn in_body(self, names: &[Option<String>]) -> Self {
        let name = |path: &str| {
            let (index, _) = path.strip_prefix("bodies[")?.split_once(']')?;
            let name = names.get(index.parse::<usize>().ok()?)?.as_deref()?;
            (!name.is_empty())
                .then(|| format!(" (body {:?})", name.chars().take(40).collect::<String>()))
        };
        match self {
            Self::Rule { path, value, mut rule } => {
                rule.extend(name(&path));
                Self::Rule { path, value, rule }
            }
            Self::File { path, mut error } => {
                error.extend(name(&path));
                Self::File { path, error }
            }
            // Of triangles that the scene itself gives, a sentence begins with the field.
            Self::Mesh(_) | Self::Sampling { .. } => {
                let sentence = self.to_string();
                match sentence.split_once(": ") {
                    Some((path, error)) if name(path).is_some() => {
                        Self::File { path: path.into(), error: error.into() }.in_body(names)
                    }
                    _ => self,
                }
            }
            Self::Pattern(_) => self,
        }
    }
}

/// " (did you mean 'wall'?)" where one of the known words is near, else nothing.
pub fn nearest(word: &str, known: &[&str]) -> String {
    const LEAST: f64 = 0.6;
    let likeness = |other: &str| strsim::normalized_damerau_levenshtein(word, other);
    let best = known.iter().max_by(|a, b| likeness(a).total_cmp(&likeness(b)));
    best.filter(|best| word.len() < 100 && likeness(best) >= LEAST)
        .map_or_else(String::new, |best| format!(" (did you mean '{best}'?)"))
}

/// A place in a description.
#[derive(Clone, Debug)]
pub(crate) struct Checker {
    path: String,
}

impl Checker {
    /// The whole description.
    pub(crate) fn root() -> Self {
        Self { path: String::new() }
    }

    /// A field of this place.
    pub(crate) fn field(&self, name: &str) -> Self {
        let path = if self.path.is_empty() { name.into() } else { format!("{}.{name}", self.path) };
        Self { path }
    }

    /// Path of the field, as in `bodies[3].shape`.
    pub(crate) fn path(&self) -> &str {
        &self.path
    }

    /// The error that this place breaks a rule.
    pub(crate) fn broken(&self, value: &str, rule: &str) -> BuildError {
        BuildError::Rule { path: self.path.clone(), value: value.into(), rule: rule.into() }
    }

    /// Error for an unusable file named at this place.
    pub(crate) fn file(&self, error: &str) -> BuildError {
        BuildError::File { path: self.path.clone(), error: error.into() }
    }

    /// Error for a pattern at this place: a parameter (a field of it), or a file.
    pub(crate) fn pattern(&self, error: &PatternError) -> BuildError {
        match error {
            PatternError::Parameter { parameter, value, rule } => {
                self.field(parameter).broken(&value.to_string(), rule)
            }
            PatternError::File { .. } if self.path.is_empty() => BuildError::Pattern(error.clone()),
            PatternError::File { .. } => self.field("path").file(&error.to_string()),
        }
    }

    fn require<T: Debug>(&self, holds: bool, value: T, rule: &str) -> Result<T, BuildError> {
        if holds { Ok(value) } else { Err(self.broken(&format!("{value:?}"), rule)) }
    }

    /// An impulse that bodies of the least mass meet at the least speeds, or more.
    pub(crate) fn impulse(&self, value: f64) -> Result<f64, BuildError> {
        let (least, most) = (1e-15, 1e12);
        let rule = format!("between {least:e} and {most:e} N s");
        self.require((least..=most).contains(&value), value, &rule)
    }

    pub(crate) fn positive(&self, value: f64, unit: &str) -> Result<f64, BuildError> {
        const MOST: f64 = 1e12;
        self.require(
            value > 0.0 && value <= MOST,
            value,
            &format!("> 0 and at most {MOST:e} {unit}"),
        )
    }

    /// A length whose square and cube neither vanish nor overflow.
    pub(crate) fn length(&self, value: f64) -> Result<f64, BuildError> {
        self.require((1e-6..=1e6).contains(&value), value, "between 1e-6 and 1e6 m")
    }

    pub(crate) fn not_negative(&self, value: f64) -> Result<f64, BuildError> {
        self.require(value.is_finite() && value >= 0.0, value, ">= 0")
    }

    pub(crate) fn within(&self, value: f64, low: f64, high: f64) -> Result<f64, BuildError> {
        self.require(value >= low && value <= high, value, &format!("between {low} and {high}"))
    }

    pub(crate) fn at_least(&self, value: f64, least: f64, unit: &str) -> Result<f64, BuildError> {
        self.require(value.is_finite() && value >= least, value, &format!(">= {least} {unit}"))
    }

    pub(crate) fn count(
        &self,
        value: usize,
        least: usize,
        most: usize,
    ) -> Result<usize, BuildError> {
        self.require((least..=most).contains(&value), value, &format!("from {least} to {most}"))
    }

    /// Three numbers that are not too large for their squares and products to be summed.
    pub(crate) fn vector(&self, value: [f64; 3], unit: &str) -> Result<DVec3, BuildError> {
        self.bounded(value, 1e9, unit)
    }

    /// Three numbers whose sizes are at most `most`.
    pub(crate) fn bounded(
        &self,
        value: [f64; 3],
        most: f64,
        unit: &str,
    ) -> Result<DVec3, BuildError> {
        let holds = value.iter().all(|x| x.abs() <= most);
        self.require(holds, value, &format!("three numbers from -{most:e} to {most:e} {unit}"))
            .map(DVec3::from_array)
    }

    pub(crate) fn rotation(&self, value: [f64; 4]) -> Result<DQuat, BuildError> {
        let quaternion = DQuat::from_array(value);
        let length = quaternion.length();
        self.require(
            length.is_finite() && length > 1e-6,
            value,
            "a quaternion x, y, z, w other than zero",
        )?;
        Ok(quaternion.normalize())
    }
}
