//! Quadratic error functions: the point that lies on given planes best.

use crate::symmetric::symmetric_eigen;
use glam::{DMat3, DVec3};

/// Sum of squared distances to planes, in units of a cell and counted from its middle [JLSW02: Ju, Losasso, Schaefer &
/// Warren 2002, Dual contouring of Hermite data].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Qef {
    normal_matrix: DMat3,
    right_side: DVec3,
}

impl Qef {
    pub(crate) const ZERO: Self = Self { normal_matrix: DMat3::ZERO, right_side: DVec3::ZERO };

    /// Adds the plane through `point` with unit `normal`.
    pub(crate) fn add_plane(&mut self, point: DVec3, normal: DVec3) {
        self.normal_matrix += DMat3::from_cols(normal * normal.x, normal * normal.y, normal * normal.z);
        self.right_side += normal * normal.dot(point);
    }

    /// The minimiser nearest to `start`, which is within `reach` of the middle along each axis. Directions with less than
    /// `truncation` of the largest eigenvalue do not count, nor do those that would lead out of reach.
    pub(crate) fn minimize(&self, start: DVec3, truncation: f64, reach: f64) -> DVec3 {
        let (eigenvalues, axes) = symmetric_eigen(&self.normal_matrix);
        let mut order = [0, 1, 2];
        order.sort_by(|&a, &b| eigenvalues[b].total_cmp(&eigenvalues[a]));
        let residual = self.right_side - self.normal_matrix * start;
        let mut point = start;
        for n in order.into_iter().filter(|&n| eigenvalues[n] > truncation * eigenvalues[order[0]]) {
            let axis = axes.col(n);
            let next = point + axis * (axis.dot(residual) / eigenvalues[n]);
            if next.abs().max_element() <= reach {
                point = next;
            }
        }
        point
    }
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
    fn a_far_corner_is_given_up_for_its_edge() {
        // Two planes and one that meets their edge far away.
        let mut qef = Qef::ZERO;
        qef.add_plane(DVec3::new(0.0, 0.0, 3.0), DVec3::Z);
        qef.add_plane(DVec3::new(0.1, 0.0, 0.0), DVec3::X);
        qef.add_plane(DVec3::new(0.0, 0.2, 0.0), DVec3::Y);
        assert!((qef.minimize(DVec3::ZERO, 0.01, 0.5) - DVec3::new(0.1, 0.2, 0.0)).length() < 1e-12);
    }
}
