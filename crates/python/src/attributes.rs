//! Attributes of mesh files, and the closest triangles to lay them on others.

use crate::convert;
use crate::errors::build_error;
use frangible::geometry::{Bvh, closest_point_on_triangle};
use frangible::geometry::{CornerAttributes, FaceAttributes, mesh_io};
use glam::DVec3;
use numpy::{PyArray1, PyArrayMethods, PyReadonlyArray1, PyReadonlyArray2, PyReadonlyArray3};
use pyo3::prelude::*;
use pyo3::types::PyDict;
use rayon::prelude::*;
use std::path::PathBuf;

/// Attributes of a mesh file's triangles; `None` if it says nothing.
#[pyfunction]
pub(crate) fn mesh_attributes(
    py: Python<'_>,
    path: PathBuf,
) -> PyResult<Option<Bound<'_, PyDict>>> {
    let (mesh, said) = py.detach(|| mesh_io::load_with_attributes(&path)).map_err(build_error)?;
    if said.is_empty() {
        return Ok(None);
    }
    let count = said.faces.len();
    let facts = PyDict::new(py);
    let corners =
        (0..count).flat_map(|triangle| mesh.corners(triangle)).map(|corner| corner.to_array());
    facts.set_item("corners", convert::rows(py, corners)?.reshape([count, 3, 3])?)?;
    facts.set_item("objects", &said.objects)?;
    facts.set_item("materials", &said.materials)?;
    let index = |of: fn(&FaceAttributes) -> Option<u32>| {
        PyArray1::from_iter(
            py,
            said.faces.iter().map(|face| of(face).map_or(-1, |index| index as i32)),
        )
    };
    facts.set_item("object", index(|face| face.object))?;
    facts.set_item("material", index(|face| face.material))?;

    // Corner by corner; not a number where there is nothing.
    let all = || said.faces.iter().flat_map(|face| &face.corners);
    fn numbers<const N: usize>(values: Option<[f32; N]>) -> [f32; N] {
        values.unwrap_or([f32::NAN; N])
    }
    let place =
        |corner: &CornerAttributes| numbers(corner.coordinates.map(|place| place.to_array()));
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
    let corner = |triangle: usize, at: usize| {
        DVec3::from_array([0, 1, 2].map(|axis| corners[[triangle, at, axis]]))
    };
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
        let faces: Vec<DVec3> =
            triangles.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a)).collect();
        let members = Groups::new(&groups, &triangles);
        let closest = |&(point, normal, group, reach): &(DVec3, DVec3, i64, f64)| {
            let (few, own_tree) = members.of(group);
            // Of a small group each is asked.
            if own_tree.is_none() && !few.is_empty() {
                let asked = few.iter().map(|&triangle| {
                    let way = closest_point_on_triangle(point, &triangles[triangle]) - point;
                    (way.length(), triangle)
                });
                let asked: Vec<(f64, usize)> = asked.collect();
                let nearest = |among: &mut dyn Iterator<Item = &(f64, usize)>| {
                    among.min_by(|a, b| a.0.total_cmp(&b.0)).copied()
                };
                let Some((distance, any)) = nearest(&mut asked.iter()) else { return -1 };
                let facing = |one: &&(f64, usize)| {
                    one.0 < distance + reach && faces[one.1].dot(normal) > 0.0
                };
                let best = nearest(&mut asked.iter().filter(facing));
                return best.map_or(any, |best| best.1) as i64;
            }
            // A large one has a tree of its own: it may be far away, behind many others.
            let number = |slot: usize| if own_tree.is_some() { few[slot] } else { slot };
            let tree = own_tree.unwrap_or(&tree);
            let Some(any) = tree.closest(point, f64::INFINITY) else { return -1 };
            // A sheet's other side is near, too.
            let bound = any.distance_squared.sqrt() + reach;
            let facing = |slot: usize| faces[number(slot)].dot(normal) > 0.0;
            let best = tree.closest_of(point, bound * bound, facing).unwrap_or(any);
            number(best.triangle) as i64
        };
        queries.par_iter().map(closest).collect()
    });
    Ok(PyArray1::from_vec(py, found))
}

/// Triangles of a group of at most so many are asked one by one.
const MOST_ASKED: usize = 64;

/// Which triangles are in each group.
struct Groups {
    /// The number of each group, sorted, and where its triangles begin.
    first_of: Vec<(i64, usize)>,
    triangles: Vec<usize>,
    /// Of each group that is large.
    trees: Vec<Option<Bvh>>,
}

impl Groups {
    fn new(groups: &[i64], corners: &[[DVec3; 3]]) -> Self {
        let mut members: Vec<(i64, usize)> = groups.iter().copied().zip(0..).collect();
        members.sort_unstable();
        let mut first_of: Vec<(i64, usize)> = Vec::new();
        for (at, &(group, _)) in members.iter().enumerate() {
            if first_of.last().is_none_or(|&(last, _)| last != group) {
                first_of.push((group, at));
            }
        }
        let triangles: Vec<usize> = members.iter().map(|&(_, triangle)| triangle).collect();
        let mut made = Self { first_of, triangles, trees: Vec::new() };
        let tree = |group: usize| {
            let own = &made.triangles[made.range(group)];
            let corners: Vec<[DVec3; 3]> = own.iter().map(|&triangle| corners[triangle]).collect();
            (own.len() > MOST_ASKED).then(|| Bvh::new(&corners))
        };
        made.trees = (0..made.first_of.len()).into_par_iter().map(tree).collect();
        made
    }

    fn range(&self, group: usize) -> std::ops::Range<usize> {
        let end = self.first_of.get(group + 1).map_or(self.triangles.len(), |&(_, first)| first);
        self.first_of[group].1..end
    }

    /// The triangles of a group, in ascending order, and their tree if they are many; none of a
    /// group that there is not.
    fn of(&self, group: i64) -> (&[usize], Option<&Bvh>) {
        match self.first_of.binary_search_by_key(&group, |&(number, _)| number) {
            Ok(at) => (&self.triangles[self.range(at)], self.trees[at].as_ref()),
            Err(_) => (&[], None),
        }
    }
}
