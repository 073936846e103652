//! Broad phase: pairs of bodies with overlapping bounds.

pub(crate) mod bounds;
pub(crate) mod crowd;
pub(crate) mod sweep_and_prune;

use crate::broad_phase::bounds::Bounds;
use crate::broad_phase::bounds::Ground;
use crate::broad_phase::sweep_and_prune::overlapping_bounded;
use crate::relative_motion::moved;
use frangible_bodies::{Bodies, Frame, Pair, Pose};
use frangible_geometry::{Columns, Hull};
use frangible_math::{Instructions, Kernel, threads, with_widest};
use std::slice::from_ref;

/// All pairs with at least one dynamic body whose bounds at `poses`, enlarged by half of `margin`
/// [m], overlap; in increasing order.
pub fn find_pairs(bodies: &Bodies, poses: &[Pose], margin: f64) -> Vec<Pair> {
    let bounds: Vec<Bounds> = bodies
        .shapes
        .iter()
        .zip(poses)
        .map(|(shape, pose)| Bounds::of(shape, pose).grown(0.5 * margin))
        .collect();
    overlapping_pairs(bodies, &bounds, &[poses], false).0
}

/// Bodies rotating by more than this in a frame [rad] get bounds for any rotation.
const LARGE_TURN: f64 = 1.0;

/// Rotations that move no point of a body further than this fraction of the margin are ignored:
/// only the bounds at the start are computed [1].
const HARDLY: f64 = 0.01;

/// Swept bounds of all bodies in a frame, and their overlaps.
pub struct Swept {
    /// Bounds around each body's path, enlarged by half of the margin.
    pub bounds: Vec<Bounds>,
    /// Pairs with at least one dynamic body and overlapping bounds, in increasing order; in crowds
    /// only the deepest overlaps.
    pub pairs: Vec<Pair>,
    /// Number of omitted pairs in crowds.
    pub left_out: usize,
}

impl Swept {
    /// Sweeps bounds along the bodies' paths through a `frame`, from their poses to `ends`;
    /// polyhedra use their vertices.
    pub fn new(bodies: &Bodies, ends: &[Pose], margin: f64, frame: &Frame) -> Self {
        let bounds =
            with_widest(frame.settings.width, AllSweptBounds { bodies, ends, margin, frame });
        let (pairs, left_out) = overlapping_pairs(bodies, &bounds, &[&bodies.poses, ends], true);
        Self { bounds, pairs, left_out }
    }
}

/// Pairs of [`Swept`].
pub fn find_swept_pairs(bodies: &Bodies, ends: &[Pose], margin: f64, frame: &Frame) -> Vec<Pair> {
    Swept::new(bodies, ends, margin, frame).pairs
}

/// [`swept_bounds_with`] of all bodies.
struct AllSweptBounds<'a> {
    bodies: &'a Bodies,
    ends: &'a [Pose],
    margin: f64,
    frame: &'a Frame,
}

impl Kernel for AllSweptBounds<'_> {
    type Output = Vec<Bounds>;

    fn compute<I: Instructions>(self) -> Vec<Bounds> {
        let Self { bodies, ends, margin, frame } = self;
        threads::list(bodies.len(), |i| {
            // Prefetch later bodies in three stages: shape, hull, vertex columns.
            let later = |steps: usize| bodies.shapes.get(i + steps * AHEAD);
            let hull_later = |steps: usize| later(steps).and_then(|shape| shape.hull.as_deref());
            later(3).into_iter().for_each(|shape| I::prefetch(from_ref(&**shape)));
            hull_later(2).into_iter().for_each(|hull| I::prefetch(from_ref(hull)));
            I::prefetch(hull_later(1).and_then(Hull::known_columns).map_or(&[], Columns::vertices));
            swept_bounds_with::<I>(bodies, i, &ends[i], margin, frame)
        })
    }
}

/// Bodies between two stages of prefetching.
const AHEAD: usize = 4;

