//! Two lines across each other, or side by side.

use glam::DVec3;

/// Where two lines meet, seen along a normal: for each point its part from 0 to 1 between the ends
/// of both. Lines side by side that leave each other by less than `close` [m] meet at both ends of
/// their common stretch, others at one point.
pub(crate) fn lines_meet(
    lines: [[DVec3; 2]; 2],
    normal: DVec3,
    close: f64,
) -> ([[f64; 2]; 2], usize) {
    let flat = |way: DVec3| way - way.dot(normal) * normal;
    let [first, second] = lines.map(|[from, to]| flat(to - from));
    let between = flat(lines[1][0] - lines[0][0]);
    let (length_first, length_second) = (first.length_squared(), second.length_squared());
    if length_first == 0.0 || length_second == 0.0 {
        return ([nearest(between, first, second); 2], 1);
    }

    // The common stretch, along the first line.
    let on_first = |along: DVec3| along.dot(first) / length_first;
    let on_second =
        |part: f64| ((part * first - between).dot(second) / length_second).clamp(0.0, 1.0);
    let [a, b] = [on_first(between), on_first(between + second)];
    let (begin, end) = (a.min(b).max(0.0), a.max(b).min(1.0));
    let sine_squared = first.cross(second).length_squared() / (length_first * length_second);
    let leaves = (end - begin).powi(2) * length_first * sine_squared;
    if end > begin && leaves <= close * close {
        return ([[begin, on_second(begin)], [end, on_second(end)]], 2);
    }
    ([nearest(between, first, second); 2], 1)
}

/// The stretch of the first line along which the second one lies, seen along a normal, from 0 to 1
/// between the first one's ends.
pub(crate) fn common_stretch(lines: [[DVec3; 2]; 2], normal: DVec3) -> Option<[f64; 2]> {
    let flat = |way: DVec3| way - way.dot(normal) * normal;
    let first = flat(lines[0][1] - lines[0][0]);
    let part = |point: DVec3| flat(point - lines[0][0]).dot(first) / first.length_squared();
    let [a, b] = lines[1].map(part);
    let (begin, end) = (a.min(b).max(0.0), a.max(b).min(1.0));
    (begin < end).then_some([begin, end])
}

/// Nearest points of two segments that begin `between` apart [Eri05 sec. 5.1.9].
fn nearest(between: DVec3, first: DVec3, second: DVec3) -> [f64; 2] {
    let (a, e) = (first.length_squared(), second.length_squared());
    let (b, c, f) = (first.dot(second), first.dot(between), second.dot(between));
    if e == 0.0 {
        return [if a > 0.0 { (c / a).clamp(0.0, 1.0) } else { 0.0 }, 0.0];
    }
    let determinant = a * e - b * b;
    let part = if a > 0.0 && determinant > 0.0 {
        ((c * e - b * f) / determinant).clamp(0.0, 1.0)
    } else {
        0.0
    };
    let other = (b * part - f) / e;
    let clamped = other.clamp(0.0, 1.0);
    if clamped == other || a == 0.0 {
        return [part, clamped];
    }
    [((b * clamped + c) / a).clamp(0.0, 1.0), clamped]
}
