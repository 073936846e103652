//! The engine's errors as Python exceptions.

use pyo3::create_exception;
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;
use std::fmt::Display;

create_exception!(
    frangible,
    BuildError,
    PyValueError,
    "A scene that cannot be built: the message names the field, the value and the rule."
);

/// The engine's sentence as a Python exception.
pub(crate) fn build_error(error: impl Display) -> PyErr {
    BuildError::new_err(error.to_string())
}
