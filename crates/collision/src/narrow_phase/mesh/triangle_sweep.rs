//! A moving ball, or a point, against a triangle's inside.

use glam::DVec3;

/// How a moving point and a feature meet on a straight way.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sweep {
    /// Fraction of the way at the touch, or where the gap is least without one [1].
    pub(crate) at: f64,
    pub(crate) touches: bool,
    /// Least gap [m], up to the touch.
    pub(crate) least: f64,
}

/// A triangle with the normal of the side that is met.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Facet {
    pub(crate) corners: [DVec3; 3],
    pub(crate) normal: DVec3,
}

impl Facet {
    /// Height of a point over the plane [m].
    #[inline]
    pub(crate) fn height(&self, point: DVec3) -> f64 {
        (point - self.corners[0]).dot(self.normal)
    }

    /// Fractions of a straight way between which its foot lies on the triangle, which is larger by
    /// `beyond` [m] on all sides.
    fn foot_within(&self, [from, to]: [DVec3; 2], beyond: f64) -> Option<[f64; 2]> {
        let (mut first, mut last) = (0.0_f64, 1.0_f64);
        // Corners run clockwise seen from a sheet's back.
        let [a, b, c] = self.corners;
        let turn = (b - a).cross(c - a).dot(self.normal).signum();
        for at in 0..3 {
            let corner = self.corners[at];
            let inward = turn * self.normal.cross(self.corners[(at + 1) % 3] - corner);
            let most = -beyond * inward.length();
            let start = inward.dot(from - corner) - most;
            let end = inward.dot(to - corner) - most;
            if start < 0.0 && end < 0.0 {
                return None;
            }
            if start < 0.0 {
                first = first.max(start / (start - end));
            } else if end < 0.0 {
                last = last.min(start / (start - end));
            }
        }
        (first <= last).then_some([first, last])
    }

    /// Meeting of a ball whose centre moves straight, with the inside of the triangle. At the way's
    /// begin it may lie in the triangle's plane at any depth; where its foot comes over the
    /// triangle later, no deeper than `slack` [m], and a ball's centre is in front. A point that
    /// comes over it so near is met only if its body `is_over` the triangle: else it passes an
    /// edge.
    pub(crate) fn sweep(
        &self,
        way: [DVec3; 2],
        radius: f64,
        (beyond, slack): (f64, f64),
        is_over: impl FnOnce() -> bool,
    ) -> Option<Sweep> {
        let [start, end] = [self.height(way[0]) - radius, self.height(way[1]) - radius];
        let [first, last] = self.foot_within(way, beyond)?;
        let gap = |at: f64| start + at * (end - start);
        let [on_entry, on_exit] = [gap(first), gap(last)];
        if first > 0.0 {
            let depth = if radius > 0.0 { slack.min(radius) } else { slack };
            if on_entry < -depth || radius == 0.0 && on_entry <= slack && !is_over() {
                return None;
            }
        }
        if on_entry <= 0.0 {
            return Some(Sweep { at: first, touches: true, least: on_entry });
        }
        if on_exit <= 0.0 {
            return Some(Sweep { at: start / (start - end), touches: true, least: 0.0 });
        }
        let at = if on_exit < on_entry { last } else { first };
        Some(Sweep { at, touches: false, least: on_entry.min(on_exit) })
    }

    /// Where a straight way goes through the triangle from its front, as a fraction of the way.
    pub(crate) fn crossing(&self, way: [DVec3; 2], beyond: f64) -> Option<f64> {
        let [start, end] = [self.height(way[0]), self.height(way[1])];
        if start <= 0.0 || end > 0.0 {
            return None;
        }
        let at = start / (start - end);
        let through = way[0].lerp(way[1], at);
        self.foot_within([through; 2], beyond).map(|_| at)
    }
}

/// Part of a straight way at which it comes nearest to zero [1].
pub(crate) fn nearest_part(from: DVec3, to: DVec3) -> f64 {
    let way = to - from;
    let squared = way.length_squared();
    if squared > 0.0 { (-from.dot(way) / squared).clamp(0.0, 1.0) } else { 0.0 }
}

/// The first touch of a vector that moves straight from `from` to `to` with the ball of `radius`
/// [m] around zero, or where it is nearest.
pub(crate) fn sweep_round(from: DVec3, to: DVec3, radius: f64) -> Sweep {
    let way = to - from;
    let (squared, along) = (way.length_squared(), from.dot(way));
    let start = from.length() - radius;
    if start <= 0.0 {
        return Sweep { at: 0.0, touches: true, least: start };
    }
    let nearest = nearest_part(from, to);
    let least = (from + nearest * way).length() - radius;
    if least > 0.0 {
        return Sweep { at: nearest, touches: false, least };
    }
    // |from + t way| = radius, the smaller root.
    let rest = from.length_squared() - radius * radius;
    let root = (along * along - squared * rest).max(0.0).sqrt();
    Sweep { at: (rest / (root - along)).clamp(0.0, 1.0), touches: true, least: 0.0 }
}
