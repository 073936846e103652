//! The same operations on the registers of WebAssembly's simd128. Nothing of relaxed SIMD: what it
//! gives is not the same on every machine.

use crate::instructions::registers::arithmetic;
use crate::instructions::{Instructions, LANES, Numbers, Singles, on_its_own};
use std::arch::wasm32::*;
use std::mem::transmute;

/// Two lanes at a time, four in single precision.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Simd128;

/// The smaller ones; `b` where one is not a number, or both are equal, as `f32x4_pmin` gives its
/// first argument there.
#[inline(always)]
fn smaller_or_second(a: v128, b: v128) -> v128 {
    f32x4_pmin(b, a)
}

/// Like [`smaller_or_second`], for maxima.
#[inline(always)]
fn larger_or_second(a: v128, b: v128) -> v128 {
    f32x4_pmax(b, a)
}

impl Instructions for Simd128 {
    arithmetic!(
        Numbers, [v128; 4],
        add f64x2_add, sub f64x2_sub, mul f64x2_mul, div f64x2_div; sqrt f64x2_sqrt,
        above |a, b| i64x2_bitmask(f64x2_gt(a, b)),
        select |mask, yes, no| {
            let mask = i64::from(mask);
            v128_bitselect(yes, no, i64x2(-(mask & 1), -(mask >> 1 & 1)))
        }
    );
    arithmetic!(
        Singles, [v128; 2],
        add_singles f32x4_add, sub_singles f32x4_sub, mul_singles f32x4_mul, div_singles f32x4_div,
        min_singles smaller_or_second, max_singles larger_or_second;
        sqrt_singles f32x4_sqrt,
        above_singles |a, b| i32x4_bitmask(f32x4_gt(a, b)),
        select_singles |mask, yes, no| {
            let bits = i32x4(1, 2, 4, 8);
            let set = v128_and(i32x4_splat(i32::from(mask)), bits);
            v128_bitselect(yes, no, i32x4_eq(set, bits))
        }
    );

    /// Blocks of two by two.
    #[inline(always)]
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES] {
        let rows = unsafe { transmute::<[Numbers; LANES], [[v128; 4]; LANES]>(rows) };
        let mut columns = rows;
        for i in 0..4 {
            for k in 0..4 {
                let (a, b) = (rows[2 * i][k], rows[2 * i + 1][k]);
                columns[2 * k][i] = i64x2_shuffle::<0, 2>(a, b);
                columns[2 * k + 1][i] = i64x2_shuffle::<1, 3>(a, b);
            }
        }
        unsafe { transmute::<[[v128; 4]; LANES], [Numbers; LANES]>(columns) }
    }

    /// Blocks of four by four.
    #[inline(always)]
    fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES] {
        let rows = unsafe { transmute::<[Singles; LANES], [[v128; 2]; LANES]>(rows) };
        let mut columns = rows;
        for i in 0..2 {
            for k in 0..2 {
                let [a, b, c, d] =
                    [rows[4 * i][k], rows[4 * i + 1][k], rows[4 * i + 2][k], rows[4 * i + 3][k]];
                let low = i32x4_shuffle::<0, 4, 1, 5>(a, b);
                let high = i32x4_shuffle::<2, 6, 3, 7>(a, b);
                let low2 = i32x4_shuffle::<0, 4, 1, 5>(c, d);
                let high2 = i32x4_shuffle::<2, 6, 3, 7>(c, d);
                columns[4 * k][i] = i64x2_shuffle::<0, 2>(low, low2);
                columns[4 * k + 1][i] = i64x2_shuffle::<1, 3>(low, low2);
                columns[4 * k + 2][i] = i64x2_shuffle::<0, 2>(high, high2);
                columns[4 * k + 3][i] = i64x2_shuffle::<1, 3>(high, high2);
            }
        }
        unsafe { transmute::<[[v128; 2]; LANES], [Singles; LANES]>(columns) }
    }

    #[inline(always)]
    fn prefetch<T>(_: &[T]) {}

    #[inline(always)]
    fn run(kernel: impl FnOnce()) {
        on_its_own(kernel);
    }
}
