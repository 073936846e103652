//! Points of pairs that have moved too far since theirs were found, found anew.

use super::points::NewPoints;
use super::{Anew, Batch, WARY};
use crate::detection::{Placed, moved_between, second_from_first};
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::hull_contact::least_height;
use crate::lanes::{Instructions, LANES, Mask};
use crate::manifold::{ManifoldFinder, ManifoldPoint, Solid};
use crate::moving::Movers;
use crate::warm_start::PointImpulse;
use crate::{Bodies, Frame, Motion, Pose};
use frangible_geometry::Hull;
use glam::DVec3;

/// Relative motion after which a pair's points are found anew, relative to the size of the smaller body: within it a curved
/// surface's normal turns by no more than some degrees.
pub(crate) const STALE: f64 = 0.12;

/// The same of polyhedra with more than one point in heaps. While `pile-deep` falls together, many of its pairs would find theirs anew in each substep: it takes 0.9 of the time with this, in the
/// mean, and its overlaps are a thirtieth deeper at the end, in the median.
pub(crate) const STALE_IN_HEAPS: f64 = 0.2;

/// A point that was taken out of a lane.
struct Taken {
    sample: (bool, u64),
    impulses: [PointImpulse; 2],
    met_at: Option<f64>,
    touched: bool,
}

impl<I: Instructions> Batch<I> {
    /// Finds the points of pairs anew that have moved too far since they were found; those that are the same go on. `rest` is what is
    /// left of the frame. Returns whether there were any: their rows have yet to follow.
    pub(crate) fn refresh(
        &mut self,
        (bodies, movers): (&Bodies, &Movers),
        finder: &mut ManifoldFinder,
        rest: &Frame,
    ) -> bool {
        let looks = if self.is_driven { Mask::of(|_| true) } else { self.looks };
        let (lanes, mut is_changed) = (self.rest.patches.len(), false);
        for lane in (0..lanes).filter(|&lane| looks.get(lane)) {
            let locals = [self.locals[0][lane], self.locals[1][lane]];
            let (travel, patch) = (movers.travel(locals), &self.rest.patches[lane]);
            if travel <= self.look_at.get(lane) {
                continue;
            }
            let (pair, struck) = (patch.pair, patch.struck);
            let shapes = [pair.first, pair.second].map(|i| &bodies.shapes[i]);
            let poses = locals.map(|local| movers.pose(local));
            let found_at = match &patch.anew {
                Some(anew) => anew.found_at,
                None => movers.start_second_from_first(locals),
            };
            let placed = [0, 1].map(|side| Placed { shape: shapes[side], pose: &poses[side] });
            let mut rests_for = patch.rests_for();
            let radii = [pair.first, pair.second].map(|i| bodies.radii[i]);
            let now = second_from_first(placed[0], placed[1]);
            if patch.is_watched || moved_between(&found_at, &now, radii, 0.0) > rests_for {
                let apart = self.apart_for(lane, (bodies, movers), placed, travel);
                if apart > 0.0 {
                    rests_for = apart;
                } else {
                    // Only now do rows that are far need to be where they are.
                    self.let_all_follow(movers);
                    let flights = [(pair.first, 0), (pair.second, 1)].map(|(i, side)| {
                        let (pose, velocity) = movers.state(bodies, locals[side]);
                        Flight::from(bodies, i, (pose, &velocity), rest)
                    });
                    let encounter =
                        Encounter::new(bodies, pair, [&flights[0], &flights[1]], rest).struck(struck);
                    self.find_anew(lane, movers, finder, &encounter);
                    rests_for = self.rest.patches[lane].rests_for();
                    is_changed = true;
                }
            }
            self.look_at.set(lane, travel + rests_for);
        }
        is_changed
    }

    /// Whether [`Self::refresh`] may find any.
    #[inline(always)]
    pub(crate) fn may_be_stale(&self) -> bool {
        self.is_driven || self.looks.any()
    }

    /// Asks for what [`Self::refresh`] will need of pairs that may have moved too far.
    #[inline(always)]
    pub(crate) fn prefetch_to_refresh(&self, movers: &Movers) {
        self.prefetch(movers, self.near_rows);
        I::prefetch(&self.rest.patches);
        for lane in (0..LANES).filter(|&lane| self.looks.get(lane)) {
            movers.prefetch_paths::<I>([self.locals[0][lane], self.locals[1][lane]]);
        }
    }

    /// How far two bodies can travel until they, or their points, could meet within a substep, after so much `travel` [m]: as far as they are apart
    /// along the normal of their points, or of their centres if they have none. Not positive if they could now.
    fn apart_for(
        &self,
        lane: usize,
        (bodies, movers): (&Bodies, &Movers),
        placed: [Placed; 2],
        travel: f64,
    ) -> f64 {
        let (mut normal, mut nearest) = (None, f64::INFINITY);
        for (at, row) in self.rows.iter().enumerate().filter(|(_, row)| row.is_there.get(lane)) {
            normal = normal.or_else(|| Some(self.basis(at, self.shared_basis()).normal.get(lane)));
            if at < self.near_rows {
                nearest = nearest.min(row.gap.get(lane));
            }
        }
        // Rows behind those have not followed: their gaps have changed by no more than their bodies have travelled.
        if let Some(far) = self.anchors.get(self.near_rows) {
            nearest = nearest.min(far.reach.get(lane) - travel);
        }
        if nearest <= 0.0 {
            return 0.0;
        }

        let pair = self.rest.patches[lane].pair;
        let motion = |side: usize, i: usize| match bodies.motions[i] {
            Motion::Kinematic { linear, angular } => (linear, angular),
            Motion::Static | Motion::Dynamic => movers.rates(self.locals[side][lane]),
        };
        let [(from, from_spin), (to, to_spin)] = [motion(0, pair.first), motion(1, pair.second)];
        let [radius, other_radius] = self.sizes.map(|size| size.get(lane));
        let [pose, other_pose] = placed.map(|placed| placed.pose);
        let between = pose.position - other_pose.position;
        let closing_along = |normal: DVec3| (to - from).dot(normal);

        // No point of theirs is nearer, even along another normal.
        let (apart, closing) = match placed.map(|placed| Solid::of(placed.shape)) {
            [Solid::Hull(hull), Solid::Hull(other)] => {
                let normal = normal.unwrap_or_else(|| between.normalize_or_zero());
                let turning =
                    from_spin.cross(normal).length() * radius + to_spin.cross(normal).length() * other_radius;
                (
                    apart_along::<I>([hull, other], [pose, other_pose], normal).min(nearest),
                    closing_along(normal) + turning,
                )
            }
            _ if radius == 0.0 || other_radius == 0.0 => return 0.0,
            // Balls around them are no nearer as they turn.
            _ => (
                (between.length() - radius - other_radius).min(nearest),
                closing_along(between.normalize_or_zero()),
            ),
        };
        apart - (WARY * closing.max(0.0) + self.rest.patches[lane].struck) * self.dt
    }

