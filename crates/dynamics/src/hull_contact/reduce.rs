//! Few points that carry as many do.

use super::HullPoint;
use glam::DVec3;

/// A flat contact needs no more.
const MOST_POINTS: usize = 4;

/// A later candidate must be better by this to be taken instead of an earlier one, so that equal ones do not take turns.
const BETTER: f64 = 1.05;

/// At most four of the points: a deepest one, the one furthest from it, and those that span the largest area on both sides of the
/// line between them. Depths that differ by less than `close` [m] are equal.
pub(crate) fn reduce(mut points: Vec<HullPoint>, normal: DVec3, close: f64) -> Vec<HullPoint> {
    // A direction along no axis, to tell equal ones apart always in the same way.
    const SOMEWHERE: DVec3 = DVec3::new(0.43, 0.57, 0.7);
    if points.len() <= MOST_POINTS {
        return points;
    }
    let middle = |point: &HullPoint| 0.5 * (point.on[0] + point.on[1]);
    let across = |a: &HullPoint, b: &HullPoint| {
        let between = middle(a) - middle(b);
        (between - between.dot(normal) * normal).length()
    };

    // What is more above another point than beside it touches after it.
    let all = points.clone();
    points.retain(|point| all.iter().all(|other| point.gap - other.gap <= across(point, other).max(close)));

    let deepest = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
    let least = points.iter().map(|point| SOMEWHERE.dot(middle(point))).fold(f64::INFINITY, f64::min) - close;
    let mut kept = Vec::with_capacity(MOST_POINTS);
    take_best(&mut points, &mut kept, |point| {
        if point.gap <= deepest + close { SOMEWHERE.dot(middle(point)) - least } else { 0.0 }
    });
    let Some(&a) = kept.first() else { return kept };
    take_best(&mut points, &mut kept, |point| across(point, &a));
    let Some(&b) = kept.get(1) else { return kept };
    // Twice the area of the triangle with two kept points, positive to the left.
    let area = |p: &HullPoint, q: &HullPoint, point: &HullPoint| {
        normal.dot((middle(q) - middle(p)).cross(middle(point) - middle(p)))
    };
    take_best(&mut points, &mut kept, |point| area(&a, &b, point).abs());
    let Some(&c) = kept.get(2) else { return kept };
    let side = if area(&a, &b, &c) < 0.0 { -1.0 } else { 1.0 };
    take_best(&mut points, &mut kept, |point| {
        let beyond = [area(&b, &a, point), area(&c, &b, point), area(&a, &c, point)];
        beyond.into_iter().map(|area| side * area).fold(f64::NEG_INFINITY, f64::max)
    });
    kept
}

/// Moves the point of the highest score over, if that is positive.
fn take_best(points: &mut Vec<HullPoint>, kept: &mut Vec<HullPoint>, score: impl Fn(&HullPoint) -> f64) {
    let mut best: Option<(usize, f64)> = None;
    for (index, point) in points.iter().enumerate() {
        let score = score(point);
        if score > best.map_or(0.0, |(_, best)| BETTER * best) {
            best = Some((index, score));
        }
    }
    if let Some((index, _)) = best {
        kept.push(points.remove(index));
    }
}
