//! Values on their way to Python and back.

use crate::errors::build_error;
use frangible::{BodyId, id_from_number, no_json};
use glam::Vec2;
use numpy::{AllowTypeChange, Element, PyArray1, PyArray2, PyArray3, PyArrayLike1, PyArrayMethods};
use pyo3::IntoPyObjectExt;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList, PyString, PyTuple};
use serde_json::{Map, Value};

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

/// Nothing in a description is nested as deeply.
const DEEPEST: usize = 12;

/// A Python value in JSON. Values that JSON has no word for become strings that a sentence can
/// show.
pub(crate) fn value(object: &Bound<'_, PyAny>) -> Value {
    nested_value(object, DEEPEST).unwrap_or_else(|| no_json(&kind(object)))
}

/// The same down to so many levels; `None` for what is of another type.
fn nested_value(object: &Bound<'_, PyAny>, levels: usize) -> Option<Value> {
    let Some(below) = levels.checked_sub(1) else {
        return Some(no_json("something nested too deeply"));
    };
    let of_item =
        |item: &Bound<'_, PyAny>| nested_value(item, below).unwrap_or_else(|| no_json(&kind(item)));
    if object.is_none() {
        return Some(Value::Null);
    }
    if let Ok(text) = object.cast::<PyString>() {
        return Some(
            text.to_str().map_or_else(|_| no_json("text with half a character"), Value::from),
        );
    }
    if let Ok(dict) = object.cast::<PyDict>() {
        let mut fields = Map::new();
        for (key, item) in dict.iter() {
            let key = key.str().ok()?.to_string_lossy().into_owned();
            fields.insert(key, of_item(&item));
        }
        return Some(Value::Object(fields));
    }
    if let Ok(list) = object.cast::<PyList>() {
        return Some(list.iter().map(|item| of_item(&item)).collect());
    }
    if let Ok(tuple) = object.cast::<PyTuple>() {
        return Some(tuple.iter().map(|item| of_item(&item)).collect());
    }
    // Arrays and numbers of NumPy; paths.
    if let Ok(plain) = object.call_method0("tolist") {
        return nested_value(&plain, below);
    }
    if let Ok(path) = object.call_method0("__fspath__") {
        return nested_value(&path, below);
    }
    number(object)
}

fn number(object: &Bound<'_, PyAny>) -> Option<Value> {
    if let Ok(flag) = object.extract::<bool>() {
        return Some(Value::Bool(flag));
    }
    // Only whole numbers have it.
    if object.hasattr("__index__").ok()? {
        if let Ok(natural) = object.extract::<u64>() {
            return Some(natural.into());
        }
        if let Ok(integer) = object.extract::<i64>() {
            return Some(integer.into());
        }
        let float = object.extract::<f64>().ok().and_then(serde_json::Number::from_f64);
        return Some(float.map_or_else(|| no_json("a whole number beyond 1.8e308"), Value::Number));
    }
    let float = object.extract::<f64>().ok()?;
    let shown = if float.is_nan() {
        "NaN"
    } else if float > 0.0 {
        "Infinity"
    } else {
        "-Infinity"
    };
    Some(serde_json::Number::from_f64(float).map_or_else(|| no_json(shown), Value::Number))
}

fn kind(object: &Bound<'_, PyAny>) -> String {
    let name = object.get_type().name().map_or_else(|_| "unknown".into(), |name| name.to_string());
    format!("a value of type {name}")
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
    rows(py, triangles.iter().flatten().map(|place| place.to_array()))?.reshape([
        triangles.len(),
        3,
        2,
    ])
}

/// Three numbers that a caller gives for `name`.
pub(crate) fn vector(name: &str, object: &Bound<'_, PyAny>) -> PyResult<[f64; 3]> {
    let Ok(array) = object.extract::<PyArrayLike1<'_, f64, AllowTypeChange>>() else {
        return Err(build_error(format!("{name}: {}, must be three numbers", shown(object))));
    };
    match array.as_array().iter().copied().collect::<Vec<_>>().as_slice() {
        &[x, y, z] => Ok([x, y, z]),
        other => Err(build_error(format!("{name}: {} numbers, must be 3", other.len()))),
    }
}

/// A number that a caller gives for `name`.
pub(crate) fn scalar(name: &str, object: &Bound<'_, PyAny>) -> PyResult<f64> {
    let broken = |_| build_error(format!("{name}: {}, must be a number", shown(object)));
    object.extract().map_err(broken)
}

/// The body that a caller gives the id of; whether it lives is the world's to say.
pub(crate) fn body(object: &Bound<'_, PyAny>) -> PyResult<BodyId> {
    let rule = "must be the id of a body, a whole number as in `World.ids`";
    let broken = |_| build_error(format!("id: {}, {rule}", shown(object)));
    object.extract().map(id_from_number).map_err(broken)
}

/// Letters of a value that a sentence shows.
const SHOWN: usize = 40;

/// A value as Python writes it, or as much of that as a sentence has room for.
fn shown(object: &Bound<'_, PyAny>) -> String {
    let text = object.repr().map_or_else(|_| kind(object), |text| text.to_string());
    let mut letters = text.chars();
    let begin: String = letters.by_ref().take(SHOWN).collect();
    if letters.next().is_some() { format!("{begin}...") } else { begin }
}
