//! Attributes of mesh files, and the closest triangles to lay them on others.

use crate::{build_error, convert};
use frangible::geometry::bvh::{Bvh, closest_point_on_triangle};
use frangible::geometry::mesh_io::{self, CornerAttributes, FaceAttributes};
use glam::DVec3;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::path::PathBuf;

/// Attributes of a mesh file's triangles; `None` if it says nothing.
#[pyfunction]
pub(crate) fn mesh_attributes(py: Python<'_>, path: PathBuf) -> PyResult<Option<Bound<'_, PyDict>>> {
    let (mesh, said) = py.detach(|| mesh_io::load_with_attributes(&path)).map_err(build_error)?;
    if said.is_empty() {
        return Ok(None);
    }
    let count = said.faces.len();
    let facts = PyDict::new(py);
    let corners = (0..count).flat_map(|triangle| mesh.corners(triangle)).map(|corner| corner.to_array());
    facts.set_item("corners", convert::rows(py, corners)?.reshape([count, 3, 3])?)?;
    facts.set_item("objects", &said.objects)?;
    facts.set_item("materials", &said.materials)?;
    let index = |of: fn(&FaceAttributes) -> Option<u32>| {
        PyArray1::from_iter(py, said.faces.iter().map(|face| of(face).map_or(-1, |index| index as i32)))
    };
    facts.set_item("object", index(|face| face.object))?;
    facts.set_item("material", index(|face| face.material))?;

    // Corner by corner; not a number where there is nothing.
    let all = || said.faces.iter().flat_map(|face| &face.corners);
    fn numbers<const N: usize>(values: Option<[f32; N]>) -> [f32; N] {
        values.unwrap_or([f32::NAN; N])
    }
    let place = |corner: &CornerAttributes| numbers(corner.coordinates.map(|place| place.to_array()));
    facts.set_item("coordinates", convert::rows(py, all().map(place))?.reshape([count, 3, 2])?)?;
    let normal = |corner: &CornerAttributes| numbers(corner.normal.map(|normal| normal.to_array()));
    facts.set_item("normals", convert::rows(py, all().map(normal))?.reshape([count, 3, 3])?)?;
    let colour = |corner: &CornerAttributes| numbers(corner.colour);
    facts.set_item("colours", convert::rows(py, all().map(colour))?.reshape([count, 3, 4])?)?;
    Ok(Some(facts))
}

/// For each point the closest triangle of its group: one that faces as its normal does, if that is
/// within reach of the closest of all.
#[pyfunction]
#[allow(clippy::too_many_arguments, reason = "each is an argument of the Python function")]
pub(crate) fn closest_triangles<'py>(
    py: Python<'py>,
    corners: PyReadonlyArray3<'py, f64>,
    groups: PyReadonlyArray1<'py, i64>,
    points: PyReadonlyArray2<'py, f64>,
    normals: PyReadonlyArray2<'py, f64>,
    wanted: PyReadonlyArray1<'py, i64>,
    reach: PyReadonlyArray1<'py, f64>,
) -> PyResult<Bound<'py, PyArray1<i64>>> {
    let (corners, groups, wanted) = (corners.as_array(), groups.as_array(), wanted.as_array());
    let (points, normals, reach) = (points.as_array(), normals.as_array(), reach.as_array());
    let three = corners.shape()[1..] == [3, 3] && points.ncols() == 3 && normals.ncols() == 3;
    let count = points.nrows();
    let lists = [normals.nrows(), wanted.len(), reach.len()];
    if !three || corners.shape()[0] != groups.len() || lists != [count; 3] {
        return Err(build_error(
            "the triangles: rows of another length than 3, or lists of different lengths",
        ));
    }
    let corner =
        |triangle: usize, at: usize| DVec3::from_array([0, 1, 2].map(|axis| corners[[triangle, at, axis]]));
    let triangles: Vec<[DVec3; 3]> =
        (0..groups.len()).map(|triangle| [0, 1, 2].map(|at| corner(triangle, at))).collect();
    let groups = groups.to_vec();
    let row = |array: &numpy::ndarray::ArrayView2<f64>, row: usize| {
        DVec3::new(array[[row, 0]], array[[row, 1]], array[[row, 2]])
    };
    let queries: Vec<(DVec3, DVec3, i64, f64)> =
        (0..count).map(|n| (row(&points, n), row(&normals, n), wanted[n], reach[n])).collect();
    let found: Vec<i64> = py.detach(|| {
        let tree = Bvh::new(&triangles);
        let faces: Vec<DVec3> = triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).collect();
        let members = Groups::new(&groups);
        let closest = |&(point, normal, group, reach): &(DVec3, DVec3, i64, f64)| {
            // Of a small group each is asked: it may be far away, behind many others.
            let few = members.of(group);
            if (1..=MOST_ASKED).contains(&few.len()) {
                let asked = few.iter().map(|&triangle| {
                    let way = closest_point_on_triangle(point, &triangles[triangle]) - point;
                    (way.length(), triangle)
                });
                let asked: Vec<(f64, usize)> = asked.collect();
                let nearest = |among: &mut dyn Iterator<Item = &(f64, usize)>| {
                    among.min_by(|a, b| a.0.total_cmp(&b.0)).copied()
                };
                let Some((distance, any)) = nearest(&mut asked.iter()) else { return -1 };
                let facing = |one: &&(f64, usize)| one.0 < distance + reach && faces[one.1].dot(normal) > 0.0;
                let best = nearest(&mut asked.iter().filter(facing));
                return best.map_or(any, |best| best.1) as i64;
            }
            let own = |triangle: usize| group < 0 || groups[triangle] == group;
            let any =
                tree.closest_of(point, f64::INFINITY, own).or_else(|| tree.closest(point, f64::INFINITY));
            let Some(any) = any else { return -1 };
            // A sheet's other side is near, too.
            let bound = any.distance_squared.sqrt() + reach;
            let facing = |triangle: usize| own(triangle) && faces[triangle].dot(normal) > 0.0;
            let best = tree.closest_of(point, bound * bound, facing).unwrap_or(any);
            best.triangle as i64
        };
        queries.par_iter().map(closest).collect()
    });
    Ok(PyArray1::from_vec(py, found))
}

/// Triangles of a group of at most so many are asked one by one.
const MOST_ASKED: usize = 64;

/// Which triangles are in each group.
struct Groups {
    /// Group and triangle, sorted.
    members: Vec<(i64, usize)>,
    triangles: Vec<usize>,
}

impl Groups {
    fn new(groups: &[i64]) -> Self {
        let mut members: Vec<(i64, usize)> = groups.iter().copied().zip(0..).collect();
        members.sort_unstable();
        let triangles = members.iter().map(|&(_, triangle)| triangle).collect();
        Self { members, triangles }
    }

    fn of(&self, group: i64) -> &[usize] {
        let first = self.members.partition_point(|&(other, _)| other < group);
        let last = self.members.partition_point(|&(other, _)| other <= group);
        &self.triangles[first..last]
    }
}
