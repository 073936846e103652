//! Points of pairs that have moved too far since theirs were found, found anew.

use super::points::NewPoints;
use super::{Anew, Batch};
use crate::detection::{moved_since, second_from_first};
use crate::encounter::Encounter;
use crate::flight::Flight;
use crate::lanes::Instructions;
use crate::manifold::{ManifoldFinder, ManifoldPoint};
use crate::moving::Movers;
use crate::warm_start::{Carried, Part, PointImpulse, WarmStart};
use crate::{Bodies, Frame};
use glam::DVec3;

/// Relative motion after which a pair's points are found anew, relative to the size of the smaller body: within it a curved
/// surface's normal turns by no more than some degrees.
pub(crate) const STALE: f64 = 0.1;

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
        let mut is_changed = false;
        for lane in 0..self.rest.patches.len() {
            let locals = [self.locals[0][lane], self.locals[1][lane]];
            let patch = &self.rest.patches[lane];
            if movers.travel(locals) - patch.travel <= STALE * patch.size {
                continue;
            }
            let pair = patch.pair;
            let flights = [(pair.first, locals[0]), (pair.second, locals[1])].map(|(i, local)| {
                let (pose, velocity) = movers.state(bodies, local);
                Flight::from(bodies, i, (pose, &velocity), rest)
            });
            let encounter = Encounter::new(bodies, pair, [&flights[0], &flights[1]], rest);
            let found_at = match &patch.anew {
                Some(anew) => anew.found_at,
                None => movers.start_second_from_first(locals),
            };
            let [first, second] = encounter.placed();
            if moved_since(&found_at, first, second, 0.0) > STALE * patch.size {
                self.find_anew(lane, movers, finder, &encounter);
                is_changed = true;
            }
            self.rest.patches[lane].travel = movers.travel(locals);
        }
        is_changed
    }

    fn find_anew(
        &mut self,
        lane: usize,
        movers: &Movers,
        finder: &mut ManifoldFinder,
        encounter: &Encounter,
    ) {
        let Encounter { bodies, pair, .. } = *encounter;
        let [first, second] = encounter.placed();
        let point = self.last_point(movers, lane);
        let mut taken = Vec::new();
        I::run(
            #[inline(always)]
            || self.take(lane, &mut taken),
        );
        let patch = &mut self.rest.patches[lane];
        patch.anew = Some(Box::new(Anew { found_at: second_from_first(first, second), point }));
        patch.touched |= taken.iter().any(|taken| taken.touched);

        let mut carried = Part::default();
        let touched = taken.iter().filter(|taken| taken.touched);
        carried.points.extend(touched.map(|taken| Carried { sample: taken.sample, forces: taken.impulses }));
        carried.end_pair(0, pair.ids(bodies));
        let manifold = finder.of_encounter(encounter, &WarmStart::of_parts(1, vec![carried]));
        let points = manifold.map(|manifold| manifold.points).unwrap_or_default();
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
            let (row, anchors) = (&mut self.rows[at], &self.rest.anchors[at]);
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
        for (at, point) in points.iter().enumerate() {
            let same = taken.iter().find(|taken| taken.sample == point.sample);
            let mut new = NewPoints::NONE;
            new.add(lane, point, same.map_or([PointImpulse::ZERO; 2], |same| same.impulses));
            self.place(at, &new, &starts);
            if let Some(same) = same {
                let row = &mut self.rows[at];
                row.has_met.set(lane, same.met_at.is_some());
                row.touched.set(lane, same.touched);
                self.rest.anchors[at].met_at.set(lane, same.met_at.unwrap_or(0.0));
            }
        }
        self.soften();
    }
}
