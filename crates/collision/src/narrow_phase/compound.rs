//! Contact points of convex compounds: part by part, without points hidden by glued neighbours.

use crate::broad_phase::bounds::Bounds;
use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_pairs::exact_points;
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::flat_contacts::few;
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::seam_contacts::{plane_points, take_covered};
use crate::narrow_phase::seams::{SAME_NORMAL, Seams, near_seams};
use crate::narrow_phase::way_out::{Piece, way_out};
use crate::relative_motion::{Placed, second_from_first};
use frangible_geometry::{Compound, HalfSpace, Shape};

/// A part of each body that has any, by its number.
type Parts = [Option<usize>; 2];

/// A pair with a compound.
struct CompoundPair<'a> {
    pair_motion: &'a PairMotion<'a>,
    shapes: [&'a Shape; 2],
    compounds: [Option<&'a Compound>; 2],
}

/// Appends the points of a pair with a compound; `false` without a compound, or if the pair needs
/// samples.
pub(crate) fn compound_points(
    pair_motion: &PairMotion,
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let shapes = pair_motion.pair.both().map(|i| &*pair_motion.bodies.shapes[i]);
    let compounds = shapes.map(|shape| shape.compound.as_deref());
    let meets_by_samples = |side: usize| {
        compounds[side].is_none() && matches!(ConvexShape::of(shapes[side]), ConvexShape::Other(_))
    };
    if compounds.iter().all(Option::is_none) || meets_by_samples(0) || meets_by_samples(1) {
        return false;
    }

    let of_pair = CompoundPair { pair_motion, shapes, compounds };
    let (mut found, mut of_parts) = (Found::default(), Vec::new());
    // A plane with faces of several parts is met once.
    let mut planes: Vec<(Parts, HalfSpace)> = Vec::new();
    let mut taken: Vec<(Parts, ManifoldPoint)> = Vec::new();
    for parts in near_parts(pair_motion.placed(), compounds, pair_motion.reach) {
        of_parts.clear();
        if !exact_points(pair_motion, of_pair.shapes(parts), scratch, &mut of_parts) {
            return false;
        }
        if let Some(seams) = of_pair.seams(parts) {
            let mover = 1 - seams.side;
            let before = of_parts.clone();
            for plane in take_covered(&seams, &mut of_parts) {
                let is_known = |(of, known): &(Parts, HalfSpace)| {
                    of[mover] == parts[mover] && seams.is_flush(known, &plane)
                };
                if !planes.iter().any(is_known) {
                    planes.push((parts, plane));
                }
            }
            let is_taken = |point: &ManifoldPoint| !of_parts.contains(point);
            taken.extend(before.into_iter().filter(is_taken).map(|point| (parts, point)));
        }
        found.add(&of_pair, parts, &of_parts);
    }
    for (parts, plane) in planes {
        of_parts.clear();
        if let Some(seams) = of_pair.seams(parts) {
            plane_points(&seams, of_pair.shapes(parts), &plane, scratch, &mut of_parts);
        }
        found.add(&of_pair, parts, &of_parts);
    }
    // A part deep below a seam may be over no face.
    if found.is_empty() {
        for (parts, point) in taken.into_iter().filter(|(_, point)| point.gap < 0.0) {
            found.add(&of_pair, parts, &[point]);
        }
    }
    points.extend(few(pair_motion, &found.outside(&of_pair), scratch));
    true
}

/// Points of all parts.
#[derive(Default)]
struct Found {
    /// Those with normals of the compound.
    shown: Vec<ManifoldPoint>,
    /// Overlaps that lead from one part into the next one.
    hidden: Vec<ManifoldPoint>,
    /// Parts that overlap deeply, and lead into others with all of their points; and the deepest of
    /// those.
    stuck: Vec<(Parts, ManifoldPoint)>,
}

impl Found {
    fn is_empty(&self) -> bool {
        self.shown.is_empty() && self.hidden.is_empty() && self.stuck.is_empty()
    }

    /// Adds the points of two parts.
    fn add(&mut self, of_pair: &CompoundPair, parts: Parts, of_parts: &[ManifoldPoint]) {
        let deep = -of_pair.pair_motion.grazing();
        let mut deepest: Option<ManifoldPoint> = None;
        let of_all = |point: ManifoldPoint| ManifoldPoint {
            feature: feature_of(point.feature, parts),
            ..point
        };
        let (hidden, shown): (Vec<_>, Vec<_>) =
            of_parts.iter().copied().partition(|point| of_pair.is_covered(parts, point));
        self.shown.extend(shown.iter().copied().map(of_all));
        for point in hidden {
            // A side that is free in places is a side, however deep its covered points are.
            let is_side = |shown: &ManifoldPoint| shown.normal.dot(point.normal) >= SAME_NORMAL;
            if point.gap >= deep {
                self.hidden.extend((point.gap < 0.0).then(|| of_all(point)));
            } else if shown.iter().any(is_side) {
                self.shown.push(of_all(point));
            } else if deepest.is_none_or(|deepest| point.gap < deepest.gap) {
                deepest = Some(point);
            }
        }
        self.stuck.extend(deepest.map(|point| (parts, point)));
    }

    /// The points that part the bodies.
    fn outside(self, of_pair: &CompoundPair) -> Vec<ManifoldPoint> {
        let Self { mut shown, mut hidden, stuck } = self;
        for (parts, point) in stuck {
            let of_parts = [0, 1].map(|side| {
                let of_compound = of_pair.compounds[side].zip(parts[side]);
                Piece { shape: of_pair.shapes(parts)[side], of_compound }
            });
            match way_out(of_pair.pair_motion, of_parts, &point, &shown) {
                Some(way) => {
                    shown.push(ManifoldPoint { feature: feature_of(way.feature, parts), ..way });
                }
                None => {
                    let feature = feature_of(point.feature, parts);
                    hidden.push(ManifoldPoint { feature, ..point });
                }
            }
        }
        // A body deep in a compound touches only features that neighbouring parts cover.
        if shown.is_empty() { hidden } else { shown }
    }
}

impl<'a> CompoundPair<'a> {
    fn shapes(&self, parts: Parts) -> [ConvexShape<'a>; 2] {
        [0, 1].map(|side| match (self.compounds[side], parts[side]) {
            (Some(compound), Some(part)) => ConvexShape::Hull(&compound.parts()[part].hull),
            _ => ConvexShape::of(self.shapes[side]),
        })
    }

    fn seams(&self, parts: Parts) -> Option<Seams<'a>> {
        let of_compound = |side: usize| Some((self.compounds[side]?, parts[side]?));
        Seams::new(self.pair_motion, self.shapes(parts), [0, 1].map(of_compound))
    }

    /// True for a point that other parts of either body cover.
    fn is_covered(&self, parts: Parts, point: &ManifoldPoint) -> bool {
        let slack = near_seams(self.pair_motion);
        [0, 1].into_iter().any(|side| {
            let (Some(compound), Some(part)) = (self.compounds[side], parts[side]) else {
                return false;
            };
            let at = if side == 0 { point.anchor_first } else { point.anchor_second };
            let outward = if side == 0 { -point.normal } else { point.normal };
            let path = self.pair_motion.paths[side];
            let body_from_world = path.start.world_from_body().inverse();
            compound.is_covered(part, at, body_from_world.direction(outward), slack)
        })
    }
}

/// Pairs of parts (for bodies with parts) with bounds within `reach` [m] of each other.
pub(crate) fn near_parts(
    placed: [Placed; 2],
    compounds: [Option<&Compound>; 2],
    reach: f64,
) -> Vec<Parts> {
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
fn feature_of(FeatureId { is_of_first, index }: FeatureId, parts: Parts) -> FeatureId {
    let [first, second] = parts.map(|part| part.unwrap_or_default() as u64 & 0xffff);
    FeatureId { is_of_first, index: index | first << 48 | second << 32 }
}
