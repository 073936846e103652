//! The instruction sets that [`Lanes`](crate::lanes::Lanes) are computed with. All of them add, multiply, divide and take roots as
//! IEEE 754 says, and none contracts, so all give the same bits.

use crate::lanes::LANES;
use crate::settings::Width;

/// A number in each lane, as it lies in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Numbers(pub(crate) [f64; LANES]);

/// What is done to all lanes at once.
pub(crate) trait Instructions: Copy + std::fmt::Debug + PartialEq + 'static {
    fn add(a: Numbers, b: Numbers) -> Numbers;
    fn sub(a: Numbers, b: Numbers) -> Numbers;
    fn mul(a: Numbers, b: Numbers) -> Numbers;
    fn div(a: Numbers, b: Numbers) -> Numbers;
    fn sqrt(a: Numbers) -> Numbers;
    /// A bit for each lane: whether `a` is greater than `b`.
    fn above(a: Numbers, b: Numbers) -> u8;
    /// In each lane whose bit is set `yes`, else `no`.
    fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers;
    /// Runs a kernel with these instructions. Only for what [`available`] has named: the machine must have them.
    fn run(kernel: impl FnOnce());
}

/// The widest that the machine has, or the one that is asked for if that is narrower.
pub(crate) fn available(asked: Width) -> Width {
    #[cfg(target_arch = "x86_64")]
    {
        let has_avx512 = is_x86_feature_detected!("avx512f") && is_x86_feature_detected!("avx512dq");
        let widest = match (has_avx512, is_x86_feature_detected!("avx2")) {
            (true, _) => Width::Avx512,
            (false, true) => Width::Avx2,
            (false, false) => Width::Sse2,
        };
        asked.min(widest)
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = asked;
        Width::Scalar
    }
}

/// One lane after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scalar;

impl Instructions for Scalar {
    #[inline(always)]
    fn add(a: Numbers, b: Numbers) -> Numbers {
        each(|lane| a.0[lane] + b.0[lane])
    }

    #[inline(always)]
    fn sub(a: Numbers, b: Numbers) -> Numbers {
        each(|lane| a.0[lane] - b.0[lane])
    }

    #[inline(always)]
    fn mul(a: Numbers, b: Numbers) -> Numbers {
        each(|lane| a.0[lane] * b.0[lane])
    }

    #[inline(always)]
    fn div(a: Numbers, b: Numbers) -> Numbers {
        each(|lane| a.0[lane] / b.0[lane])
    }

    #[inline(always)]
    fn sqrt(a: Numbers) -> Numbers {
        each(|lane| a.0[lane].sqrt())
    }

    #[inline(always)]
    fn above(a: Numbers, b: Numbers) -> u8 {
        (0..LANES).fold(0, |mask, lane| mask | u8::from(a.0[lane] > b.0[lane]) << lane)
    }

    #[inline(always)]
    fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers {
        each(|lane| if mask >> lane & 1 == 1 { yes.0[lane] } else { no.0[lane] })
    }

    #[inline(always)]
    fn run(kernel: impl FnOnce()) {
        kernel();
    }
}

#[inline(always)]
fn each(value: impl Fn(usize) -> f64) -> Numbers {
    let mut numbers = [0.0; LANES];
    for lane in 0..LANES {
        numbers[lane] = value(lane);
    }
    Numbers(numbers)
}

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512, Sse2};

/// The same operations on whole registers. Sound because [`available`] names a set only where the machine has it, and the sizes are equal.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "the compiler does not turn these loops into vectors by itself")]
mod x86 {
    use super::{Instructions, LANES, Numbers};
    use std::arch::x86_64::*;
    use std::mem::transmute;

    macro_rules! lane_by_lane {
        ($count:literal, $($method:ident $operation:ident),*) => { $(
            #[inline(always)]
            fn $method(a: Numbers, b: Numbers) -> Numbers {
                let (mut a, b) = (Self::registers(a), Self::registers(b));
                for part in 0..$count {
                    a[part] = unsafe { $operation(a[part], b[part]) };
                }
                Self::numbers(a)
            }
        )* };
    }

    macro_rules! instructions {
        ($name:ident, $doc:literal, $register:ty, $count:literal, $features:literal,
         $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident,
         |$a:ident, $b:ident| $above:expr, |$mask:ident, $yes:ident, $no:ident| $select:expr) => {
            #[doc = $doc]
            #[derive(Clone, Copy, Debug, PartialEq)]
            pub(crate) struct $name;

            impl $name {
                #[inline(always)]
                fn registers(numbers: Numbers) -> [$register; $count] {
                    unsafe { transmute::<Numbers, [$register; $count]>(numbers) }
                }

                #[inline(always)]
                fn numbers(registers: [$register; $count]) -> Numbers {
                    unsafe { transmute::<[$register; $count], Numbers>(registers) }
                }
            }

            impl Instructions for $name {
                lane_by_lane!($count, add $add, sub $sub, mul $mul, div $div);

                #[inline(always)]
                fn sqrt(a: Numbers) -> Numbers {
                    let mut a = Self::registers(a);
                    for part in 0..$count {
                        a[part] = unsafe { $sqrt(a[part]) };
                    }
                    Self::numbers(a)
                }

                #[inline(always)]
                fn above(a: Numbers, b: Numbers) -> u8 {
                    let (a, b) = (Self::registers(a), Self::registers(b));
                    let mut mask = 0;
                    for part in 0..$count {
                        let ($a, $b) = (a[part], b[part]);
                        mask |= unsafe { $above } << (part * (LANES / $count));
                    }
                    mask
                }

                #[inline(always)]
                fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers {
                    let (yes, no) = (Self::registers(yes), Self::registers(no));
                    let mut out = no;
                    for part in 0..$count {
                        let ($mask, $yes, $no) = (mask >> (part * (LANES / $count)), yes[part], no[part]);
                        out[part] = unsafe { $select };
                    }
                    Self::numbers(out)
                }

                #[inline(always)]
                fn run(kernel: impl FnOnce()) {
                    #[target_feature(enable = $features)]
                    fn with(kernel: impl FnOnce()) {
                        kernel();
                    }
                    unsafe { with(kernel) }
                }
            }
        };
    }

    instructions!(
        Sse2, "Two lanes at a time.", __m128d, 4, "sse2",
        _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd,
        |a, b| _mm_movemask_pd(_mm_cmpgt_pd(a, b)) as u8,
        |mask, yes, no| {
            let mask = i64::from(mask);
            let mask = _mm_castsi128_pd(_mm_set_epi64x(-(mask >> 1 & 1), -(mask & 1)));
            _mm_or_pd(_mm_and_pd(mask, yes), _mm_andnot_pd(mask, no))
        }
    );

    instructions!(
        Avx2, "Four lanes at a time.", __m256d, 2, "avx2",
        _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd,
        |a, b| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(a, b)) as u8,
        |mask, yes, no| {
            let bits = _mm256_set_epi64x(8, 4, 2, 1);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(mask)), bits);
            _mm256_blendv_pd(no, yes, _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bits)))
        }
    );

    instructions!(
        Avx512, "All lanes at once.", __m512d, 1, "avx512f,avx512dq",
        _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd,
        |a, b| _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, b),
        |mask, yes, no| _mm512_mask_blend_pd(mask, no, yes)
    );
}
