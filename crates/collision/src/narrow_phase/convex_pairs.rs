//! Exact contacts between balls, polyhedra, planes, bodies of revolution and static triangles.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::hull_hull::approach::hull_points;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::hull_plane::plane_points;
use crate::narrow_phase::mesh::selection::mesh_points;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::revolved::contact::revolved_points;
use crate::narrow_phase::sphere::BallContact;

/// Appends the points of a pair with a ball or static triangles, or of two shapes with convex
/// features; `false` for other pairs.
pub(crate) fn exact_points(
    pair_motion: &PairMotion,
    convex_shapes: [ConvexShape; 2],
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let ball = |ball_is_first: bool, radius: f64, other: ConvexShape| {
        BallContact { pair_motion, ball_is_first, radius, other, is_core: false }.point()
    };
    match convex_shapes {
        [ConvexShape::Mesh(mesh), other] => {
            mesh_points(pair_motion, (mesh, true), other, scratch, points);
        }
        [other, ConvexShape::Mesh(mesh)] => {
            mesh_points(pair_motion, (mesh, false), other, scratch, points);
        }
        [ConvexShape::Ball(radius), other] => points.extend(ball(true, radius, other)),
        [other, ConvexShape::Ball(radius)] => points.extend(ball(false, radius, other)),
        [ConvexShape::Hull(a), ConvexShape::Hull(b)] => {
            let _ = hull_points(pair_motion, [a, b], scratch, points);
        }
        [ConvexShape::Hull(hull), ConvexShape::Ground(ground)] => {
            let _ = plane_points(pair_motion, hull, true, ground, scratch, points);
        }
        [ConvexShape::Ground(ground), ConvexShape::Hull(hull)] => {
            let _ = plane_points(pair_motion, hull, false, ground, scratch, points);
        }
        _ => return revolved_points(pair_motion, convex_shapes, scratch, points),
    }
    true
}
