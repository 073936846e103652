//! Why a pattern cannot be made.

use thiserror::Error;

/// Why a pattern cannot be made.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum PatternError {
    /// A parameter is out of its range.
    #[error("{parameter}: {value}, must be {rule}")]
    Parameter {
        /// Its name.
        parameter: &'static str,
        /// As given.
        value: f64,
        /// Violated rule.
        rule: &'static str,
    },
    /// A file cannot be read, written or used.
    #[error("{path}: {reason}")]
    File {
        /// As given.
        path: String,
        /// In a sentence.
        reason: String,
    },
}
