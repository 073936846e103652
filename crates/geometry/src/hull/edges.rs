//! Edges of hulls, and planes through their corners.

use crate::half_space::HalfSpace;
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// An edge of a hull.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct HullEdge {
    /// Vertex indices, in the order in which the first face has them.
    pub vertices: [u32; 2],
    /// Face indices.
    pub faces: [u32; 2],
}

/// The directed edges of a loop.
pub(crate) fn sides(loop_of: &[u32]) -> impl Iterator<Item = [u32; 2]> + '_ {
    (0..loop_of.len()).map(|at| [loop_of[at], loop_of[(at + 1) % loop_of.len()]])
}

/// The plane of a loop of points, outward if they run counter-clockwise; none of them lies outside.
pub(crate) fn plane_of(points: impl Iterator<Item = DVec3> + Clone) -> Option<HalfSpace> {
    // Twice the area vector, Newell's way: from the first point, so that nothing large cancels.
    let origin = points.clone().next()?;
    let levers = points.clone().map(|point| point - origin);
    let area: DVec3 = levers.clone().zip(levers.skip(1)).map(|(a, b)| a.cross(b)).sum();
    let normal = area.try_normalize()?;
    let offset = points.map(|point| normal.dot(point)).fold(f64::NEG_INFINITY, f64::max);
    Some(HalfSpace { normal, offset })
}
