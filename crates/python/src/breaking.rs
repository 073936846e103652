//! Breaking meshes without a simulation. All is in the mesh's frame [m].

use crate::convert;
use crate::errors::build_error;
use crate::interrupt::interruptible;
use crate::mesh::PyMesh;
use crate::patterns::Pattern;
use frangible::default_voxels;
use frangible::fracture::{
    CutPiece, Impact, Interface, ShatterSettings, Smallest, cutters, interfaces, mesh_interfaces,
    resurfaced, sampled_body, shatter,
};
use frangible::geometry::{MassProperties, TriMesh, mesh_io};
use glam::DVec3;
use numpy::{PyArray1, PyArray2, PyReadonlyArray1};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};
use std::path::PathBuf;

/// Vertices [m] and triangles.
type MeshArrays<'py> = (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>);

/// Vertices [m], triangles, and the face of the cell that each is a part of.
type CutterArrays<'py> =
    (Bound<'py, PyArray2<f64>>, Bound<'py, PyArray2<u32>>, Bound<'py, PyArray1<u32>>);

/// The cells, laid onto a box.
#[pyfunction]
#[pyo3(signature = (pattern, bounds, at, normal, coarseness=1.0))]
pub(crate) fn pattern_cutters<'py>(
    py: Python<'py>,
    pattern: &Pattern,
    bounds: ([f64; 3], [f64; 3]),
    at: [f64; 3],
    normal: [f64; 3],
    coarseness: f64,
) -> PyResult<Vec<CutterArrays<'py>>> {
    let impact = Impact { point_body: at.into(), normal_body: DVec3::from(normal) };
    let pattern = pattern.0.clone();
    let bounds = (bounds.0.into(), bounds.1.into());
    let cells = interruptible(py, move || cutters(&pattern, &impact, bounds, coarseness))?;
    let arrays = |cell: &frangible::fracture::Cutter| {
        let (vertices, triangles) = mesh_arrays(py, &cell.mesh)?;
        Ok((vertices, triangles, PyArray1::from_slice(py, &cell.face)))
    };
    cells.iter().map(arrays).collect()
}

/// Break a mesh on a grid.
#[pyfunction]
#[pyo3(signature = (pattern, mesh, at, normal, voxels, smallest=Smallest::default().part))]
#[allow(clippy::too_many_arguments, reason = "each is a keyword of the Python function")]
pub(crate) fn break_mesh_on_grid<'py>(
    py: Python<'py>,
    pattern: &Pattern,
    mesh: PyMesh<'_>,
    at: [f64; 3],
    normal: [f64; 3],
    voxels: usize,
    smallest: f64,
) -> PyResult<Bound<'py, PyDict>> {
    let mesh = mesh.to_mesh()?;
    let smallest = Smallest { part: smallest, ..Smallest::default() };
    let settings = ShatterSettings { smallest, ..ShatterSettings::default() };
    let impact = Impact { point_body: at.into(), normal_body: DVec3::from(normal) };
    let pattern = pattern.0.clone();
    let broken = interruptible(py, move || {
        sampled_body(&mesh, voxels).map(|body| {
            let (volume, pieces) = (body.volume, shatter(&body, &pattern, &impact, &settings));
            let surfaces: Vec<_> = pieces.iter().map(|piece| piece.shape.surface()).collect();
            let contacts = interfaces(&pieces);
            (volume, pieces, surfaces, contacts)
        })
    });
    let (volume, pieces, surfaces, contacts) = broken?.map_err(build_error)?;

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

/// Read a mesh file as it is.
#[pyfunction]
pub(crate) fn load_mesh(py: Python<'_>, path: PathBuf) -> PyResult<MeshArrays<'_>> {
    mesh_arrays(py, &interruptible(py, move || mesh_io::load(&path))?.map_err(build_error)?)
}

/// Make plates of open parts; their number comes behind the mesh.
#[pyfunction]
#[pyo3(signature = (mesh, thickness, name="the mesh".to_owned()))]
pub(crate) fn thicken_mesh<'py>(
    py: Python<'py>,
    mesh: PyMesh<'_>,
    thickness: f64,
    name: String,
) -> PyResult<(MeshArrays<'py>, usize)> {
    let mesh = mesh.to_mesh()?;
    let thick =
        interruptible(py, move || mesh.thickened(thickness, &name))?.map_err(build_error)?;
    Ok((mesh_arrays(py, &thick.mesh)?, thick.plates))
}

/// Make solids of raw triangles.
#[pyfunction]
#[pyo3(signature = (mesh, name="the mesh".to_owned()))]
pub(crate) fn clean_mesh<'py>(
    py: Python<'py>,
    mesh: PyMesh<'_>,
    name: String,
) -> PyResult<Bound<'py, PyDict>> {
    let mesh = mesh.to_mesh()?;
    let clean = interruptible(py, move || {
        mesh.cleaned(&name).map(|clean| {
            let meeting = clean.meeting();
            (clean, meeting)
        })
    });
    let (clean, meeting) = clean?.map_err(build_error)?;
    let facts = PyDict::new(py);
    let (vertices, triangles) = mesh_arrays(py, &clean.mesh)?;
    facts.set_item("vertices", vertices)?;
    facts.set_item("triangles", triangles)?;
    let source = clean.source.iter().map(|source| source.map_or(-1, i64::from));
    facts.set_item("source", PyArray1::from_iter(py, source))?;
    facts.set_item("solid", PyArray1::from_slice(py, &clean.solid))?;
    facts.set_item("meets", PyArray1::from_vec(py, meeting.others))?;
    facts.set_item("buried", PyArray1::from_vec(py, meeting.buried))?;
    facts.set_item("voxels", default_voxels(&clean))?;
    facts.set_item("holes", clean.changes.holes)?;
    facts.set_item("notes", clean.changes.sentences())?;
    Ok(facts)
}

/// Make the surface of what a mesh encloses anew.
#[pyfunction]
pub(crate) fn resurface<'py>(
    py: Python<'py>,
    mesh: PyMesh<'_>,
    voxels: usize,
) -> PyResult<MeshArrays<'py>> {
    let mesh = mesh.to_mesh()?;
    let anew = interruptible(py, move || resurfaced(&mesh, voxels))?;
    mesh_arrays(py, &anew.map_err(build_error)?)
}

/// Volume, centre of mass and inertia of what a closed mesh encloses.
#[pyfunction]
pub(crate) fn mesh_mass<'py>(py: Python<'py>, mesh: PyMesh<'_>) -> PyResult<Bound<'py, PyDict>> {
    mass_dict(py, &mesh.to_mesh()?.mass_properties())
}

/// Which pieces stay together so that none is smaller than a part of the mean one: for each the
/// number of the one that it joins.
#[pyfunction]
pub(crate) fn join_slivers(
    volumes: Vec<f64>,
    contacts: Vec<([usize; 2], f64)>,
    smallest: f64,
) -> PyResult<Vec<usize>> {
    if contacts.iter().any(|(pair, _)| pair.iter().any(|&piece| piece >= volumes.len())) {
        return Err(build_error("contacts: a number of no piece, must be those of the volumes"));
    }
    let smallest = Smallest { part: smallest, ..Smallest::default() };
    Ok(frangible::fracture::join_slivers(&volumes, &contacts, &smallest))
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
            return Err(build_error(
                "the cracks: not as many as triangles, must be true or false for each",
            ));
        }
        cut.push(CutPiece { mesh, inner });
    }
    contact_list(py, &interruptible(py, move || mesh_interfaces(&cut))?)
}
