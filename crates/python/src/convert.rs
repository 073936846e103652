//! Values on their way to Python and back.

use crate::build_error;
use glam::Vec2;
use numpy::{AllowTypeChange, Element, PyArray1, PyArray2, PyArray3, PyArrayLike1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use serde_json::Value;

/// A JSON value as the same value in Python.
pub(crate) fn json<'py>(py: Python<'py>, value: &Value) -> PyResult<Bound<'py, PyAny>> {
    match value {
        Value::Null => Ok(py.None().into_bound(py)),
        Value::Bool(flag) => flag.into_bound_py_any(py),
        Value::Number(number) => match (number.as_u64(), number.as_i64()) {
            (Some(natural), _) => natural.into_bound_py_any(py),
            (None, Some(integer)) => integer.into_bound_py_any(py),
            // Every JSON number is a float if it is no integer.
            (None, None) => number.as_f64().into_bound_py_any(py),
        },
        Value::String(text) => text.into_bound_py_any(py),
        Value::Array(items) => {
            let list = PyList::empty(py);
            for item in items {
                list.append(json(py, item)?)?;
            }
            Ok(list.into_any())
        }
        Value::Object(fields) => {
            let dict = PyDict::new(py);
            for (key, item) in fields {
                dict.set_item(key, json(py, item)?)?;
            }
            Ok(dict.into_any())
        }
    }
}

/// Rows of equal length as an array (n, N).
pub(crate) fn rows<'py, T: Element + Copy, const N: usize>(
    py: Python<'py>,
    rows: impl Iterator<Item = [T; N]>,
) -> PyResult<Bound<'py, PyArray2<T>>> {
    let flat: Vec<T> = rows.flatten().collect();
    let count = flat.len() / N;
    PyArray1::from_vec(py, flat).reshape([count, N])
}

/// Texture coordinates of triangles' corners as an array (t, 3, 2).
pub(crate) fn coordinates<'py>(
    py: Python<'py>,
    triangles: &[[Vec2; 3]],
) -> PyResult<Bound<'py, PyArray3<f32>>> {
    rows(py, triangles.iter().flatten().map(|place| place.to_array()))?.reshape([triangles.len(), 3, 2])
}

/// A vector of three numbers.
pub(crate) fn vector(name: &str, array: &PyArrayLike1<'_, f64, AllowTypeChange>) -> PyResult<[f64; 3]> {
    match array.as_array().iter().copied().collect::<Vec<_>>().as_slice() {
        &[x, y, z] => Ok([x, y, z]),
        other => Err(build_error(format!("{name}: {} numbers, must be 3", other.len()))),
    }
}
