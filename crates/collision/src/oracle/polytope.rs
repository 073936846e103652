//! The least overlap of two cores, proved: a polytope in their difference that grows where its
//! surface is nearest to the origin [Bergen01].
//!
//! The overlap along a direction is how far the difference reaches there, so each direction bounds
//! the least overlap from above. A closed surface of points of the difference that winds around the
//! origin bounds it from below: the difference is convex, and holds every ball about the origin that
//! the surface does not cut. Where both bounds meet the least overlap is known; where rounding keeps
//! them apart there is no answer.

use crate::oracle::body::Convex;
use glam::DVec3;
use std::f64::consts::TAU;

/// Bounds meet within this part of the smaller radius.
const PRECISE: f64 = 1e-8;

/// Points of the surface at most. Two rims need about a hundred.
const MOST_POINTS: usize = 400;

/// A triangle of the surface.
struct Face {
    corners: [DVec3; 3],
    /// Unit, outward.
    normal: DVec3,
    /// Of its plane, along the normal from the origin [m]; infinite without area.
    offset: f64,
}

impl Face {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        match (b - a).cross(c - a).try_normalize() {
            Some(normal) => {
                let offset = corners.map(|corner| corner.dot(normal)).into_iter();
                Self { corners, normal, offset: offset.fold(f64::INFINITY, f64::min) }
            }
            None => Self { corners, normal: DVec3::ZERO, offset: f64::INFINITY },
        }
    }

    /// [m]
    fn distance_to_origin(&self) -> f64 {
        let [a, b, c] = self.corners;
        let sides = [[a, b], [b, c], [c, a]];
        let is_over = |[from, to]: &[DVec3; 2]| self.normal.dot((*to - *from).cross(-*from)) >= 0.0;
        if self.offset.is_finite() && sides.iter().all(is_over) {
            return self.offset.abs();
        }
        let of_side = |[from, to]: [DVec3; 2]| {
            let along = to - from;
            let part = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
            if part.is_finite() { (from + part * along).length() } else { from.length() }
        };
        sides.map(of_side).into_iter().fold(f64::INFINITY, f64::min)
    }

    /// Solid angle as the origin sees it, positive from behind [vanOosterom83].
    fn solid_angle(&self) -> f64 {
        let [a, b, c] = self.corners;
        let [x, y, z] = [a.length(), b.length(), c.length()];
        let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
        2.0 * a.dot(b.cross(c)).atan2(below)
    }
}

/// Separation along the best normal [m], negative for overlap, and this normal, from the second to
/// the first; `None` where it is not proved.
pub(crate) fn least_overlap(first: &Convex, second: &Convex) -> Option<(f64, DVec3)> {
    let size = first.radius().min(second.radius());
    let scale = first.radius().max(second.radius());
    let (precise, rounding) = (PRECISE * size, 1e-15 * scale);
    let support = |way: DVec3| first.support(way) - second.support(-way);
    let mut faces = tetrahedron(support)?;
    for _ in 0..MOST_POINTS {
        let nearest = faces.iter().min_by(|a, b| a.offset.total_cmp(&b.offset))?;
        let (normal, offset) = (nearest.normal, nearest.offset);
        let point = support(normal);
        let reach = point.dot(normal);
        if reach - offset <= precise {
            let distances = faces.iter().map(Face::distance_to_origin);
            let clear = distances.fold(f64::INFINITY, f64::min);
            let turns = || faces.iter().map(Face::solid_angle).sum::<f64>() / (2.0 * TAU);
            let is_proved = if reach <= precise {
                // They touch: the origin is as near to the surface, from within or not.
                reach.abs() <= precise && clear <= precise
            } else {
                clear >= reach - 2.0 * precise && (turns() - 1.0).abs() < 0.1
            };
            return is_proved.then_some((-reach, -normal));
        }
        // A point that is known cannot lie outside: rounding has spoiled the normal.
        // Nor has a surface that does not cross itself more than twice as many faces as points.
        let is_known = faces.iter().any(|face| face.corners.contains(&point));
        if is_known || faces.len() > 2 * MOST_POINTS {
            return None;
        }
        grow(&mut faces, point, rounding);
    }
    None
}

/// Replaces the faces that a point sees by those between it and their rim.
fn grow(faces: &mut Vec<Face>, point: DVec3, rounding: f64) {
    let is_seen = |face: &mut Face| {
        face.offset.is_finite() && point.dot(face.normal) - face.offset > rounding
    };
    let seen: Vec<Face> = faces.extract_if(.., is_seen).collect();
    let sides = |face: &Face| {
        let [a, b, c] = face.corners;
        [[a, b], [b, c], [c, a]]
    };
    let mut rim: Vec<[DVec3; 2]> = Vec::new();
    for [from, to] in seen.iter().flat_map(sides) {
        match rim.iter().position(|&side| side == [to, from]) {
            Some(back) => drop(rim.swap_remove(back)),
            None => rim.push([from, to]),
        }
    }
    faces.extend(rim.into_iter().map(|[from, to]| Face::new([from, to, point])));
}

/// Four points of a body, far from each other; `None` for a flat one.
fn tetrahedron(support: impl Fn(DVec3) -> DVec3) -> Option<Vec<Face>> {
    let [a, b] = [DVec3::X, -DVec3::X].map(&support);
    let along = (b - a).try_normalize()?;
    let furthest = |ways: [DVec3; 2], normal: DVec3| {
        let away = |point: &DVec3| (*point - a).dot(normal).abs();
        let points = ways.map(&support);
        if away(&points[0]) >= away(&points[1]) { points[0] } else { points[1] }
    };
    let (across, other) = along.any_orthonormal_pair();
    let off_line = |point: DVec3| (point - a).cross(along).length_squared();
    let [u, v] = [across, other].map(|way| furthest([way, -way], way));
    let c = if off_line(u) >= off_line(v) { u } else { v };
    let normal = (b - a).cross(c - a).try_normalize()?;
    let d = furthest([normal, -normal], normal);
    // Outward: the fourth point lies behind the first three.
    let [b, c] = if (d - a).dot(normal) < 0.0 { [b, c] } else { [c, b] };
    let faces = [[a, b, c], [a, c, d], [c, b, d], [b, a, d]].map(Face::new);
    faces.iter().all(|face| face.offset.is_finite()).then(|| faces.into())
}
