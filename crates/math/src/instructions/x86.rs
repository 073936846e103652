//! The same operations on whole registers. Sound because [`available`](crate::available) names a
//! set only where the machine has it, and the sizes are equal.

use crate::instructions::registers::arithmetic;
use crate::instructions::{Instructions, LANES, Numbers, Singles};
use std::arch::x86_64::*;
use std::mem::transmute;

macro_rules! instructions {
    ($name:ident, $doc:literal, $register:ty, $count:literal, $features:literal,
     $transpose:ident, $singles:ty, $transpose_singles:ident, {$($arithmetic:tt)*}) => {
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
            $($arithmetic)*

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
            fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES] {
                unsafe {
                    let columns = $transpose_singles(transmute::<[Singles; LANES], [$singles; LANES]>(rows));
                    transmute::<[$singles; LANES], [Singles; LANES]>(columns)
                }
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
    Sse2,
    "Two lanes at a time, four in single precision.",
    __m128d,
    4,
    "sse2",
    transpose_pairs,
    [__m128; 2],
    transpose_singles_by_four,
    {
        arithmetic!(
            Numbers, [__m128d; 4],
            add _mm_add_pd, sub _mm_sub_pd, mul _mm_mul_pd, div _mm_div_pd; sqrt _mm_sqrt_pd,
            above |a, b| _mm_movemask_pd(_mm_cmpgt_pd(a, b)) as u8,
            select |mask, yes, no| {
                let mask = i64::from(mask);
                let mask = _mm_castsi128_pd(_mm_set_epi64x(-(mask >> 1 & 1), -(mask & 1)));
                _mm_or_pd(_mm_and_pd(mask, yes), _mm_andnot_pd(mask, no))
            }
        );
        arithmetic!(
            Singles, [__m128; 2],
            add_singles _mm_add_ps, sub_singles _mm_sub_ps, mul_singles _mm_mul_ps, div_singles _mm_div_ps,
            min_singles _mm_min_ps, max_singles _mm_max_ps;
            sqrt_singles _mm_sqrt_ps,
            above_singles |a, b| _mm_movemask_ps(_mm_cmpgt_ps(a, b)) as u8,
            select_singles |mask, yes, no| {
                let bits = _mm_set_epi32(8, 4, 2, 1);
                let set = _mm_and_si128(_mm_set1_epi32(i32::from(mask)), bits);
                let mask = _mm_castsi128_ps(_mm_cmpeq_epi32(set, bits));
                _mm_or_ps(_mm_and_ps(mask, yes), _mm_andnot_ps(mask, no))
            }
        );
    }
);

instructions!(
    Avx2,
    "Four lanes at a time, all in single precision.",
    __m256d,
    2,
    "avx2",
    transpose_fours,
    __m256,
    transpose_singles_by_eight,
    {
        arithmetic!(
            Numbers, [__m256d; 2],
            add _mm256_add_pd, sub _mm256_sub_pd, mul _mm256_mul_pd, div _mm256_div_pd; sqrt _mm256_sqrt_pd,
            above |a, b| _mm256_movemask_pd(_mm256_cmp_pd::<_CMP_GT_OQ>(a, b)) as u8,
            select |mask, yes, no| {
                let bits = _mm256_set_epi64x(8, 4, 2, 1);
                let set = _mm256_and_si256(_mm256_set1_epi64x(i64::from(mask)), bits);
                _mm256_blendv_pd(no, yes, _mm256_castsi256_pd(_mm256_cmpeq_epi64(set, bits)))
            }
        );
        arithmetic!(
            Singles, [__m256; 1],
            add_singles _mm256_add_ps, sub_singles _mm256_sub_ps, mul_singles _mm256_mul_ps,
            div_singles _mm256_div_ps, min_singles _mm256_min_ps, max_singles _mm256_max_ps; sqrt_singles _mm256_sqrt_ps,
            above_singles |a, b| _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_GT_OQ>(a, b)) as u8,
            select_singles |mask, yes, no| {
                let bits = _mm256_set_epi32(128, 64, 32, 16, 8, 4, 2, 1);
                let set = _mm256_and_si256(_mm256_set1_epi32(i32::from(mask)), bits);
                _mm256_blendv_ps(no, yes, _mm256_castsi256_ps(_mm256_cmpeq_epi32(set, bits)))
            }
        );
    }
);

