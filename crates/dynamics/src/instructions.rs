//! The instruction sets that [`Lanes`](crate::lanes::Lanes) are computed with. All of them add, multiply, divide and take roots as
//! IEEE 754 says, and none contracts, so all give the same bits.

use crate::lanes::LANES;
use crate::settings::Width;

/// A number in each lane, as it lies in memory.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Numbers(pub(crate) [f64; LANES]);

impl Numbers {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// A number in each lane in single precision: half the room.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Singles(pub(crate) [f32; LANES]);

/// What is done to all lanes at once.
pub(crate) trait Instructions: Copy + std::fmt::Debug + PartialEq + Send + Sync + 'static {
    fn add(a: Numbers, b: Numbers) -> Numbers;
    fn sub(a: Numbers, b: Numbers) -> Numbers;
    fn mul(a: Numbers, b: Numbers) -> Numbers;
    fn div(a: Numbers, b: Numbers) -> Numbers;
    fn sqrt(a: Numbers) -> Numbers;
    /// A bit for each lane: whether `a` is greater than `b`.
    fn above(a: Numbers, b: Numbers) -> u8;
    /// In each lane whose bit is set `yes`, else `no`.
    fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers;
    /// To double precision.
    fn widen(a: Singles) -> Numbers;
    /// To the nearest in single precision.
    fn narrow(a: Numbers) -> Singles;
    /// Rows become columns.
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES];
    /// Asks for what will be needed soon; changes nothing.
    fn prefetch<T>(soon: &[T]);
    /// Runs a kernel with these instructions. Only for what [`available`] has named: the machine must have them.
    fn run(kernel: impl FnOnce());
}

