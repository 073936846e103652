//! Strength that varies over a body: factors at points, and between them.

use crate::scene::check::{BuildError, Checker};
use crate::scene::desc::strength_points::StrengthPointDesc;
use glam::DVec3;
use std::sync::Arc;

/// The least factor, and one over the largest: below, all blows break, and above, none.
const LEAST: f64 = 1e-6;

/// Factors of a body's strength, in the frame of its shape, which its fragments share.
#[derive(Clone, Debug, PartialEq)]
pub struct StrengthPoints {
    /// Place [m] and factor; at least one.
    points: Vec<(DVec3, f64)>,
}

impl StrengthPoints {
    /// Checked; `None` without points.
    pub(crate) fn build(
        points: &[StrengthPointDesc],
        at: &Checker,
    ) -> Result<Option<Arc<Self>>, BuildError> {
        let mut checked = Vec::with_capacity(points.len());
        for (index, StrengthPointDesc { point, factor }) in points.iter().enumerate() {
            let at = at.field(&format!("strength_points[{index}]"));
            let point = at.field("point").vector(*point, "m")?;
            checked.push((point, at.field("factor").within(*factor, LEAST, 1.0 / LEAST)?));
        }
        Ok((!checked.is_empty()).then(|| Arc::new(Self { points: checked })))
    }

    /// The least of all factors.
    pub(crate) fn least(&self) -> f64 {
        self.points.iter().map(|&(_, factor)| factor).fold(f64::INFINITY, f64::min)
    }

    /// The factor at a point of the shape's frame: the mean of those of all points, weighted by the
    /// inverse squares of their distances [She68]. At a point it is that point's, and nowhere less
    /// than the least or more than the largest.
    pub(crate) fn factor(&self, place: DVec3) -> f64 {
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
        let of = |x: f64, factor: f64| StrengthPointDesc { point: [x, 0.0, 0.0], factor };
        let built = StrengthPoints::build(&[of(0.0, 1.0), of(2.0, 3.0)], &Checker::root());
        let points = built.unwrap().unwrap();
        let at = |x: f64| points.factor(DVec3::new(x, 0.0, 0.0));
        assert_eq!((at(0.0), at(1.0), at(2.0), points.least()), (1.0, 2.0, 3.0, 1.0));
        assert!(at(0.5) > 1.0 && at(0.5) < at(1.5) && at(-5.0) < 2.0);
        let bad = StrengthPoints::build(&[of(0.0, 0.0)], &Checker::root()).unwrap_err();
        let rule = "strength_points[0].factor: 0.0, must be between 0.000001 and 1000000";
        assert_eq!(bad.to_string(), rule);
    }
}