instructions!(
    Avx512,
    "All lanes at once.",
    __m512d,
    1,
    "avx512f,avx512dq,avx512vl",
    transpose_eights,
    __m256,
    transpose_singles_by_eight,
    {
        arithmetic!(
            Numbers, [__m512d; 1],
            add _mm512_add_pd, sub _mm512_sub_pd, mul _mm512_mul_pd, div _mm512_div_pd; sqrt _mm512_sqrt_pd,
            above |a, b| _mm512_cmp_pd_mask::<_CMP_GT_OQ>(a, b),
            select |mask, yes, no| _mm512_mask_blend_pd(mask, no, yes)
        );
        arithmetic!(
            Singles, [__m256; 1],
            add_singles _mm256_add_ps, sub_singles _mm256_sub_ps, mul_singles _mm256_mul_ps,
            div_singles _mm256_div_ps, min_singles _mm256_min_ps, max_singles _mm256_max_ps; sqrt_singles _mm256_sqrt_ps,
            above_singles |a, b| _mm256_cmp_ps_mask::<_CMP_GT_OQ>(a, b),
            select_singles |mask, yes, no| _mm256_mask_blend_ps(mask, no, yes)
        );
    }
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
                let (low, high) =
                    (_mm256_unpacklo_pd(at(0), at(1)), _mm256_unpackhi_pd(at(0), at(1)));
                let (low2, high2) =
                    (_mm256_unpacklo_pd(at(2), at(3)), _mm256_unpackhi_pd(at(2), at(3)));
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
            let (low2, high2) =
                (_mm512_unpacklo_pd(at(2), at(3)), _mm512_unpackhi_pd(at(2), at(3)));
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

/// Blocks of four by four.
#[inline(always)]
unsafe fn transpose_singles_by_four(rows: [[__m128; 2]; LANES]) -> [[__m128; 2]; LANES] {
    let mut columns = rows;
    for i in 0..2 {
        for k in 0..2 {
            let [a, b, c, d] =
                [rows[4 * i][k], rows[4 * i + 1][k], rows[4 * i + 2][k], rows[4 * i + 3][k]];
            unsafe {
                let (low, high) = (_mm_unpacklo_ps(a, b), _mm_unpackhi_ps(a, b));
                let (low2, high2) = (_mm_unpacklo_ps(c, d), _mm_unpackhi_ps(c, d));
                columns[4 * k][i] = _mm_movelh_ps(low, low2);
                columns[4 * k + 1][i] = _mm_movehl_ps(low2, low);
                columns[4 * k + 2][i] = _mm_movelh_ps(high, high2);
                columns[4 * k + 3][i] = _mm_movehl_ps(high2, high);
            }
        }
    }
    columns
}

/// First fours in each half of the registers, then halves.
#[inline(always)]
unsafe fn transpose_singles_by_eight(rows: [__m256; LANES]) -> [__m256; LANES] {
    let mut fours = rows;
    for i in 0..2 {
        let [a, b, c, d] = [rows[4 * i], rows[4 * i + 1], rows[4 * i + 2], rows[4 * i + 3]];
        unsafe {
            let low = _mm256_castps_pd(_mm256_unpacklo_ps(a, b));
            let high = _mm256_castps_pd(_mm256_unpackhi_ps(a, b));
            let low2 = _mm256_castps_pd(_mm256_unpacklo_ps(c, d));
            let high2 = _mm256_castps_pd(_mm256_unpackhi_ps(c, d));
            fours[4 * i] = _mm256_castpd_ps(_mm256_unpacklo_pd(low, low2));
            fours[4 * i + 1] = _mm256_castpd_ps(_mm256_unpackhi_pd(low, low2));
            fours[4 * i + 2] = _mm256_castpd_ps(_mm256_unpacklo_pd(high, high2));
            fours[4 * i + 3] = _mm256_castpd_ps(_mm256_unpackhi_pd(high, high2));
        }
    }
    let mut columns = fours;
    for at in 0..4 {
        unsafe {
            columns[at] = _mm256_permute2f128_ps::<0x20>(fours[at], fours[at + 4]);
            columns[at + 4] = _mm256_permute2f128_ps::<0x31>(fours[at], fours[at + 4]);
        }
    }
    columns
}
