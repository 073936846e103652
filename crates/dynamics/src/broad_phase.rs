//! Pairs of bodies whose bounds overlap: sweep and prune along one axis [Bar92].

use crate::detection::radius;
use crate::pair::Pair;
use crate::{Bodies, Pose};
use frangible_geometry::{RigidTransform, Shape};
use glam::DVec3;

/// An axis-aligned box [m], in the world frame unless told otherwise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Lowest corner.
    pub low: DVec3,
    /// Highest corner.
    pub high: DVec3,
}

impl Bounds {
    /// Of a shape at a pose; infinite for a half-space.
    pub fn of(shape: &Shape, pose: &Pose) -> Self {
        let (low, high) = shape.bounds;
        if !low.is_finite() || !high.is_finite() {
            return Self { low: DVec3::NEG_INFINITY, high: DVec3::INFINITY };
        }
        Self { low, high }.seen_from(&pose.world_from_body())
    }

    /// Around this box, which lies along another frame's axes.
    pub fn seen_from(&self, to_from_other: &RigidTransform) -> Self {
        let Self { low, high } = *self;
        let center = to_from_other.point(0.5 * (low + high));
        let matrix = to_from_other.matrix();
        let half = 0.5 * (high - low);
        let reach =
            half.x * matrix.x_axis.abs() + half.y * matrix.y_axis.abs() + half.z * matrix.z_axis.abs();
        Self { low: center - reach, high: center + reach }
    }

    /// Of a shape at a position, however it is turned.
    fn of_any_turn(shape: &Shape, pose: &Pose) -> Self {
        let reach = DVec3::splat(radius(shape));
        Self { low: pose.position - reach, high: pose.position + reach }
    }

    /// The box around this and another.
    pub fn around(&self, other: &Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high) }
    }

    /// Larger by `margin` [m] on every side.
    pub fn grown(&self, margin: f64) -> Self {
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Whether the boxes have a point in common.
    pub fn overlaps(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }
}

/// All pairs of bodies whose bounds at `poses`, enlarged by half of `margin` [m], overlap and of which at least one is dynamic, in increasing
/// order.
pub fn find_pairs(bodies: &Bodies, poses: &[Pose], margin: f64) -> Vec<Pair> {
    let bounds: Vec<Bounds> = bodies
        .shapes
        .iter()
        .zip(poses)
        .map(|(shape, pose)| Bounds::of(shape, pose).grown(0.5 * margin))
        .collect();
    overlapping_pairs(bodies, &bounds)
}

/// Turning by less than this [rad] within a frame, a body stays between its bounds at both ends to within 2 % of its size.
const SMALL_TURN: f64 = 0.2;

/// The same for bounds around all of the bodies' ways through a frame of `dt` [s], from their poses to `ends`.
pub fn find_swept_pairs(bodies: &Bodies, ends: &[Pose], dt: f64, margin: f64) -> Vec<Pair> {
    let swept = |i: usize| {
        let (shape, start, end) = (&bodies.shapes[i], &bodies.poses[i], &ends[i]);
        let turns = bodies.spin(i, start, &bodies.velocities[i]).length() * dt > SMALL_TURN;
        let bounds =
            |pose: &Pose| if turns { Bounds::of_any_turn(shape, pose) } else { Bounds::of(shape, pose) };
        bounds(start).around(&bounds(end)).grown(0.5 * margin)
    };
    let bounds: Vec<Bounds> = (0..bodies.len()).map(swept).collect();
    overlapping_pairs(bodies, &bounds)
}

fn overlapping_pairs(bodies: &Bodies, bounds: &[Bounds]) -> Vec<Pair> {
    // Sort along x; equal keys fall back on the index, so the order is one only.
    let mut order: Vec<usize> = (0..bodies.len()).collect();
    order.sort_by(|&a, &b| bounds[a].low.x.total_cmp(&bounds[b].low.x).then(a.cmp(&b)));

    // Sweep: what begins before this one ends may overlap it.
    let mut pairs = Vec::new();
    for (rank, &a) in order.iter().enumerate() {
        for &b in &order[rank + 1..] {
            if bounds[b].low.x > bounds[a].high.x {
                break;
            }
            let moves = !bodies.inertias[a].is_infinite() || !bodies.inertias[b].is_infinite();
            if moves && bounds[a].overlaps(&bounds[b]) {
                pairs.push(Pair { first: a.min(b), second: a.max(b) });
            }
        }
    }
    pairs.sort_unstable();
    pairs
}
