//! Points of two flat areas on each other, and of a line on an area.

use crate::narrow_phase::revolved::features::{Area, outward_of, sides_of, sides_of_triangle};
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use frangible_geometry::Hull;
use glam::DVec3;

/// A disc this nearly parallel to the other area has no lowest point: its points are fixed in the
/// body [rad]. With a hundredth of it a stack of eight flat cylinders moves at 67 mm/s, as the
/// points turn with the noise of its tilt; with this value at 0.02.
const LEVEL: f64 = 1e-3;

/// Rim points this near to a side of the other area, relative to the radius, are inside.
const ON_SIDE: f64 = 1e-9;

/// Points this near to a rim, relative to its radius, are on the disc: as far as discs that tilt by
/// two degrees are no circles to each other.
const NEARLY: f64 = 1e-3;

/// Numbers of rim points 0 to 7; of the second body's 8 to 15.
pub(crate) const OF_PARTNER: u64 = 8;
const CROSSING: u64 = 32;
const VERTEX: u64 = 1 << 32;
const EDGE: u64 = 2 << 32;

/// A point of a disc and of another area.
pub(crate) struct AreaPoint {
    /// On the disc and on the area [m].
    pub(crate) on: [DVec3; 2],
    pub(crate) id: u64,
    /// True for a point of the disc's own rim.
    pub(crate) is_rim: bool,
    /// True for a point of the other area's rim.
    pub(crate) is_other_rim: bool,
}

/// Gravity across the axis, relative to all of it, for which a level disc has a point downhill [1].
const SLOPE: f64 = 0.01;

/// Four points of a rim, the first of them lowest towards a plane with this normal, or downhill.
fn rim_points(
    body: &PlacedRevolved,
    end: usize,
    plane_normal: DVec3,
    gravity: DVec3,
) -> [DVec3; 4] {
    let (_, _, tilt) = body.split(plane_normal);
    let (along, _, downhill) = body.split(gravity);
    let lowest = if tilt > LEVEL {
        body.radial(-plane_normal)
    } else if downhill > SLOPE * along.abs() {
        body.radial(gravity)
    } else {
        body.across
    };
    let beside = body.axis.cross(lowest);
    [lowest, beside, -lowest, -beside].map(|radial| body.rim(end, radial))
}

/// Points where a disc lies on another area.
pub(crate) fn disc_on_area(
    body: &PlacedRevolved,
    end: usize,
    area: Area,
    [normal, gravity]: [DVec3; 2],
    points: &mut Vec<AreaPoint>,
) {
    if let Area::Disc(other, other_end) = area {
        return disc_on_disc([(body, end), (other, other_end)], [normal, gravity], points);
    }
    let close = ON_SIDE * body.ends[end].radius;
    for (k, rim) in rim_points(body, end, area.plane().normal, gravity).into_iter().enumerate() {
        let below = area.drop(rim, normal);
        if area.contains(below, normal, close) {
            let id = (4 * end + k) as u64;
            points.push(AreaPoint { on: [rim, below], id, is_rim: true, is_other_rim: false });
        }
    }
    if let Area::Face(hull, face) = area {
        face_in_disc(body, end, (hull, face), normal, points);
    }
}

/// Vertices of a face within a disc, and crossings of its sides with the rim.
fn face_in_disc(
    body: &PlacedRevolved,
    end: usize,
    (hull, face): (&Hull, usize),
    normal: DVec3,
    points: &mut Vec<AreaPoint>,
) {
    let disc = Area::Disc(body, end);
    let of_face = hull.face(face);
    for (at, [start, stop]) in sides_of(hull, face).enumerate() {
        let [from, to] = [start, stop].map(|vertex| disc.drop(vertex, normal));
        let mut add = |on: [DVec3; 2], id: u64| {
            points.push(AreaPoint { on, id, is_rim: false, is_other_rim: false });
        };
        if disc.contains(from, normal, 0.0) {
            add([from, start], VERTEX | u64::from(of_face.vertices[at]));
        }
        let Some(within) = within_disc([from, to], body, end) else { continue };
        for (which, part) in within.into_iter().enumerate() {
            if part > 0.0 && part < 1.0 {
                let id = EDGE | u64::from(of_face.edges[at]) << 1 | which as u64;
                add([from.lerp(to, part), start.lerp(stop, part)], id);
            }
        }
    }
}

/// The part of a line in the plane of a disc that lies within the disc, from 0 to 1 between its
/// ends.
fn within_disc([from, to]: [DVec3; 2], body: &PlacedRevolved, end: usize) -> Option<[f64; 2]> {
    let (way, lever) = (to - from, from - body.center(end));
    let radius = body.ends[end].radius;
    let (a, b) = (way.length_squared(), way.dot(lever));
    let root = b * b - a * (lever.length_squared() - radius * radius);
    if a <= 0.0 || root < 0.0 {
        return None;
    }
    let root = root.sqrt();
    Some([(-b - root) / a, (-b + root) / a])
}

