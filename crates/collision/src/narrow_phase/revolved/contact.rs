//! Contact points of a body of revolution with a polyhedron, a half-space or another one, within a
//! frame.

use crate::manifold::{FeatureId, ManifoldPoint};
use crate::narrow_phase::convex_shape::ConvexShape;
use crate::narrow_phase::hull_hull::hull_pair::PREFERENCE;
use crate::narrow_phase::hull_hull::hull_point::{Feature, HullPoint};
use crate::narrow_phase::hull_hull::reduction::{FEW_POINTS, reduce};
use crate::narrow_phase::hull_hull::scratch::Scratch;
use crate::narrow_phase::pair_motion::PairMotion;
use crate::narrow_phase::revolved::first_touch::{Apart, DEEPER, Meeting};
use crate::narrow_phase::revolved::partner::Partner;
use crate::narrow_phase::revolved::placed::PlacedRevolved;
use crate::narrow_phase::revolved::points::{Instant, is_of_partner};
use crate::narrow_phase::revolved::round_point::RoundPoint;
use crate::narrow_phase::revolved::separation::{
    Separation, contact_separation, flat_separation, quick_separation,
};
use frangible_bodies::{BallisticPath, Pose};
use frangible_geometry::Revolved;
use frangible_math::RigidTransform;
use glam::DVec3;

/// Separation of a touch, relative to the thinner body's half thickness [1].
pub(crate) const TOUCH: f64 = 1e-3;

/// Normals as good within this part of the thinner body's half thickness are equal [1]; for thin
/// bodies less than [`PREFERENCE`] of the radius.
pub(crate) const THIN: f64 = 1e-2;

/// Cosine of the angle within which the closest approach has the normal of the first touch [1]: the
/// points of a first touch that is as good are kept.
const SAME_NORMAL: f64 = 1.0 - 1e-6;

/// A body of revolution and its partner in a frame.
#[derive(Clone, Copy)]
pub(crate) struct RoundPair<'a> {
    pair_motion: &'a PairMotion<'a>,
    round: Revolved,
    round_is_first: bool,
    /// Half thickness of the thinner body [m].
    thin: f64,
    close: f64,
}

/// The partner's shape in its own frame; `None` for balls and for shapes with samples.
pub(crate) fn as_partner<'a>(shape: &ConvexShape<'a>) -> Option<Partner<'a>> {
    match *shape {
        ConvexShape::Hull(hull) => Some(Partner::Hull(hull)),
        ConvexShape::Ground(plane) => Some(Partner::Plane(plane)),
        ConvexShape::Revolved(ref revolved) => {
            Some(Partner::Revolved(PlacedRevolved::new(revolved, &RigidTransform::IDENTITY)))
        }
        ConvexShape::Ball(_) | ConvexShape::Mesh(_) | ConvexShape::Other(_) => None,
    }
}

/// The body of revolution of a pair, its partner, and whether it is the first body.
pub(crate) fn round_and_partner<'a>(
    shapes: [ConvexShape<'a>; 2],
) -> Option<(Revolved, ConvexShape<'a>, bool)> {
    match shapes {
        [ConvexShape::Revolved(round), other] => Some((round, other, true)),
        [other, ConvexShape::Revolved(round)] => Some((round, other, false)),
        _ => None,
    }
}

/// Appends the contact points of a pair with a body of revolution; `false` for other pairs.
pub(crate) fn revolved_points(
    pair_motion: &PairMotion,
    shapes: [ConvexShape; 2],
    scratch: &mut Scratch,
    points: &mut Vec<ManifoldPoint>,
) -> bool {
    let Some((round, partner, round_is_first)) = round_and_partner(shapes) else { return false };
    let Some(shape) = as_partner(&partner) else { return false };
    let half_extent = |side: usize| {
        let i = [pair_motion.pair.first, pair_motion.pair.second][side];
        let (low, high) = pair_motion.bodies.shapes[i].bounds;
        0.5 * (high - low).min_element()
    };
    let thin = half_extent(0).min(half_extent(1));
    let close = (PREFERENCE * pair_motion.size).min(THIN * thin);
    let pair = RoundPair { pair_motion, round, round_is_first, thin, close };
    pair.append(&shape, scratch, points);
    true
}

