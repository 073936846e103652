//! Holes of a mesh, closed by triangles.

use crate::TriMesh;
use glam::DVec3;
use std::collections::{BTreeMap, BTreeSet};

impl TriMesh {
    /// Closes each hole by triangles between the vertices of its rim, and answers with the number of holes. Vertices at the same
    /// position must be one, see [`TriMesh::weld`]. Where edges have more than two triangles the mesh stays open.
    pub fn fill_holes(&mut self) -> usize {
        let rims = self.rims();
        for rim in &rims {
            self.triangles.extend(triangulated(rim, &self.positions));
        }
        rims.len()
    }

    /// The loops of edges that a triangle is missing at, in its direction. None passes a vertex twice.
    fn rims(&self) -> Vec<Vec<u32>> {
        // The missing edges.
        let directed: BTreeSet<[u32; 2]> =
            self.triangles.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]).collect();
        let mut next: BTreeMap<u32, Vec<u32>> = BTreeMap::new();
        for &[a, b] in directed.iter().filter(|&&[a, b]| !directed.contains(&[b, a])) {
            next.entry(b).or_default().push(a);
        }

        // Walk along them, and cut off a loop whenever a vertex comes again.
        let mut rims = Vec::new();
        let starts: Vec<u32> = next.keys().copied().collect();
        for start in starts {
            let mut walked = vec![start];
            while let Some(to) = walked.last().and_then(|last| next.get_mut(last)?.pop()) {
                if let Some(before) = walked.iter().position(|&vertex| vertex == to) {
                    let rim = walked.split_off(before);
                    walked.push(to);
                    if rim.len() > 2 {
                        rims.push(rim);
                    }
                } else {
                    walked.push(to);
                }
            }
        }
        rims
    }
}

/// Triangles that fill a loop of vertices, in its direction: ears are clipped off, those with the shortest side first, as seen
/// along the loop's mean normal.
fn triangulated(rim: &[u32], positions: &[DVec3]) -> Vec<[u32; 3]> {
    let at = |vertex: u32| positions[vertex as usize];
    let levers = rim.iter().map(|&vertex| at(vertex) - at(rim[0]));
    let normal =
        levers.clone().zip(levers.skip(1)).map(|(a, b)| a.cross(b)).sum::<DVec3>().normalize_or(DVec3::Y);
    let turn = |a: u32, b: u32, c: u32| (at(b) - at(a)).cross(at(c) - at(a)).dot(normal);

    let mut left = rim.to_vec();
    let mut triangles = Vec::with_capacity(rim.len());
    while left.len() > 3 {
        let corner =
            |n: usize| [left[(n + left.len() - 1) % left.len()], left[n], left[(n + 1) % left.len()]];
        let is_ear = |&n: &usize| {
            let [a, b, c] = corner(n);
            let holds = |p: u32| turn(a, b, p) >= 0.0 && turn(b, c, p) >= 0.0 && turn(c, a, p) >= 0.0;
            let mut others = left.iter().filter(|&&p| p != a && p != b && p != c);
            turn(a, b, c) > 0.0 && !others.any(|&p| holds(p))
        };
        let side = |n: usize| {
            let [a, _, c] = corner(n);
            at(a).distance_squared(at(c))
        };
        let mut order: Vec<usize> = (0..left.len()).collect();
        order.sort_by(|&m, &n| side(m).total_cmp(&side(n)));
        // A loop that crosses itself may have no ear: then the shortest side goes.
        let ear = order.iter().copied().find(is_ear).unwrap_or(order[0]);
        triangles.push(corner(ear));
        left.remove(ear);
    }
    triangles.extend(<[u32; 3]>::try_from(left));
    triangles
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Hull;

    /// A cube without one face and without one triangle of the opposite one.
    fn open_cube() -> TriMesh {
        let mut cube = Hull::cuboid(DVec3::ONE).surface();
        let up = |mesh: &TriMesh, n: usize| mesh.corners(n).iter().all(|corner| corner.y > 0.0);
        let down = |mesh: &TriMesh, n: usize| mesh.corners(n).iter().all(|corner| corner.y < 0.0);
        let first_down = (0..12).find(|&n| down(&cube, n));
        let kept = (0..12).filter(|&n| !up(&cube, n) && Some(n) != first_down);
        cube.triangles = kept.map(|n| cube.triangles[n]).collect();
        cube
    }

    #[test]
    fn a_cube_with_two_holes_is_closed_again() {
        let mut cube = open_cube();
        assert!(!cube.is_watertight());
        assert_eq!(cube.fill_holes(), 2);
        assert!(cube.is_watertight());
        assert!((cube.mass_properties().volume - 8.0).abs() < 1e-12);
        assert_eq!(cube.fill_holes(), 0);
    }

    /// An L has its middle on its edge; ears stay inside.
    #[test]
    fn a_hole_that_is_not_convex_is_filled_inside_of_its_rim() {
        let rim = [(0.0, 0.0), (3.0, 0.0), (3.0, 1.0), (1.0, 1.0), (1.0, 3.0), (0.0, 3.0)];
        let positions: Vec<DVec3> = rim.iter().map(|&(x, y)| DVec3::new(x, y, 0.0)).collect();
        let triangles = triangulated(&[0, 1, 2, 3, 4, 5], &positions);
        let mesh = TriMesh { positions, triangles };
        assert_eq!(mesh.triangles.len(), 4);
        assert!((mesh.area() - 5.0).abs() < 1e-12);
    }

    #[test]
    fn holes_that_touch_at_a_vertex_are_two() {
        // Two opposite triangles of a pyramid's side, which meet at its apex only.
        let base = [DVec3::X, DVec3::Z, DVec3::NEG_X, DVec3::NEG_Z];
        let positions: Vec<DVec3> = base.into_iter().chain([DVec3::Y]).collect();
        let triangles = vec![[0, 2, 1], [0, 3, 2], [1, 2, 4], [3, 0, 4]];
        let mut pyramid = TriMesh { positions, triangles };
        pyramid.flip();
        assert_eq!(pyramid.fill_holes(), 2);
        assert!(pyramid.is_watertight());
    }
}
