//! Penetration depths of overlapping bodies.

use crate::broad_phase::find_pairs;
use crate::narrow_phase::compound::near_parts;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::mesh::overlap::mesh_separation;
use crate::narrow_phase::pair_separation::pair_separation;
use crate::narrow_phase::samples::deepest;
use crate::relative_motion::{placed, second_from_first};
use frangible_bodies::{Bodies, Pair, Pose};

/// Penetration depth [m] of each overlapping pair with at least one dynamic body, in increasing
/// order of the pairs: minimum translation for balls, half-spaces, bodies of revolution and convex
/// polyhedra; deepest part for compounds; deepest contact for static triangles; deepest sample for
/// level sets.
pub fn find_penetrations(bodies: &Bodies) -> Vec<(Pair, f64)> {
    let depth = |&pair: &Pair| Some((pair, penetration(bodies, pair, &bodies.poses)?));
    find_pairs(bodies, &bodies.poses, 0.0).iter().filter_map(depth).collect()
}

/// Penetration depth of one pair at the given poses; `None` without overlap.
pub(crate) fn penetration(bodies: &Bodies, pair: Pair, poses: &[Pose]) -> Option<f64> {
    let (first, second) = placed(bodies, pair, poses);
    let second_from_first = second_from_first(first, second);
    let convex_shapes = [ConvexShape::of(first.shape), ConvexShape::of(second.shape)];
    let compounds = [first, second].map(|body| body.shape.compound.as_deref());

    // Part by part for compounds.
    let depth_of = |parts: [Option<usize>; 2]| {
        let convex_shape = |side: usize| match (compounds[side], parts[side]) {
            (Some(compound), Some(part)) => ConvexShape::Hull(&compound.parts()[part].hull),
            _ => convex_shapes[side],
        };
        let size = first.shape.radius().min(second.shape.radius());
        match [convex_shape(0), convex_shape(1)] {
            [ConvexShape::Mesh(mesh), other] => {
                return Some(mesh_separation(bodies, pair, poses, (mesh, true), other));
            }
            [other, ConvexShape::Mesh(mesh)] => {
                return Some(mesh_separation(bodies, pair, poses, (mesh, false), other));
            }
            _ => {}
        }
        let shapes = [convex_shape(0), convex_shape(1)];
        pair_separation(shapes, &second_from_first, size).map(|found| found.0)
    };
    let least = if compounds.iter().all(Option::is_none) {
        depth_of([None; 2])
    } else {
        let of_parts = near_parts([first, second], compounds, 0.0).into_iter().map(depth_of);
        of_parts.reduce(|a, b| Some(a?.min(b?))).unwrap_or(Some(f64::INFINITY))
    };
    // Shapes without convex features use samples.
    let phi = least.or_else(|| deepest(first, second).map(f64::from))?;
    (phi <= 0.0).then_some(-phi)
}

#[cfg(test)]
mod tests {
    use super::*;
    use frangible_bodies::{Motion, NewBody, SurfaceProperties, Velocity};
    use frangible_geometry::{ClosedForm, Compound, HalfSpace, Hull, Shape};
    use frangible_math::RigidTransform;
    use glam::{DQuat, DVec3};
    use std::sync::Arc;

    /// Penetration depth of two shapes, the second at `position`, rotated about y.
    fn depth(first: Shape, second: Shape, position: DVec3, turn: f64) -> Option<f64> {
        let mut bodies = Bodies::default();
        for (shape, position, turn) in [(first, DVec3::ZERO, 0.0), (second, position, turn)] {
            bodies.spawn(NewBody {
                shape: Arc::new(shape),
                density: 1.0,
                motion: Motion::Dynamic,
                pose: Pose { position, orientation: DQuat::from_rotation_y(turn) },
                velocity: Velocity::default(),
                surface: SurfaceProperties::new(0.0, 0.0),
            });
        }
        find_penetrations(&bodies).first().map(|&(_, depth)| depth)
    }

    fn ball() -> Shape {
        Shape::closed_form(ClosedForm::Sphere { radius: 0.5 }, 0.1)
    }

    fn cube() -> Shape {
        Shape::closed_form(ClosedForm::Box { half: DVec3::splat(0.5) }, 0.1)
    }

    fn ground() -> Shape {
        Shape::closed_form(
            ClosedForm::HalfSpace(HalfSpace { normal: DVec3::Y, offset: -0.45 }),
            0.1,
        )
    }

    /// Three cubes side by side along z.
    fn row() -> Shape {
        let half = DVec3::splat(0.5);
        let cube = |k: i32| {
            Hull::cuboid(half)
                .transformed(&RigidTransform::new(DQuat::IDENTITY, f64::from(k) * DVec3::Z))
        };
        Shape::compound(Compound::new((-1..=1).map(cube).collect()), 0.1).unwrap()
    }

    #[test]
    fn what_overlaps_is_as_deep_as_it_is() {
        let beside = DVec3::new(0.98, 0.1, 0.2);
        for (first, second, at, turn, expected) in [
            (cube(), cube(), beside, 0.0, Some(0.02)),
            (cube(), cube(), beside + 0.03 * DVec3::X, 0.0, None),
            // An edge of a rotated cube in a face.
            (
                cube(),
                cube(),
                DVec3::new(1.17, 0.0, 0.0),
                0.25 * std::f64::consts::PI,
                Some(0.5_f64.sqrt() - 0.67),
            ),
            (ball(), cube(), DVec3::new(1.3, 0.1, 0.2), 0.3, None),
            (ball(), cube(), beside, 0.0, Some(0.02)),
            (cube(), ball(), beside, 0.0, Some(0.02)),
            (ball(), ball(), DVec3::new(0.0, 0.9, 0.0), 0.0, Some(0.1)),
            (ground(), cube(), DVec3::Y * 0.01, 0.4, Some(0.04)),
            (cube(), ground(), DVec3::Y * 0.01, 0.4, Some(0.06)),
            (ball(), ground(), DVec3::Y * 0.01, 0.4, Some(0.06)),
            (row(), cube(), DVec3::new(0.95, 0.2, 0.7), 0.0, Some(0.05)),
            (cube(), row(), DVec3::new(0.95, 0.2, 0.7), 0.0, Some(0.05)),
            (row(), row(), DVec3::new(0.93, 0.2, 0.1), 0.0, Some(0.07)),
            (row(), ground(), DVec3::ZERO, 0.0, Some(0.05)),
            (row(), ball(), DVec3::new(0.97, 0.0, 0.9), 0.0, Some(0.03)),
        ] {
            match (depth(first, second, at, turn), expected) {
                (Some(depth), Some(expected)) => {
                    assert!((depth - expected).abs() < 1e-12, "{depth} {expected}")
                }
                (found, expected) => assert_eq!(found, expected),
            }
        }
    }
}