    fn find_anew(
        &mut self,
        lane: usize,
        movers: &Movers,
        finder: &mut ManifoldFinder,
        encounter: &Encounter,
    ) {
        let [first, second] = encounter.placed();
        let point = self.last_point(movers, lane);
        let mut taken = Vec::with_capacity(self.rows.len());
        I::run(
            #[inline(always)]
            || self.take(lane, &mut taken),
        );
        let patch = &mut self.rest.patches[lane];
        patch.anew = Some(Box::new(Anew { found_at: second_from_first(first, second), point }));
        patch.is_watched = false;
        patch.touched |= taken.iter().any(|taken| taken.touched);

        let has_carried = |sample| taken.iter().any(|taken| taken.touched && taken.sample == sample);
        let manifold = finder.of_encounter(encounter, has_carried);
        let points = manifold.map(|manifold| manifold.points).unwrap_or_default();
        self.rest.patches[lane].has_few = points.len() <= 1;
        I::run(
            #[inline(always)]
            || self.put_back(lane, movers, points, &taken),
        );
    }

    /// Empties a lane; what it held.
    #[inline(always)]
    fn take(&mut self, lane: usize, taken: &mut Vec<Taken>) {
        for at in 0..self.rows.len() {
            if !self.rows[at].is_there.get(lane) {
                continue;
            }
            let impulses = self.impulses_of(at, lane, (&self.lines(at, 1.0), 1.0));
            let (row, anchors) = (&mut self.rows[at], &self.anchors[at]);
            let met_at = row.has_met.get(lane).then_some(anchors.met_at.get(lane));
            let touched = row.touched.get(lane);
            taken.push(Taken { sample: anchors.sample(lane), impulses, met_at, touched });
            row.clear(lane);
            if self.rolls {
                self.rest.twists[at].iter_mut().for_each(|twist| twist.set(lane, DVec3::ZERO));
            }
        }
    }

    /// Puts points into an empty lane; those that were taken out of it go on as they were.
    #[inline(always)]
    fn put_back(&mut self, lane: usize, movers: &Movers, points: &[ManifoldPoint], taken: &[Taken]) {
        let starts = self.starts(movers);
        self.make_room(points.len());
        for (at, point) in points.iter().enumerate() {
            let same = taken.iter().find(|taken| taken.sample == point.sample);
            let mut new = NewPoints::none(1.0);
            new.add(lane, point, same.map(|same| &same.impulses));
            self.place(at, &new, &starts);
            if let Some(same) = same {
                let row = &mut self.rows[at];
                row.has_met.set(lane, same.met_at.is_some());
                row.touched.set(lane, same.touched);
                self.anchors[at].met_at.set(lane, same.met_at.unwrap_or(0.0));
            }
        }
        self.soften();
        self.find_reach();
        self.forget_who_acts();
    }
}

/// A lower bound of the distance of two hulls [m], along a normal in the world frame, to single precision; if it is negative, it says nothing.
fn apart_along<I: Instructions>(hulls: [&Hull; 2], poses: [&Pose; 2], normal: DVec3) -> f64 {
    let lowest = |side: usize, up: DVec3| {
        least_height::<I>(hulls[side].columns(), poses[side].orientation.conjugate() * up)
    };
    (poses[0].position - poses[1].position).dot(normal) + lowest(0, normal) + lowest(1, -normal)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instructions::Scalar;
    use glam::DQuat;

    /// Along the axis between two cubes it is their distance, and along none is it more; what overlaps is apart along none.
    #[test]
    fn hulls_are_no_further_apart_along_a_normal_than_they_are() {
        let cube = Hull::cuboid(DVec3::splat(0.5));
        let turn = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_4);
        let at = |height: f64, orientation| Pose { position: height * DVec3::Y, orientation };
        let corner = std::f64::consts::FRAC_1_SQRT_2;
        for (height, distance) in [(2.0, 1.5 - corner), (0.8, 0.3 - corner)] {
            let poses = [&at(height, turn), &at(0.0, DQuat::IDENTITY)];
            let apart = |normal: DVec3| apart_along::<Scalar>([&cube, &cube], poses, normal);
            assert!((apart(DVec3::Y) - distance).abs() < 1e-6);
            for step in 0..64 {
                let (sine, cosine) = libm::sincos(0.1 * f64::from(step));
                assert!(apart(DVec3::new(0.0, cosine, sine)) <= distance.max(0.0) + 1e-6, "{step}");
            }
        }
    }
}
