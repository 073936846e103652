//! Few points that carry as many do.

use crate::narrow_phase::hull_hull::hull_point::HullPoint;
use glam::DVec3;

/// A flat contact between two hulls needs no more.
pub(crate) const FEW_POINTS: usize = 4;

/// A later candidate must be better by this [1] to be taken instead of an earlier one, so that equal
/// ones do not take turns. Without it a falling heap overlaps by a tenth more.
const BETTER: f64 = 1.05;

/// Leaves some of the points, if they are many: a deepest one, the one furthest from it, the one
/// that spans the largest area with these, and then, up to so many, always the one that is furthest
/// beyond a side of what they span, by the area of the triangle with that side. Depths that differ
/// by less than `close` [m] are equal. `all` is room.
pub(crate) fn reduce(
    points: &mut Vec<HullPoint>,
    all: &mut Vec<HullPoint>,
    most: usize,
    (normal, close): (DVec3, f64),
) {
    // A direction along no axis, to tell equal ones apart always in the same way.
    const SOMEWHERE: DVec3 = DVec3::new(0.43, 0.57, 0.7);
    if points.len() <= FEW_POINTS {
        return;
    }
    let middle = |point: &HullPoint| 0.5 * (point.on[0] + point.on[1]);
    let across_squared = |a: &HullPoint, b: &HullPoint| {
        let between = middle(a) - middle(b);
        (between - between.dot(normal) * normal).length_squared()
    };

    // What is more above another point than beside it touches after it.
    all.clear();
    all.extend_from_slice(points);
    points.retain(|point| {
        all.iter().all(|other| {
            let above = point.gap - other.gap;
            above <= close || above * above <= across_squared(point, other)
        })
    });

    // On the ground all may stay; between two hulls what adds no area goes even if they are few.
    if most > FEW_POINTS && points.len() <= most {
        return;
    }

    // Those that are taken go to the front, in turn; the others keep their order.
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
        // Clockwise about the normal, so that what is beyond a side is to the left of it.
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

/// The point of the highest score, if that is positive.
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
