//! Quadratic error functions: the point that lies on given planes best.

use frangible_math::symmetric_eigen;
use glam::{DMat3, DVec3};

/// Sum of squared distances to planes, in units of a cell and counted from its middle [JLSW02: Ju,
/// Losasso, Schaefer & Warren 2002, Dual contouring of Hermite data].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Qef {
    normal_matrix: DMat3,
    right_side: DVec3,
}

impl Qef {
    pub(crate) const ZERO: Self = Self { normal_matrix: DMat3::ZERO, right_side: DVec3::ZERO };

    /// Adds the plane through `point` with unit `normal`.
    pub(crate) fn add_plane(&mut self, point: DVec3, normal: DVec3) {
        self.normal_matrix += outer(normal);
        self.right_side += normal * normal.dot(point);
    }

    /// True without planes.
    pub(crate) fn is_empty(&self) -> bool {
        self.normal_matrix == DMat3::ZERO
    }

    /// The minimiser nearest to `start`, which is within `reach` of the middle along each axis.
    /// Directions with less than `truncation` of the largest eigenvalue do not count, nor do those
    /// that would lead out of reach.
    pub(crate) fn minimize(&self, start: DVec3, truncation: f64, reach: f64) -> DVec3 {
        self.descend(start, reach, |largest| [0.0, truncation * largest])
    }

    /// The minimiser nearest to `start` along the directions that `free` projects on. Of these the
    /// first one counts from an angle of 6 degrees between it and the planes on, the other one as
    /// an edge that leads across the first.
    pub(crate) fn minimize_along(
        &self,
        free: &DMat3,
        start: DVec3,
        truncation: f64,
        reach: f64,
    ) -> DVec3 {
        const LEAST_ANGLE: f64 = 0.01;
        let planes =
            self.normal_matrix.x_axis.x + self.normal_matrix.y_axis.y + self.normal_matrix.z_axis.z;
        let normal_matrix = *free * self.normal_matrix * *free;
        let right_side =
            *free * (self.right_side - self.normal_matrix * start) + normal_matrix * start;
        let sections = Self { normal_matrix, right_side };
        sections.descend(start, reach, |_| [LEAST_ANGLE * planes, truncation * planes])
    }

    /// Projects on the directions along which the minimum is not unique.
    pub(crate) fn free_directions(&self, truncation: f64) -> DMat3 {
        let (eigenvalues, axes) = symmetric_eigen(&self.normal_matrix);
        let weak = |&n: &usize| eigenvalues[n] <= truncation * eigenvalues.max_element();
        (0..3).filter(weak).fold(DMat3::ZERO, |sum, n| sum + outer(axes.col(n)))
    }

    /// Number of significant directions.
    pub(crate) fn rank(&self, truncation: f64) -> usize {
        let (eigenvalues, _) = symmetric_eigen(&self.normal_matrix);
        let least = truncation * eigenvalues.max_element();
        eigenvalues.to_array().iter().filter(|&&eigenvalue| eigenvalue > least).count()
    }

    /// Newton's step along each eigenvector in turn. The largest eigenvalue and all others must
    /// exceed the two thresholds that `least` returns for it.
    fn descend(&self, start: DVec3, reach: f64, least: impl Fn(f64) -> [f64; 2]) -> DVec3 {
        let (eigenvalues, axes) = symmetric_eigen(&self.normal_matrix);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
        let [first, further] = least(eigenvalues[order[0]]);
        let residual = self.right_side - self.normal_matrix * start;
        let mut point = start;
        for (n, least) in order.into_iter().zip([first, further, further]) {
            if eigenvalues[n] <= least {
                continue;
            }
            let axis = axes.col(n);
            let next = point + axis * (axis.dot(residual) / eigenvalues[n]);
            if next.abs().max_element() <= reach {
                point = next;
            }
        }
        point
    }
}

/// The matrix that projects on a unit vector, times its length squared.
fn outer(vector: DVec3) -> DMat3 {
    DMat3::from_cols(vector * vector.x, vector * vector.y, vector * vector.z)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planes_meet_in_a_corner_on_an_edge_or_nowhere_in_particular() {
        let corner = DVec3::new(0.2, -0.1, 0.4);
        let tilted = DVec3::new(1.0, 2.0, 2.0) / 3.0;
        let mut qef = Qef::ZERO;
        qef.add_plane(corner, tilted);
        let face = qef.minimize(DVec3::ZERO, 0.01, 0.5);
        assert!((face - tilted * tilted.dot(corner)).length() < 1e-14, "the foot of the start");
        qef.add_plane(corner + DVec3::Z, DVec3::X);
        let edge = qef.minimize(DVec3::ZERO, 0.01, 0.5);
        let along = tilted.cross(DVec3::X);
        assert!((edge - corner).cross(along).length() < 1e-14 && edge.dot(along).abs() < 1e-14);
        qef.add_plane(corner, DVec3::NEG_Y);
        assert!((qef.minimize(DVec3::ZERO, 0.01, 0.5) - corner).length() < 1e-13);
    }

    #[test]
    fn where_planes_leave_it_free_a_point_meets_others_in_section() {
        let mut exact = Qef::ZERO;
        exact.add_plane(DVec3::new(0.0, 0.0, 0.2), DVec3::Z);
        let free = exact.free_directions(0.01);
        assert_eq!(
            (exact.rank(0.01), free * DVec3::new(1.0, 2.0, 3.0)),
            (1, DVec3::new(1.0, 2.0, 0.0))
        );
        // Two that disagree on the third axis, and one that is too flat to cut the exact plane.
        let mut rough = Qef::ZERO;
        rough.add_plane(DVec3::new(0.3, 0.0, 0.2), DVec3::new(0.8, 0.0, 0.6));
        rough.add_plane(DVec3::new(0.3, 0.0, 0.2), DVec3::new(0.8, 0.0, -0.6));
        let foot = DVec3::new(-0.4, 0.1, 0.2);
        let rim = rough.minimize_along(&free, foot, 0.1, 0.5);
        assert!((rim - DVec3::new(0.3, 0.1, 0.2)).length() < 1e-14, "{rim}");
        let mut flat = Qef::ZERO;
        flat.add_plane(DVec3::ZERO, DVec3::new(0.05, 0.0, 1.0).normalize());
        assert_eq!(flat.minimize_along(&free, foot, 0.1, 0.5), foot);
    }

    #[test]
    fn a_far_corner_is_given_up_for_its_edge() {
        // Two planes and one that meets their edge far away.
        let mut qef = Qef::ZERO;
        qef.add_plane(DVec3::new(0.0, 0.0, 3.0), DVec3::Z);
        qef.add_plane(DVec3::new(0.1, 0.0, 0.0), DVec3::X);
        qef.add_plane(DVec3::new(0.0, 0.2, 0.0), DVec3::Y);
        assert!(
            (qef.minimize(DVec3::ZERO, 0.01, 0.5) - DVec3::new(0.1, 0.2, 0.0)).length() < 1e-12
        );
    }
}
