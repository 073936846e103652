//! Strength that varies over a body: factors at points, and between them.

use frangible_geometry::Bvh;
use frangible_math::check::{Check, Checked, finite_vector, require};
use glam::DVec3;
use serde::{Deserialize, Serialize};

/// Points that a factor beside them is a mean of, where no triangles join them: a body's corners,
/// or those around a place. Fewer than a painted neck has around it.
const NEAREST: usize = 8;

/// Factors of a body's strength, in the frame of its shape, which its fragments share.
#[derive(Clone, Debug, Serialize, Deserialize)]
#[serde(try_from = "StrengthRecord")]
pub struct StrengthPoints {
    /// Place [m] and factor; at least one.
    points: Vec<(DVec3, f64)>,
    /// Corners of the triangles between points, by number; none if nothing joins them.
    triangles: Vec<[u32; 3]>,
    #[serde(skip_serializing)]
    tree: Bvh,
}

/// What a snapshot holds of them.
#[derive(Deserialize)]
struct StrengthRecord {
    points: Vec<(DVec3, f64)>,
    triangles: Vec<[u32; 3]>,
}

impl TryFrom<StrengthRecord> for StrengthPoints {
    type Error = &'static str;

    fn try_from(StrengthRecord { points, triangles }: StrengthRecord) -> Result<Self, Self::Error> {
        let are_known = triangles.iter().flatten().all(|&at| (at as usize) < points.len());
        require(are_known && !points.is_empty(), "triangles between points of strength")?;
        let corners: Vec<[DVec3; 3]> =
            triangles.iter().map(|corners| corners.map(|at| points[at as usize].0)).collect();
        Ok(Self { tree: Bvh::new(&corners), points, triangles })
    }
}

impl Check for StrengthPoints {
    fn check(&self) -> Checked {
        require(!self.points.is_empty(), "some points of strength")?;
        self.points.iter().try_for_each(|&(point, factor)| {
            require(factor > 0.0 && factor.is_finite(), "positive factors of strength")?;
            finite_vector(point)
        })
    }
}

impl StrengthPoints {
    /// Of places [m] and positive factors, and of triangles between them; `None` without places or
    /// with a corner that is none of them.
    pub fn new(points: Vec<(DVec3, f64)>, triangles: Vec<[u32; 3]>) -> Option<Self> {
        Self::try_from(StrengthRecord { points, triangles }).ok()
    }

    /// The least of all factors.
    pub fn least(&self) -> f64 {
        self.points.iter().map(|&(_, factor)| factor).fold(f64::INFINITY, f64::min)
    }

    /// The factor at a point of the shape's frame: that of the nearest point of the triangles,
    /// linear between their corners, or a mean of the nearest points. At a point it is that
    /// point's, and nowhere less than the least or more than the largest.
    pub fn factor(&self, place: DVec3) -> f64 {
        let Some(nearest) = self.tree.closest(place, f64::INFINITY) else {
            return self.mean_of_nearest(place);
        };
        let corners = self.triangles[nearest.triangle].map(|at| self.points[at as usize]);
        linear(corners, nearest.point)
    }

    /// Weighted by `((R - d) / (R d))^2`, with the distance d of a point and that of the first that
    /// counts no more, R: what lies farther says nothing, and nothing jumps [FN80].
    fn mean_of_nearest(&self, place: DVec3) -> f64 {
        let squares =
            self.points.iter().map(|(point, factor)| (point.distance_squared(place), *factor));
        let mut near: Vec<(f64, f64)> = squares.collect();
        let order = |a: &(f64, f64), b: &(f64, f64)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1));
        let mut reach = f64::INFINITY;
        if near.len() > NEAREST {
            let (_, beyond, _) = near.select_nth_unstable_by(NEAREST, order);
            reach = beyond.0.sqrt();
            near.truncate(NEAREST);
        }
        near.sort_unstable_by(order);
        let (mut sum, mut weights) = (0.0, 0.0);
        for (square, factor) in &near {
            if *square == 0.0 {
                return *factor;
            }
            let closeness = 1.0 / square.sqrt() - 1.0 / reach;
            sum += factor * closeness * closeness;
            weights += closeness * closeness;
        }
        // All are equally far.
        if weights > 0.0 { sum / weights } else { near[0].1 }
    }
}

