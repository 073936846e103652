//! Contact points of a pair at seams: with a plane instead of what neighbours cover.

use crate::manifold::ManifoldPoint;
use crate::narrow_phase::convex_pairs::exact_points;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seams::{FLAT, SAME_NORMAL, Seams};
use frangible_geometry::HalfSpace;

/// Replaces those points of a pair that neighbours of a fixed body cover; `true` if there are any.
pub(crate) fn mend_seams(
    pair_motion: &PairMotion,
    shapes: [ConvexShape; 2],
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let Some(seams) = Seams::new(pair_motion, shapes, [None; 2]) else { return false };
    let planes = take_covered(&seams, points);
    for plane in &planes {
        let normal = seams.normal_of(plane);
        if !points.iter().any(|point| point.normal.dot(normal) >= FLAT) {
            plane_points(&seams, shapes, plane, scratch, points);
        }
    }
    !planes.is_empty()
}

/// Takes out the points that neighbours of the fixed body cover. Returns the planes to meet
/// instead, in its frame.
pub(crate) fn take_covered(seams: &Seams, points: &mut Vec<ManifoldPoint>) -> Vec<HalfSpace> {
    // Points of one normal together.
    let is_same = |a: &ManifoldPoint, b: &ManifoldPoint| a.normal.dot(b.normal) >= SAME_NORMAL;
    let mut groups: Vec<Vec<ManifoldPoint>> = Vec::new();
    for point in points.iter() {
        match groups.iter_mut().find(|group| is_same(&group[0], point)) {
            Some(group) => group.push(*point),
            None => groups.push(vec![*point]),
        }
    }
    points.clear();
    let mut planes = Vec::new();
    for group in groups {
        match seams.plane_over(&group) {
            Some(plane) => planes.push(plane),
            None => points.extend(group),
        }
    }
    planes
}

/// Appends the points of the moving body with a plane, as far as faces reach.
pub(crate) fn plane_points(
    seams: &Seams,
    mut shapes: [ConvexShape; 2],
    plane: &HalfSpace,
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) {
    shapes[seams.side] = ConvexShape::Ground(*plane);
    let mut on_plane = Vec::new();
    let _ = exact_points(seams.pair_motion, shapes, scratch, &mut on_plane);
    points.extend(on_plane.into_iter().filter(|point| seams.is_over_face(point, plane)));
}

#[cfg(test)]
mod tests {
    use crate::impulse_cache::ImpulseCache;
    use crate::narrow_phase::finder::{ManifoldFinder, find_manifolds};
    use frangible_bodies::{
        Bodies, Frame, Motion, NewBody, Pair, Pose, StepSettings, SurfaceProperties, Velocity,
    };
    use frangible_geometry::{ClosedForm, Shape};
    use glam::{DQuat, DVec3};
    use std::sync::Arc;

    const DT: f64 = 1.0 / 30.0;

    /// Normals of the second block that a body slides onto along x at 3 m/s, from 1 cm before it
    /// and deeper in the first than bodies that graze; the second block is higher by `step` [m].
    fn normals(mover: ClosedForm, step: f64, are_both_known: bool) -> Vec<DVec3> {
        let half = DVec3::new(1.0, 0.5, 1.0);
        let body = |form: ClosedForm, motion: Motion, at: DVec3| NewBody {
            shape: Arc::new(Shape::closed_form(form, 0.05)),
            density: 1.0,
            motion,
            pose: Pose { position: at, orientation: DQuat::IDENTITY },
            velocity: if motion == Motion::Static {
                Velocity::default()
            } else {
                Velocity { linear: 3.0 * DVec3::X, ..Velocity::default() }
            },
            surface: SurfaceProperties::new(0.0, 0.5),
        };
        let mut bodies = Bodies::default();
        for (side, height) in [(-1.0, 0.0), (1.0, step)] {
            let at = DVec3::new(side, height - half.y, 0.0);
            bodies.spawn(body(ClosedForm::Box { half }, Motion::Static, at));
        }
        bodies.spawn(body(mover, Motion::Dynamic, DVec3::new(-0.06, 0.0495, 0.0)));
        let frame = Frame { dt: DT, gravity: -9.81 * DVec3::Y, settings: StepSettings::default() };
        let (warm, pair) = (ImpulseCache::default(), Pair { first: 1, second: 2 });
        let of = |points: &[crate::manifold::ManifoldPoint]| {
            points.iter().map(|point| -point.normal).collect()
        };
        if !are_both_known {
            let mut finder = ManifoldFinder::default();
            return finder
                .find(&bodies, pair, &warm, &frame)
                .map_or_else(Vec::new, |known| of(known.points));
        }
        let pairs = [Pair { first: 0, second: 2 }, pair];
        let found = find_manifolds(&bodies, &pairs, &warm, &frame);
        found.iter().filter(|found| found.pair == pair).flat_map(|found| of(found.points)).collect()
    }

    /// Beside a flush block the top of the next one is met, and its side beside none and above a
    /// step.
    #[test]
    fn sides_count_where_they_are_free() {
        let radius = 0.05;
        let movers = [
            ClosedForm::Box { half: DVec3::splat(radius) },
            ClosedForm::Sphere { radius },
            ClosedForm::Cylinder { radius, half_height: radius },
        ];
        for mover in movers {
            let is_top = |normal: &DVec3| normal.y > 1.0 - 1e-9;
            let on_row = normals(mover, 0.0, true);
            assert!(!on_row.is_empty() && on_row.iter().all(is_top), "{mover:?}: {on_row:?}");
            let alone = normals(mover, 0.0, false);
            assert!(!alone.iter().all(is_top), "{mover:?}: {alone:?}");
            let on_step = normals(mover, 0.02, true);
            assert!(on_step.iter().any(|normal| normal.x < -0.5), "{mover:?}: {on_step:?}");
        }
    }
}
