//! Strength that varies over a body: factors at points, and between them.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Factors of a body's strength, in the frame of its shape, which its fragments share.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StrengthPoints {
    /// Place [m] and factor; at least one.
    points: Vec<(DVec3, f64)>,
}

impl StrengthPoints {
    /// Of places [m] and positive factors; `None` without any.
    pub fn new(points: Vec<(DVec3, f64)>) -> Option<Self> {
        (!points.is_empty()).then_some(Self { points })
    }

    /// The least of all factors.
    pub fn least(&self) -> f64 {
        self.points.iter().map(|&(_, factor)| factor).fold(f64::INFINITY, f64::min)
    }

    /// The factor at a point of the shape's frame: the mean of those of all points, weighted by the
    /// inverse squares of their distances [She68]. At a point it is that point's, and nowhere less
    /// than the least or more than the largest.
    pub fn factor(&self, place: DVec3) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for &(point, factor) in &self.points {
            let square = point.distance_squared(place);
            if square == 0.0 {
                return factor;
            }
            sum += factor / square;
            weights += 1.0 / square;
        }
        sum / weights
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_those_of_the_points_and_between_them() {
        let points = StrengthPoints::new(vec![(DVec3::ZERO, 1.0), (2.0 * DVec3::X, 3.0)]).unwrap();
        let at = |x: f64| points.factor(DVec3::new(x, 0.0, 0.0));
        assert_eq!((at(0.0), at(1.0), at(2.0), points.least()), (1.0, 2.0, 3.0, 1.0));
        assert!(at(0.5) > 1.0 && at(0.5) < at(1.5) && at(-5.0) < 2.0);
        assert_eq!(StrengthPoints::new(Vec::new()), None);
    }
}
