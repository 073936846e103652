//! One point of contact of each of several pairs, side by side.

use crate::Frame;
use crate::lanes::{Instructions, Lanes, Lanes3, Mask};
use crate::moving::Side;
use crate::warm_start::PointImpulse;
use glam::DVec3;

/// Fastest closing of an overlap [m/s]: a tenth of a metre in a frame, so that deep overlaps part gently [Cat24].
const PUSH_SPEED: f64 = 3.0;

/// The times in a substep at which contact acts.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Stage {
    /// Overlaps begin to close.
    BeforeDrift,
    /// The closing speed is taken out again.
    AfterDrift,
    /// Then, what met fast leaves again.
    Bounce,
}

/// When rows act.
#[derive(Clone, Copy)]
pub(crate) struct Beat {
    pub(crate) stage: Stage,
    /// Of the substep [s].
    pub(crate) dt: f64,
    /// What gravity gave since the state whose energy counts, to what falls [m/s].
    pub(crate) kick: DVec3,
}

/// A point of contact of each pair.
#[derive(Clone)]
pub(crate) struct Row<I> {
    /// Which lanes have one.
    pub(crate) is_there: Mask,
    /// Unit, world frame, from the second body to the first.
    pub(crate) normal: Lanes3<I>,
    /// From the centres of mass to the point [m]: one point for both bodies, so that angular momentum is exact.
    pub(crate) levers: [Lanes3<I>; 2],
    /// What static and kinematic bodies add to the velocity of the first body's material less the second's [m/s].
    pub(crate) drive: Lanes3<I>,
    /// Between the surfaces, along the normal [m].
    pub(crate) gap: Lanes<I>,
    /// Change of the speed along the normal per impulse along it [1/kg], and its inverse; the latter is 0 where there is no point.
    pub(crate) answer: Lanes<I>,
    /// See `answer` [kg].
    pub(crate) mass: Lanes<I>,
    /// Of this substep, before and after the drift.
    pub(crate) impulses: [RowImpulse<I>; 2],
    /// Whether the surfaces have met, and at which speed [m/s].
    pub(crate) has_met: Mask,
    /// See `has_met`.
    pub(crate) met_at: Lanes<I>,
    /// Whether it still has to bounce.
    pub(crate) bounces: Mask,
    /// Whether it has acted.
    pub(crate) touched: Mask,
}

/// What acts at the points of a row.
#[derive(Clone, Copy)]
pub(crate) struct RowImpulse<I> {
    /// Along the normal, not negative [N s].
    pub(crate) normal: Lanes<I>,
    /// Across it [N s].
    pub(crate) tangent: Lanes3<I>,
    /// Of rolling and spinning friction [N m s].
    pub(crate) twist: Lanes3<I>,
}

impl Stage {
    /// Which of a row's impulses are its own.
    pub(crate) fn at(self) -> usize {
        usize::from(self != Self::BeforeDrift)
    }
}

impl Beat {
    /// An impulse in the middle of gravity's kick works against what gravity will do, too.
    pub(crate) fn new(stage: Stage, step: &Frame) -> Self {
        let kick = if stage == Stage::BeforeDrift { 0.5 * step.dt * step.gravity } else { DVec3::ZERO };
        Self { stage, dt: step.dt, kick }
    }
}

impl<I: Instructions> Row<I> {
    pub(crate) fn empty() -> Self {
        Self {
            is_there: Mask::NONE,
            normal: Lanes3::ZERO,
            levers: [Lanes3::ZERO; 2],
            drive: Lanes3::ZERO,
            gap: Lanes::ZERO,
            answer: Lanes::ZERO,
            mass: Lanes::ZERO,
            impulses: [RowImpulse::ZERO; 2],
            has_met: Mask::NONE,
            met_at: Lanes::ZERO,
            bounces: Mask::NONE,
            touched: Mask::NONE,
        }
    }

    /// Takes a lane's point out.
    pub(crate) fn clear(&mut self, lane: usize) {
        self.is_there.set(lane, false);
        self.normal.set(lane, DVec3::ZERO);
        self.has_met.set(lane, false);
        self.bounces.set(lane, false);
        self.touched.set(lane, false);
        self.impulses.iter_mut().for_each(|impulse| impulse.clear(lane));
    }

    pub(crate) fn impulses_of(&self, lane: usize) -> [PointImpulse; 2] {
        self.impulses.map(|impulse| PointImpulse {
            normal: impulse.normal.get(lane),
            tangent: impulse.tangent.get(lane),
            twist: impulse.twist.get(lane),
        })
    }

    #[inline(always)]
    pub(crate) fn relative_velocity(&self, sides: &[Side<I>; 2]) -> Lanes3<I> {
        sides[0].at(self.levers[0]) - sides[1].at(self.levers[1]) + self.drive
    }

    #[inline(always)]
    pub(crate) fn push(&self, sides: &mut [Side<I>; 2], impulse: Lanes3<I>) {
        sides[0].push(self.levers[0], impulse);
        sides[1].push(self.levers[1], -impulse);
    }

    /// What no longer meets within a substep of `dt` [s] has nothing to go on from.
    #[inline(always)]
    pub(crate) fn forget_if_parted(&mut self, stage: Stage, sides: &[Side<I>; 2], dt: f64) {
        let closing = -self.relative_velocity(sides).dot(self.normal);
        let parts = self.gap.above(closing.max(Lanes::ZERO) * Lanes::splat(dt));
        if parts.any() {
            let impulse = &mut self.impulses[stage.at()];
            impulse.normal = parts.select(Lanes::ZERO, impulse.normal);
            impulse.tangent = parts.select3(Lanes3::ZERO, impulse.tangent);
            impulse.twist = parts.select3(Lanes3::ZERO, impulse.twist);
        }
    }

    /// The rows of pairs that act at a stage: what has not met yet is stopped before the next drift, where it meets.
    #[inline(always)]
    pub(crate) fn acts(&self, beat: &Beat) -> Mask {
        if beat.stage == Stage::BeforeDrift { self.is_there } else { self.is_there.and(self.has_met) }
    }

    /// Overlaps before the drift: they are soft.
    #[inline(always)]
    pub(crate) fn softens(&self, beat: &Beat) -> Mask {
        if beat.stage == Stage::BeforeDrift { self.gap.above(Lanes::ZERO).not() } else { Mask::NONE }
    }

    /// Speed at which the surfaces are to separate [m/s]; negative if they may approach.
    #[inline(always)]
    pub(crate) fn target_speed(&self, rate: Lanes<I>, beat: &Beat) -> Lanes<I> {
        let closing =
            self.softens(beat).select((-(rate * self.gap)).min(Lanes::splat(PUSH_SPEED)), Lanes::ZERO);
        self.gap.above(Lanes::ZERO).select(-self.gap * Lanes::splat(1.0 / beat.dt), closing)
    }
}

impl<I: Instructions> RowImpulse<I> {
    pub(crate) const ZERO: Self = Self { normal: Lanes::ZERO, tangent: Lanes3::ZERO, twist: Lanes3::ZERO };

    pub(crate) fn clear(&mut self, lane: usize) {
        self.normal.set(lane, 0.0);
        self.tangent.set(lane, DVec3::ZERO);
        self.twist.set(lane, DVec3::ZERO);
    }
}
