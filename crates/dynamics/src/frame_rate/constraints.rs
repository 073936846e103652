//! Contact constraints: up to four points of a manifold with a common normal, with their
//! accumulated impulses from the last frame.

use frangible_bodies::{Bodies, Frame, Motion, PairSurface};
use frangible_collision::{CachedImpulse, Manifold, ManifoldPoint};
use glam::DVec3;

/// Maximum number of points per constraint.
pub(super) const MOST_POINTS: usize = 4;

/// Normals within a quarter of a degree share a constraint: the cosine of this angle.
pub(crate) const SAME_NORMAL: f64 = 1.0 - 1e-5;

/// A point is near if its separation is at most this fraction of gravity's displacement in a frame
/// ([`Frame::speculative_margin`]). Near points without a cached impulse share the impulses of
/// vanished points, and near points count as touching for sleep.
pub(super) const NEAR: f64 = 0.2;

/// Points of a manifold in one constraint.
#[derive(Clone, Copy)]
pub(super) struct Selection {
    /// Index of the manifold.
    pub(super) manifold: u32,
    /// Solver lines of both bodies.
    pub(super) lines: [u32; 2],
    numbers: [u16; MOST_POINTS],
    count: u16,
}

impl Selection {
    /// Indices of the points in the manifold.
    pub(super) fn points(&self) -> impl ExactSizeIterator<Item = usize> + Clone + '_ {
        self.numbers[..self.count.into()].iter().map(|&number| number.into())
    }

    /// Appends the constraints of one manifold. `is_done` is scratch memory.
    pub(super) fn all(
        selections: &mut Vec<Self>,
        (manifold, points): (usize, &[ManifoldPoint]),
        lines: [u32; 2],
        is_done: &mut Vec<bool>,
    ) {
        debug_assert!(points.len() <= u16::MAX.into());
        is_done.clear();
        is_done.resize(points.len(), false);
        for first in 0..points.len() {
            if is_done[first] {
                continue;
            }
            let none =
                Self { manifold: manifold as u32, lines, numbers: [0; MOST_POINTS], count: 0 };
            let mut selection = none;
            for next in first..points.len() {
                let has_room = !is_done[next] && usize::from(selection.count) < MOST_POINTS;
                // Friction acts at the centre of a constraint, and contacts of corners and of cores
                // have different centres.
                let of_one_kind = points[first].feature.is_ball() == points[next].feature.is_ball();
                let is_along = points[first].normal.dot(points[next].normal) > SAME_NORMAL;
                if has_room && of_one_kind && is_along {
                    is_done[next] = true;
                    selection.numbers[usize::from(selection.count)] = next as u16;
                    selection.count += 1;
                }
            }
            selections.push(selection);
        }
    }
}

/// One point of a constraint.
#[derive(Clone, Copy, Debug)]
pub(super) struct ConstraintPoint {
    /// Index in the manifold.
    pub(super) number: usize,
    /// From the bodies' centres, world frame [m].
    pub(super) anchors: [DVec3; 2],
    /// [m]
    pub(super) separation: f64,
    /// Impulse of the last frame, per substep [N s].
    pub(super) impulse: f64,
    /// Distance from the constraint's centre [m].
    pub(super) radius: f64,
}

/// A contact constraint in double precision, before
/// [`ContactBatch`](super::contact_batch::ContactBatch) packs eight of them.
pub(super) struct Constraint {
    /// Solver lines of both bodies.
    pub(super) lines: [u32; 2],
    /// True for kinematic bodies.
    pub(super) is_driven: [bool; 2],
    /// World frame, from the first body to the second.
    pub(super) normal: DVec3,
    pub(super) tangent: DVec3,
    pub(super) points: Points,
    /// Mean of the anchors [m], and its distance along the normal to where friction acts [m]: on both
    /// surfaces, which meet there, or in the middle of an overlap.
    pub(super) centers: [DVec3; 2],
    pub(super) offsets: [f64; 2],
    /// Impulses of the last frame, per substep: along both tangents [N s], about the normal and
    /// both tangents [N m s].
    pub(super) friction_impulse: [f64; 2],
    pub(super) twist_impulse: f64,
    pub(super) rolling_impulse: [f64; 2],
    pub(super) surface: PairSurface,
    /// Relative gravity along the normal [m/s^2].
    pub(super) gravity: f64,
}

impl Constraint {
    /// True if any impulse is nonzero before the bodies approach.
    pub(super) fn carries(&self) -> bool {
        let [along, across] = self.friction_impulse;
        let [about, other] = self.rolling_impulse;
        let all = [along, across, self.twist_impulse, about, other];
        self.points.iter().map(|point| point.impulse).chain(all).any(|impulse| impulse != 0.0)
    }
}

/// Up to [`MOST_POINTS`] points.
#[derive(Clone, Copy)]
pub(super) struct Points {
    of: [ConstraintPoint; MOST_POINTS],
    count: usize,
}

impl std::ops::Deref for Points {
    type Target = [ConstraintPoint];
    fn deref(&self) -> &[ConstraintPoint] {
        &self.of[..self.count]
    }
}

impl std::ops::DerefMut for Points {
    fn deref_mut(&mut self) -> &mut [ConstraintPoint] {
        &mut self.of[..self.count]
    }
}

