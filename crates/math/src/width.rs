//! Widest instruction set of the machine.

use crate::instructions::Instructions;
#[cfg(target_arch = "x86_64")]
use crate::instructions::scalar::Scalar;
#[cfg(target_arch = "x86_64")]
use crate::instructions::x86::{Avx2, Avx512, Sse2};

/// SIMD width: up to eight lanes in single precision; narrower machines use their own width. Other
/// than on x86-64 the width is fixed at compile time, and this setting has no effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Width {
    /// One.
    Scalar,
    /// Two.
    Sse2,
    /// Four.
    Avx2,
    /// Eight.
    Avx512,
}

/// Prefetches memory with any instruction set; no other effect.
#[inline(always)]
pub fn prefetch<T>(soon: &[T]) {
    #[cfg(target_arch = "x86_64")]
    Sse2::prefetch(soon);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = soon;
}

/// The widest available width, at most `asked`.
#[cfg(target_arch = "x86_64")]
fn available(asked: Width) -> Width {
    let has_avx512 = is_x86_feature_detected!("avx512f")
        && is_x86_feature_detected!("avx512dq")
        && is_x86_feature_detected!("avx512vl");
    let widest = match (has_avx512, is_x86_feature_detected!("avx2")) {
        (true, _) => Width::Avx512,
        (false, true) => Width::Avx2,
        (false, false) => Width::Sse2,
    };
    asked.min(widest)
}

/// The instructions that are known when the engine is compiled.
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
type Only = crate::instructions::simd128::Simd128;
/// The instructions that are known when the engine is compiled.
#[cfg(not(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128"))))]
type Only = crate::instructions::scalar::Scalar;

/// Work over lanes that [`with_widest`] gives instructions to. The instruction sets themselves have
/// no names outside of this crate: only sets that the machine has reach a kernel.
///
/// ```compile_fail
/// use frangible_math::Avx512;
/// ```
pub trait Kernel {
    /// What it computes.
    type Output;

    /// Computes it with one instruction set.
    fn compute<I: Instructions>(self) -> Self::Output;
}

/// Computes a kernel with the widest available instruction set, on x86-64 at most `asked`.
#[inline]
pub fn with_widest<K: Kernel>(asked: Width, kernel: K) -> K::Output {
    #[cfg(target_arch = "x86_64")]
    match available(asked) {
        Width::Scalar => kernel.compute::<Scalar>(),
        Width::Sse2 => kernel.compute::<Sse2>(),
        Width::Avx2 => kernel.compute::<Avx2>(),
        Width::Avx512 => kernel.compute::<Avx512>(),
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = asked;
        kernel.compute::<Only>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::instructions::scalar::Scalar;
    use crate::instructions::{LANES, Numbers, Singles};

    /// Rows become columns, and arithmetic has the same bits, in every width that this machine has.
    #[test]
    fn all_widths_agree() {
        fn check<I: Instructions>() {
            let rows: [Numbers; LANES] = std::array::from_fn(|i| {
                Numbers(std::array::from_fn(|k| (10 * i + k) as f64 + 1.0 / (3 + i + k) as f64))
            });
            let columns = I::transpose(rows);
            for i in 0..LANES {
                for k in 0..LANES {
                    assert_eq!(columns[k].0[i], rows[i].0[k]);
                }
            }
            let narrow = |numbers: Numbers| Singles(numbers.0.map(|number| number as f32));
            let singles: [Singles; LANES] = rows.map(narrow);
            assert_eq!(I::transpose_singles(singles), Scalar::transpose_singles(singles));
            assert_eq!(Scalar::transpose_singles(singles)[3].0[5], singles[5].0[3]);

            // Arithmetic, of doubles and of singles.
            let (a, b) = (rows[0], Numbers(std::array::from_fn(|lane| 3.0 - 0.7 * lane as f64)));
            let (c, d) = (narrow(a), narrow(b));
            for (of, expected) in [
                (I::add(a, b), Scalar::add(a, b)),
                (I::sub(a, b), Scalar::sub(a, b)),
                (I::mul(a, b), Scalar::mul(a, b)),
                (I::div(a, b), Scalar::div(a, b)),
                (I::sqrt(a), Scalar::sqrt(a)),
                (I::select(0b0110_1001, a, b), Scalar::select(0b0110_1001, a, b)),
            ] {
                assert_eq!(of, expected);
            }
            for (of, expected) in [
                (I::add_singles(c, d), Scalar::add_singles(c, d)),
                (I::sub_singles(c, d), Scalar::sub_singles(c, d)),
                (I::mul_singles(c, d), Scalar::mul_singles(c, d)),
                (I::div_singles(c, d), Scalar::div_singles(c, d)),
                (I::sqrt_singles(c), Scalar::sqrt_singles(c)),
                (I::min_singles(c, d), Scalar::min_singles(c, d)),
                (I::max_singles(c, d), Scalar::max_singles(c, d)),
                (I::select_singles(0b0110_1001, c, d), Scalar::select_singles(0b0110_1001, c, d)),
            ] {
                assert_eq!(of, expected);
            }
            assert_eq!(I::above(a, b), Scalar::above(a, b));
            assert_eq!(I::above_singles(c, d), Scalar::above_singles(c, d));
            assert!(![0, u8::MAX].contains(&I::above_singles(c, d)));

            // Also of zeros of both signs, equal numbers and what is none.
            let odd = Singles([0.0, -0.0, 1.0, f32::NAN, 2.0, f32::INFINITY, -0.0, f32::NAN]);
            let other = Singles([-0.0, 0.0, 1.0, 3.0, f32::NAN, 4.0, -0.0, f32::NAN]);
            let bits = |singles: Singles| singles.0.map(f32::to_bits);
            assert_eq!(bits(I::min_singles(odd, other)), bits(Scalar::min_singles(odd, other)));
            assert_eq!(bits(I::max_singles(odd, other)), bits(Scalar::max_singles(odd, other)));
        }
        check::<Scalar>();
        #[cfg(target_arch = "x86_64")]
        {
            let widest = available(Width::Avx512);
            check::<Sse2>();
            if widest >= Width::Avx2 {
                check::<Avx2>();
            }
            if widest >= Width::Avx512 {
                check::<Avx512>();
            }
        }
    }
}