/// Points of two discs on each other; nearly parallel ones, as others touch in few points.
fn disc_on_disc(
    discs: [(&PlacedRevolved, usize); 2],
    [normal, gravity]: [DVec3; 2],
    points: &mut Vec<AreaPoint>,
) {
    let areas = discs.map(|(body, end)| Area::Disc(body, end));
    let radii = discs.map(|(body, end)| body.ends[end].radius);
    let centers = discs.map(|(body, end)| body.center(end));
    let small = usize::from(radii[1] < radii[0]);
    let large = 1 - small;
    // In the smaller disc's plane.
    let middle = areas[small].drop(centers[large], normal);
    let apart = middle.distance(centers[small]);
    let id = |side: usize, k: usize| {
        (4 * discs[side].1 + k) as u64 + if side == 1 { OF_PARTNER } else { 0 }
    };
    let mut add = |of: usize, on_small: DVec3, id: u64, is_rim: bool| {
        let on_large = areas[large].drop(on_small, normal);
        // Discs at an angle see each other as ellipses.
        let is_on_both = [(small, on_small), (large, on_large)]
            .into_iter()
            .all(|(side, point)| areas[side].contains(point, normal, NEARLY * radii[side]));
        if !is_on_both {
            return;
        }
        let on = if small == 0 { [on_small, on_large] } else { [on_large, on_small] };
        let (is_rim, is_other_rim) = (is_rim && of == 0, is_rim && of == 1);
        points.push(AreaPoint { on, id, is_rim, is_other_rim });
    };
    let towards_small = areas[large].plane().normal;
    let rims = rim_points(discs[small].0, discs[small].1, towards_small, gravity);
    if apart <= radii[small] || apart + radii[small] <= radii[large] {
        // Rim points beyond the larger disc move towards its middle, which is in both.
        for (k, rim) in rims.into_iter().enumerate() {
            let way = rim - middle;
            let length = way.length();
            let is_inside = length <= radii[large];
            let point = if is_inside { rim } else { middle + radii[large] / length * way };
            add(small, point, id(small, k), is_inside);
        }
        return;
    }
    for (k, rim) in rims.into_iter().enumerate() {
        if rim.distance(middle) <= radii[large] {
            add(small, rim, id(small, k), true);
        }
    }
    // The larger disc's point furthest in the smaller one, and where the rims cross.
    let towards = (centers[small] - middle) / apart;
    let deep = middle + radii[large] * towards;
    if deep.distance(centers[small]) <= radii[small] {
        add(large, deep, id(large, 0), false);
    }
    let along =
        0.5 * (apart + (radii[large] - radii[small]) * (radii[large] + radii[small]) / apart);
    let half = (radii[large] * radii[large] - along * along).max(0.0).sqrt();
    let beside = towards.cross(areas[small].plane().normal);
    for (which, side) in [half, -half].into_iter().enumerate() {
        add(large, middle + along * towards + side * beside, CROSSING + which as u64, false);
    }
}

/// The part of a line over an area, seen along a normal, from 0 to 1 between its ends.
pub(crate) fn line_on_area([from, to]: [DVec3; 2], area: Area, normal: DVec3) -> Option<[f64; 2]> {
    let (mut begin, mut end) = (0.0_f64, 1.0_f64);
    // By the heights of both ends beyond a side of the area.
    let mut cut = |heights: [f64; 2]| {
        let change = heights[1] - heights[0];
        if change > 0.0 {
            end = end.min(-heights[0] / change);
        } else if change < 0.0 {
            begin = begin.max(-heights[0] / change);
        } else if heights[0] > 0.0 {
            return None;
        }
        Some(())
    };
    match area {
        Area::Plane(_) => {}
        Area::Face(hull, face) => {
            for [start, stop] in sides_of(hull, face) {
                let outward = outward_of(hull, face, stop - start, normal);
                cut([from, to].map(|point| outward.dot(point - start)))?;
            }
        }
        Area::Triangle(corners, plane) => {
            for [start, stop] in sides_of_triangle(corners) {
                let outward = (stop - start).cross(plane.normal.dot(normal).signum() * normal);
                cut([from, to].map(|point| outward.dot(point - start)))?;
            }
        }
        Area::Disc(body, disc) => {
            let on_disc = [from, to].map(|point| area.drop(point, normal));
            let within = within_disc(on_disc, body, disc)?;
            (begin, end) = (begin.max(within[0]), end.min(within[1]));
        }
    }
    (begin <= end).then_some([begin, end])
}
