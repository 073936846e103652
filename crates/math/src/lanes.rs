//! SIMD lanes. Lanes are independent: results do not depend on the register width.

use crate::instructions::{Instructions, LANES, Numbers, Singles};
use crate::number::Number;
use glam::DVec3;
use std::marker::PhantomData;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A number in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lanes<I>(Numbers, PhantomData<I>);

/// A number in each lane in single precision: what contact is computed with, and kept in, that has
/// no sum to keep exact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Single<I>(Singles, PhantomData<I>);

/// A yes or no in each lane: its bits, the first lane's lowest.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Mask(u8);

/// A vector in each lane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Three<N> {
    /// Along x.
    pub x: N,
    /// Along y.
    pub y: N,
    /// Along z.
    pub z: N,
}

/// A vector in each lane, in double precision.
pub type Lanes3<I> = Three<Lanes<I>>;
/// A vector in each lane, in single precision.
pub type Single3<I> = Three<Single<I>>;

/// A symmetric matrix in each lane.
#[derive(Clone, Copy, Debug)]
pub struct Symmetric<N> {
    /// On the diagonal.
    pub diagonal: Three<N>,
    /// The entries yz, xz and xy.
    pub off: Three<N>,
}

/// Types a [`Mask`] selects between.
pub trait Blend: Copy {
    /// In each lane whose bit is set `yes`, else `no`.
    fn blend(mask: u8, yes: Self, no: Self) -> Self;
}

macro_rules! of_lanes {
    ($name:ident, $memory:ident, $number:ty: $above:ident, $sqrt:ident, $select:ident,
     $($trait:ident $method:ident $operation:ident),*) => {
        impl<I: Instructions> $name<I> {
            /// Zero in each lane.
            pub const ZERO: Self = Self($memory::ZERO, PhantomData);

            /// The same in each lane.
            #[inline(always)]
            pub fn splat(value: f64) -> Self {
                Self($memory([value as $number; LANES]), PhantomData)
            }

            /// The roots.
            #[inline(always)]
            pub fn sqrt(self) -> Self {
                Self(I::$sqrt(self.0), PhantomData)
            }

            /// Where this is greater than `other`.
            #[inline(always)]
            pub fn above(self, other: Self) -> Mask {
                Mask(I::$above(self.0, other.0))
            }
        }

        impl<I: Instructions> Blend for $name<I> {
            #[inline(always)]
            fn blend(mask: u8, yes: Self, no: Self) -> Self {
                Self(I::$select(mask, yes.0, no.0), PhantomData)
            }
        }

        impl<I: Instructions> Number for $name<I> {
            #[inline(always)]
            fn of(value: f64) -> Self {
                Self::splat(value)
            }
        }

        impl<I: Instructions> Neg for $name<I> {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                Self::splat(-0.0) - self
            }
        }

        $(
            impl<I: Instructions> $trait for $name<I> {
                type Output = Self;
                #[inline(always)]
                fn $method(self, other: Self) -> Self {
                    Self(I::$operation(self.0, other.0), PhantomData)
                }
            }
        )*
    };
}

of_lanes!(Lanes, Numbers, f64: above, sqrt, select, Add add add, Sub sub sub, Mul mul mul, Div div div);
of_lanes!(Single, Singles, f32: above_singles, sqrt_singles, select_singles,
    Add add add_singles, Sub sub sub_singles, Mul mul mul_singles, Div div div_singles);

impl<I: Instructions> Lanes<I> {
    /// Rows become columns.
    #[inline(always)]
    pub fn transposed(rows: [Numbers; LANES]) -> [Self; LANES] {
        let columns = I::transpose(rows);
        let mut lanes = [Self::ZERO; LANES];
        for i in 0..LANES {
            lanes[i].0 = columns[i];
        }
        lanes
    }

    /// See [`Self::transposed`].
    #[inline(always)]
    pub fn rows(columns: [Self; LANES]) -> [Numbers; LANES] {
        let mut numbers = [Numbers::ZERO; LANES];
        for i in 0..LANES {
            numbers[i] = columns[i].0;
        }
        I::transpose(numbers)
    }
}

impl<I: Instructions> Single<I> {
    /// Of one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> f64 {
        f64::from(self.0.0[lane])
    }

    /// Of one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: f64) {
        self.0.0[lane] = value as f32;
    }

    /// Eight numbers that lie side by side.
    #[inline(always)]
    pub fn of_column(column: &Singles) -> Self {
        Self(*column, PhantomData)
    }

    /// One number in all lanes.
    #[inline(always)]
    pub fn same(value: f32) -> Self {
        Self(Singles([value; LANES]), PhantomData)
    }

    /// Maximum of all lanes, by pairwise reduction for a short dependency chain.
    #[inline(always)]
    pub fn largest(self) -> f32 {
        let mut largest = self.0.0;
        for half in [4, 2, 1] {
            for lane in 0..half {
                let other = largest[lane + half];
                largest[lane] = if other > largest[lane] { other } else { largest[lane] };
            }
        }
        largest[0]
    }

    /// In the order of the lanes.
    #[inline(always)]
    pub fn to_array(self) -> [f32; LANES] {
        self.0.0
    }

    /// Rows become columns.
    #[inline(always)]
    pub fn transposed(rows: [Singles; LANES]) -> [Self; LANES] {
        let columns = I::transpose_singles(rows);
        let mut lanes = [Self::ZERO; LANES];
        for i in 0..LANES {
            lanes[i].0 = columns[i];
        }
        lanes
    }

    /// See [`Self::transposed`].
    #[inline(always)]
    pub fn rows(columns: [Self; LANES]) -> [Singles; LANES] {
        let mut singles = [Singles::ZERO; LANES];
        for i in 0..LANES {
            singles[i] = columns[i].0;
        }
        I::transpose_singles(singles)
    }

    /// Lane maxima; `other` where this is NaN.
    #[inline(always)]
    pub fn max(self, other: Self) -> Self {
        Self(I::max_singles(self.0, other.0), PhantomData)
    }

    /// Lane minima; `other` where this is NaN.
    #[inline(always)]
    pub fn min(self, other: Self) -> Self {
        Self(I::min_singles(self.0, other.0), PhantomData)
    }
}

