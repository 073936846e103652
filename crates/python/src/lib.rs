//! The Python door: `frangible._frangible`, thin over the engine. `python/frangible/_frangible.pyi`
//! documents it.

mod attributes;
mod breaking;
mod convert;
mod errors;
mod interrupt;
mod memory;
mod mesh;
mod meshopt;
mod own_world;
mod patterns;
mod scene_files;
mod threads;
mod world;

use errors::{BuildError, build_error};
use frangible::geometry::{MeshError, mesh_io};
use frangible::{Method, SceneDesc};
use frangible_shots::claims::{CLAIMS, Claim, Finding};
use frangible_shots::{SHOTS, Shot, ShotOptions};
use interrupt::{interruptible, interruptible_in};
use pyo3::exceptions::PyKeyError;
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::ThreadPoolBuilder;
use std::path::PathBuf;

/// Name and one line for every shot.
#[pyfunction]
fn shots() -> Vec<(&'static str, &'static str)> {
    SHOTS.iter().map(|shot| (shot.name, shot.caption)).collect()
}

/// What `shot_scene` takes for what it is not told.
#[pyfunction]
fn shot_defaults(py: Python<'_>) -> PyResult<Bound<'_, PyDict>> {
    let defaults = ShotOptions::default();
    let values = PyDict::new(py);
    values.set_item("fps", defaults.frames_per_second)?;
    values.set_item(
        "method",
        convert::json(py, &serde_json::to_value(defaults.method).map_err(build_error)?)?,
    )?;
    values.set_item("seed", defaults.seed)?;
    Ok(values)
}

/// How many frames a shot takes at `fps` frames per second.
#[pyfunction]
#[pyo3(signature = (name, fps=None))]
fn shot_frames(name: &str, fps: Option<f64>) -> PyResult<u32> {
    let shot = Shot::find(name).map_err(build_error)?;
    Ok(shot.frames_at(frame_rate(fps)?))
}

/// As given, or the default.
fn frame_rate(fps: Option<f64>) -> PyResult<f64> {
    match fps {
        None => Ok(ShotOptions::default().frames_per_second),
        Some(fps) if fps > 0.0 && fps.is_finite() => Ok(fps),
        Some(fps) => Err(build_error(format!("fps: {fps}, must be a number > 0"))),
    }
}

/// The scene of a shot, as JSON.
#[pyfunction]
#[pyo3(signature = (name, *, mesh=None, fps=None, method=None, seed=None, thickness=None))]
fn shot_scene(
    name: &str,
    mesh: Option<PathBuf>,
    fps: Option<f64>,
    method: Option<&str>,
    seed: Option<u64>,
    thickness: Option<f64>,
) -> PyResult<String> {
    let defaults = ShotOptions::default();
    let method = match method {
        Some(method) => frangible::read::<Method>(method.into(), "method").map_err(build_error)?,
        None => defaults.method,
    };
    let options = ShotOptions {
        mesh,
        thickness,
        frames_per_second: frame_rate(fps)?,
        method,
        seed: seed.unwrap_or(defaults.seed),
    };
    let scene = Shot::find(name).and_then(|shot| shot.scene(&options)).map_err(build_error)?;
    serde_json::to_string(&scene).map_err(build_error)
}

/// The JSON Schema of scenes.
#[pyfunction]
fn scene_schema(py: Python<'_>) -> PyResult<Bound<'_, PyAny>> {
    convert::json(py, &frangible::schema::<SceneDesc>())
}

/// Name, what is promised and who says so, for every claim.
#[pyfunction]
fn claims() -> Vec<(&'static str, &'static str, &'static str)> {
    CLAIMS.iter().map(|claim| (claim.name, claim.says, claim.source)).collect()
}

/// Measures a claim, on one thread.
#[pyfunction]
fn check_claim<'py>(py: Python<'py>, name: &str) -> PyResult<Vec<Bound<'py, PyDict>>> {
    let claim = Claim::find(name).map_err(|error| PyKeyError::new_err(error.to_string()))?;
    let pool = ThreadPoolBuilder::new().num_threads(1).build().map_err(build_error)?;
    let findings = interruptible_in(py, &pool, || py.check_signals(), || claim.check())?;
    let as_dict = |finding: &Finding| {
        let facts = PyDict::new(py);
        facts.set_item("quantity", &finding.quantity)?;
        facts.set_item("unit", finding.unit)?;
        facts.set_item("measured", finding.measured)?;
        facts.set_item("low", finding.low)?;
        facts.set_item("high", finding.high)?;
        facts.set_item("holds", finding.holds())?;
        facts.set_item("bounded", finding.is_bounded())?;
        Ok(facts)
    };
    findings.iter().map(as_dict).collect()
}

