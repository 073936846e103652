//! Patterns, by name and from files.

use crate::{build_error, convert, threads};
use frangible::{PatternDesc, fracture};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};

/// A box broken into cells.
#[pyclass(frozen, module = "frangible._frangible")]
pub(crate) struct Pattern(pub(crate) fracture::Pattern);

/// Vertices (v, 3) and triangles (t, 3).
type Mesh<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// Faces, corners, volumes and whether they are inner, (n,) each.
type Shapes<'py> = (
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<u32>>,
    Bound<'py, PyArray1<f64>>,
    Bound<'py, PyArray1<bool>>,
);

impl Pattern {
    /// One that a file holds, if the name has an ending, else one by its name.
    pub(crate) fn find(name: &str, cells: Option<usize>, seed: Option<u64>) -> PyResult<Self> {
        if Path::new(name).extension().is_some() {
            for (field, given) in [("cells", cells.is_some()), ("seed", seed.is_some())] {
                if given {
                    let sentence =
                        format!("{field}: must be left out for the pattern in {name}, which is what it is");
                    return Err(PyValueError::new_err(sentence));
                }
            }
            return fracture::Pattern::load(Path::new(name)).map(Self).map_err(build_error);
        }
        let desc = PatternDesc::named(name, cells, seed).map_err(build_error)?;
        desc.pattern().map(Self).map_err(build_error)
    }

    fn check(&self, cell: usize) -> PyResult<()> {
        let cells = self.0.len();
        let sentence = || format!("cell: {cell}, must be below the number of cells, {cells}");
        if cell < cells { Ok(()) } else { Err(PyIndexError::new_err(sentence())) }
    }
}

#[pymethods]
impl Pattern {
    #[staticmethod]
    #[pyo3(signature = (name, *, cells=None, seed=None))]
    fn named(py: Python<'_>, name: &str, cells: Option<usize>, seed: Option<u64>) -> PyResult<Self> {
        threads::detached(py, || Self::find(name, cells, seed))?
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        threads::detached(py, || fracture::Pattern::load(&path))?.map(Self).map_err(build_error)
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        threads::detached(py, || self.0.save(&path))?.map_err(build_error)
    }

    fn __len__(&self) -> usize {
        self.0.len()
    }

    fn __eq__(&self, other: &Self) -> bool {
        self.0 == other.0
    }

    #[getter]
    fn half_extent<'py>(&self, py: Python<'py>) -> Bound<'py, PyArray1<f64>> {
        PyArray1::from_slice(py, &self.0.half_extent.to_array())
    }

    fn is_joint(&self, cell: usize) -> PyResult<bool> {
        self.check(cell)?;
        Ok(self.0.is_joint(cell))
    }

    #[pyo3(signature = (cell, longest_edge=f64::INFINITY))]
    fn region_mesh<'py>(&self, py: Python<'py>, cell: usize, longest_edge: f64) -> PyResult<Mesh<'py>> {
        self.check(cell)?;
        let mesh = threads::detached(py, || self.0.region_mesh(cell, longest_edge))?;
        let vertices = convert::rows(py, mesh.positions.iter().map(|position| position.to_array()))?;
        Ok((vertices, convert::rows(py, mesh.triangles.into_iter())?))
    }

    fn shapes<'py>(&self, py: Python<'py>) -> PyResult<Shapes<'py>> {
        let shapes = threads::detached(py, || self.0.cell_shapes())?;
        let faces = shapes.iter().map(|shape| shape.faces as u32);
        let corners = shapes.iter().map(|shape| shape.corners as u32);
        Ok((
            PyArray1::from_iter(py, faces),
            PyArray1::from_iter(py, corners),
            PyArray1::from_iter(py, shapes.iter().map(|shape| shape.volume)),
            PyArray1::from_iter(py, shapes.iter().map(|shape| shape.inner)),
        ))
    }
}

/// Name and one line for every kind of pattern.
#[pyfunction]
pub(crate) fn patterns() -> Vec<(&'static str, &'static str)> {
    PatternDesc::names().collect()
}
