//! Faces of polyhedra as polygons, and what two of them share.

use crate::hull::Hull;
use glam::DVec3;

/// Corners of a face, counter-clockwise seen from outside [m].
pub(crate) fn corners_of(hull: &Hull, face: usize) -> Vec<DVec3> {
    hull.face(face).vertices.iter().map(|&vertex| hull.vertices()[vertex as usize]).collect()
}

/// Area of a polygon with this unit normal [m^2]; negative if it runs clockwise.
pub(crate) fn polygon_area(corners: &[DVec3], normal: DVec3) -> f64 {
    let Some(&origin) = corners.first() else { return 0.0 };
    let doubled: DVec3 =
        corners.windows(2).map(|pair| (pair[0] - origin).cross(pair[1] - origin)).sum();
    0.5 * doubled.dot(normal)
}

/// Area that two convex polygons in one plane share [m^2]: the first, counter-clockwise about
/// `normal`, cut along the sides of the second, which runs the other way.
pub(crate) fn overlap_area(first: &[DVec3], second: &[DVec3], normal: DVec3) -> f64 {
    let mut left = first.to_vec();
    for at in 0..second.len() {
        let (start, end) = (second[at], second[(at + 1) % second.len()]);
        let outward = (end - start).cross(-normal);
        let height = |point: DVec3| outward.dot(point - start);
        let whole = std::mem::take(&mut left);
        for (from, &a) in whole.iter().enumerate() {
            let b = whole[(from + 1) % whole.len()];
            let (height_a, height_b) = (height(a), height(b));
            if height_a <= 0.0 {
                left.push(a);
            }
            if height_a * height_b < 0.0 {
                left.push(a + (b - a) * (height_a / (height_a - height_b)));
            }
        }
    }
    polygon_area(&left, normal)
}
