//! Manifold reduction.

use crate::narrow_phase::hull_hull::hull_point::HullPoint;
use glam::DVec3;

/// Maximum number of points of a flat contact between two hulls.
pub(crate) const FEW_POINTS: usize = 4;

/// A later candidate needs this factor in score over an earlier candidate [1], for a stable choice
/// among equals. Without it a falling heap overlaps by a tenth more.
const BETTER: f64 = 1.05;

/// Reduces a large manifold to at most `most` points: a deepest point, the point furthest from it,
/// the point spanning the largest area with both, and then repeatedly the point with the largest
/// triangle beyond a side of the polygon. Depths within `close` [m] are equal. `all` is scratch
/// memory.
pub(crate) fn reduce(
    points: &mut Vec<HullPoint>,
    all: &mut Vec<HullPoint>,
    most: usize,
    (normal, close): (DVec3, f64),
) {
    // A direction off all axes, for a unique order of equal points.
    const SOMEWHERE: DVec3 = DVec3::new(0.43, 0.57, 0.7);
    if points.len() <= FEW_POINTS {
        return;
    }
    let middle = |point: &HullPoint| 0.5 * (point.on[0] + point.on[1]);
    let across_squared = |a: &HullPoint, b: &HullPoint| {
        let between = middle(a) - middle(b);
        (between - between.dot(normal) * normal).length_squared()
    };

    // Drop points higher above another point than beside it: they touch later.
    all.clear();
    all.extend_from_slice(points);
    points.retain(|point| {
        all.iter().all(|other| {
            let above = point.gap - other.gap;
            above <= close || above * above <= across_squared(point, other)
        })
    });

    // On the ground all points may stay; between two hulls even few points are reduced by area.
    if most > FEW_POINTS && points.len() <= most {
        return;
    }

    // Chosen points move to the front, in order; the others keep their order.
    let deepest = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
    let least =
        points.iter().map(|point| SOMEWHERE.dot(middle(point))).fold(f64::INFINITY, f64::min)
            - close;
    let mut taken = 0;
    let mut take = |score: &dyn Fn(&HullPoint) -> f64| {
        let best = best_of(&points[taken..], score).map(|index| taken + index);
        if let Some(index) = best {
            points[taken..=index].rotate_right(1);
            taken += 1;
        }
        best.map(|_| points[taken - 1])
    };
    let depth = |point: &HullPoint| {
        if point.gap <= deepest + close { SOMEWHERE.dot(middle(point)) - least } else { 0.0 }
    };
    // Twice the area of the triangle with two kept points, positive to the left.
    let area = |p: &HullPoint, q: &HullPoint, point: &HullPoint| {
        normal.dot((middle(q) - middle(p)).cross(middle(point) - middle(p)))
    };
    let mut around = Vec::with_capacity(most);
    if let Some(a) = take(&depth)
        && let Some(b) = take(&|point| across_squared(point, &a).sqrt())
        && let Some(c) = take(&|point| area(&a, &b, point).abs())
    {
        // Clockwise about the normal: points beyond a side lie to the left of it.
        around.extend(if area(&a, &b, &c) < 0.0 { [a, b, c] } else { [b, a, c] });
    }
    while (3..most).contains(&around.len()) {
        let beyond = |side: usize, point: &HullPoint| {
            area(&around[side], &around[(side + 1) % around.len()], point)
        };
        let sides = 0..around.len();
        let most_beyond =
            |point: &HullPoint| sides.clone().map(|side| beyond(side, point)).fold(0.0, f64::max);
        let Some(next) = take(&most_beyond) else { break };
        let side =
            sides.clone().find(|&side| beyond(side, &next) == most_beyond(&next)).unwrap_or(0);
        around.insert(side + 1, next);
    }
    points.truncate(taken);
}

/// Point with the highest positive score.
fn best_of(points: &[HullPoint], score: &dyn Fn(&HullPoint) -> f64) -> Option<usize> {
    let mut best: Option<(usize, f64)> = None;
    for (index, point) in points.iter().enumerate() {
        let score = score(point);
        if score > best.map_or(0.0, |(_, best)| BETTER * best) {
            best = Some((index, score));
        }
    }
    best.map(|(index, _)| index)
}
