//! Several numbers at a time. No lane sees another, so it does not matter how many of them the machine does at once.

use crate::instructions::Singles;
pub(crate) use crate::instructions::{Instructions, Numbers};
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// As many as the widest registers hold.
pub(crate) const LANES: usize = 8;

/// A number in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes<I>(Numbers, PhantomData<I>);

/// A number in each lane as it is kept, in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept<I>(Singles, PhantomData<I>);

/// A vector in each lane as it is kept.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Kept3<I> {
    x: Kept<I>,
    y: Kept<I>,
    z: Kept<I>,
}

/// A yes or no in each lane: its bits, the first lane's lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Mask(u8);

/// A vector in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Lanes3<I> {
    pub(crate) x: Lanes<I>,
    pub(crate) y: Lanes<I>,
    pub(crate) z: Lanes<I>,
}

/// A symmetric matrix in each lane.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SymmetricLanes<I> {
    /// On the diagonal.
    pub(crate) diagonal: Lanes3<I>,
    /// The entries yz, xz and xy.
    pub(crate) off: Lanes3<I>,
}

impl<I: Instructions> Lanes<I> {
    pub(crate) const ZERO: Self = Self(Numbers::ZERO, PhantomData);

    #[inline(always)]
    pub(crate) fn splat(value: f64) -> Self {
        Self(Numbers([value; LANES]), PhantomData)
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0.0[lane]
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: f64) {
        self.0.0[lane] = value;
    }

    /// In single precision.
    #[inline(always)]
    pub(crate) fn kept(self) -> Kept<I> {
        Kept(I::narrow(self.0), PhantomData)
    }

    /// Rows become columns.
    #[inline(always)]
    pub(crate) fn transposed(rows: [Numbers; LANES]) -> [Self; LANES] {
        let columns = I::transpose(rows);
        let mut lanes = [Self::ZERO; LANES];
        for (lanes, column) in lanes.iter_mut().zip(columns) {
            lanes.0 = column;
        }
        lanes
    }

    /// See [`Self::transposed`].
    #[inline(always)]
    pub(crate) fn rows(columns: [Self; LANES]) -> [Numbers; LANES] {
        let mut numbers = [Numbers::ZERO; LANES];
        for (numbers, column) in numbers.iter_mut().zip(columns) {
            *numbers = column.0;
        }
        I::transpose(numbers)
    }

    #[inline(always)]
    pub(crate) fn sqrt(self) -> Self {
        Self(I::sqrt(self.0), PhantomData)
    }

    /// The larger one; `other` where this is not a number.
    #[inline(always)]
    pub(crate) fn max(self, other: Self) -> Self {
        self.above(other).select(self, other)
    }

    /// The smaller one; `other` where this is not a number.
    #[inline(always)]
    pub(crate) fn min(self, other: Self) -> Self {
        other.above(self).select(self, other)
    }

    #[inline(always)]
    pub(crate) fn above(self, other: Self) -> Mask {
        Mask(I::above(self.0, other.0))
    }

    #[inline(always)]
    pub(crate) fn differs_from_zero(self) -> Mask {
        self.above(Self::ZERO).or(Self::ZERO.above(self))
    }

    /// The sum over all lanes, always in the same order.
    pub(crate) fn sum(self) -> f64 {
        self.0.0.iter().sum()
    }
}

impl<I: Instructions> Kept<I> {
    pub(crate) const ZERO: Self = Self(Singles([0.0; LANES]), PhantomData);

    #[inline(always)]
    pub(crate) fn splat(value: f32) -> Self {
        Self(Singles([value; LANES]), PhantomData)
    }

    #[inline(always)]
    pub(crate) fn lanes(self) -> Lanes<I> {
        Lanes(I::widen(self.0), PhantomData)
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> f64 {
        self.0.0[lane].into()
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: f64) {
        self.0.0[lane] = value as f32;
    }

    /// The same, but another one in some lanes.
    #[inline(always)]
    pub(crate) fn but(self, lanes: Mask, other: Self) -> Self {
        lanes.select(other.lanes(), self.lanes()).kept()
    }
}

impl<I: Instructions> Kept3<I> {
    pub(crate) const ZERO: Self = Self { x: Kept::ZERO, y: Kept::ZERO, z: Kept::ZERO };

    #[inline(always)]
    pub(crate) fn lanes(self) -> Lanes3<I> {
        Lanes3 { x: self.x.lanes(), y: self.y.lanes(), z: self.z.lanes() }
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x.get(lane), self.y.get(lane), self.z.get(lane))
    }

    /// See [`Kept::but`].
    #[inline(always)]
    pub(crate) fn but(self, lanes: Mask, other: Self) -> Self {
        Self { x: self.x.but(lanes, other.x), y: self.y.but(lanes, other.y), z: self.z.but(lanes, other.z) }
    }

