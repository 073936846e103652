//! Breaking meshes without a simulation. All is in the mesh's frame [m].

use crate::patterns::Pattern;
use crate::{build_error, convert};
use frangible::fracture::{
    CutPiece, Impact, Interface, break_on_grid, cutters, interfaces, mesh_interfaces, resurfaced,
};
use frangible::geometry::{MassProperties, TriMesh, mesh_io};
use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1, PyReadonlyArray2};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;

/// Vertices [m] and triangles.
type MeshArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// Vertices [m], triangles, and the face of the cell that each is a part of.
type CutterArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<u32>>);

/// The cells, laid onto a box.
#[pyfunction]
pub(crate) fn pattern_cutters<'py>(
    py: Python<'py>,
    pattern: &Pattern,
    bounds: ([f64; 3], [f64; 3]),
    at: [f64; 3],
    normal: [f64; 3],
) -> PyResult<Vec<CutterArrays<'py>>> {
    let impact = Impact { point_body: at.into(), normal_body: DVec3::from(normal) };
    let cells = py.detach(|| cutters(&pattern.0, &impact, (bounds.0.into(), bounds.1.into())));
    let arrays = |cell: &frangible::fracture::Cutter| {
        let (vertices, triangles) = mesh_arrays(py, &cell.mesh)?;
        Ok((vertices, triangles, PyArray1::from_slice(py, &cell.face)))
    };
    cells.iter().map(arrays).collect()
}

/// Break a mesh on a grid.
#[pyfunction]
pub(crate) fn break_mesh_on_grid<'py>(
    py: Python<'py>,
    pattern: &Pattern,
    mesh: PyMesh<'_>,
    at: [f64; 3],
    normal: [f64; 3],
    voxels: usize,
) -> PyResult<Bound<'py, PyDict>> {
    let mesh = mesh.to_mesh()?;
    let impact = Impact { point_body: at.into(), normal_body: DVec3::from(normal) };
    let broken = py.detach(|| {
        break_on_grid(&mesh, &pattern.0, &impact, voxels).map(|(volume, pieces)| {
            let surfaces: Vec<_> = pieces.iter().map(|piece| piece.shape.surface()).collect();
            let contacts = interfaces(&pieces);
            (volume, pieces, surfaces, contacts)
        })
    });
    let (volume, pieces, surfaces, contacts) = broken.map_err(build_error)?;

    let list = PyList::empty(py);
    for (piece, mut surface) in pieces.iter().zip(surfaces) {
        for position in &mut surface.mesh.positions {
            *position = piece.parent_from_fragment.point(*position);
        }
        let rotation = piece.parent_from_fragment.matrix();
        let moments = glam::DMat3::from_diagonal(piece.shape.unit_moments);
        let mass = MassProperties {
            volume: piece.shape.volume,
            center: piece.parent_from_fragment.translation,
            inertia: rotation * moments * rotation.transpose(),
        };
        let facts = mass_dict(py, &mass)?;
        let (vertices, triangles) = mesh_arrays(py, &surface.mesh)?;
        facts.set_item("vertices", vertices)?;
        facts.set_item("triangles", triangles)?;
        facts.set_item("coordinates", convert::coordinates(py, &surface.coordinates)?)?;
        facts.set_item("inner", PyArray1::from_vec(py, surface.interior))?;
        list.append(facts)?;
    }
    let facts = PyDict::new(py);
    facts.set_item("volume_m3", volume)?;
    facts.set_item("pieces", list)?;
    facts.set_item("contacts", contact_list(py, &contacts)?)?;
    Ok(facts)
}

/// A mesh as it comes from Python.
#[derive(FromPyObject)]
pub(crate) struct PyMesh<'py>(PyReadonlyArray2<'py, f64>, PyReadonlyArray2<'py, u32>);

impl PyMesh<'_> {
    /// Checked: indices are in range, coordinates finite.
    fn to_mesh(&self) -> PyResult<TriMesh> {
        let (vertices, triangles) = (self.0.as_array(), self.1.as_array());
        if vertices.ncols() != 3 || triangles.ncols() != 3 {
            return Err(build_error("the mesh: rows of another length than 3, must be points and triangles"));
        }
        let positions = vertices.rows().into_iter().map(|row| DVec3::new(row[0], row[1], row[2])).collect();
        let triangles = triangles.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
        let mesh = TriMesh { positions, triangles };
        mesh.check("the mesh").map_err(build_error)?;
        Ok(mesh)
    }
}

