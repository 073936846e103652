//! The instruction sets that [`Lanes`](crate::lanes::Lanes) are computed with. All of them add,
//! multiply, divide and take roots as IEEE 754 says, and none contracts, so all give the same bits.

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "the compiler does not turn these loops into vectors by itself")]
mod x86;

use crate::lanes::LANES;
use crate::settings::Width;

/// A number in each lane, as it lies in memory; or as many numbers of one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub(crate) struct Numbers(pub(crate) [f64; LANES]);

impl Numbers {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// A number in each lane in single precision: half the room, and half the work where registers hold
/// no more than eight of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub(crate) struct Singles(pub(crate) [f32; LANES]);

impl Singles {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);
}

/// What is done to all lanes at once.
pub(crate) trait Instructions:
    Copy + std::fmt::Debug + PartialEq + Send + Sync + 'static
{
    fn add(a: Numbers, b: Numbers) -> Numbers;
    fn sub(a: Numbers, b: Numbers) -> Numbers;
    fn mul(a: Numbers, b: Numbers) -> Numbers;
    fn div(a: Numbers, b: Numbers) -> Numbers;
    fn sqrt(a: Numbers) -> Numbers;
    /// A bit for each lane: whether `a` is greater than `b`.
    fn above(a: Numbers, b: Numbers) -> u8;
    /// In each lane whose bit is set `yes`, else `no`.
    fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers;
    fn add_singles(a: Singles, b: Singles) -> Singles;
    fn sub_singles(a: Singles, b: Singles) -> Singles;
    fn mul_singles(a: Singles, b: Singles) -> Singles;
    fn div_singles(a: Singles, b: Singles) -> Singles;
    fn sqrt_singles(a: Singles) -> Singles;
    /// The smaller ones; `b` where one is not a number, or both are equal.
    fn min_singles(a: Singles, b: Singles) -> Singles;
    /// The larger ones; `b` where one is not a number, or both are equal.
    fn max_singles(a: Singles, b: Singles) -> Singles;
    fn above_singles(a: Singles, b: Singles) -> u8;
    fn select_singles(mask: u8, yes: Singles, no: Singles) -> Singles;
    /// Rows become columns.
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES];
    fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES];
    /// Asks for what will be needed soon; changes nothing.
    fn prefetch<T>(soon: &[T]);
    /// Runs a kernel with these instructions. Only for what [`available`] has named: the machine
    /// must have them.
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
    #[cfg(not(target_arch = "x86_64"))]
    {
        let _ = asked;
        Width::Scalar
    }
}

/// Calls a function of some instructions with the widest that there are, up to a width.
macro_rules! with_widest {
    ($asked:expr, $function:ident($($argument:expr),*)) => {{
        #[cfg(target_arch = "x86_64")]
        use $crate::instructions::{Avx2, Avx512, Sse2};
        use $crate::instructions::{Scalar, available};
        use $crate::settings::Width;
        match available($asked) {
            Width::Scalar => $function::<Scalar>($($argument),*),
            #[cfg(target_arch = "x86_64")]
            Width::Sse2 => $function::<Sse2>($($argument),*),
            #[cfg(target_arch = "x86_64")]
            Width::Avx2 => $function::<Avx2>($($argument),*),
            #[cfg(target_arch = "x86_64")]
            Width::Avx512 => $function::<Avx512>($($argument),*),
            #[cfg(not(target_arch = "x86_64"))]
            Width::Sse2 | Width::Avx2 | Width::Avx512 => $function::<Scalar>($($argument),*),
        }
    }};
}
pub(crate) use with_widest;

/// One lane after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Scalar;

macro_rules! one_by_one {
    ($type:ident: $add:ident $sub:ident $mul:ident $div:ident $sqrt:ident $above:ident $select:ident) => {
        one_by_one!($type: $add +, $sub -, $mul *, $div /);

        #[inline(always)]
        fn $sqrt(a: $type) -> $type {
            $type(each(|lane| a.0[lane].sqrt()))
        }

        #[inline(always)]
        fn $above(a: $type, b: $type) -> u8 {
            (0..LANES).fold(0, |mask, lane| mask | u8::from(a.0[lane] > b.0[lane]) << lane)
        }

        #[inline(always)]
        fn $select(mask: u8, yes: $type, no: $type) -> $type {
            $type(each(|lane| if mask >> lane & 1 == 1 { yes.0[lane] } else { no.0[lane] }))
        }
    };
    ($type:ident: $($method:ident $operator:tt),*) => { $(
        #[inline(always)]
        fn $method(a: $type, b: $type) -> $type {
            $type(each(|lane| a.0[lane] $operator b.0[lane]))
        }
    )* };
}

impl Instructions for Scalar {
    one_by_one!(Numbers: add sub mul div sqrt above select);
    one_by_one!(Singles: add_singles sub_singles mul_singles div_singles sqrt_singles above_singles select_singles);

    #[inline(always)]
    fn min_singles(a: Singles, b: Singles) -> Singles {
        Singles(each(|lane| if a.0[lane] < b.0[lane] { a.0[lane] } else { b.0[lane] }))
    }

    #[inline(always)]
    fn max_singles(a: Singles, b: Singles) -> Singles {
        Singles(each(|lane| if a.0[lane] > b.0[lane] { a.0[lane] } else { b.0[lane] }))
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
    fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES] {
        let mut columns = [Singles::ZERO; LANES];
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
fn each<T: Copy + Default>(value: impl Fn(usize) -> T) -> [T; LANES] {
    let mut all = [T::default(); LANES];
    for lane in 0..LANES {
        all[lane] = value(lane);
    }
    all
}

#[cfg(target_arch = "x86_64")]
pub(crate) use x86::{Avx2, Avx512, Sse2};

#[cfg(test)]
mod tests {
    use super::*;

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
