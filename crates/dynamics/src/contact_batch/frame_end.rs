//! What is left of a batch at the frame's end: what its points carried, and what its pairs owe.

use super::Batch;
use crate::Bodies;
use crate::contact_rows::{Basis, RowImpulse};
use crate::lanes::{Instructions, LANES, Lanes, Mask, Single, Single3, Singles};
use crate::moving::Movers;
use crate::tally::{Debt, Tally};
use crate::warm_start::{Carried, Part, PointImpulse};
use glam::{DVec3, Vec3};

/// What acts at the points of a row, a line for each lane.
pub(crate) type Lines = [Singles; LANES];

impl<I: Instructions> Batch<I> {
    /// What its pairs carried, and their books. `room` is for the lines of its rows.
    #[inline(always)]
    pub(crate) fn end_frame(
        &self,
        (bodies, movers): (&Bodies, &Movers),
        room: &mut Vec<Lines>,
        (kept, tally): (&mut Part, &mut Tally),
    ) {
        self.book_work(bodies, tally);
        let by = 1.0 / self.dt;
        let mut touched = Mask::NONE;
        room.clear();
        for at in 0..self.rows.len() {
            touched = touched.or(self.rows[at].touched);
            room.push(self.lines(at, by));
        }
        let owes = self.given.above(Lanes::ZERO);
        for (lane, patch) in self.rest.patches.iter().enumerate() {
            // Its points that acted.
            for (at, row) in self.rows.iter().enumerate() {
                if row.is_there.get(lane) && row.touched.get(lane) {
                    let forces = self.impulses_of(at, lane, (&room[at], by));
                    kept.points.push(Carried { sample: self.anchors[at].sample(lane), forces });
                }
            }
            kept.end_pair(patch.manifold, patch.pair);

            // What it gave in all, if anything, is to be paid back where its first point acts.
            if patch.touched || touched.get(lane) || owes.get(lane) {
                tally.link(bodies, patch.pair);
            }
            let energy = self.given.get(lane);
            if energy != 0.0 {
                tally.given.push((patch.pair, energy));
            }
            if owes.get(lane) {
                let point = self.last_point(movers, lane);
                tally.debts.push(Debt { ids: patch.pair.ids(bodies), point, energy, net: 0.0 });
            }
        }
    }

    /// How many points it has that acted.
    pub(crate) fn carried_points(&self) -> usize {
        self.rows.iter().map(|row| row.is_there.and(row.touched).count() as usize).sum()
    }

    /// So many times what acts at the points of a row, a line for each lane: the part along the normal, and all of it as a vector in the world, before and after
    /// the drift.
    #[inline(always)]
    pub(super) fn lines(&self, at: usize, by: f64) -> Lines {
        let basis = self.directions.of(at).basis();
        let [before, after] = &self.rows[at].impulses;
        let ([n, x, y, z], [later_n, tx, ty, tz]) = (before.in_world(&basis, by), after.in_world(&basis, by));
        Single::rows([n, x, y, z, later_n, tx, ty, tz])
    }

    /// So many times what acts at a point, by the lines of its row, which are as many times that.
    #[inline(always)]
    pub(super) fn impulses_of(
        &self,
        at: usize,
        lane: usize,
        (lines, by): (&Lines, f64),
    ) -> [PointImpulse; 2] {
        let Singles([n, x, y, z, later_n, tx, ty, tz]) = lines[lane];
        let twist = |stage: usize| match self.rest.twists.get(at) {
            Some(twists) => by as f32 * twists[stage].get(lane).as_vec3(),
            None => Vec3::ZERO,
        };
        [
            PointImpulse { normal: n, force: Vec3::new(x, y, z), twist: twist(0) },
            PointImpulse { normal: later_n, force: Vec3::new(tx, ty, tz), twist: twist(1) },
        ]
    }

    /// Books what kinematic bodies did.
    fn book_work(&self, bodies: &Bodies, tally: &mut Tally) {
        if self.is_driven {
            for (lane, patch) in self.rest.patches.iter().enumerate() {
                let pair = patch.pair;
                let is_on_first = bodies.inertias[pair.second].is_infinite();
                let [on, by] =
                    if is_on_first { [pair.first, pair.second] } else { [pair.second, pair.first] };
                tally.book_outside(bodies, [on, by], (DVec3::ZERO, DVec3::ZERO), self.rest.work.get(lane));
            }
        }
    }
}

impl<I: Instructions> RowImpulse<I> {
    /// So many times what acts: the part along the normal, and all of it as a vector in the world.
    #[inline(always)]
    fn in_world(&self, basis: &Basis<I>, by: f64) -> [Single<I>; 4] {
        let by = Single::splat(by);
        let Single3 { x, y, z } = basis.in_world(self.normal, self.tangent);
        [self.normal * by, x * by, y * by, z * by]
    }
}
