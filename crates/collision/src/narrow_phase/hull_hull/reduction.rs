//! Manifold reduction.

use crate::narrow_phase::hull_hull::hull_point::HullPoint;
use glam::DVec3;

/// Maximum number of points of a flat contact between two hulls.
pub(crate) const FEW_POINTS: usize = 4;

/// Number of points up to which all are compared with all [1]: of fewer sorting takes longer.
const FEW_TO_COMPARE: usize = 128;

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

    // Drop points higher above another point than beside it: they touch later.
    all.clear();
    all.extend_from_slice(points);
    let near = NearPoints::of(all, normal, close);
    points.retain(|point| {
        near.to(point).iter().all(|other| {
            let above = point.gap - other.gap;
            above <= close || above * above <= across_squared(point, other, normal)
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
    // A polygon, clockwise about the normal: points beyond a side lie to the left of it.
    let mut around = Vec::with_capacity(most);
    if let Some(a) = take(&depth)
        && let Some(b) = take(&|point| across_squared(point, &a, normal).sqrt())
        && let Some(c) = take(&|point| area(&a, &b, point, normal).abs())
    {
        around.extend(if area(&a, &b, &c, normal) < 0.0 { [a, b, c] } else { [b, a, c] });
    }
    // Each turn may drop as many as it adds.
    for _ in 0..2 * most {
        if around.len() < 3 || taken >= most {
            break;
        }
        let beyond = |side: usize, point: &HullPoint| {
            beyond(&around[side], &around[(side + 1) % around.len()], point, (normal, close))
        };
        let sides = 0..around.len();
        let most_beyond =
            |point: &HullPoint| sides.clone().map(|side| beyond(side, point)).fold(0.0, f64::max);
        let Some(index) = best_of(&points[taken..], &most_beyond) else { break };
        let next = points[taken + index];
        points[taken..=taken + index].rotate_right(1);
        taken += 1;
        let side =
            sides.clone().find(|&side| beyond(side, &next) == most_beyond(&next)).unwrap_or(0);
        for dropped in extend(&mut around, side, next, (normal, close)) {
            let at = points[..taken].iter().position(|kept| kept.on == dropped.on);
            if let Some(at) = at {
                points[at..taken].rotate_left(1);
                taken -= 1;
            }
        }
    }
    points.truncate(taken);
}

/// Points among which others are looked for that are below a point.
struct NearPoints<'a> {
    points: &'a [HullPoint],
    /// Across the normal, if the points are in the order of their places along it.
    along: Option<DVec3>,
    /// Least separation of all [m].
    lowest: f64,
    /// Separations within this are equal [m].
    close: f64,
}

impl<'a> NearPoints<'a> {
    fn of(points: &'a mut [HullPoint], normal: DVec3, close: f64) -> Self {
        let lowest = points.iter().map(|point| point.gap).fold(f64::INFINITY, f64::min);
        let is_flat = points.iter().all(|point| point.gap - lowest <= close);
        let is_sorted = points.len() > FEW_TO_COMPARE && !is_flat;
        let along = is_sorted.then(|| normal.any_orthonormal_vector());
        if let Some(along) = along {
            points.sort_unstable_by(|a, b| along.dot(middle(a)).total_cmp(&along.dot(middle(b))));
        }
        Self { points, along, lowest, close }
    }

    /// At least those that lie no further beside a point than below it, by more than is equal.
    fn to(&self, point: &HullPoint) -> &[HullPoint] {
        let above = point.gap - self.lowest;
        if above <= self.close {
            return &[];
        }
        let Some(along) = self.along else { return self.points };
        let (at, most) = (along.dot(middle(point)), above + self.close);
        let first = self.points.partition_point(|other| along.dot(middle(other)) < at - most);
        let rest = &self.points[first..];
        &rest[..rest.partition_point(|other| along.dot(middle(other)) <= at + most)]
    }
}

/// Adds a point beyond a side to a convex polygon. Returns the corners that are none any more, but
/// those that are deeper than a flat body would be there.
fn extend(
    around: &mut Vec<HullPoint>,
    side: usize,
    point: HullPoint,
    (normal, close): (DVec3, f64),
) -> Vec<HullPoint> {
    // The point comes last: its neighbours are the first one and the one before it.
    let first = (side + 1) % around.len();
    around.rotate_left(first);
    around.push(point);
    let mut dropped = Vec::new();
    let is_corner = |around: &[HullPoint], at: usize| {
        let [from, to] = [around.len() - 1, 1].map(|step| &around[(at + step) % around.len()]);
        beyond(from, to, &around[at], (normal, close)) > 0.0
    };
    for is_first in [true, false] {
        let at = |around: &[HullPoint]| if is_first { 0 } else { around.len() - 2 };
        while around.len() > 3 && !is_corner(around, at(around)) {
            let corner = around.remove(at(around));
            if !is_deeper(around, &corner, (normal, close)) {
                dropped.push(corner);
            }
        }
    }
    dropped
}

/// True for a point that lies deeper, by more than `close` [m], than a plane through the ends of the
/// nearest side of a polygon and the corner furthest from that.
fn is_deeper(around: &[HullPoint], point: &HullPoint, (normal, close): (DVec3, f64)) -> bool {
    let ends = |side: usize| (&around[side], &around[(side + 1) % around.len()]);
    let inward = |side: usize, point: &HullPoint| {
        let (from, to) = ends(side);
        -area(from, to, point, normal) / across_squared(from, to, normal).sqrt()
    };
    let nearest = (0..around.len()).min_by(|&a, &b| inward(a, point).total_cmp(&inward(b, point)));
    let Some(side) = nearest else { return true };
    let (from, to) = ends(side);
    let furthest = around.iter().max_by(|a, b| inward(side, a).total_cmp(&inward(side, b)));
    let Some(opposite) = furthest else { return true };
    let level = area(to, opposite, point, normal) * from.gap
        + area(opposite, from, point, normal) * to.gap
        + area(from, to, point, normal) * opposite.gap;
    point.gap < level / area(from, to, opposite, normal) - close
}

/// Middle of both surfaces' points [m].
fn middle(point: &HullPoint) -> DVec3 {
    0.5 * (point.on[0] + point.on[1])
}

/// Squared distance of two points across the normal [m^2].
fn across_squared(a: &HullPoint, b: &HullPoint, normal: DVec3) -> f64 {
    let between = middle(a) - middle(b);
    (between - between.dot(normal) * normal).length_squared()
}

/// Twice the area of the triangle with two other points [m^2], positive to their left.
fn area(from: &HullPoint, to: &HullPoint, point: &HullPoint, normal: DVec3) -> f64 {
    normal.dot((middle(to) - middle(from)).cross(middle(point) - middle(from)))
}

/// Twice the area of the triangle with a side [m^2], for points beyond it by more than `close` [m];
/// zero for others: they add nothing, and rounding would choose among them.
fn beyond(
    from: &HullPoint,
    to: &HullPoint,
    point: &HullPoint,
    (normal, close): (DVec3, f64),
) -> f64 {
    let area = area(from, to, point, normal);
    let is_beyond = area > 0.0 && area * area > close * close * across_squared(from, to, normal);
    if is_beyond { area } else { 0.0 }
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
