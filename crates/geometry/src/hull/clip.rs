//! A hull cut by a plane.

use super::{Hull, HullEdge, HullFace, Polygon, sides};
use crate::HalfSpace;
use glam::DVec3;
use std::collections::BTreeMap;

/// A vertex this close to the cut, relative to the hull's longest side, lies on it: nothing shorter than what rounding moves is
/// cut off.
const ON_THE_CUT: f64 = 1e-10;

impl Hull {
    /// The part inside a half-space; `None` if there is none. What is left of the faces keeps their planes, and the two
    /// sides of a cut, `cut` and `cut` turned round, share its vertices bit for bit.
    pub fn clipped(&self, cut: &HalfSpace) -> Option<Self> {
        // Sort the vertices into inside, on the cut (0), and outside.
        let (low, high) = self.bounds();
        let close = ON_THE_CUT * (high - low).max_element();
        let heights: Vec<f64> = self
            .vertices
            .iter()
            .map(|&vertex| cut.distance(vertex))
            .map(|height| if height.abs() <= close { 0.0 } else { height })
            .collect();
        if heights.iter().all(|&height| height <= 0.0) {
            return Some(self.clone());
        }
        if heights.iter().all(|&height| height >= 0.0) {
            return None;
        }

        // New vertices where the plane crosses an edge: interpolated from its first end, whichever side is kept.
        let mut vertices = self.vertices.clone();
        let mut crossings: BTreeMap<[u32; 2], u32> = BTreeMap::new();
        for &HullEdge { vertices: [a, b], .. } in &self.edges {
            let (from, to) = (heights[a as usize], heights[b as usize]);
            if from * to < 0.0 {
                let (start, end) = (self.vertices[a as usize], self.vertices[b as usize]);
                crossings.insert([a, b], vertices.len() as u32);
                crossings.insert([b, a], vertices.len() as u32);
                vertices.push(start + (end - start) * (from / (from - to)));
            }
        }

        // Cut the faces, and close what is open.
        let mut faces: Vec<Polygon> =
            self.faces.iter().filter_map(|face| clip_face(face, &heights, &crossings)).collect();
        if let Some(cap) = open_loop(&faces) {
            faces.push(Polygon { plane: *cut, vertices: cap });
            if let Some(hull) = Self::from_faces(&vertices, faces) {
                return Some(hull);
            }
        }
        // Slivers at the limit of precision may leave no loop: then the points decide.
        let kept: Vec<DVec3> = (0..vertices.len())
            .filter(|&vertex| heights.get(vertex).is_none_or(|&height| height <= 0.0))
            .map(|vertex| vertices[vertex])
            .collect();
        Self::of_points(&kept).ok()
    }
}

/// The part of a face at heights of at most 0.
fn clip_face(face: &HullFace, heights: &[f64], crossings: &BTreeMap<[u32; 2], u32>) -> Option<Polygon> {
    let mut kept = Vec::with_capacity(face.vertices.len() + 1);
    for side in sides(&face.vertices) {
        if heights[side[0] as usize] <= 0.0 {
            kept.push(side[0]);
        }
        kept.extend(crossings.get(&side));
    }
    // What only touches the cut vanishes, or is the cap's.
    let is_inside =
        kept.iter().any(|&vertex| heights.get(vertex as usize).is_some_and(|&height| height < 0.0));
    (is_inside && kept.len() > 2).then_some(Polygon { plane: face.plane, vertices: kept })
}

/// The loop of edges that only one face has, the other way round; `None` if it is not one.
fn open_loop(faces: &[Polygon]) -> Option<Vec<u32>> {
    let mut next: BTreeMap<u32, u32> = BTreeMap::new();
    let directed: BTreeMap<[u32; 2], ()> =
        faces.iter().flat_map(|face| sides(&face.vertices)).map(|side| (side, ())).collect();
    for &[a, b] in directed.keys().filter(|&&[a, b]| !directed.contains_key(&[b, a])) {
        if next.insert(b, a).is_some() {
            return None;
        }
    }
    let start = *next.keys().next()?;
    let mut walked = vec![start];
    let mut at = *next.get(&start)?;
    while at != start {
        walked.push(at);
        if walked.len() > next.len() {
            return None;
        }
        at = *next.get(&at)?;
    }
    (walked.len() == next.len()).then_some(walked)
}
