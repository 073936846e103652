//! Normals of least overlap of two bodies of revolution.

use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::search::{Search, least_along};
use glam::DVec3;
use std::f64::consts::TAU;

/// Normals tried around each axis, to find the deepest of several.
const AROUND: usize = 24;

/// Steps of Newton's method on the sphere of normals.
const NEWTON_STEPS: usize = 30;

/// Axes within this sine are parallel [1].
const PARALLEL: f64 = 1e-9;

/// Normals of both round sides at once, from the second body to the first, and of the first side
/// towards the second axis.
pub(crate) fn across_both(
    round: &PlacedRevolved,
    other: &PlacedRevolved,
) -> impl Iterator<Item = DVec3> {
    let apart = other.middle - round.middle;
    let towards =
        [-round.side_normal(round.radial(apart)), other.side_normal(other.radial(-apart))];
    towards.into_iter().chain(on_both_sides(round, other).into_iter().flatten())
}

/// Normals that belong to both sides: `outward . axis` is given for both.
fn on_both_sides(round: &PlacedRevolved, other: &PlacedRevolved) -> [Option<DVec3>; 2] {
    let cross = round.axis.cross(other.axis);
    let sine_squared = cross.length_squared();
    if sine_squared < PARALLEL * PARALLEL {
        return [None; 2];
    }
    let cosine = round.axis.dot(other.axis);
    let (of_round, of_other) = (round.side.y, -other.side.y);
    let along_round = (of_round - cosine * of_other) / sine_squared;
    let along_other = (of_other - cosine * of_round) / sine_squared;
    let in_plane = along_round * round.axis + along_other * other.axis;
    let rest = 1.0 - in_plane.length_squared();
    if rest < 0.0 {
        return [None; 2];
    }
    let out = cross * (rest / sine_squared).sqrt();
    [Some(-(in_plane + out).normalize()), Some(-(in_plane - out).normalize())]
}

/// A rim of either body on the other's side or rim.
pub(crate) fn rims(search: &mut Search, other: &PlacedRevolved, begin: &[DVec3]) {
    let round = *search.round;
    // Around the circles of both sides' normals.
    for (body, sign) in [(&round, -1.0), (other, 1.0)] {
        let beside = body.axis.cross(body.across);
        let normal_at = |angle: f64| {
            let radial = libm::cos(angle) * body.across + libm::sin(angle) * beside;
            sign * body.side_normal(radial)
        };
        let angle = least_along([0.0, TAU], AROUND, |angle| search.overlap(normal_at(angle)));
        search.offer(normal_at(angle));
    }

    // Rim on rim: smooth between the ends and the side.
    for &normal in begin {
        search.offer(descend(search, other, normal));
    }
}

/// Newton's method on the sphere of normals from a beginning; steps that gain nothing are halved.
fn descend(search: &Search, other: &PlacedRevolved, begin: DVec3) -> DVec3 {
    let (round, mut normal) = (search.round, begin);
    let mut depth = search.overlap(normal);
    for _ in 0..NEWTON_STEPS {
        let between = other.support(normal) - round.support(-normal);
        let (u, v) = normal.any_orthonormal_pair();
        let gradient = [between.dot(u), between.dot(v)];
        // Curvature of the overlap: rims bend along their tangents.
        let mut matrix = [-depth, 0.0, -depth];
        for (body, towards) in [(round, -normal), (other, normal)] {
            let (_, _, across) = body.split(towards);
            if across > 0.0 {
                let end = body.ends[body.furthest_end(towards)];
                let tangent = body.axis.cross(towards) / across;
                let [a, b] = [tangent.dot(u), tangent.dot(v)];
                let bend = end.radius / across;
                matrix[0] += bend * a * a;
                matrix[1] += bend * a * b;
                matrix[2] += bend * b * b;
            }
        }
        let determinant = matrix[0] * matrix[2] - matrix[1] * matrix[1];
        let is_bowl = determinant > 0.0 && matrix[0] > 0.0;
        let step = if is_bowl {
            [
                (matrix[1] * gradient[1] - matrix[2] * gradient[0]) / determinant,
                (matrix[1] * gradient[0] - matrix[0] * gradient[1]) / determinant,
            ]
        } else {
            let scale = 0.3 / (gradient[0].abs() + gradient[1].abs()).max(f64::MIN_POSITIVE);
            [-scale * gradient[0], -scale * gradient[1]]
        };
        let mut part = 1.0;
        let mut found = None;
        for _ in 0..12 {
            let next = (normal + part * (step[0] * u + step[1] * v)).normalize();
            let there = search.overlap(next);
            if there < depth {
                found = Some((next, there));
                break;
            }
            part *= 0.4;
        }
        let Some((next, there)) = found else { break };
        let gain = depth - there;
        (normal, depth) = (next, there);
        if gain <= 1e-13 * depth.abs() {
            break;
        }
    }
    normal
}
