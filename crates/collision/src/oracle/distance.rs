//! Distance of cores that are apart: the point of their difference nearest to the origin, over all
//! corners, sides and triangles of a growing set of support points.

use crate::oracle::body::Convex;
use glam::DVec3;

const MOST_STEPS: usize = 400;

/// The distance is proved to this part of the smaller radius, or of itself where it is larger, and
/// to what rounding leaves of the coordinates.
const PRECISE: f64 = 1e-11;
const ROUNDING: f64 = 4e-15;

/// Where rounding ends the search earlier, a distance is good enough to this part of itself, which
/// leaves 1.4e-4 rad of its normal; of cores that nearly touch, at this part of the smaller radius,
/// to this part of that: they have many normals as good.
const ENOUGH: f64 = 1e-8;
const TOUCH: f64 = 1e-3;

/// A distance of two cores.
pub(crate) struct Distance {
    /// [m]
    pub(crate) least: f64,
    /// Unit, from the second to the first.
    pub(crate) normal: DVec3,
    /// No other normal separates further.
    pub(crate) is_proved: bool,
}

/// Distance of two cores; `None` for cores that overlap, or touch within rounding.
pub(crate) fn distance(first: &Convex, second: &Convex) -> Option<Distance> {
    let size = first.radius().min(second.radius());
    let scale = first.middle().distance(second.middle()) + size;
    let precise = |length: f64| PRECISE * size.max(length) + ROUNDING * scale;
    let support = |way: DVec3| first.support(-way) - second.support(way);
    let mut kept = vec![support(first.middle() - second.middle())];
    let mut way = kept[0];
    let mut best: Option<(f64, DVec3)> = None;
    let mut is_proved = false;
    for _ in 0..MOST_STEPS {
        let length = way.length();
        if length <= precise(0.0) {
            break;
        }
        let normal = way / length;
        let next = support(normal);
        let least = next.dot(normal);
        if least > 0.0 && best.is_none_or(|best| least > best.0) {
            best = Some((least, normal));
        }
        if length - least <= precise(length) {
            is_proved = true;
            break;
        }
        kept.push(next);
        if holds_origin(&kept) {
            break;
        }
        let (nearest, of) = nearest(&kept);
        if nearest.length_squared() >= way.length_squared() {
            break;
        }
        (kept, way) = (of, nearest);
    }
    best.map(|(least, normal)| {
        let (length, left) = (way.length(), (way.length() - least).abs());
        let is_enough = left <= ENOUGH * length || length <= TOUCH * size && left <= ENOUGH * size;
        Distance { least, normal, is_proved: is_proved || is_enough }
    })
}

/// True if the last points, up to five, have the origin in one of their tetrahedra.
fn holds_origin(points: &[DVec3]) -> bool {
    let count = points.len();
    let is_within = |corners: [DVec3; 4]| {
        (0..4).all(|at| {
            let [apex, a, b, c] = [0, 1, 2, 3].map(|k| corners[(at + k) % 4]);
            let normal = (b - a).cross(c - a);
            (apex - a).dot(normal) * (-a).dot(normal) > 0.0
        })
    };
    (0..count).any(|left_out| {
        let mut rest = (0..count).filter(|&at| count == 4 || at != left_out);
        let corners = [0; 4].map(|_: i32| rest.next());
        matches!(corners, [Some(a), Some(b), Some(c), Some(d)]
            if is_within([a, b, c, d].map(|at| points[at])))
    })
}

/// The nearest point of all triangles, and its corners.
fn nearest(points: &[DVec3]) -> (DVec3, Vec<DVec3>) {
    let mut best: (f64, DVec3, Vec<DVec3>) = (f64::INFINITY, DVec3::ZERO, Vec::new());
    let mut offer = |point: DVec3, corners: &[DVec3]| {
        let squared = point.length_squared();
        if squared < best.0 {
            best = (squared, point, corners.to_vec());
        }
    };
    for (i, &a) in points.iter().enumerate() {
        offer(a, &[a]);
        for (j, &b) in points.iter().enumerate().skip(i + 1) {
            let along = b - a;
            let part = -a.dot(along) / along.length_squared();
            if part > 0.0 && part < 1.0 {
                offer(a + part * along, &[a, b]);
            }
            for &c in &points[j + 1..] {
                let normal = (b - a).cross(c - a);
                let foot = a.dot(normal) / normal.length_squared() * normal;
                let inside =
                    |from: DVec3, to: DVec3| normal.dot((to - from).cross(foot - from)) >= 0.0;
                if foot.is_finite() && inside(a, b) && inside(b, c) && inside(c, a) {
                    offer(foot, &[a, b, c]);
                }
            }
        }
    }
    (best.1, best.2)
}