impl<'a> IntoIterator for &'a Points {
    type Item = &'a ConstraintPoint;
    type IntoIter = std::slice::Iter<'a, ConstraintPoint>;
    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

/// A manifold with its cached impulses.
pub(super) struct Source<'a> {
    pub(super) manifold: &'a Manifold<'a>,
    pub(super) carried: &'a [CachedImpulse],
}

impl Source<'_> {
    /// Substep of length `h` [s] in which the first of the selected points can touch.
    pub(super) fn acts_in(&self, selection: &Selection, (h, frame): (f64, &Frame)) -> u16 {
        let fall = frame.dt * frame.gravity.length();
        let time = |number: usize| {
            let ManifoldPoint { gap, approach, .. } = self.manifold.points[number];
            if gap > 0.0 { gap / (approach + fall) } else { 0.0 }
        };
        let first = selection.points().map(time).fold(f64::INFINITY, f64::min);
        if self.carried.is_empty() { (first / h) as u16 } else { 0 }
    }

    /// Builds the constraint of the selected points for substeps of `h` [s].
    pub(super) fn constraint(
        &self,
        selection: &Selection,
        bodies: &Bodies,
        (h, frame): (f64, &Frame),
    ) -> Constraint {
        let Manifold { pair, points, .. } = self.manifold;
        let both = [pair.first, pair.second];
        let normal = -points[usize::from(selection.numbers[0])].normal;
        let tangent = normal.any_orthonormal_vector();
        let count = selection.points().len();
        let share = 1.0 / count as f64;

        let none = ConstraintPoint {
            number: 0,
            anchors: [DVec3::ZERO; 2],
            separation: 0.0,
            impulse: 0.0,
            radius: 0.0,
        };
        let mut all = Points { of: [none; MOST_POINTS], count };
        let (mut centers, mut offsets) = ([DVec3::ZERO; 2], [0.0; 2]);
        for (to, number) in all.iter_mut().zip(selection.points()) {
            let ManifoldPoint { anchor_first, anchor_second, rounding, gap, .. } = points[number];
            let turned = |i: usize, anchor: DVec3| bodies.poses[i].orientation * anchor;
            to.number = number;
            to.anchors = [turned(pair.first, anchor_first), turned(pair.second, anchor_second)];
            to.separation = gap;
            for side in 0..2 {
                let half = 0.5 * gap.min(0.0);
                let offset = if side == 0 { rounding[0] + half } else { -rounding[1] - half };
                centers[side] += share * to.anchors[side];
                offsets[side] += share * offset;
            }
        }
        for point in all.iter_mut() {
            point.radius = (point.anchors[0] - centers[0]).length();
        }
        let is_movable = both.map(|i| !bodies.inertias[i].is_infinite());
        let of = |side: usize| if is_movable[side] { frame.gravity } else { DVec3::ZERO };
        let mut constraint = Constraint {
            lines: selection.lines,
            is_driven: both.map(|i| matches!(bodies.motions[i], Motion::Kinematic { .. })),
            normal,
            tangent,
            points: all,
            centers,
            offsets,
            friction_impulse: [0.0; 2],
            twist_impulse: 0.0,
            rolling_impulse: [0.0; 2],
            surface: bodies.pair_surface(pair.first, pair.second),
            gravity: (of(1) - of(0)).dot(normal),
        };
        self.warm(&mut constraint, h, NEAR * frame.speculative_margin());
        constraint
    }

    /// Warm starting: copies cached impulses point by point. Impulses of vanished points go to new
    /// points with a separation below `near` [m]. Friction keeps its direction in the world frame.
    fn warm(&self, constraint: &mut Constraint, h: f64, near: f64) {
        let points = self.manifold.points;
        let has_all = constraint.points.len() == points.len();
        let (mut force, mut torque) = (DVec3::ZERO, DVec3::ZERO);
        let mut left = 0.0;
        for carried in self.carried {
            let is_it =
                |point: &&mut ConstraintPoint| points[point.number].feature == carried.feature;
            let acts = &carried.force;
            let normal = h * f64::from(acts.normal);
            if let Some(point) = constraint.points.iter_mut().find(is_it) {
                point.impulse = normal;
            } else if has_all {
                left += normal;
            } else {
                continue;
            }
            force -= h * acts.force.as_dvec3();
            torque -= h * acts.twist.as_dvec3();
        }
        let is_new = |point: &ConstraintPoint| {
            let feature = points[point.number].feature;
            point.separation < near && self.carried.iter().all(|carried| carried.feature != feature)
        };
        let new = constraint.points.iter().filter(|point| is_new(point)).count();
        if has_all && left > 0.0 && new > 0 {
            let share = left / new as f64;
            for point in constraint.points.iter_mut().filter(|point| is_new(point)) {
                point.impulse = share;
            }
        }
        let other = constraint.normal.cross(constraint.tangent);
        constraint.friction_impulse = [force.dot(constraint.tangent), force.dot(other)];
        constraint.twist_impulse = torque.dot(constraint.normal);
        constraint.rolling_impulse = [torque.dot(constraint.tangent), torque.dot(other)];
    }
}
