//! Contact points of convex compounds: part by part, without points hidden by glued neighbours.

use crate::broad_phase::bounds::Bounds;
use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_pairs::exact_points;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::flat_contacts::few;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seam_contacts::{plane_points, take_covered};
use crate::narrow_phase::seams::{Seams, near_seams};
use crate::relative_motion::{Placed, second_from_first};
use frangible_geometry::{Compound, HalfSpace, Shape};

/// Appends the points of a pair with a compound; `false` without a compound, or if the pair needs
/// samples.
pub(crate) fn compound_points(
    pair_motion: &PairMotion,
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let PairMotion { bodies, pair, .. } = *pair_motion;
    let shapes = [&*bodies.shapes[pair.first], &*bodies.shapes[pair.second]];
    let compounds = [shapes[0].compound.as_deref(), shapes[1].compound.as_deref()];
    let meets_by_samples = |side: usize| {
        compounds[side].is_none() && matches!(ConvexShape::of(shapes[side]), ConvexShape::Other(_))
    };
    if compounds.iter().all(Option::is_none) || meets_by_samples(0) || meets_by_samples(1) {
        return false;
    }

    let shapes_of = |parts: [Option<usize>; 2]| {
        [0, 1].map(|side| match (compounds[side], parts[side]) {
            (Some(compound), Some(part)) => ConvexShape::Hull(&compound.parts()[part].hull),
            _ => ConvexShape::of(shapes[side]),
        })
    };
    let seams_of = |parts: [Option<usize>; 2]| {
        let of_compounds =
            [0, 1].map(|side| compounds[side].and_then(|of| parts[side].map(|part| (of, part))));
        Seams::new(pair_motion, shapes_of(parts), of_compounds)
    };
    let slack = near_seams(pair_motion);
    let is_inner = |parts: [Option<usize>; 2], point: &ManifoldPoint| {
        let is_inner_on = |side: usize| {
            let (Some(compound), Some(part)) = (compounds[side], parts[side]) else {
                return false;
            };
            let at = if side == 0 { point.anchor_first } else { point.anchor_second };
            let outward = if side == 0 { -point.normal } else { point.normal };
            let body_from_world = pair_motion.paths[side].start.world_from_body().inverse();
            compound.is_covered(part, at, body_from_world.direction(outward), slack)
        };
        is_inner_on(0) || is_inner_on(1)
    };
    let (mut all, mut hidden, mut of_parts) = (Vec::new(), Vec::new(), Vec::new());
    let mut add = |parts: [Option<usize>; 2], of_parts: &[ManifoldPoint]| {
        for point in of_parts {
            let of_points = if is_inner(parts, point) { &mut hidden } else { &mut all };
            of_points.push(ManifoldPoint { feature: feature_of(point.feature, parts), ..*point });
        }
    };
    // A plane with faces of several parts is met once.
    let mut planes: Vec<([Option<usize>; 2], HalfSpace)> = Vec::new();
    for parts in near_parts(pair_motion.placed(), compounds, pair_motion.reach) {
        of_parts.clear();
        if !exact_points(pair_motion, shapes_of(parts), scratch, &mut of_parts) {
            return false;
        }
        if let Some(seams) = seams_of(parts) {
            let mover = 1 - seams.side;
            for plane in take_covered(&seams, &mut of_parts) {
                let is_known = |(of, known): &([Option<usize>; 2], HalfSpace)| {
                    of[mover] == parts[mover] && seams.is_flush(known, &plane)
                };
                if !planes.iter().any(is_known) {
                    planes.push((parts, plane));
                }
            }
        }
        add(parts, &of_parts);
    }
    for (parts, plane) in planes {
        of_parts.clear();
        if let Some(seams) = seams_of(parts) {
            plane_points(&seams, shapes_of(parts), &plane, scratch, &mut of_parts);
        }
        add(parts, &of_parts);
    }
    // A body deep in a compound touches only features that neighbouring parts cover.
    if all.is_empty() {
        all.extend(hidden.into_iter().filter(|point| point.gap < 0.0));
    }
    points.extend(few(pair_motion, &all, scratch));
    true
}

/// Pairs of parts (for bodies with parts) with bounds within `reach` [m] of each other.
pub(crate) fn near_parts(
    placed: [Placed; 2],
    compounds: [Option<&Compound>; 2],
    reach: f64,
) -> Vec<[Option<usize>; 2]> {
    let of_second = bounds_of(placed[1].shape);
    let second_from_first = second_from_first(placed[0], placed[1]);
    let near = |compound: &Compound, of: Bounds| {
        let Bounds { low, high } = of.grown(reach);
        compound.parts_near(low, high)
    };
    match compounds {
        [Some(first), Some(second)] => {
            let of_second = of_second.seen_from(&second_from_first.inverse());
            let with_second = |a: usize| {
                let (low, high) = first.parts()[a].bounds;
                let of_part = Bounds { low, high }.seen_from(&second_from_first);
                near(second, of_part).into_iter().map(move |b| [Some(a), Some(b)])
            };
            near(first, of_second).into_iter().flat_map(with_second).collect()
        }
        [Some(compound), None] | [None, Some(compound)] => {
            let is_first = compounds[0].is_some();
            let (other, compound_from_other) = if is_first {
                (placed[1].shape, second_from_first.inverse())
            } else {
                (placed[0].shape, second_from_first)
            };
            let parts = if let ConvexShape::Ground(ground) = ConvexShape::of(other) {
                let normal = compound_from_other.direction(ground.normal);
                let offset = ground.offset + normal.dot(compound_from_other.translation) + reach;
                compound.parts_in(&HalfSpace { normal, offset })
            } else {
                near(compound, bounds_of(other).seen_from(&compound_from_other))
            };
            parts
                .into_iter()
                .map(|part| if is_first { [Some(part), None] } else { [None, Some(part)] })
                .collect()
        }
        [None, None] => Vec::new(),
    }
}

/// Bounds in the body frame.
fn bounds_of(shape: &Shape) -> Bounds {
    let (low, high) = shape.bounds;
    Bounds { low, high }
}

/// Feature id of a point of two parts: part indices and the part's own feature id.
fn feature_of(FeatureId { is_of_first, index }: FeatureId, parts: [Option<usize>; 2]) -> FeatureId {
    let [first, second] = parts.map(|part| part.unwrap_or_default() as u64 & 0xffff);
    FeatureId { is_of_first, index: index | first << 48 | second << 32 }
}
