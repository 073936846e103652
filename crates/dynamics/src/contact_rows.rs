//! One point of contact of each of several pairs, side by side, in single precision.

use crate::Frame;
use crate::lanes::{Instructions, Mask, Single, Single3, Symmetric};
use crate::moving::{Rates, Sides};
use glam::DVec3;

/// Fastest closing of an overlap [m/s]: a tenth of a metre in a frame, so that deep overlaps part gently [Cat24].
const PUSH_SPEED: f64 = 3.0;

/// The times in a substep at which contact acts.
#[derive(Clone, Copy, PartialEq)]
pub(crate) enum Stage {
    /// Overlaps begin to close.
    BeforeDrift,
    /// What met fast leaves again.
    Bounce,
    /// The closing speed is taken out again.
    AfterDrift,
}

/// When rows act.
#[derive(Clone, Copy)]
pub(crate) struct Beat {
    pub(crate) stage: Stage,
    /// Of the substep [s].
    pub(crate) dt: f64,
    /// What gravity gave since the state whose energy counts, to what falls [m/s].
    pub(crate) kick: DVec3,
    /// Of the speed at which overlaps close, so much is paid for [1].
    pub(crate) parting: f64,
}

/// A point of contact of each pair, as it is kept: a heap is as fast as its rows come from memory.
#[derive(Clone)]
pub(crate) struct Row<I> {
    /// From the first bodies' centres of mass to the point [m].
    pub(crate) lever: Single3<I>,
    /// Between the surfaces, along the normal [m].
    pub(crate) gap: Single<I>,
    pub(crate) response: Response<I>,
    /// Of this substep, before and after the drift.
    pub(crate) impulses: [RowImpulse<I>; 2],
    /// Which lanes have one.
    pub(crate) is_there: Mask,
    /// Whether the surfaces have met.
    pub(crate) has_met: Mask,
    /// Whether it has met fast in this substep.
    pub(crate) bounces: Mask,
    /// Whether it takes part in the impact that acts now.
    pub(crate) impacts: Mask,
    /// Whether it has acted.
    pub(crate) touched: Mask,
}

/// How the relative velocity at a point answers impulses there. All masses are 0 where there is no point.
#[derive(Clone, Copy)]
pub(crate) struct Response<I> {
    /// Its change along the normal and the two tangents per impulse along the normal [1/kg].
    pub(crate) to_normal: Single3<I>,
    /// Inverse of the first [kg].
    pub(crate) mass: Single<I>,
    /// Inverse of its change along the tangents per impulse along them, a symmetric matrix: entries 11, 22 and 12 [kg].
    pub(crate) slip_mass: Single3<I>,
    /// The least mass that it shows to any tangent impulse [kg].
    pub(crate) least_slip_mass: Single<I>,
}

/// What acts at the points of a row.
#[derive(Clone, Copy)]
pub(crate) struct RowImpulse<I> {
    /// Along the normal, not negative [N s].
    pub(crate) normal: Single<I>,
    /// Along the two tangents [N s].
    pub(crate) tangent: [Single<I>; 2],
}

/// Directions of contact, as they are kept.
#[derive(Clone, Copy)]
pub(crate) struct Directions<I> {
    /// Unit, world frame, from the second body to the first.
    pub(crate) normal: Single3<I>,
    /// One of the two tangents.
    pub(crate) tangent: Single3<I>,
}

/// Directions of contact of some rows, as they are kept.
pub(crate) enum RowDirections<I> {
    /// All rows have the same ones, as long as all points of each pair have.
    Shared(Directions<I>),
    /// Of each row.
    Each(Vec<Directions<I>>),
}

/// Directions of contact.
#[derive(Clone, Copy)]
pub(crate) struct Basis<I> {
    /// Unit, world frame, from the second body to the first.
    pub(crate) normal: Single3<I>,
    /// Across it and each other.
    pub(crate) tangents: [Single3<I>; 2],
}

/// A point of contact of each pair, as it acts.
#[derive(Clone, Copy)]
pub(crate) struct Point<I> {
    pub(crate) basis: Basis<I>,
    /// From the centres of mass to the point [m]. It is one point for both bodies; that angular momentum is exact is [`Batch::give_exactly`](crate::contact_batch::Batch::give_exactly)'s work.
    pub(crate) levers: [Single3<I>; 2],
    /// What static and kinematic bodies add to the velocity of the first body's material less the second's, if they move [m/s].
    pub(crate) drive: Option<Single3<I>>,
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
        Self { stage, dt: step.dt, kick, parting: 1.0 }
    }
}

impl<I: Instructions> Row<I> {
    pub(crate) fn empty() -> Self {
        Self {
            lever: Single3::ZERO,
            gap: Single::ZERO,
            response: Response::NONE,
            impulses: [RowImpulse::ZERO; 2],
            is_there: Mask::NONE,
            has_met: Mask::NONE,
            bounces: Mask::NONE,
            impacts: Mask::NONE,
            touched: Mask::NONE,
        }
    }

