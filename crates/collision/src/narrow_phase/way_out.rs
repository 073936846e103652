//! The way out of a part of a compound for what lies so deep in it that the shortest way leads into
//! the next part.

use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seams::near_seams;
use frangible_geometry::{Compound, HalfSpace, Hull};
use glam::DVec3;

/// A part of a compound, or a body alone.
#[derive(Clone, Copy)]
pub(crate) struct Piece<'a> {
    pub(crate) shape: ConvexShape<'a>,
    /// The compound and the part's number.
    pub(crate) of_compound: Option<(&'a Compound, usize)>,
}

/// Cosine between a normal and one that pushes against it [1]: normals within 45 degrees of the
/// opposite.
const AGAINST: f64 = -0.7;

/// Bit of the feature of a way out: the rest is the face.
const WAY_OUT: u64 = 1 << 28;

/// The least way out of two pieces that overlap at a point of contact, over faces of either piece
/// that no neighbour covers there, and against none of the points of other parts that overlap.
pub(crate) fn way_out(
    pair_motion: &PairMotion,
    pieces: [Piece; 2],
    deepest: &ManifoldPoint,
    others: &[ManifoldPoint],
) -> Option<ManifoldPoint> {
    let starts = pair_motion.paths.map(|path| path.start);
    let [on_first, on_second] = deepest.on_surfaces_at([&starts[0], &starts[1]]);
    let inside = 0.5 * (on_first + on_second);
    let deep = -pair_motion.grazing();
    let is_against = |normal: DVec3| {
        others.iter().any(|other| other.gap < deep && other.normal.dot(normal) <= AGAINST)
    };
    let leads_out = |side: usize, outward: DVec3| {
        let body_from_world = starts[side].world_from_body().inverse();
        let (at, outward) = (body_from_world.point(inside), body_from_world.direction(outward));
        pieces[side].is_free(at, outward, near_seams(pair_motion))
    };

    let mut best: Option<(f64, DVec3, FeatureId)> = None;
    for side in [0, 1] {
        let ConvexShape::Hull(hull) = pieces[side].shape else { continue };
        let own_from_other =
            starts[side].world_from_body().inverse().after(&starts[1 - side].world_from_body());
        for (face, plane) in hull.planes().iter().enumerate() {
            let overlap =
                plane.offset + pieces[1 - side].shape.reach(&own_from_other, -plane.normal);
            // Planes and triangles have no other side.
            if overlap <= 0.0 || overlap.is_infinite() {
                return None;
            }
            if best.is_some_and(|(least, ..)| overlap >= least) {
                continue;
            }
            let outward = starts[side].orientation * plane.normal;
            let normal = if side == 0 { -outward } else { outward };
            if !is_against(normal) && leads_out(side, outward) && leads_out(1 - side, -outward) {
                let feature = FeatureId { is_of_first: side == 0, index: WAY_OUT | face as u64 };
                best = Some((overlap, normal, feature));
            }
        }
    }
    best.map(|(overlap, normal, feature)| {
        let on_second = inside + 0.5 * overlap * normal;
        let on_first = inside - 0.5 * overlap * normal;
        let speed =
            pair_motion.paths[0].velocity(inside, 0.0) - pair_motion.paths[1].velocity(inside, 0.0);
        ManifoldPoint {
            anchor_first: starts[0].world_from_body().inverse().point(on_first),
            anchor_second: starts[1].world_from_body().inverse().point(on_second),
            rounding: [0.0; 2],
            normal,
            feature,
            approach: pair_motion.surface_speed(normal, -speed.dot(normal), -overlap),
            gap: -overlap,
        }
    })
}

impl Piece<'_> {
    /// True if no neighbour covers the piece where a ray from a point in it leaves it; all in the
    /// body's frame.
    fn is_free(&self, from: DVec3, outward: DVec3, slack: f64) -> bool {
        let Some((compound, part)) = self.of_compound else { return true };
        let at = from + way_to_surface(&compound.parts()[part].hull, from, outward) * outward;
        !compound.is_covered(part, at, outward, slack)
    }
}

/// Length of a ray from a point in a hull to its surface [m].
fn way_to_surface(hull: &Hull, from: DVec3, direction: DVec3) -> f64 {
    let to_plane = |plane: &HalfSpace| {
        let rate = plane.normal.dot(direction);
        (rate > 0.0).then(|| -plane.distance(from) / rate)
    };
    hull.planes().iter().filter_map(to_plane).fold(f64::INFINITY, f64::min).max(0.0)
}