fn mesh_arrays<'py>(py: Python<'py>, mesh: &TriMesh) -> PyResult<MeshArrays<'py>> {
    let vertices = convert::rows(py, mesh.positions.iter().map(|position| position.to_array()))?;
    Ok((vertices, convert::rows(py, mesh.triangles.iter().copied())?))
}

fn mass_dict<'py>(py: Python<'py>, mass: &MassProperties) -> PyResult<Bound<'py, PyDict>> {
    let facts = PyDict::new(py);
    facts.set_item("volume_m3", mass.volume)?;
    facts.set_item("center_m", mass.center.to_array())?;
    facts.set_item("unit_inertia_m5", mass.inertia.transpose().to_cols_array_2d())?;
    Ok(facts)
}

fn contact_list<'py>(py: Python<'py>, contacts: &[Interface]) -> PyResult<Bound<'py, PyList>> {
    let list = PyList::empty(py);
    for contact in contacts {
        let facts = PyDict::new(py);
        facts.set_item("a", contact.a)?;
        facts.set_item("b", contact.b)?;
        facts.set_item("area_m2", contact.area)?;
        facts.set_item("centroid_m", contact.centroid.to_array())?;
        facts.set_item("normal", contact.normal.to_array())?;
        list.append(facts)?;
    }
    Ok(list)
}

/// Read a mesh file; equal vertices are made one.
#[pyfunction]
pub(crate) fn load_mesh(py: Python<'_>, path: PathBuf) -> PyResult<MeshArrays<'_>> {
    let name = path.display().to_string();
    let read = || {
        let mut mesh = mesh_io::load(&path)?;
        mesh.check_volume(&name)?;
        mesh.weld();
        Ok::<_, frangible::geometry::MeshError>(mesh)
    };
    mesh_arrays(py, &py.detach(read).map_err(build_error)?)
}

/// Close the holes of a mesh: the mesh, and how many holes there were.
#[pyfunction]
pub(crate) fn fill_holes<'py>(py: Python<'py>, mesh: PyMesh<'_>) -> PyResult<(MeshArrays<'py>, usize)> {
    let mut mesh = mesh.to_mesh()?;
    let holes = py.detach(|| mesh.fill_holes());
    Ok((mesh_arrays(py, &mesh)?, holes))
}

/// Whether outside lies in front of the whole surface and inside behind it.
#[pyfunction]
pub(crate) fn bounds_a_solid(py: Python<'_>, mesh: PyMesh<'_>, spacing: f64) -> PyResult<bool> {
    let mesh = mesh.to_mesh()?;
    Ok(py.detach(|| mesh.bounds_a_solid(spacing)))
}

/// Make the surface of what a mesh encloses anew.
#[pyfunction]
pub(crate) fn resurface<'py>(py: Python<'py>, mesh: PyMesh<'_>, voxels: usize) -> PyResult<MeshArrays<'py>> {
    let mesh = mesh.to_mesh()?;
    mesh_arrays(py, &py.detach(|| resurfaced(&mesh, voxels)).map_err(build_error)?)
}

/// Volume, centre of mass and inertia of what a closed mesh encloses.
#[pyfunction]
pub(crate) fn mesh_mass<'py>(py: Python<'py>, mesh: PyMesh<'_>) -> PyResult<Bound<'py, PyDict>> {
    mass_dict(py, &mesh.to_mesh()?.mass_properties())
}

/// The contacts of pieces that were cut out of a mesh.
#[pyfunction]
pub(crate) fn piece_contacts<'py>(
    py: Python<'py>,
    pieces: Vec<(PyMesh<'_>, PyReadonlyArray1<'_, bool>)>,
) -> PyResult<Bound<'py, PyList>> {
    let mut cut = Vec::with_capacity(pieces.len());
    for (mesh, inner) in &pieces {
        let (mesh, inner) = (mesh.to_mesh()?, inner.as_array().to_vec());
        if inner.len() != mesh.triangles.len() {
            return Err(build_error("the cracks: not as many as triangles, must be true or false for each"));
        }
        cut.push(CutPiece { mesh, inner });
    }
    contact_list(py, &py.detach(|| mesh_interfaces(&cut)))
}
