//! A mesh as it comes from Python.

use crate::errors::build_error;
use frangible::geometry::TriMesh;
use glam::DVec3;
use numpy::PyReadonlyArray2;
use pyo3::prelude::*;

/// A mesh as it comes from Python.
#[derive(FromPyObject)]
pub(crate) struct PyMesh<'py>(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, u32>);

impl PyMesh<'_> {
    /// Checked: indices are in range, coordinates finite.
    pub(crate) fn to_mesh(&self) -> PyResult<TriMesh> {
        let (vertices, triangles) = (self.0.as_array(), self.1.as_array());
        if vertices.ncols() != 3 || triangles.ncols() != 3 {
            return Err(build_error(
                "the mesh: rows of another length than 3, must be points and triangles",
            ));
        }
        let positions =
            vertices.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
        let triangles = triangles.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
        let mesh = TriMesh { positions, triangles };
        mesh.check("the mesh").map_err(build_error)?;
        Ok(mesh)
    }
}
