//! Vectors and unit quaternions of one body, or of several side by side: what is written for these
//! is the same for either, bit for bit.

use crate::lanes::Three;
use crate::number::Number;
use glam::{DQuat, DVec3};
use std::ops::{Add, Mul, Neg, Sub};

/// Three numbers.
pub trait Vector:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Self::Number, Output = Self>
    + Neg<Output = Self>
{
    /// Of its components.
    type Number: Number;
    /// The dot product.
    fn dot(self, other: Self) -> Self::Number;
    /// The cross product.
    fn cross(self, other: Self) -> Self;
    /// Component by component.
    fn times(self, other: Self) -> Self;
    /// Each component less a number.
    fn less(self, number: Self::Number) -> Self;
    /// Along x, y and z.
    fn components(self) -> [Self::Number; 3];
}

/// A unit quaternion by its vector and its scalar.
#[derive(Clone, Copy)]
pub struct Turn<V: Vector> {
    /// The axis times the sine of half the angle.
    pub vector: V,
    /// The cosine of half the angle.
    pub scalar: V::Number,
}

impl Vector for DVec3 {
    type Number = f64;

    #[inline(always)]
    fn dot(self, other: Self) -> f64 {
        DVec3::dot(self, other)
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        DVec3::cross(self, other)
    }

    #[inline(always)]
    fn less(self, number: f64) -> Self {
        self - number
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        self * other
    }

    #[inline(always)]
    fn components(self) -> [f64; 3] {
        [self.x, self.y, self.z]
    }
}

impl<N: Number> Vector for Three<N> {
    type Number = N;

    #[inline(always)]
    fn dot(self, other: Self) -> N {
        Three::dot(self, other)
    }

    #[inline(always)]
    fn cross(self, other: Self) -> Self {
        Three::cross(self, other)
    }

    #[inline(always)]
    fn less(self, number: N) -> Self {
        Self { x: self.x - number, y: self.y - number, z: self.z - number }
    }

    #[inline(always)]
    fn times(self, other: Self) -> Self {
        Self { x: self.x * other.x, y: self.y * other.y, z: self.z * other.z }
    }

    #[inline(always)]
    fn components(self) -> [N; 3] {
        [self.x, self.y, self.z]
    }
}

impl<V: Vector> Turn<V> {
    /// First `other`, then this.
    #[inline(always)]
    pub fn after(self, other: Self) -> Self {
        Self {
            vector: other.vector * self.scalar
                + self.vector * other.scalar
                + self.vector.cross(other.vector),
            scalar: self.scalar * other.scalar - self.vector.dot(other.vector),
        }
    }

    /// The other way.
    #[inline(always)]
    pub fn back(self) -> Self {
        Self { vector: -self.vector, scalar: self.scalar }
    }

    /// Turns a vector. Written like this its rounding does not lean to one side: a million
    /// rotations keep their energy.
    #[inline(always)]
    pub fn turn(self, v: V) -> V {
        let Self { vector: b, scalar: w } = self;
        let two = V::Number::of(2.0);
        v * (w * w - b.dot(b)) + b * (v.dot(b) * two) + b.cross(v) * (w * two)
    }

    /// By `|theta|` [rad] about `theta`, of which the square is below 1e-4: by its series, where
    /// the next term, |theta|^6/46080 of the cosine, is below rounding.
    #[inline(always)]
    pub fn by_little(theta: V) -> Self {
        let of = V::Number::of;
        let squared = theta.dot(theta);
        let square = squared * squared;
        let sine_ratio = of(0.5) - squared / of(48.0) + square / of(3840.0);
        Self {
            vector: theta * sine_ratio,
            scalar: of(1.0) - squared / of(8.0) + square / of(384.0),
        }
    }
}

impl From<DQuat> for Turn<DVec3> {
    #[inline(always)]
    fn from(q: DQuat) -> Self {
        Self { vector: q.xyz(), scalar: q.w }
    }
}

impl From<Turn<DVec3>> for DQuat {
    #[inline(always)]
    fn from(turn: Turn<DVec3>) -> Self {
        Self::from_vec4(turn.vector.extend(turn.scalar))
    }
}
