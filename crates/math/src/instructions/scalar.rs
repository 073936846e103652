//! The same operations without vectors: what the others must agree with.

use crate::instructions::{Instructions, LANES, Numbers, Singles, on_its_own};

/// One lane after the other.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scalar;

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
        on_its_own(kernel);
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