/// What a mesh file holds.
#[pyfunction]
fn mesh_info<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyDict>> {
    let name = path.display().to_string();
    let own_name = name.clone();
    let read = move || {
        let mesh = mesh_io::load(&path)?;
        let clean = mesh.cleaned(&own_name);
        Ok::<_, MeshError>((mesh.info(), clean))
    };
    let (info, clean) = interruptible(py, read)?.map_err(build_error)?;
    let facts = PyDict::new(py);
    facts.set_item("vertices", info.vertices)?;
    facts.set_item("triangles", info.triangles)?;
    facts.set_item("parts", info.parts)?;
    let whole = clean.as_ref().is_ok_and(|clean| {
        clean.changes.holes == 0 && clean.changes.turned == 0 && clean.changes.sheets.is_empty()
    });
    facts.set_item("watertight", whole)?;
    facts.set_item("low_m", info.bounds.0.to_array())?;
    facts.set_item("high_m", info.bounds.1.to_array())?;
    match clean {
        Ok(clean) => {
            facts.set_item("notes", clean.changes.sentences())?;
            let mass = clean.mesh.mass_properties();
            facts.set_item("volume_m3", mass.volume)?;
            facts.set_item("center_m", mass.center.to_array())?;
            facts.set_item("unit_inertia_m5", mass.inertia.transpose().to_cols_array_2d())?;
        }
        Err(error) => {
            let sentence = error.to_string();
            let sentence = sentence.strip_prefix(&format!("{name}: ")).unwrap_or(&sentence);
            facts.set_item("notes", [sentence])?;
            facts.set_item("volume_m3", 0.0)?;
        }
    }
    Ok(facts)
}

/// The compiled module.
#[pymodule]
fn _frangible(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.setattr("_memory_kept_ms", memory::keep_freed())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add("BuildError", module.py().get_type::<BuildError>())?;
    module.add("MOST_TRIANGLES", frangible::geometry::TriMesh::MOST_TRIANGLES)?;
    module.add_class::<world::World>()?;
    module.add_class::<patterns::Pattern>()?;
    module.add_function(wrap_pyfunction!(patterns::patterns, module)?)?;
    module.add_function(wrap_pyfunction!(shots, module)?)?;
    module.add_function(wrap_pyfunction!(shot_defaults, module)?)?;
    module.add_function(wrap_pyfunction!(shot_frames, module)?)?;
    module.add_function(wrap_pyfunction!(shot_scene, module)?)?;
    module.add_function(wrap_pyfunction!(scene_schema, module)?)?;
    module.add_function(wrap_pyfunction!(claims, module)?)?;
    module.add_function(wrap_pyfunction!(check_claim, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::pattern_cutters, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::break_mesh_on_grid, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::load_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::clean_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::thicken_mesh, module)?)?;
    module.add_function(wrap_pyfunction!(attributes::mesh_attributes, module)?)?;
    module.add_function(wrap_pyfunction!(attributes::closest_triangles, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::resurface, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::mesh_mass, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::piece_contacts, module)?)?;
    module.add_function(wrap_pyfunction!(breaking::join_slivers, module)?)?;
    module.add_function(wrap_pyfunction!(meshopt::decode_meshopt, module)?)?;
    module.add_function(wrap_pyfunction!(mesh_info, module)?)
}
