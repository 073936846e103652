//! The axis along which two hulls are furthest apart, or overlap least: separating axis test over faces and edges [Gregorius13].

use frangible_geometry::{HalfSpace, Hull, RigidTransform};
use glam::DVec3;

/// A hull seen from the frame in which two of them meet.
pub(crate) struct View<'a> {
    pub(crate) hull: &'a Hull,
    pub(crate) vertices: Vec<DVec3>,
    pub(crate) planes: Vec<HalfSpace>,
}

impl<'a> View<'a> {
    /// In its own frame.
    pub(crate) fn own(hull: &'a Hull) -> Self {
        let planes = hull.planes().to_vec();
        Self { hull, vertices: hull.vertices().to_vec(), planes }
    }

    pub(crate) fn from_elsewhere(hull: &'a Hull, here_from_hull: &RigidTransform) -> Self {
        let (matrix, shift) = (here_from_hull.matrix(), here_from_hull.translation);
        let plane = |plane: HalfSpace| {
            let normal = matrix * plane.normal;
            HalfSpace { normal, offset: plane.offset + normal.dot(shift) }
        };
        Self {
            hull,
            vertices: hull.vertices().iter().map(|&vertex| matrix * vertex + shift).collect(),
            planes: hull.planes().iter().map(|&each| plane(each)).collect(),
        }
    }

    /// Lowest and highest corner of all that is within `reach` [m].
    pub(crate) fn bounds(&self, reach: f64) -> (DVec3, DVec3) {
        let low = self.vertices.iter().fold(DVec3::INFINITY, |low, &vertex| low.min(vertex));
        let high = self.vertices.iter().fold(DVec3::NEG_INFINITY, |high, &vertex| high.max(vertex));
        (low - reach, high + reach)
    }

    /// The vertices in a box, by number.
    pub(crate) fn vertices_in(&self, (low, high): (DVec3, DVec3)) -> Vec<usize> {
        let is_in = |&vertex: &usize| {
            let point = self.vertices[vertex];
            point.cmple(high).all() && point.cmpge(low).all()
        };
        (0..self.vertices.len()).filter(is_in).collect()
    }

    /// The edges that come into a box, by number.
    pub(crate) fn edges_in(&self, (low, high): (DVec3, DVec3)) -> Vec<usize> {
        let comes_in = |&edge: &usize| {
            let [start, end] = self.ends(edge);
            start.min(end).cmple(high).all() && start.max(end).cmpge(low).all()
        };
        (0..self.hull.edges().len()).filter(comes_in).collect()
    }

    /// The ends of an edge [m].
    pub(crate) fn ends(&self, edge: usize) -> [DVec3; 2] {
        self.hull.edges()[edge].vertices.map(|vertex| self.vertices[vertex as usize])
    }
}

/// A face whose normal separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct FaceAxis {
    /// Of the hull that has the face.
    pub(crate) face: usize,
    /// The vertex of the other hull that is deepest below the face.
    pub(crate) vertex: usize,
    /// How far that is above the face's plane [m].
    pub(crate) separation: f64,
}

/// The face of `hull` that `other` is furthest away from; the first that it is more than `most` [m] away from.
pub(crate) fn face_axis(hull: &View, other: &View, most: f64) -> FaceAxis {
    let mut best = FaceAxis { face: 0, vertex: 0, separation: f64::NEG_INFINITY };
    for (face, plane) in hull.planes.iter().enumerate() {
        let (mut lowest, mut vertex) = (f64::INFINITY, 0);
        for (index, &point) in other.vertices.iter().enumerate() {
            let height = plane.normal.dot(point);
            if height < lowest {
                (lowest, vertex) = (height, index);
            }
        }
        let separation = lowest - plane.offset;
        if separation > best.separation {
            best = FaceAxis { face, vertex, separation };
            if separation > most {
                break;
            }
        }
    }
    best
}

/// A pair of edges whose common perpendicular separates two hulls.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EdgeAxis {
    /// Of the first hull and of the second.
    pub(crate) edges: [usize; 2],
    /// Unit, from the second hull to the first.
    pub(crate) normal: DVec3,
    /// Along the normal [m].
    pub(crate) separation: f64,
}

/// An edge and the normals beside it.
struct Ridge {
    edge: usize,
    start: DVec3,
    along: DVec3,
    normals: [DVec3; 2],
}

fn ridges(view: &View, edges: &[usize]) -> Vec<Ridge> {
    let ridge = |&edge: &usize| {
        let [start, end] = view.ends(edge);
        let normals = view.hull.edges()[edge].faces.map(|face| view.planes[face as usize].normal);
        Ridge { edge, start, along: end - start, normals }
    };
    edges.iter().map(ridge).collect()
}

/// The pair of some edges that are furthest apart, of those that make a face of the Minkowski difference; `None` if all that do are
/// parallel.
pub(crate) fn edge_axis(first: &View, second: &View, edges: [&[usize]; 2]) -> Option<EdgeAxis> {
    // Sine of the angle below which edges count as parallel: then a face's normal does as well.
    const PARALLEL: f64 = 1e-3;
    let mut best: Option<EdgeAxis> = None;
    let (ridges_first, ridges_second) = (ridges(first, edges[0]), ridges(second, edges[1]));
    for of_first in &ridges_first {
        for of_second in &ridges_second {
            // Arcs of the Gauss map: those between the first edge's normals and between the negated ones of the second must
            // cross, else other features are further apart.
            let [c, d] = of_second.normals.map(|normal| normal.dot(of_first.along));
            if c * d >= 0.0 {
                continue;
            }
            let [u, v] = of_first.normals.map(|normal| -normal.dot(of_second.along));
            if u * v >= 0.0 || c * v <= 0.0 {
                continue;
            }
            let across = of_first.along.cross(of_second.along);
            let squared = across.length_squared();
            let lengths = of_first.along.length_squared() * of_second.along.length_squared();
            if squared <= PARALLEL * PARALLEL * lengths {
                continue;
            }
            // Outward of the second hull is between the normals of its edge.
            let across = across / squared.sqrt();
            let outward = of_second.normals[0] + of_second.normals[1];
            let normal = if across.dot(outward) < 0.0 { -across } else { across };
            let separation = normal.dot(of_first.start - of_second.start);
            if best.is_none_or(|best| separation > best.separation) {
                best = Some(EdgeAxis { edges: [of_first.edge, of_second.edge], normal, separation });
            }
        }
    }
    best
}
