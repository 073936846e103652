//! Corners of the convex outline of points in a plane.

use glam::DVec2;

/// Angle [rad] by which an outline turns at a corner at least, and distance between two corners as
/// a fraction of the extent [1]: 100 times the rounding errors of contact points.
const LEAST_TURN: f64 = 1e-3;
const LEAST_DISTANCE: f64 = 1e-3;

/// For each point: true if it is a corner, and not at an earlier one.
pub(super) fn corners(points: &[DVec2]) -> Vec<bool> {
    let none = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    let (low, high) = points.iter().fold(none, |(low, high), &at| (low.min(at), high.max(at)));
    let least = LEAST_DISTANCE * (high - low).length();
    let mut angles = Vec::with_capacity(points.len());
    let mut is_corner = |(number, &point): (usize, &DVec2)| {
        angles.clear();
        for (other, &at) in points.iter().enumerate() {
            let to = at - point;
            if to.length() > least {
                angles.push(libm::atan2(to.y, to.x));
            } else if other < number {
                return false;
            }
        }
        angles.sort_unstable_by(f64::total_cmp);
        // Each angle with the next one, the last with the first.
        let around = angles.first().map(|first| first + std::f64::consts::TAU);
        let next = angles.iter().skip(1).copied().chain(around);
        let gaps = angles.iter().zip(next).map(|(from, to)| to - from);
        angles.is_empty() || gaps.fold(0.0, f64::max) > std::f64::consts::PI + LEAST_TURN
    };
    points.iter().enumerate().map(&mut is_corner).collect()
}

#[cfg(test)]
mod tests {
    use super::corners;
    use glam::DVec2;

    /// Corners of a square count, and not points on its sides, within it, or at them.
    #[test]
    fn a_square_has_four_corners() {
        let grid = |i: usize| DVec2::new((i % 5) as f64, (i / 5) as f64);
        let shaken = |i: usize| grid(i) + 1e-7 * DVec2::new((i % 3) as f64, (i % 7) as f64);
        let points: Vec<DVec2> = (0..25).map(shaken).chain((0..25).map(grid)).collect();
        let found: Vec<usize> =
            (0..50).zip(corners(&points)).filter(|of| of.1).map(|of| of.0).collect();
        assert_eq!(found, [0, 4, 20, 24]);
    }

    /// Both ends of a line are corners, and all points of a circle, and a single point.
    #[test]
    fn lines_have_two_corners_and_circles_many() {
        let line: Vec<DVec2> = (0..7).map(|i| DVec2::new(0.3, -0.7) * f64::from(i)).collect();
        assert_eq!(corners(&line), [true, false, false, false, false, false, true]);
        let circle: Vec<DVec2> = (0..64).map(|i| DVec2::from_angle(0.098 * f64::from(i))).collect();
        assert!(corners(&circle).into_iter().all(|is_corner| is_corner));
        assert_eq!(corners(&[DVec2::ONE, DVec2::ONE]), [true, false]);
    }
}
