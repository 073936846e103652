//! Vertices on the planes of their merged faces.

use super::face_loops::FaceLoops;
use crate::half_space::HalfSpace;
use crate::hull::edges::plane_of;
use glam::DVec3;

/// Vertices this close to a face's plane are on it, relative to the hull's longest extent: planes and
/// vertices of a million times the rounding of both describe two bodies, and a small one that meets
/// both is apart from the one while it overlaps the other.
const ON_PLANE: f64 = 1e-10;

/// A direction that the planes before have nearly used up would carry a vertex far away [1].
const LEAST_FREEDOM: f64 = 0.01;

/// The points, moved onto the planes of their faces with more than three vertices, so that volumes
/// do not depend on how a face is cut into triangles. Triangles' planes follow their vertices.
pub(super) fn flattened(
    points: &[DVec3],
    planes: &mut [HalfSpace],
    loops: &FaceLoops,
) -> Vec<DVec3> {
    let mut moved = points.to_vec();
    let mut freedom: Vec<Vec<DVec3>> = vec![Vec::new(); points.len()];
    for (face, plane) in planes.iter().enumerate().filter(|(face, _)| loops.of(*face).len() > 3) {
        for &vertex in loops.of(face) {
            // Direction along which the vertex stays on all its earlier planes.
            let taken = &mut freedom[vertex as usize];
            let normal = plane.normal;
            let across =
                taken.iter().fold(normal, |across, &other| across - across.dot(other) * other);
            if across.length() > LEAST_FREEDOM {
                let across = across.normalize();
                let position = &mut moved[vertex as usize];
                *position -= across * (plane.distance(*position) / normal.dot(across));
                taken.push(across);
            }
        }
    }
    for (face, plane) in
        planes.iter_mut().enumerate().filter(|(face, _)| loops.of(*face).len() == 3)
    {
        let corners = loops.of(face).iter().map(|&vertex| moved[vertex as usize]);
        *plane = plane_of(corners).unwrap_or(*plane);
    }
    moved
}

/// Faces that are at odds with the rest: with vertices beside their plane, which had no freedom left,
/// or with vertices that they moved outside of another face, or that of a face with another one
/// outside.
pub(super) fn at_odds(
    moved: &[DVec3],
    planes: &[HalfSpace],
    loops: &FaceLoops,
    extent: f64,
) -> Vec<bool> {
    let far = ON_PLANE * extent;
    let mut used = vec![false; moved.len()];
    let faces = 0..planes.len();
    faces.clone().flat_map(|face| loops.of(face)).for_each(|&vertex| used[vertex as usize] = true);
    let mut is_off = vec![false; moved.len()];
    for (face, plane) in planes.iter().enumerate() {
        let above = (0..moved.len()).filter(|&at| used[at] && plane.distance(moved[at]) > far);
        let above: Vec<usize> = above.collect();
        if !above.is_empty() {
            let own = loops.of(face).iter().map(|&vertex| vertex as usize);
            above.into_iter().chain(own).for_each(|vertex| is_off[vertex] = true);
        }
    }
    let is_at_odds = |face: usize| {
        let mut corners = loops.of(face).iter().map(|&vertex| vertex as usize);
        corners.any(|at| is_off[at] || planes[face].distance(moved[at]).abs() > far)
    };
    faces.map(is_at_odds).collect()
}
