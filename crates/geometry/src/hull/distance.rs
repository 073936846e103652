//! Distance of a point from a hull.

use super::{Hull, HullFace};
use crate::hull::edges::sides;
use glam::DVec3;

/// Closer than this to the surface, relative to the hull's extent, the way to it has no direction
/// that rounding leaves alone.
const TOUCHING: f64 = 1e-13;

impl Hull {
    /// Signed distance [m], negative inside, and its unit gradient. Where several points of the
    /// surface are nearest, the gradient belongs to one of them, always the same.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        // Inside, and in front of a face, its plane decides.
        let (height, face) = self.highest_face(point);
        let normal = face.plane.normal;
        if height <= 0.0 || self.is_over(face, point) {
            return (height, normal);
        }

        // Elsewhere the nearest point is on one of the faces that can be seen from here, or on
        // their edges.
        let foot = self.nearest_outside(point);
        let away = point - foot;
        let distance = away.length();
        let extent = point.abs().max_element().max(foot.abs().max_element());
        if distance > TOUCHING * extent { (distance, away / distance) } else { (distance, normal) }
    }

    /// Signed distance [m] without gradient. Values above `most` are only lower bounds, and at
    /// least `most`.
    pub fn distance_up_to(&self, point: DVec3, most: f64) -> f64 {
        let (height, _) = self.highest_face(point);
        if height > most || height <= 0.0 { height } else { self.distance_and_gradient(point).0 }
    }

    /// The face whose plane is furthest below the point, and the height over it [m].
    fn highest_face(&self, point: DVec3) -> (f64, HullFace<'_>) {
        let mut highest = (self.planes[0].distance(point), 0);
        for (face, plane) in self.planes.iter().enumerate().skip(1) {
            let height = plane.distance(point);
            if height > highest.0 {
                highest = (height, face);
            }
        }
        (highest.0, self.face(highest.1))
    }

    /// True if a point's foot on a face's plane lies in the face.
    fn is_over(&self, face: HullFace<'_>, point: DVec3) -> bool {
        sides(face.vertices).all(|[a, b]| {
            let (start, end) = (self.vertices[a as usize], self.vertices[b as usize]);
            (end - start).cross(point - start).dot(face.plane.normal) >= 0.0
        })
    }

    /// The point of the surface that is nearest to a point outside [m].
    fn nearest_outside(&self, point: DVec3) -> DVec3 {
        let mut nearest = (f64::INFINITY, point);
        for face in self.faces() {
            let height = face.plane.distance(point);
            if height <= 0.0 {
                continue;
            }
            if self.is_over(face, point) {
                return point - height * face.plane.normal;
            }
            for [a, b] in sides(face.vertices) {
                let (start, end) = (self.vertices[a as usize], self.vertices[b as usize]);
                let along = end - start;
                let part = ((point - start).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                let foot = start + part * along;
                let squared = foot.distance_squared(point);
                if squared < nearest.0 {
                    nearest = (squared, foot);
                }
            }
        }
        nearest.1
    }
}