/// Bounds around a body's path, enlarged by half of `margin` [m].
fn swept_bounds_with<I: Instructions>(
    bodies: &Bodies,
    i: usize,
    end: &Pose,
    margin: f64,
    frame: &Frame,
) -> Bounds {
    let (shape, start) = (&bodies.shapes[i], &bodies.poses[i]);
    let turn = bodies.spin(i, start, &bodies.velocities[i]).length() * frame.dt;
    if turn > LARGE_TURN {
        let bounds = |pose: &Pose| Bounds::of_any_turn(shape, pose).grown(0.5 * margin);
        return bounds(start).around(&bounds(end));
    }
    let bounds = Bounds::of_vertices::<I>(shape, start);
    let turned = Pose { position: start.position, ..*end };
    let further = moved(start, &turned, bodies.radii[i]);
    let (at_end, beyond) = if further <= HARDLY * margin {
        let way = end.position - start.position;
        (Bounds { low: bounds.low + way, high: bounds.high + way }, further)
    } else {
        // Points move along arcs. Arcs exceed their chords by at most this bulge if the spin keeps
        // its axis; none of 6,000 freely rotating boxes (half a radian to one) exceeds it.
        let bulge = if turn > 0.0 { 0.125 * turn * turn * bodies.radii[i] } else { 0.0 };
        (Bounds::of_vertices::<I>(shape, end), bulge)
    };
    bounds.around(&at_end).grown(beyond).grown(0.5 * margin)
}

/// Pairs with at least one dynamic body and overlapping bounds, for bodies at each of `poses`; if
/// crowds are thinned, also the number of omitted pairs.
fn overlapping_pairs(
    bodies: &Bodies,
    bounds: &[Bounds],
    poses: &[&[Pose]],
    thins: bool,
) -> (Vec<Pair>, usize) {
    let moves: Vec<bool> = bodies.inertias.iter().map(|inertia| !inertia.is_infinite()).collect();
    let may_collide = |a, b| bodies.may_collide(a, b);
    let (mut pairs, left_out) = overlapping_bounded(bounds, &moves, &may_collide, thins);

    // Unbounded bodies meet every body, except bodies above ground.
    let mut with_boundless = Vec::new();
    for a in (0..bodies.len()).filter(|&i| bounds[i].is_boundless()) {
        let ground = Ground::of(bodies, a, poses);
        let is_above = |b: usize| ground.as_ref().is_some_and(|ground| ground.is_below(&bounds[b]));
        let meets = |&b: &usize| (moves[a] || moves[b]) && a != b && may_collide(a, b);
        for b in (0..bodies.len()).filter(meets) {
            let is_second = bounds[b].is_boundless() && b < a;
            if !is_second && !bounds[b].is_nan() && !is_above(b) {
                with_boundless.push(Pair { first: a.min(b), second: a.max(b) });
            }
        }
    }
    pairs.push(with_boundless);
    (sorted(&pairs, bodies.len()), left_out)
}

/// Bodies per sorting task.
const SORTED: usize = 512;

/// Pairs of `count` bodies in increasing order: counting sort by first body, then a small sort by
/// second body.
fn sorted(pairs: &[Vec<Pair>], count: usize) -> Vec<Pair> {
    let mut begin = vec![0; count + 1];
    pairs.iter().flatten().for_each(|pair| begin[pair.first + 1] += 1);
    for first in 0..count {
        begin[first + 1] += begin[first];
    }
    let mut next = begin.clone();
    let mut ordered = vec![Pair { first: 0, second: 0 }; pairs.iter().map(Vec::len).sum()];
    for pair in pairs.iter().flatten() {
        ordered[next[pair.first]] = *pair;
        next[pair.first] += 1;
    }
    let mut of_each = Vec::with_capacity(count.div_ceil(SORTED));
    let mut rest = ordered.as_mut_slice();
    for first in (0..count).step_by(SORTED) {
        let begins = &begin[first..=(first + SORTED).min(count)];
        let (some, others) = rest.split_at_mut(begins[begins.len() - 1] - begins[0]);
        of_each.push((some, begins));
        rest = others;
    }
    threads::for_each(&mut of_each, count, |(some, begins)| {
        for ends in begins.windows(2) {
            some[ends[0] - begins[0]..ends[1] - begins[0]].sort_unstable_by_key(|pair| pair.second);
        }
    });
    ordered
}

#[cfg(test)]
mod tests;
