//! The least overlap of two cores, proved.
//!
//! A growing polytope finds it; whether it is right does not depend on how the surface came about:
//! a closed surface of points of the difference that winds around the origin bounds the least
//! overlap from below, as the difference is convex and holds every ball about the origin that the
//! surface does not cut. The overlap along any direction bounds it from above.

use crate::narrow_phase::revolved::polytope::{Face, least_reach};
use crate::oracle::body::Convex;
use glam::DVec3;
use std::f64::consts::TAU;

/// Bounds meet within this part of the smaller radius.
const PRECISE: f64 = 1e-8;

/// Separation along the best normal [m], negative for overlap, and this normal, from the second to
/// the first; `None` where it is not proved.
pub(crate) fn least_overlap(first: &Convex, second: &Convex) -> Option<(f64, DVec3)> {
    let size = first.radius().min(second.radius());
    let precise = PRECISE * size;
    let support = |way: DVec3| first.support(way) - second.support(-way);
    let least = least_reach(support, precise)?;
    let reach = support(least.direction).dot(least.direction);
    let clear = least.surface.iter().map(distance_to_origin).fold(f64::INFINITY, f64::min);
    let turns = || least.surface.iter().map(solid_angle).sum::<f64>() / (2.0 * TAU);
    let is_proved = if reach <= precise {
        // They touch: the origin is as near to the surface, from within or not.
        reach.abs() <= precise && clear <= precise
    } else {
        clear >= reach - 2.0 * precise && is_closed(&least.surface) && (turns() - 1.0).abs() < 0.1
    };
    is_proved.then_some((-reach, -least.direction))
}

/// Each side of a face is passed as often the one way as the other.
fn is_closed(surface: &[Face]) -> bool {
    let key = |[from, to]: [DVec3; 2]| [from, to].map(|point| point.to_array().map(f64::to_bits));
    let sides = || surface.iter().flat_map(Face::sides);
    let mut ahead: Vec<_> = sides().map(key).collect();
    let mut back: Vec<_> = sides().map(|[from, to]| key([to, from])).collect();
    ahead.sort_unstable();
    back.sort_unstable();
    ahead == back
}

/// [m]
fn distance_to_origin(face: &Face) -> f64 {
    let [a, b, c] = face.corners;
    let normal = (b - a).cross(c - a);
    let is_over = |[from, to]: [DVec3; 2]| normal.dot((to - from).cross(-from)) >= 0.0;
    if let Some(unit) = normal.try_normalize().filter(|_| face.sides().into_iter().all(is_over)) {
        return a.dot(unit).abs().min(b.dot(unit).abs()).min(c.dot(unit).abs());
    }
    let of_side = |[from, to]: [DVec3; 2]| {
        let along = to - from;
        let part = (-from.dot(along) / along.length_squared()).clamp(0.0, 1.0);
        if part.is_finite() { (from + part * along).length() } else { from.length() }
    };
    face.sides().map(of_side).into_iter().fold(f64::INFINITY, f64::min)
}

/// As the origin sees a face, positive from behind [VS83].
fn solid_angle(face: &Face) -> f64 {
    let [a, b, c] = face.corners;
    let [x, y, z] = [a.length(), b.length(), c.length()];
    let below = x * y * z + a.dot(b) * z + b.dot(c) * x + c.dot(a) * y;
    2.0 * a.dot(b.cross(c)).atan2(below)
}
