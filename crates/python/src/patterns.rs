//! Patterns, by name and from files.

use crate::errors::build_error;
use crate::mesh::PyMesh;
use crate::{convert, threads};
use frangible::fracture::{Filling, Impact, MOST_CELLS, MeshBreakError, ShatterSettings, shatter};
use frangible::{Fineness, PatternDesc, PatternFile, fracture};
use numpy::{PyArray1, PyArray2};
use pyo3::exceptions::{PyIndexError, PyValueError};
use pyo3::prelude::*;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Offline a pattern is searched for until the number of pieces is right up to this part of it: a
/// try costs little.
const PIECES_WITHIN: f64 = 0.02;

/// A box broken into cells, and the description that it was made by, if it was.
#[pyclass(frozen, module = "frangible._frangible")]
pub(crate) struct Pattern(pub(crate) fracture::Pattern, Option<PatternDesc>);

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
                    let sentence = format!(
                        "{field}: must be left out for the pattern in {name}, which is what it is"
                    );
                    return Err(PyValueError::new_err(sentence));
                }
            }
            return Self::of_file(Path::new(name));
        }
        let desc = PatternDesc::named(name, cells, seed).map_err(build_error)?;
        let pattern = desc.pattern().map_err(build_error)?;
        Ok(Self(pattern, Some(desc)))
    }

    fn of_file(path: &Path) -> PyResult<Self> {
        fracture::Pattern::load(path).map(|pattern| Self(pattern, None)).map_err(build_error)
    }

    /// The pattern that `attempt` makes about so many pieces with, and how many.
    fn searched(
        &self,
        pieces: usize,
        filling: Option<&Filling>,
        mut attempt: impl FnMut(&fracture::Pattern) -> usize,
    ) -> Option<(Self, usize)> {
        // A pattern without a description, such as a file's, cannot be made finer.
        let desc = self
            .1
            .clone()
            .unwrap_or_else(|| PatternDesc::File(PatternFile { path: PathBuf::new() }));
        let fineness = Fineness::new(desc, Arc::new(self.0.clone()));
        let counted = |pattern: &fracture::Pattern| (attempt(pattern), ());
        let found = fineness.search_in(filling, (pieces, PIECES_WITHIN), counted)?;
        Some((Self(fracture::Pattern::clone(&found.pattern), self.1.clone()), found.count))
    }

    fn seed(&self) -> Option<u64> {
        self.1.as_ref().and_then(PatternDesc::seed)
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
    fn named(
        py: Python<'_>,
        name: &str,
        cells: Option<usize>,
        seed: Option<u64>,
    ) -> PyResult<Self> {
        threads::detached(py, || Self::find(name, cells, seed))?
    }

    #[staticmethod]
    fn load(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        threads::detached(py, || Self::of_file(&path))?
    }

    fn save(&self, py: Python<'_>, path: PathBuf) -> PyResult<()> {
        threads::detached(py, || self.0.save(&path))?.map_err(build_error)
    }

    #[pyo3(signature = (pieces, mesh=None, at=[0.0; 3], normal=[0.0, 1.0, 0.0], voxels=48, smallest_voxels=27.0))]
    #[allow(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
    fn with_pieces(
        &self,
        py: Python<'_>,
        pieces: usize,
        mesh: Option<PyMesh<'_>>,
        at: [f64; 3],
        normal: [f64; 3],
        voxels: usize,
        smallest_voxels: f64,
    ) -> PyResult<(Self, usize)> {
        check_pieces(pieces)?;
        let found = match mesh {
            None => threads::detached(py, || self.searched(pieces, None, fracture::Pattern::len))?,
            Some(mesh) => {
                let mesh = mesh.to_mesh()?;
                let impact = Impact { point_body: at.into(), normal_body: normal.into() };
                let settings = ShatterSettings {
                    smallest_fragment_voxels: smallest_voxels,
                    ..ShatterSettings::default()
                };
                threads::detached(py, || {
                    let body = fracture::sampled_body(&mesh, voxels)?;
                    let of_body =
                        |seed| Filling::of_body(&body, &impact, &settings, (pieces, seed));
                    let filling = self.seed().and_then(of_body);
                    Ok(self.searched(pieces, filling.as_ref(), |pattern| {
                        shatter(&body, pattern, &impact, &settings).len()
                    }))
                })?
                .map_err(|error: MeshBreakError| build_error(error))?
            }
        };
        found.ok_or_else(no_cells)
    }

    /// As [`Pattern::with_pieces`]; `attempt` breaks something, and says how many pieces there are.
    /// With a closed mesh the patterns are made for it.
    #[pyo3(signature = (pieces, attempt, mesh=None, at=[0.0; 3], normal=[0.0, 1.0, 0.0], number=0))]
    #[allow(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
    fn with_pieces_by(
        &self,
        py: Python<'_>,
        pieces: usize,
        attempt: &Bound<'_, PyAny>,
        mesh: Option<PyMesh<'_>>,
        at: [f64; 3],
        normal: [f64; 3],
        number: u64,
    ) -> PyResult<(Self, usize)> {
        check_pieces(pieces)?;
        let impact = Impact { point_body: at.into(), normal_body: normal.into() };
        let mesh = mesh.map(|mesh| mesh.to_mesh()).transpose()?;
        let filling = threads::detached(py, || {
            let seed = self.seed()?.wrapping_add(number);
            Filling::of_mesh(mesh.as_ref()?, &impact, (pieces, seed))
        })?;
        // An exception ends the search.
        let mut failed = None;
        let found = self.searched(pieces, filling.as_ref(), |pattern| {
            let tried = Bound::new(py, Self(pattern.clone(), None));
            let count = tried.and_then(|tried| attempt.call1((tried,))?.extract());
            count.unwrap_or_else(|error| {
                failed = Some(error);
                pieces
            })
        });
        if let Some(error) = failed {
            return Err(error);
        }
        found.ok_or_else(no_cells)
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

    #[getter]
    fn is_planar(&self) -> bool {
        self.0.planar().is_some()
    }

    #[getter]
    fn has_middle(&self) -> bool {
        matches!(self.1, None | Some(PatternDesc::Radial(_) | PatternDesc::File(_)))
    }

    fn is_joint(&self, cell: usize) -> PyResult<bool> {
        self.check(cell)?;
        Ok(self.0.is_joint(cell))
    }

    #[pyo3(signature = (cell, longest_edge=f64::INFINITY))]
    fn region_mesh<'py>(
        &self,
        py: Python<'py>,
        cell: usize,
        longest_edge: f64,
    ) -> PyResult<Mesh<'py>> {
        self.check(cell)?;
        let mesh = threads::detached(py, || self.0.region_mesh(cell, longest_edge))?;
        let vertices =
            convert::rows(py, mesh.positions.iter().map(|position| position.to_array()))?;
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

fn check_pieces(pieces: usize) -> PyResult<()> {
    let sentence = || format!("pieces: {pieces}, must be from 1 to {MOST_CELLS}");
    if (1..=MOST_CELLS).contains(&pieces) { Ok(()) } else { Err(build_error(sentence())) }
}

fn no_cells() -> PyErr {
    build_error("pattern: has no cells, must have at least 1")
}

/// Name and one line for every kind of pattern.
#[pyfunction]
pub(crate) fn patterns() -> Vec<(&'static str, &'static str)> {
    PatternDesc::names().collect()
}