    /// Takes a lane's point out.
    pub(crate) fn clear(&mut self, lane: usize) {
        self.is_there.set(lane, false);
        self.has_met.set(lane, false);
        self.bounces.set(lane, false);
        self.touched.set(lane, false);
        self.impulses.iter_mut().for_each(|impulse| impulse.clear(lane));
    }

    /// What no longer meets, at a `closing` speed [m/s], within a substep of `dt` [s] has nothing to go on from. Says where that is.
    #[inline(always)]
    pub(crate) fn forget_if_parted(&mut self, stage: Stage, closing: Single<I>, dt: f64) -> Mask {
        let parts = self.gap.above(closing.max(Single::ZERO) * Single::splat(dt));
        if parts.any() {
            let impulse = &mut self.impulses[stage.at()];
            impulse.normal = parts.select(Single::ZERO, impulse.normal);
            for tangent in &mut impulse.tangent {
                *tangent = parts.select(Single::ZERO, *tangent);
            }
        }
        parts
    }

    /// The rows of pairs that act at a stage: what has not met yet is stopped before the next drift, where it meets.
    #[inline(always)]
    pub(crate) fn acts(&self, beat: &Beat) -> Mask {
        if beat.stage == Stage::BeforeDrift { self.is_there } else { self.is_there.and(self.has_met) }
    }

    /// Those that meet fast at a stage.
    #[inline(always)]
    pub(crate) fn meets(&self, beat: &Beat) -> Mask {
        if beat.stage == Stage::Bounce { self.impacts } else { self.bounces }
    }

    /// Speed at which the surfaces are to separate [m/s], negative if they may approach; and where they overlap before the drift: such
    /// points are soft.
    #[inline(always)]
    pub(crate) fn target_speed(&self, rate: Single<I>, beat: &Beat) -> (Single<I>, Mask) {
        let gap = self.gap;
        let is_open = gap.above(Single::ZERO);
        let softens = if beat.stage == Stage::BeforeDrift { is_open.not() } else { Mask::NONE };
        let closing = softens.select(closing_speed(gap, rate) * Single::splat(beat.parting), Single::ZERO);
        (is_open.select(-gap * Single::splat(1.0 / beat.dt), closing), softens)
    }
}

/// Speed at which an overlap closes if that is paid for, negative where there is none [m/s].
#[inline(always)]
pub(crate) fn closing_speed<I: Instructions>(gap: Single<I>, rate: Single<I>) -> Single<I> {
    (-(rate * gap)).min(Single::splat(PUSH_SPEED))
}

impl<I: Instructions> Point<I> {
    #[inline(always)]
    pub(crate) fn relative_velocity(&self, rates: &Rates<I>) -> Single3<I> {
        let [lever, other_lever] = self.levers;
        let velocity = rates.apart + rates.spins[0].cross(lever) - rates.spins[1].cross(other_lever);
        match self.drive {
            Some(drive) => velocity + drive,
            None => velocity,
        }
    }

    #[inline(always)]
    pub(crate) fn closing(&self, rates: &Rates<I>) -> Single<I> {
        -self.relative_velocity(rates).dot(self.basis.normal)
    }

    /// How it answers, where there is a point.
    #[inline(always)]
    pub(crate) fn response(&self, sides: &Sides<I>, is_there: Mask) -> Response<I> {
        let of_first = self.answer(&sides.inverse_tensors[0], self.levers[0]);
        let of_second = self.answer(&sides.inverse_tensors[1], self.levers[1]);
        let (one, linear) = (Single::splat(1.0), sides.inverse_mass);
        let to_normal = of_first.0 + of_second.0 + Single3 { x: linear, y: Single::ZERO, z: Single::ZERO };
        let across = of_first.1 + of_second.1;
        let (tt, bb, tb) = (across.x + linear, across.y + linear, across.z);

        // The inverse of two by two, and its eigenvalues.
        let (mean, half) = ((tt + bb) * Single::splat(0.5), (tt - bb) * Single::splat(0.5));
        let most = mean + (half * half + tb * tb).sqrt();
        let least_mass = one / most;
        let (tt, bb, tb) = (tt * least_mass, bb * least_mass, tb * least_mass);
        let area = tt * bb - tb * tb;
        let inverse = least_mass / area;
        let is_round = (area * Single::splat(MOST_ELONGATED)).above(one);
        let across = Single3 { x: bb * inverse, y: tt * inverse, z: -(tb * inverse) };
        let around = Single3 { x: least_mass, y: least_mass, z: Single::ZERO };
        let slip_mass = is_there.select(is_round.select(across, around), Single3::ZERO);
        Response {
            to_normal,
            mass: is_there.select(one / to_normal.x, Single::ZERO),
            slip_mass,
            least_slip_mass: is_there.select(least_mass, Single::ZERO),
        }
    }