impl RoundPair<'_> {
    fn append(&self, shape: &Partner, scratch: &mut Scratch, points: &mut Vec<ManifoldPoint>) {
        let motion = self.pair_motion;
        let guess = motion.paths[0].start.position - motion.paths[1].start.position;
        let start = self.apart(shape, (0.0, motion.reach), guess);
        if start.gap > motion.reach {
            return;
        }
        let meeting = Meeting {
            at: &|time, guess| self.apart(shape, (time, f64::INFINITY), guess),
            closing: &|time, normal| self.fastest_closing(time, normal),
            dt: motion.frame.dt,
            touch: TOUCH * self.thin,
            near: motion.near,
        };
        let Some(touch) = meeting.first_touch(start) else { return };
        let straight = motion.paths.map(BallisticPath::straight);
        let straight = PairMotion { paths: [&straight[0], &straight[1]], ..*motion };
        let straight = RoundPair { pair_motion: &straight, ..*self };
        match self.grazing(&straight, shape, &touch, start.gap) {
            Some(nearest) => straight.append_at(&nearest, shape, scratch, points),
            None => self.append_at(&touch, shape, scratch, points),
        }
    }

    /// Appends the points of a touch or of a closest approach.
    fn append_at(
        &self,
        touch: &Apart,
        shape: &Partner,
        scratch: &mut Scratch,
        points: &mut Vec<ManifoldPoint>,
    ) {
        let motion = self.pair_motion;
        let (round, poses) = self.placed(touch.time);
        let partner_from_world = poses[1].orientation.conjugate();
        let guess = self.seen_by_order(partner_from_world * touch.normal);
        let sizes = (motion.size, self.close);
        let separation = contact_separation(&round, shape, sizes, guess);
        let angular = self.paths().map(|path| partner_from_world * path.angular);
        let gravity = partner_from_world * motion.frame.gravity;
        let close = self.close;
        let instant =
            Instant { round: &round, partner: shape, separation, angular, gravity, close };
        let mut found = Vec::with_capacity(8);
        instant.points(&mut found);
        found.retain(|point| self.can_touch(point, touch.time));
        // Of large bodies a face's points may all be out of reach while a rim touches.
        if found.is_empty() {
            let mut others = [instant.nearest(), instant.furthest()].into_iter();
            found.extend(others.find(|point| self.can_touch(point, touch.time)));
        }
        self.few(&instant, &mut found, scratch);
        if let [alone] = found[..] {
            found[0] = instant.alone(alone);
        }
        points.extend(found.iter().map(|point| self.manifold_point(point, touch.time)));
    }

    /// Closest approach in `straight` motion of a pair `now` [m] apart that touches at `touch`, if
    /// it overlaps no deeper than grazing until the frame's end. Gravity is left out, as of bodies
    /// that something carries. Pairs that are further apart are seen again before they act.
    fn grazing(
        &self,
        straight: &RoundPair,
        shape: &Partner,
        touch: &Apart,
        now: f64,
    ) -> Option<Apart> {
        let PairMotion { ahead, is_substep, near, .. } = *self.pair_motion;
        let grazing = self.pair_motion.grazing();
        let gets_deeper = -touch.parting * ahead > DEEPER * grazing;
        if touch.gap <= -grazing || !gets_deeper || !is_substep && now > near {
            return None;
        }
        let at = |time, guess| straight.overlapping(shape, time, guess);
        let meeting = Meeting {
            at: &at,
            closing: &|time, normal| straight.fastest_closing(time, normal),
            dt: ahead,
            touch: 0.0,
            near,
        };
        let from = at(touch.time, touch.normal);
        let near = meeting.grazed(from, grazing)?;
        let is_same = |known: &Apart| near.normal.dot(known.normal) >= SAME_NORMAL;
        if is_same(touch) {
            return None;
        }
        // Later the body may be beside what bears it now.
        Some(if is_same(&from) { from } else { near })
    }

    /// Paths of the body of revolution and of its partner.
    fn paths(&self) -> [&BallisticPath; 2] {
        let [first, second] = self.pair_motion.paths;
        if self.round_is_first { [first, second] } else { [second, first] }
    }

    /// A normal from the second body to the first as one from the partner to the body of
    /// revolution, and back.
    fn seen_by_order(&self, normal: DVec3) -> DVec3 {
        if self.round_is_first { normal } else { -normal }
    }

    /// The body of revolution in the partner's frame at an instant, and both poses.
    fn placed(&self, time: f64) -> (PlacedRevolved, [Pose; 2]) {
        let poses = self.paths().map(|path| path.pose(time));
        let [round, partner] = poses.map(|pose| pose.world_from_body());
        (PlacedRevolved::new(&self.round, &partner.inverse().after(&round)), poses)
    }

    /// Both bodies at an instant; beyond `most` [m] the gap is only known to be larger. Bodies that
    /// overlap have the guess as their normal.
    fn apart(&self, shape: &Partner, (time, most): (f64, f64), guess: DVec3) -> Apart {
        self.seen(time, guess, |round, guess| {
            quick_separation(round, shape, (self.pair_motion.size, most), guess)
        })
    }

    /// Both bodies at an instant, with a flat face's or a round side's normal where they overlap.
    fn overlapping(&self, shape: &Partner, time: f64, guess: DVec3) -> Apart {
        self.seen(time, guess, |round, guess| {
            flat_separation(round, shape, (self.pair_motion.size, self.close), guess)
        })
    }

    fn seen(
        &self,
        time: f64,
        guess: DVec3,
        separation: impl Fn(&PlacedRevolved, DVec3) -> Separation,
    ) -> Apart {
        let (round, poses) = self.placed(time);
        let partner_from_world = poses[1].orientation.conjugate();
        let found = separation(&round, partner_from_world * self.seen_by_order(guess));
        let normal = self.seen_by_order(poses[1].orientation * found.normal);
        Apart { time, gap: found.gap, normal, parting: self.parting(&found, &round, &poses, time) }
    }

    /// Separating speed of the closest points [m/s].
    fn parting(
        &self,
        found: &Separation,
        round: &PlacedRevolved,
        poses: &[Pose; 2],
        time: f64,
    ) -> f64 {
        let at = found.on.map_or_else(|| round.support(-found.normal), |on| on[0]);
        let at = poses[1].world_from_body().point(at - round.rounding * found.normal);
        let [round, partner] = self.paths().map(|path| path.velocity(at, time));
        (round - partner).dot(poses[1].orientation * found.normal)
    }

    /// Upper bound of the closing speed along a normal of any two points, from an instant to the
    /// frame's end [m/s]. Spin about the own axis moves no surface of revolution.
    fn fastest_closing(&self, time: f64, normal: DVec3) -> f64 {
        let [first, second] = self.pair_motion.paths;
        // Common gravity cancels.
        let falling = (second.acceleration - first.acceleration).dot(normal);
        let most = (time * falling).max(self.pair_motion.frame.dt * falling);
        let turning = first.spin_speed + second.spin_speed;
        (second.linear - first.linear).dot(normal) + most + turning
    }

    /// True for a point that can touch within the frame from a separated start.
    fn can_touch(&self, point: &RoundPoint, time: f64) -> bool {
        let gap = point.gap();
        if gap > self.pair_motion.search {
            return false;
        }
        let least = gap.min(0.0) - self.pair_motion.grazing();
        time == 0.0 || self.manifold_point(point, time).gap >= least
    }

    /// At most four points.
    fn few(&self, instant: &Instant, points: &mut Vec<RoundPoint>, scratch: &mut Scratch) {
        if points.len() <= FEW_POINTS {
            return;
        }
        let normal = instant.separation.normal;
        let candidate = |(index, point): (usize, &RoundPoint)| HullPoint {
            on: point.on_surfaces(),
            normal,
            gap: point.gap(),
            feature: Feature::VertexOfFirst(index as u32),
        };
        scratch.points.clear();
        scratch.points.extend(points.iter().enumerate().map(candidate));
        reduce(&mut scratch.points, &mut scratch.spare, FEW_POINTS, (normal, self.close));
        let kept = scratch.points.iter().filter_map(|point| match point.feature {
            Feature::VertexOfFirst(index) => Some(points[index as usize]),
            Feature::VertexOfSecond(_) | Feature::Edges(..) => None,
        });
        *points = kept.collect();
    }

    fn manifold_point(&self, point: &RoundPoint, time: f64) -> ManifoldPoint {
        let poses = self.paths().map(|path| path.pose(time));
        let [world_from_round, world_from_partner] = poses.map(|pose| pose.world_from_body());
        let outward = world_from_partner.direction(point.normal);
        let [of_round, of_partner] = point.anchors;
        let in_world = [of_round, of_partner].map(|held| world_from_partner.point(held.point));
        let anchors = [world_from_round.inverse().point(in_world[0]), of_partner.point];
        let roundings = [of_round.rounding, of_partner.rounding];

        let speeds: [DVec3; 2] = std::array::from_fn(|side| {
            let away = if side == 0 { -roundings[0] } else { roundings[1] };
            self.paths()[side].velocity(in_world[side] + away * outward, time)
        });
        let closing = -(speeds[0] - speeds[1]).dot(outward);
        // Separation along this normal at the frame's start.
        let at_start: [DVec3; 2] = std::array::from_fn(|side| {
            self.paths()[side].start.world_from_body().point(anchors[side])
        });
        let gap = (at_start[0] - at_start[1]).dot(outward) - roundings[0] - roundings[1];
        let normal = self.seen_by_order(outward);
        let gap_then = point.gap();
        let by_order =
            |pair: [DVec3; 2]| if self.round_is_first { pair } else { [pair[1], pair[0]] };
        let [anchor_first, anchor_second] = by_order(anchors);
        ManifoldPoint {
            anchor_first,
            anchor_second,
            rounding: if self.round_is_first { roundings } else { [roundings[1], roundings[0]] },
            normal,
            feature: FeatureId {
                is_of_first: self.round_is_first != is_of_partner(point.id),
                index: point.id,
            },
            approach: self.pair_motion.surface_speed(normal, closing, gap_then),
            gap,
        }
    }
}

#[cfg(test)]
mod tests;
