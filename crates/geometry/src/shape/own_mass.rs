//! Shapes whose mass is not spread evenly.

use super::{BodyFrame, Geometry, Shape};
use crate::closed_form::ClosedForm;
use crate::hull::Hull;
use crate::sample_clusters::ClusteredSamples;
use frangible_math::RigidTransform;
use glam::DVec3;
use std::sync::Arc;

/// Frames that differ by no more than this are one [1, or parts of the size]: a thousand roundings
/// of the transforms that a tensor came through.
const SAME: f64 = 1e-12;
/// An axis of a body of revolution may lean by this [rad]: as far as a single rounds it.
const UPRIGHT: f64 = 1e-6;

impl Shape {
    /// The same solid in another body frame, with another volume and other moments: a box becomes
    /// a polyhedron where its axes or its middle are others. `None` for what has no mass, and for a
    /// body of revolution whose axis or middle were lost.
    pub fn with_body_frame(&self, frame: BodyFrame) -> Option<Self> {
        let BodyFrame { body_from_grid, volume, unit_moments } = frame;
        let from_old = body_from_grid.after(&self.body_from_grid.inverse());
        let turns = from_old.rotation.w.abs() < 1.0 - SAME;
        let is_moved = from_old.translation.abs().max_element() > SAME * self.radius();
        if !turns && !is_moved {
            return Some(Self { volume, unit_moments, ..self.clone() });
        }
        let own = Self { body_from_grid, volume, unit_moments, ..self.clone() };
        Some(match &self.geometry {
            Geometry::ClosedForm(ClosedForm::Box { half }) => {
                own.of_hull(Arc::new(Hull::cuboid(*half)), body_from_grid)
            }
            Geometry::ClosedForm(ClosedForm::HalfSpace(_)) | Geometry::Mesh(_) => return None,
            Geometry::ClosedForm(form) => {
                let is_upright = (from_old.rotation * DVec3::Y - DVec3::Y).length() < UPRIGHT;
                let is_ball = matches!(form, ClosedForm::Sphere { .. });
                if is_moved || !(is_ball || is_upright) {
                    return None;
                }
                own
            }
            Geometry::Hull(hull) => own.of_hull(hull.clone(), body_from_grid),
            Geometry::Compound(compound) => {
                let in_body = compound.transformed(&body_from_grid);
                Self { bounds: in_body.bounds(), compound: Some(Arc::new(in_body)), ..own }
            }
            Geometry::Solid(solid) => {
                let bounds = solid.bounds_in(&body_from_grid);
                let hull = own.hull.as_ref().map(|hull| Arc::new(hull.transformed(&from_old)));
                let compound = own.compound.as_ref();
                let compound = compound.map(|parts| Arc::new(parts.transformed(&from_old)));
                Self { bounds, hull, compound, samples: Default::default(), ..own }
            }
            Geometry::Grid(solid) => {
                let into_new = |sample: &glam::Vec3| from_old.point(sample.as_dvec3()).as_vec3();
                let samples = self.samples().iter().map(into_new).collect();
                let solid = solid.as_ref().clone();
                Self::from_clusters(solid, frame, ClusteredSamples::new(samples))
            }
        })
    }

    /// With a polyhedron in place of its geometry.
    fn of_hull(self, hull: Arc<Hull>, body_from_grid: RigidTransform) -> Self {
        let in_body = hull.transformed(&body_from_grid);
        let (bounds, samples) = (in_body.bounds(), Default::default());
        Self {
            geometry: Geometry::Hull(hull),
            bounds,
            hull: Some(Arc::new(in_body)),
            samples,
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    /// A corner of a box, seen from a centre and axes of its own, is where it was in its grid
    /// frame; so are distances.
    #[test]
    fn the_solid_stays_where_it_is() {
        let half = DVec3::new(0.5, 0.2, 0.3);
        let form = ClosedForm::Box { half };
        let turn = DQuat::from_axis_angle(DVec3::new(1.0, 2.0, -0.5).normalize(), 0.6);
        let center = DVec3::new(0.1, -0.05, 0.2);
        let body_from_grid = RigidTransform::new(turn, center).inverse();
        let frame = BodyFrame { body_from_grid, volume: 1.0, unit_moments: DVec3::ONE };
        let even = Shape::closed_form(form, 0.1);
        let convex = Shape::convex(Hull::cuboid(half), 0.1).unwrap();
        for shape in [&even, &convex] {
            let own = shape.with_body_frame(frame).unwrap();
            assert_eq!(own.unit_moments, DVec3::ONE);
            assert_eq!(own.volume, 1.0);
            for point in [DVec3::new(0.7, 0.1, 0.2), DVec3::new(0.1, 0.1, -0.25)] {
                let (distance, normal) = own.distance_and_gradient(body_from_grid.point(point));
                let (exact, gradient) = form.distance_and_gradient(point);
                assert!((distance - exact).abs() < 1e-12);
                assert!((normal - body_from_grid.direction(gradient)).length() < 1e-12);
            }
            let corner = body_from_grid.point(half);
            let vertices = own.hull.as_ref().unwrap().vertices().to_vec();
            assert!(vertices.iter().any(|vertex| (*vertex - corner).length() < 1e-12));
        }
    }

    /// Round bodies turn about their middle: a cylinder keeps its axis, a ball takes any.
    #[test]
    fn round_bodies_keep_their_middle() {
        let frame = |rotation, translation| BodyFrame {
            body_from_grid: RigidTransform::new(rotation, translation),
            volume: 1.0,
            unit_moments: DVec3::ONE,
        };
        let cylinder =
            Shape::closed_form(ClosedForm::Cylinder { radius: 0.2, half_height: 0.5 }, 0.1);
        let ball = Shape::closed_form(ClosedForm::Sphere { radius: 0.2 }, 0.1);
        let lies = DQuat::from_rotation_x(0.5);
        assert!(
            cylinder.with_body_frame(frame(DQuat::from_rotation_y(0.5), DVec3::ZERO)).is_some()
        );
        assert!(cylinder.with_body_frame(frame(lies, DVec3::ZERO)).is_none());
        assert!(ball.with_body_frame(frame(lies, DVec3::ZERO)).is_some());
        assert!(ball.with_body_frame(frame(DQuat::IDENTITY, DVec3::X)).is_none());
    }
}
