//! The closed surface of one cell of a pattern, as triangles that fit its neighbours'.

use crate::pattern::region::Region;
use frangible_geometry::{Hull, TriMesh};
use glam::DVec3;
use std::collections::BTreeMap;

/// Vertices of neighbours closer than this fraction of the box are equal: far above the rounding of
/// the meeting point of four cells, and far below any visible edge.
const SAME_VERTEX: f64 = 1e-9;

/// Maximum number of halvings per edge.
const MOST_HALVINGS: usize = 12;

/// A cell's surface within the pattern's box.
#[derive(Clone, Debug, Default)]
pub(crate) struct CellMesh {
    /// Closed, pattern frame.
    pub(crate) mesh: TriMesh,
    /// For each triangle, whether it lies on a crack; the others lie on the box.
    pub(crate) crack: Vec<bool>,
}

impl CellMesh {
    /// The polyhedron of a region, its faces in fans of triangles. Empty for a region beyond the
    /// box.
    pub(crate) fn planar(regions: &[Region], half_extent: DVec3, cell: usize) -> Self {
        let Some(hull) = regions[cell].hull(half_extent) else { return Self::default() };
        let mut made = Self::default();
        let number = made.add_vertices(&shared_vertices(regions, half_extent, cell, &hull));
        for face in hull.faces() {
            let on_crack = regions[cell].cuts.iter().any(|cut| cut.half_space == face.plane);
            let mut corners: Vec<u32> =
                face.vertices.iter().map(|&vertex| number[vertex as usize]).collect();
            corners.dedup();
            // The fan begins at the same corner on both sides of the face.
            let least = (0..corners.len()).min_by(|&a, &b| {
                compare(
                    made.mesh.positions[corners[a] as usize],
                    made.mesh.positions[corners[b] as usize],
                )
            });
            corners.rotate_left(least.unwrap_or(0));
            for pair in corners.get(1..).unwrap_or_default().windows(2) {
                if pair[0] != corners[0] && pair[1] != corners[0] {
                    made.mesh.triangles.push([corners[0], pair[0], pair[1]]);
                    made.crack.push(on_crack);
                }
            }
        }
        made
    }

    /// Adds points, equal ones once; the number of each.
    fn add_vertices(&mut self, points: &[DVec3]) -> Vec<u32> {
        let mut known: BTreeMap<[u64; 3], u32> = BTreeMap::new();
        let positions = &mut self.mesh.positions;
        let mut number_of = |&point: &DVec3| {
            *known.entry((point + DVec3::ZERO).to_array().map(f64::to_bits)).or_insert_with(|| {
                positions.push(point);
                positions.len() as u32 - 1
            })
        };
        points.iter().map(&mut number_of).collect()
    }

    /// The same surface with edges halved to at most `longest_edge`. The result for an edge and a
    /// triangle depends only on their corners: matching surfaces still match.
    pub(crate) fn refined(mut self, longest_edge: f64) -> Self {
        for _ in 0..MOST_HALVINGS {
            let before = self.mesh.triangles.len();
            self.halve_edges(longest_edge);
            if self.mesh.triangles.len() == before {
                break;
            }
        }
        self
    }

    /// Halves each edge above the limit, and cuts its triangles.
    fn halve_edges(&mut self, longest_edge: f64) {
        let positions = &mut self.mesh.positions;
        let mut middle_of: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        let mut triangles = Vec::with_capacity(self.mesh.triangles.len());
        let mut crack = Vec::with_capacity(self.crack.len());
        for (&triangle, &on_crack) in self.mesh.triangles.iter().zip(&self.crack) {
            let middles = [0, 1, 2].map(|side| {
                let (a, b) = (triangle[side], triangle[(side + 1) % 3]);
                let (start, end) = (positions[a as usize], positions[b as usize]);
                (start.distance(end) > longest_edge).then(|| {
                    *middle_of.entry([a.min(b), a.max(b)]).or_insert_with(|| {
                        positions.push(0.5 * (start + end));
                        positions.len() as u32 - 1
                    })
                })
            });
            cut_triangle(triangle, middles, positions, &mut triangles);
            crack.resize(triangles.len(), on_crack);
        }
        self.mesh.triangles = triangles;
        self.crack = crack;
    }
}

/// Cuts a triangle with halved sides, counted from its first corner.
fn cut_triangle(
    [a, b, c]: [u32; 3],
    middles: [Option<u32>; 3],
    positions: &[DVec3],
    triangles: &mut Vec<[u32; 3]>,
) {
    match middles {
        [None, None, None] => triangles.push([a, b, c]),
        [Some(ab), Some(bc), Some(ca)] => {
            triangles.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]])
        }
        [Some(ab), None, None] => triangles.extend([[a, ab, c], [ab, b, c]]),
        [Some(ab), Some(bc), None] => {
            // Of the four-sided rest, the shorter diagonal; of equals, that from the lesser corner.
            let at = |vertex: u32| positions[vertex as usize];
            let (from_a, from_c) = (at(a).distance(at(bc)), at(c).distance(at(ab)));
            let a_first = from_a < from_c || (from_a == from_c && compare(at(a), at(c)).is_lt());
            triangles.push([ab, b, bc]);
            triangles.extend(if a_first {
                [[a, ab, bc], [a, bc, c]]
            } else {
                [[a, ab, c], [ab, bc, c]]
            });
        }
        // The same, turned.
        [ab, bc, ca] => cut_triangle([b, c, a], [bc, ca, ab], positions, triangles),
    }
}

/// Order of points: by x, then y, then z.
fn compare(a: DVec3, b: DVec3) -> std::cmp::Ordering {
    a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z))
}

/// The corners of a cell's hull. Where several cells have one within rounding, all take that of the
/// first cell.
fn shared_vertices(regions: &[Region], half_extent: DVec3, cell: usize, hull: &Hull) -> Vec<DVec3> {
    let close = SAME_VERTEX * half_extent.max_element();
    let mut hulls: BTreeMap<usize, Option<Hull>> = BTreeMap::new();
    let mut shared = |&vertex: &DVec3| {
        let before = regions[..cell].iter().enumerate();
        for (other, _) in before.filter(|(_, region)| region.distance(vertex) <= close) {
            let hull = hulls.entry(other).or_insert_with(|| regions[other].hull(half_extent));
            let corners = hull.iter().flat_map(Hull::vertices);
            if let Some(&first) =
                corners.into_iter().find(|corner| corner.distance(vertex) <= close)
            {
                return first;
            }
        }
        vertex
    };
    hull.vertices().iter().map(&mut shared).collect()
}