    /// The lanes in which it is another one.
    #[inline(always)]
    pub(crate) fn differs(self, other: Self) -> Mask {
        let differs = |a: Kept<I>, b: Kept<I>| (a.lanes() - b.lanes()).differs_from_zero();
        differs(self.x, other.x).or(differs(self.y, other.y)).or(differs(self.z, other.z))
    }
}

impl Mask {
    pub(crate) const NONE: Self = Self(0);

    #[inline(always)]
    pub(crate) fn of(value: impl Fn(usize) -> bool) -> Self {
        let mut mask = Self::NONE;
        for lane in 0..LANES {
            mask.set(lane, value(lane));
        }
        mask
    }

    #[inline(always)]
    pub(crate) fn get(self, lane: usize) -> bool {
        self.0 >> lane & 1 == 1
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: bool) {
        self.0 = self.0 & !(1 << lane) | u8::from(value) << lane;
    }

    #[inline(always)]
    pub(crate) fn select<I: Instructions>(self, yes: Lanes<I>, no: Lanes<I>) -> Lanes<I> {
        Lanes(I::select(self.0, yes.0, no.0), PhantomData)
    }

    #[inline(always)]
    pub(crate) fn select3<I: Instructions>(self, yes: Lanes3<I>, no: Lanes3<I>) -> Lanes3<I> {
        Lanes3 { x: self.select(yes.x, no.x), y: self.select(yes.y, no.y), z: self.select(yes.z, no.z) }
    }

    #[inline(always)]
    pub(crate) fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    #[inline(always)]
    pub(crate) fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    #[inline(always)]
    pub(crate) fn not(self) -> Self {
        Self(!self.0)
    }

    #[inline(always)]
    pub(crate) fn any(self) -> bool {
        self.0 != 0
    }

    #[inline(always)]
    pub(crate) fn count(self) -> u32 {
        self.0.count_ones()
    }
}

impl<I: Instructions> Lanes3<I> {
    pub(crate) const ZERO: Self = Self { x: Lanes::ZERO, y: Lanes::ZERO, z: Lanes::ZERO };

    /// In single precision.
    #[inline(always)]
    pub(crate) fn kept(self) -> Kept3<I> {
        Kept3 { x: self.x.kept(), y: self.y.kept(), z: self.z.kept() }
    }

    #[inline(always)]
    pub(crate) fn splat(value: DVec3) -> Self {
        Self { x: Lanes::splat(value.x), y: Lanes::splat(value.y), z: Lanes::splat(value.z) }
    }

    #[inline(always)]
    pub(crate) fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x.get(lane), self.y.get(lane), self.z.get(lane))
    }

    #[inline(always)]
    pub(crate) fn set(&mut self, lane: usize, value: DVec3) {
        self.x.set(lane, value.x);
        self.y.set(lane, value.y);
        self.z.set(lane, value.z);
    }

    /// The sum over all lanes, always in the same order.
    pub(crate) fn sum(self) -> DVec3 {
        DVec3::new(self.x.sum(), self.y.sum(), self.z.sum())
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> Lanes<I> {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    #[inline(always)]
    pub(crate) fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }

    /// No longer than `most` in each lane.
    #[inline(always)]
    pub(crate) fn shortened_to(self, most: Lanes<I>) -> Self {
        let squared = self.dot(self);
        let is_over = squared.above(most * most);
        self * is_over.select(most / squared.sqrt(), Lanes::splat(1.0))
    }
}

impl<I: Instructions> Mul<Lanes3<I>> for SymmetricLanes<I> {
    type Output = Lanes3<I>;
    #[inline(always)]
    fn mul(self, v: Lanes3<I>) -> Lanes3<I> {
        let Self { diagonal: d, off } = self;
        Lanes3 {
            x: d.x * v.x + off.z * v.y + off.y * v.z,
            y: off.z * v.x + d.y * v.y + off.x * v.z,
            z: off.y * v.x + off.x * v.y + d.z * v.z,
        }
    }
}

macro_rules! lane_by_lane {
    ($($trait:ident $method:ident),*) => { $(
        impl<I: Instructions> $trait for Lanes<I> {
            type Output = Self;
            #[inline(always)]
            fn $method(self, other: Self) -> Self {
                Self(I::$method(self.0, other.0), PhantomData)
            }
        }
    )* };
}

lane_by_lane!(Add add, Sub sub, Mul mul, Div div);

impl<I: Instructions> Neg for Lanes<I> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::splat(-0.0) - self
    }
}

impl<I: Instructions> Add for Lanes3<I> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<I: Instructions> Sub for Lanes3<I> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<I: Instructions> Mul<Lanes<I>> for Lanes3<I> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: Lanes<I>) -> Self {
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }
}

impl<I: Instructions> Neg for Lanes3<I> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