impl Mask {
    /// No lane.
    pub const NONE: Self = Self(0);

    /// True if the mask contains the lane.
    #[inline(always)]
    pub fn get(self, lane: usize) -> bool {
        self.0 >> lane & 1 == 1
    }

    /// Takes the lane in, or out.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: bool) {
        self.0 = self.0 & !(1 << lane) | u8::from(value) << lane;
    }

    /// Lanes of `yes` inside the mask, of `no` outside.
    #[inline(always)]
    pub fn select<T: Blend>(self, yes: T, no: T) -> T {
        T::blend(self.0, yes, no)
    }

    /// Intersection of two masks.
    #[inline(always)]
    pub fn and(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }

    /// Union of two masks.
    #[inline(always)]
    pub fn or(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Complement of the mask.
    #[allow(clippy::should_implement_trait, reason = "it follows `and` and `or` in chains")]
    #[inline(always)]
    pub fn not(self) -> Self {
        Self(!self.0)
    }

    /// True if any lane is set.
    #[inline(always)]
    pub fn any(self) -> bool {
        self.0 != 0
    }
}

impl<N: Blend> Blend for Three<N> {
    #[inline(always)]
    fn blend(mask: u8, yes: Self, no: Self) -> Self {
        Self {
            x: N::blend(mask, yes.x, no.x),
            y: N::blend(mask, yes.y, no.y),
            z: N::blend(mask, yes.z, no.z),
        }
    }
}

impl<I: Instructions> Single3<I> {
    /// Zero in each lane.
    pub const ZERO: Self = Self { x: Single::ZERO, y: Single::ZERO, z: Single::ZERO };

    /// Of one lane.
    #[inline(always)]
    pub fn get(&self, lane: usize) -> DVec3 {
        DVec3::new(self.x.get(lane), self.y.get(lane), self.z.get(lane))
    }

    /// Of one lane.
    #[inline(always)]
    pub fn set(&mut self, lane: usize, value: DVec3) {
        self.x.set(lane, value.x);
        self.y.set(lane, value.y);
        self.z.set(lane, value.z);
    }

    /// No longer than `most` in each lane.
    #[inline(always)]
    pub fn shortened_to(self, most: Single<I>) -> Self {
        let squared = self.dot(self);
        let is_over = squared.above(most * most);
        self * is_over.select(most / squared.sqrt(), Single::splat(1.0))
    }
}

impl<N: Number> Three<N> {
    /// The same in each lane.
    #[inline(always)]
    pub fn splat(value: DVec3) -> Self {
        Self { x: N::of(value.x), y: N::of(value.y), z: N::of(value.z) }
    }

    /// The dot products.
    #[inline(always)]
    pub fn dot(self, other: Self) -> N {
        self.x * other.x + self.y * other.y + self.z * other.z
    }

    /// The cross products.
    #[inline(always)]
    pub fn cross(self, other: Self) -> Self {
        Self {
            x: self.y * other.z - self.z * other.y,
            y: self.z * other.x - self.x * other.z,
            z: self.x * other.y - self.y * other.x,
        }
    }
}

impl<N: Number> Mul<Three<N>> for Symmetric<N> {
    type Output = Three<N>;
    #[inline(always)]
    fn mul(self, v: Three<N>) -> Three<N> {
        let Self { diagonal: d, off } = self;
        Three {
            x: d.x * v.x + off.z * v.y + off.y * v.z,
            y: off.z * v.x + d.y * v.y + off.x * v.z,
            z: off.y * v.x + off.x * v.y + d.z * v.z,
        }
    }
}

impl<N: Number> Add for Three<N> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { x: self.x + other.x, y: self.y + other.y, z: self.z + other.z }
    }
}

impl<N: Number> Sub for Three<N> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { x: self.x - other.x, y: self.y - other.y, z: self.z - other.z }
    }
}

impl<N: Number> Mul<N> for Three<N> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, scale: N) -> Self {
        Self { x: self.x * scale, y: self.y * scale, z: self.z * scale }
    }
}

impl<N: Number> Neg for Three<N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { x: -self.x, y: -self.y, z: -self.z }
    }
}