    /// What the turning of one side adds to the change of the velocity: per impulse along the normal, along it and the tangents; and per impulse along
    /// the tangents, entries 11, 22 and 12 [1/kg].
    #[inline(always)]
    fn answer(&self, inverse_tensor: &Symmetric<Single<I>>, lever: Single3<I>) -> (Single3<I>, Single3<I>) {
        let Basis { normal: n, tangents: [t, b] } = self.basis;
        let (about_n, about_t, about_b) = (lever.cross(n), lever.cross(t), lever.cross(b));
        let (by_n, by_t) = (*inverse_tensor * about_n, *inverse_tensor * about_t);
        let by_b = *inverse_tensor * about_b;
        let to_normal = Single3 { x: by_n.dot(about_n), y: by_n.dot(about_t), z: by_n.dot(about_b) };
        let across = Single3 { x: by_t.dot(about_t), y: by_b.dot(about_b), z: by_t.dot(about_b) };
        (to_normal, across)
    }

    /// An impulse along the normal and the two tangents, in the world.
    #[inline(always)]
    pub(crate) fn impulse(&self, normal: Single<I>, tangent: [Single<I>; 2]) -> Single3<I> {
        self.basis.in_world(normal, tangent)
    }
}

impl<I: Instructions> Basis<I> {
    /// What is so much along the normal and the two tangents.
    #[inline(always)]
    pub(crate) fn in_world(&self, normal: Single<I>, tangent: [Single<I>; 2]) -> Single3<I> {
        let Self { normal: n, tangents: [t, b] } = *self;
        n * normal + t * tangent[0] + b * tangent[1]
    }
}

/// Ratio of the masses that a point shows to two tangent impulses, from which on one of them stands for both [1]: in single precision
/// their matrix has lost the other.
const MOST_ELONGATED: f64 = 1e4;

impl<I: Instructions> Directions<I> {
    pub(crate) const NONE: Self = Self { normal: Single3::ZERO, tangent: Single3::ZERO };

    #[inline(always)]
    pub(crate) fn basis(&self) -> Basis<I> {
        let Self { normal, tangent } = *self;
        Basis { normal, tangents: [tangent, normal.cross(tangent)] }
    }

    /// The same, but others in some lanes.
    #[inline(always)]
    fn but(&self, lanes: Mask, other: Self) -> Self {
        Self { normal: self.normal.but(lanes, other.normal), tangent: self.tangent.but(lanes, other.tangent) }
    }
}

impl<I: Instructions> RowDirections<I> {
    /// Asks for them.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        if let Self::Each(each) = self {
            I::prefetch(each);
        }
    }

    /// Those of a row.
    #[inline(always)]
    pub(crate) fn of(&self, row: usize) -> &Directions<I> {
        match self {
            Self::Shared(shared) => shared,
            Self::Each(each) => &each[row],
        }
    }

    /// Gives some lanes of a row, of so many, other ones; first to a lane's first row.
    #[inline(always)]
    pub(crate) fn set(&mut self, (row, rows): (usize, usize), lanes: Mask, other: Directions<I>) {
        if let Self::Shared(shared) = self {
            if row == 0 {
                *shared = shared.but(lanes, other);
            }
            if !shared.normal.differs(other.normal).and(lanes).any() {
                return;
            }
            *self = Self::Each(vec![*shared; rows]);
        }
        if let Self::Each(each) = self {
            let last = each[each.len() - 1];
            each.resize(rows.max(each.len()), last);
            each[row] = each[row].but(lanes, other);
        }
    }
}

impl<I: Instructions> Response<I> {
    const NONE: Self = Self {
        to_normal: Single3::ZERO,
        mass: Single::ZERO,
        slip_mass: Single3::ZERO,
        least_slip_mass: Single::ZERO,
    };
}

impl<I: Instructions> RowImpulse<I> {
    pub(crate) const ZERO: Self = Self { normal: Single::ZERO, tangent: [Single::ZERO; 2] };

    /// What acts in the world; what would pull does not, along the normal.
    #[inline(always)]
    pub(crate) fn new(force: Single3<I>, basis: &Basis<I>) -> Self {
        let [t, b] = basis.tangents;
        Self { normal: force.dot(basis.normal).max(Single::ZERO), tangent: [force.dot(t), force.dot(b)] }
    }

    /// Whether anything acts.
    #[inline(always)]
    pub(crate) fn is_any(&self) -> bool {
        let [t, b] = self.tangent;
        self.normal.differs_from_zero().or(t.differs_from_zero()).or(b.differs_from_zero()).any()
    }

    pub(crate) fn clear(&mut self, lane: usize) {
        self.normal.set(lane, 0.0);
        self.tangent.iter_mut().for_each(|tangent| tangent.set(lane, 0.0));
    }

    /// The same, but another one in some lanes.
    #[inline(always)]
    pub(crate) fn but(&self, lanes: Mask, other: Self) -> Self {
        let ([t, b], [other_t, other_b]) = (self.tangent, other.tangent);
        Self {
            normal: self.normal.but(lanes, other.normal),
            tangent: [t.but(lanes, other_t), b.but(lanes, other_b)],
        }
    }
}
