//! Distance from a static mesh, signed by the nearest feature's pseudo-normal [BA05].

use crate::bvh::closest_point_on_triangle;
use crate::static_mesh::StaticMesh;
use crate::static_mesh::kinds::Sides;
use glam::DVec3;

/// The nearest point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NearestPoint {
    /// [m]
    pub point: DVec3,
    /// A triangle that it lies on.
    pub triangle: usize,
}

/// Closer than this to the surface, relative to the coordinates, the way to it has no direction
/// that rounding leaves alone [1].
const TOUCHING: f64 = 1e-13;

/// A foot within this fraction of the triangle's size of an edge or corner lies on it [1].
const ON_EDGE: f64 = 1e-9;

impl StaticMesh {
    /// The nearest point of the mesh closer than `most` [m], if any.
    pub fn nearest(&self, point: DVec3, most: f64) -> Option<NearestPoint> {
        let mut best = None;
        self.tree.visit_nearest(point, most * most, |triangle, bound| {
            let foot = closest_point_on_triangle(point, &self.corners(triangle));
            let squared = foot.distance_squared(point);
            if squared < bound {
                best = Some(NearestPoint { point: foot, triangle });
                squared
            } else {
                bound
            }
        });
        best
    }

    /// Signed distance [m] and its unit gradient; negative behind a one-sided mesh, never negative
    /// for a sheet.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let Some(nearest) = self.nearest(point, f64::INFINITY) else {
            return (f64::INFINITY, DVec3::Y);
        };
        let away = point - nearest.point;
        let distance = away.length();
        let outward = self.pseudo_normal(&nearest);
        let extent = point.abs().max_element().max(nearest.point.abs().max_element());
        let is_behind = self.sides == Sides::One && away.dot(outward) < 0.0;
        if distance <= TOUCHING * extent {
            (if is_behind { -distance } else { distance }, outward)
        } else if is_behind {
            (-distance, -away / distance)
        } else {
            (distance, away / distance)
        }
    }

    /// Signed distance [m]; values beyond `most` are only known to be beyond it.
    pub fn distance_up_to(&self, point: DVec3, most: f64) -> f64 {
        if self.sides == Sides::Two {
            let near = self.nearest(point, most.max(0.0));
            return near.map_or(f64::INFINITY, |near| near.point.distance(point));
        }
        self.distance_and_gradient(point).0
    }

    /// Normal at a point of the surface: a triangle's, the mean of an edge's two, or at a vertex
    /// the mean of all around weighted by their angles. Distances have its sign.
    fn pseudo_normal(&self, nearest: &NearestPoint) -> DVec3 {
        let NearestPoint { point, triangle } = *nearest;
        let corners = self.corners(triangle);
        let longest = (0..3).map(|at| corners[at].distance(corners[(at + 1) % 3]));
        let near = ON_EDGE * longest.fold(0.0, f64::max);
        if let Some(at) = (0..3).find(|&at| corners[at].distance(point) <= near) {
            return self.vertex_normal(self.triangles[triangle][at] as usize);
        }
        let own = self.normal(triangle);
        let is_on = |at: usize| {
            let (from, to) = (corners[at], corners[(at + 1) % 3]);
            (to - from).cross(point - from).length() <= near * (to - from).length()
        };
        let edge = (0..3).find(|&at| is_on(at));
        let other = edge.and_then(|at| self.neighbour_normal(triangle, at));
        (own + other.unwrap_or(own)).normalize_or(own)
    }

    fn vertex_normal(&self, vertex: usize) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for &triangle in self.around(vertex) {
            let corners = self.triangles[triangle as usize];
            let at = (0..3).find(|&at| corners[at] as usize == vertex).unwrap_or(0);
            let [peak, next, last] =
                [at, (at + 1) % 3, (at + 2) % 3].map(|k| self.positions[corners[k] as usize]);
            sum += (next - peak).angle_between(last - peak) * self.normal(triangle as usize);
        }
        sum.normalize_or(DVec3::Y)
    }
}