/// The value at a point of a triangle with values at its corners.
fn linear(corners: [(DVec3, f64); 3], point: DVec3) -> f64 {
    let [a, b, c] = corners.map(|(corner, _)| corner);
    let normal = (b - a).cross(c - a);
    let square = normal.length_squared();
    if square == 0.0 {
        let nearest = |one: &(DVec3, f64), other: &(DVec3, f64)| {
            one.0.distance_squared(point).total_cmp(&other.0.distance_squared(point))
        };
        return corners.into_iter().min_by(nearest).map_or(1.0, |(_, value)| value);
    }
    let part = |from: DVec3, to: DVec3| {
        ((to - from).cross(point - from).dot(normal) / square).clamp(0.0, 1.0)
    };
    let parts = [part(b, c), part(c, a), part(a, b)];
    let sum: f64 = parts.iter().sum();
    parts.iter().zip(corners).map(|(part, (_, value))| part * value).sum::<f64>() / sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn factors_are_those_of_the_points_and_between_them() {
        let points = vec![(DVec3::ZERO, 1.0), (2.0 * DVec3::X, 3.0)];
        let points = StrengthPoints::new(points, Vec::new()).unwrap();
        let at = |x: f64| points.factor(DVec3::new(x, 0.0, 0.0));
        assert_eq!((at(0.0), at(1.0), at(2.0), points.least()), (1.0, 2.0, 3.0, 1.0));
        assert!(at(0.5) > 1.0 && at(0.5) < at(1.5) && at(-5.0) < 2.0);
        assert!(StrengthPoints::new(Vec::new(), Vec::new()).is_none());
        assert!(StrengthPoints::new(vec![(DVec3::ZERO, 1.0)], vec![[0, 0, 1]]).is_none());
    }

    /// A neck of rings of weak points on a strong body, with and without triangles.
    #[test]
    fn what_is_painted_is_local() {
        let (rings, around) = (21_u32, 16_u32);
        let mut points = Vec::new();
        for ring in 0..rings {
            let height = 0.05 * f64::from(ring);
            for n in 0..around {
                let angle = std::f64::consts::TAU * f64::from(n) / f64::from(around);
                let place = DVec3::new(libm::cos(angle), height / 0.1, libm::sin(angle)) * 0.1;
                let factor = if height > 0.72 { 0.05 } else { 20.0 };
                points.push((place, factor));
            }
        }
        let mut triangles = Vec::new();
        for ring in 0..rings - 1 {
            for n in 0..around {
                let [a, b] = [n, (n + 1) % around].map(|at| ring * around + at);
                triangles.extend([[a, a + around, b], [b, a + around, b + around]]);
            }
        }
        let joined = StrengthPoints::new(points.clone(), triangles).unwrap();
        let alone = StrengthPoints::new(points, Vec::new()).unwrap();
        for n in 0..50 {
            let angle = 0.13 * f64::from(n);
            let at =
                |height: f64| 0.1 * DVec3::new(libm::cos(angle), height / 0.1, libm::sin(angle));
            for strength in [&joined, &alone] {
                let neck = strength.factor(at(0.87));
                assert!((neck / 0.05 - 1.0).abs() < 1e-9, "{neck}");
                let foot = strength.factor(at(0.31));
                assert!((foot / 20.0 - 1.0).abs() < 1e-9, "{foot}");
            }
            // Linear between the rings at 0.7 and 0.75.
            let between = joined.factor(at(0.725));
            assert!((between - 10.025).abs() < 0.2, "{between}");
        }
    }

    #[test]
    fn nothing_jumps_between_points() {
        let mut points = Vec::new();
        for n in 0..60 {
            let x = libm::sin(12.9898 * f64::from(n)) * 437.5;
            let y = libm::sin(78.233 * f64::from(n)) * 437.5;
            let place = DVec3::new(x - x.floor(), y - y.floor(), 0.0);
            points.push((place, if n % 2 == 0 { 1.0 } else { 3.0 }));
        }
        let points = StrengthPoints::new(points, Vec::new()).unwrap();
        let mut before = points.factor(DVec3::new(0.1, 0.1, 0.05));
        for n in 1..=4000 {
            let at = 0.1 + 0.8 * f64::from(n) / 4000.0;
            let now = points.factor(DVec3::new(at, 0.9 * at, 0.05));
            assert!((now - before).abs() < 0.02, "{before} {now}");
            before = now;
        }
    }
}
