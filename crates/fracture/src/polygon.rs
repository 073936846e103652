//! Convex polygons in space, cut by half-spaces.

use frangible_geometry::HalfSpace;
use glam::DVec3;

/// The part of a convex polygon that lies inside a half-space; empty if there is none.
pub(crate) fn clip(polygon: &[DVec3], half_space: &HalfSpace) -> Vec<DVec3> {
    let mut kept = Vec::with_capacity(polygon.len() + 1);
    clip_into(polygon, half_space, &mut kept);
    kept
}

/// The same, its corners added to `kept`.
pub(crate) fn clip_into(polygon: &[DVec3], half_space: &HalfSpace, kept: &mut Vec<DVec3>) {
    let Some(&first) = polygon.first() else { return };
    let mut to = half_space.distance(first);
    for (at, &start) in polygon.iter().enumerate() {
        let end = polygon.get(at + 1).copied().unwrap_or(first);
        let from = std::mem::replace(&mut to, half_space.distance(end));
        if from <= 0.0 {
            kept.push(start);
        }
        if (from < 0.0 && to > 0.0) || (from > 0.0 && to < 0.0) {
            kept.push(start + (end - start) * (from / (from - to)));
        }
    }
}

/// The six half-spaces whose intersection is the box from `low` to `high`.
pub(crate) fn box_half_spaces(low: DVec3, high: DVec3) -> [HalfSpace; 6] {
    let upper = |normal: DVec3| HalfSpace { normal, offset: normal.dot(high) };
    let lower = |normal: DVec3| HalfSpace { normal: -normal, offset: -normal.dot(low) };
    [
        upper(DVec3::X),
        lower(DVec3::X),
        upper(DVec3::Y),
        lower(DVec3::Y),
        upper(DVec3::Z),
        lower(DVec3::Z),
    ]
}

/// The part of a half-space's plane inside the box of `half_extent` around the origin,
/// counter-clockwise seen from outside of the half-space.
pub(crate) fn box_section(half_space: &HalfSpace, half_extent: DVec3) -> Vec<DVec3> {
    let (u, v) = half_space.normal.any_orthonormal_pair();
    let v = if u.cross(v).dot(half_space.normal) < 0.0 { -v } else { v };
    let middle = half_space.normal * half_space.offset;

    // A square that covers the whole section, then the box's faces cut it.
    let reach = 2.0 * (half_extent.length() + half_space.offset.abs());
    let mut polygon = vec![
        middle + reach * (u + v),
        middle + reach * (v - u),
        middle - reach * (u + v),
        middle + reach * (u - v),
    ];
    for face in box_half_spaces(-half_extent, half_extent) {
        polygon = clip(&polygon, &face);
    }
    polygon
}

/// Area [m^2] of a convex polygon.
pub(crate) fn area(polygon: &[DVec3]) -> f64 {
    let Some((&apex, others)) = polygon.split_first() else { return 0.0 };
    let doubled: DVec3 = others.windows(2).map(|pair| (pair[0] - apex).cross(pair[1] - apex)).sum();
    0.5 * doubled.length()
}

/// Area [m^2] and centroid [m] of a convex polygon.
pub(crate) fn area_and_centroid(polygon: &[DVec3]) -> (f64, DVec3) {
    let Some((&apex, others)) = polygon.split_first() else { return (0.0, DVec3::ZERO) };
    let (mut area, mut moment) = (0.0, DVec3::ZERO);
    for pair in others.windows(2) {
        let part = 0.5 * (pair[0] - apex).cross(pair[1] - apex).length();
        area += part;
        moment += part * ((pair[0] - apex) + (pair[1] - apex)) / 3.0;
    }
    if area > 0.0 { (area, apex + moment / area) } else { (0.0, apex) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn section_of_the_unit_cube_across_its_diagonal_is_the_regular_hexagon() {
        let diagonal = HalfSpace { normal: DVec3::ONE.normalize(), offset: 0.0 };
        let hexagon = box_section(&diagonal, DVec3::splat(0.5));
        let edge = 0.5f64.sqrt();
        assert!((area(&hexagon) - 1.5 * 3f64.sqrt() * edge * edge).abs() < 1e-12);
        assert!(hexagon.iter().all(|&vertex| diagonal.distance(vertex).abs() < 1e-12));
        let turn = (hexagon[1] - hexagon[0]).cross(hexagon[2] - hexagon[0]);
        assert!(turn.dot(diagonal.normal) > 0.0, "counter-clockwise seen from outside");
    }

    #[test]
    fn what_lies_outside_is_cut_off() {
        let square = [DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Y, DVec3::Y];
        let quarter = clip(&square, &HalfSpace { normal: DVec3::X, offset: 0.25 });
        assert!((area(&quarter) - 0.25).abs() < 1e-15);
        assert!(clip(&square, &HalfSpace { normal: DVec3::X, offset: -0.1 }).is_empty());
    }
}
