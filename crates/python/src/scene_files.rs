//! Scenes on their way into the engine.

use crate::convert;
use crate::errors::build_error;
use frangible::SceneDesc;
use pyo3::prelude::*;
use pyo3::types::PyString;

/// A scene of plain data, or of JSON.
pub(crate) fn scene(readable: &Bound<'_, PyAny>) -> PyResult<SceneDesc> {
    let Ok(text) = readable.cast::<PyString>() else {
        return SceneDesc::from_value(convert::value(readable)).map_err(build_error);
    };
    if let Some(scene) = text.to_str().ok().and_then(|text| serde_json::from_str(text).ok()) {
        return Ok(scene);
    }
    // Python also reads NaN, and numbers of any size: the sentence can name their fields.
    let read =
        readable.py().import("frangible.scenes")?.call_method1("parse_json", ("scene", text))?;
    SceneDesc::from_value(convert::value(&read)).map_err(build_error)
}

/// What is made of a scene whose files are read, and converted for as long as it takes, in Python.
pub(crate) fn with_files<T>(
    scene: &Bound<'_, PyAny>,
    make: impl FnOnce(&Bound<'_, PyAny>) -> PyResult<T>,
) -> PyResult<T> {
    let py = scene.py();
    let files = py.import("frangible.scenes")?.call_method1("readable_scene", (scene,))?;
    let made = make(&files.call_method0("__enter__")?);
    match &made {
        Ok(_) => files.call_method1("__exit__", (py.None(), py.None(), py.None()))?,
        Err(error) => files
            .call_method1("__exit__", (error.get_type(py), error.value(py), error.traceback(py)))?,
    };
    made
}
