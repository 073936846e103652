//! Convex bodies of revolution: cylinder, capsule and cone.

use glam::{DVec2, DVec3};

/// A convex body of revolution around the y axis: the convex hull of two discs across the axis,
/// rounded. A cylinder has two equal discs, a cone one of radius 0, a capsule two of radius 0 and a
/// rounding.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Revolved {
    /// The lower and the higher disc.
    pub ends: [RevolvedEnd; 2],
    /// All points within this distance of the hull of the discs belong to the body [m].
    pub rounding: f64,
}

/// A disc across the axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RevolvedEnd {
    /// Along the axis [m].
    pub height: f64,
    /// [m]
    pub radius: f64,
}

impl Revolved {
    /// Cosine and sine of the angle between the side's normal and the plane across the axis;
    /// positive where the side faces upwards.
    pub fn side_normal(&self) -> DVec2 {
        let [low, high] = self.ends;
        DVec2::new(high.height - low.height, low.radius - high.radius).normalize()
    }

    /// Signed distance [m], negative inside, and its unit gradient. Where several points of the
    /// surface are nearest, the gradient belongs to one of them, always the same.
    pub fn distance_and_gradient(&self, point: DVec3) -> (f64, DVec3) {
        let radial = DVec2::new(point.x, point.z);
        let from_axis = radial.length();
        let outward = if from_axis > 0.0 { radial / from_axis } else { DVec2::X };
        let (distance, gradient) = self.in_half_plane(DVec2::new(from_axis, point.y));
        let along = gradient.x * outward;
        (distance - self.rounding, DVec3::new(along.x, gradient.y, along.y))
    }

    /// Distance from the hull of the discs, in the half-plane of a point: x from the axis, y along
    /// it.
    fn in_half_plane(&self, point: DVec2) -> (f64, DVec2) {
        let [low, high] = self.ends.map(|end| DVec2::new(end.radius, end.height));
        let side = self.side_normal();
        // The first of equally near sides decides.
        let heights = [
            (side.dot(point - low), side),
            (low.y - point.y, DVec2::NEG_Y),
            (point.y - high.y, DVec2::Y),
        ];
        let nearest = heights.iter().fold(heights[0], |a, b| if b.0 > a.0 { *b } else { a });
        if nearest.0 <= 0.0 {
            return nearest;
        }
        let foot_on = |start: DVec2, end: DVec2| {
            let along = end - start;
            let length_squared = along.length_squared();
            let part = if length_squared > 0.0 {
                ((point - start).dot(along) / length_squared).clamp(0.0, 1.0)
            } else {
                0.0
            };
            start + part * along
        };
        let on_axis = |end: DVec2| DVec2::new(0.0, end.y);
        let feet = [foot_on(low, high), foot_on(on_axis(low), low), foot_on(on_axis(high), high)];
        let way = |foot: &DVec2| (point - *foot).length_squared();
        let foot = feet.iter().fold(feet[0], |a, b| if way(b) < way(&a) { *b } else { a });
        let apart = point - foot;
        let distance = apart.length();
        // So near the surface, the way to it has no direction.
        if distance > 1e-14 * (point.length() + high.length()) {
            (distance, apart / distance)
        } else {
            nearest
        }
    }
}
