//! Pairs at rest.

use super::Batch;
use crate::lanes::{Instructions, Lanes3, Single3};
use crate::moving::Movers;

impl<I: Instructions> Batch<I> {
    /// Comes to rest, if its bodies may and none of them is kinematic, and it has points.
    #[inline(always)]
    pub(crate) fn lie_down(&mut self, movers: &Movers) {
        let is_settled = !self.is_driven && !self.looks.any() && !self.rows.is_empty();
        self.rests = is_settled && self.locals.iter().all(|locals| movers.may_rest(locals));
        if self.rests {
            self.locals.iter().for_each(|locals| movers.lie_down(locals));
        }
    }

    /// If it acts on what rests, it has been in balance with that.
    #[inline(always)]
    pub(crate) fn lean(&self, movers: &Movers) {
        if !self.rows.is_empty() && self.locals.iter().any(|locals| movers.any_rests(locals)) {
            self.be_in_balance(movers);
        }
    }

    /// Whether one of its bodies is fast.
    #[inline(always)]
    pub(crate) fn is_stirred(&self, movers: &Movers) -> bool {
        !self.locals.iter().all(|locals| movers.are_quiet(locals))
    }

    /// Acts again.
    #[inline(always)]
    pub(crate) fn get_up(&mut self, movers: &Movers) {
        self.rests = false;
        self.locals.iter().for_each(|locals| movers.get_up(locals));
        self.be_in_balance(movers);
        self.follow_points(movers, None);
    }

    /// What acts here is what its bodies that rest elsewhere are in balance with.
    #[inline(always)]
    fn be_in_balance(&self, movers: &Movers) {
        let given = [self.carried(movers, 0), self.carried(movers, 1)];
        movers.lean(&self.locals[0], given);
        let opposite = given.map(|(j, moment)| (-j, -(moment + self.start_offset.cross(j))));
        movers.lean(&self.locals[1], opposite);
    }

    /// What acts on the first bodies before or after the drift: an impulse, and its moment about where their centres were at the frame's start.
    #[inline(always)]
    fn carried(&self, movers: &Movers, stage: usize) -> (Lanes3<I>, Lanes3<I>) {
        let shift = movers.shifts::<I>(&self.locals[0]).translation;
        let shared = self.shared_basis();
        // As it is given to the bodies: see `Visit::push`.
        let (mut sum, mut moments) = (Single3::ZERO, [Single3::ZERO; 2]);
        for at in 0..self.carrying_rows[stage] {
            let impulse = &self.rows[at].impulses[stage];
            let point = self.point(at, shared);
            let j = point.impulse(impulse.normal, impulse.tangent);
            sum = sum + j;
            for side in 0..2 {
                moments[side] = moments[side] + point.levers[side].cross(j);
                if self.rolls {
                    moments[side] = moments[side] + self.rest.twists[at][stage];
                }
            }
        }
        let sum = sum.double();
        (sum, self.first_moments(sum, moments) + shift.cross(sum))
    }
}