/// Asks for what will be needed soon, whatever the instructions; changes nothing.
#[inline(always)]
pub(crate) fn prefetch<T>(soon: &[T]) {
    #[cfg(target_arch = "x86_64")]
    Sse2::prefetch(soon);
    #[cfg(not(target_arch = "x86_64"))]
    let _ = soon;
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
    fn widen(a: Singles) -> Numbers {
        each(|lane| f64::from(a.0[lane]))
    }

    #[inline(always)]
    fn narrow(a: Numbers) -> Singles {
        let mut singles = [0.0; LANES];
        for lane in 0..LANES {
            singles[lane] = a.0[lane] as f32;
        }
        Singles(singles)
    }

    #[inline(always)]
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES] {
        let mut columns = [Numbers::ZERO; LANES];
        for (i, row) in rows.iter().enumerate() {
            for (column, number) in columns.iter_mut().zip(row.0) {
                column.0[i] = number;
            }
        }
        columns
    }

    #[inline(always)]
    fn prefetch<T>(_: &[T]) {}

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
    use super::{Instructions, LANES, Numbers, Singles};
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
        ($name:ident, $doc:literal, $register:ty, $half:ty, $count:literal, $features:literal,
         $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $transpose:ident,
         |$a:ident, $b:ident| $above:expr, |$mask:ident, $yes:ident, $no:ident| $select:expr,
         |$single:ident| $widen:expr, |$double:ident| $narrow:expr) => {
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
                fn widen(a: Singles) -> Numbers {
                    let halves = unsafe { transmute::<Singles, [$half; $count]>(a) };
                    let mut out = Self::registers(Numbers::ZERO);
                    for part in 0..$count {
                        let $single = halves[part];
                        out[part] = unsafe { $widen };
                    }
                    Self::numbers(out)
                }

                #[inline(always)]
                fn narrow(a: Numbers) -> Singles {
                    let registers = Self::registers(a);
                    let mut halves = unsafe { transmute::<Singles, [$half; $count]>(Singles([0.0; LANES])) };
                    for part in 0..$count {
                        let $double = registers[part];
                        halves[part] = unsafe { $narrow };
                    }
                    unsafe { transmute::<[$half; $count], Singles>(halves) }
                }

                #[inline(always)]
                fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES] {
                    let mut registers = [Self::registers(Numbers::ZERO); LANES];
                    for i in 0..LANES {
                        registers[i] = Self::registers(rows[i]);
                    }
                    let columns = unsafe { $transpose(registers) };
                    let mut out = [Numbers::ZERO; LANES];
                    for i in 0..LANES {
                        out[i] = Self::numbers(columns[i]);
                    }
                    out
                }

                #[inline(always)]
                fn prefetch<T>(soon: &[T]) {
                    let start = soon.as_ptr().cast::<i8>();
                    for line in (0..size_of_val(soon)).step_by(64) {
                        unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
                    }
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
        Sse2, "Two lanes at a time.", __m128d, f64, 4, "sse2",
        _mm_add_pd _mm_sub_pd _mm_mul_pd _mm_div_pd _mm_sqrt_pd transpose_pairs,
        |a, b| _mm_movemask_pd(_mm_cmpgt_pd(a, b)) as u8,
        |mask, yes, no| {
            let mask = i64::from(mask);
            let mask = _mm_castsi128_pd(_mm_set_epi64x(-(mask >> 1 & 1), -(mask & 1)));
            _mm_or_pd(_mm_and_pd(mask, yes), _mm_andnot_pd(mask, no))
        },
        |single| _mm_cvtps_pd(_mm_castpd_ps(_mm_set_sd(single))),
        |double| _mm_cvtsd_f64(_mm_castps_pd(_mm_cvtpd_ps(double)))
    );

    instructions!(
        Avx2, "Four lanes at a time.", __m256d, __m128, 2, "avx2",
        _mm256_add_pd _mm256_sub_pd _mm256_mul_pd _mm256_div_pd _mm256_sqrt_pd transpose_fours,
        |a, b| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(a, b)) as u8,
        |mask, yes, no| {
            let bits = _mm256_set_epi64x(8, 4, 2, 1);
            let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(mask)), bits);
            _mm256_blendv_pd(no, yes, _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bits)))
        },
        |single| _mm256_cvtps_pd(single),
        |double| _mm256_cvtpd_ps(double)
    );

    instructions!(
        Avx512, "All lanes at once.", __m512d, __m256, 1, "avx512f,avx512dq",
        _mm512_add_pd _mm512_sub_pd _mm512_mul_pd _mm512_div_pd _mm512_sqrt_pd transpose_eights,
        |a, b| _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, b),
        |mask, yes, no| _mm512_mask_blend_pd(mask, no, yes),
        |single| _mm512_cvtps_pd(single),
        |double| _mm512_cvtpd_ps(double)
    );

    /// Blocks of two by two.
    #[inline(always)]
    unsafe fn transpose_pairs(rows: [[__m128d; 4]; LANES]) -> [[__m128d; 4]; LANES] {
        let mut columns = rows;
        for i in 0..4 {
            for k in 0..4 {
                let (a, b) = (rows[2 * i][k], rows[2 * i + 1][k]);
                unsafe {
                    columns[2 * k][i] = _mm_unpacklo_pd(a, b);
                    columns[2 * k + 1][i] = _mm_unpackhi_pd(a, b);
                }
            }
        }
        columns
    }

    /// Blocks of four by four.
    #[inline(always)]
    unsafe fn transpose_fours(rows: [[__m256d; 2]; LANES]) -> [[__m256d; 2]; LANES] {
        let mut columns = rows;
        for i in 0..2 {
            for k in 0..2 {
                let at = |row: usize| rows[4 * i + row][k];
                unsafe {
                    let (low, high) = (_mm256_unpacklo_pd(at(0), at(1)), _mm256_unpackhi_pd(at(0), at(1)));
                    let (low2, high2) = (_mm256_unpacklo_pd(at(2), at(3)), _mm256_unpackhi_pd(at(2), at(3)));
                    columns[4 * k][i] = _mm256_permute2f128_pd::<0x20>(low, low2);
                    columns[4 * k + 1][i] = _mm256_permute2f128_pd::<0x20>(high, high2);
                    columns[4 * k + 2][i] = _mm256_permute2f128_pd::<0x31>(low, low2);
                    columns[4 * k + 3][i] = _mm256_permute2f128_pd::<0x31>(high, high2);
                }
            }
        }
        columns
    }

    /// First pairs of rows, then fours, then all.
    #[inline(always)]
    unsafe fn transpose_eights(rows: [[__m512d; 1]; LANES]) -> [[__m512d; 1]; LANES] {
        let mut columns = rows;
        // Of each half of the rows: columns (0, 4), (2, 6), (1, 5), (3, 7), in pairs of rows.
        let mut halves = [[rows[0][0]; 4]; 2];
        for half in 0..2 {
            let at = |row: usize| rows[4 * half + row][0];
            unsafe {
                let (low, high) = (_mm512_unpacklo_pd(at(0), at(1)), _mm512_unpackhi_pd(at(0), at(1)));
                let (low2, high2) = (_mm512_unpacklo_pd(at(2), at(3)), _mm512_unpackhi_pd(at(2), at(3)));
                halves[half] = [
                    _mm512_shuffle_f64x2::<0x88>(low, low2),
                    _mm512_shuffle_f64x2::<0xdd>(low, low2),
                    _mm512_shuffle_f64x2::<0x88>(high, high2),
                    _mm512_shuffle_f64x2::<0xdd>(high, high2),
                ];
            }
        }
        for (k, column) in [0, 2, 1, 3].into_iter().enumerate() {
            unsafe {
                columns[column][0] = _mm512_shuffle_f64x2::<0x88>(halves[0][k], halves[1][k]);
                columns[column + 4][0] = _mm512_shuffle_f64x2::<0xdd>(halves[0][k], halves[1][k]);
            }
        }
        columns
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rows become columns, and what is narrowed is the nearest single, in every width that this machine has.
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
                let single = I::narrow(rows[i]);
                assert_eq!(single, Scalar::narrow(rows[i]));
                assert_eq!(I::widen(single), Scalar::widen(single));
            }
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
