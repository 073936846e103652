//! Inverses of masses, lane by lane.

use frangible_math::{Instructions, Single};

/// Minimum determinant of a 2 x 2 effective mass, relative to the product of its diagonal. For
/// slivers the determinant is pure rounding error.
const LEAST_DETERMINANT: f64 = 1e-5;

/// 1/x for positive x, else 0.
#[inline(always)]
pub(super) fn reciprocal<I: Instructions>(x: Single<I>) -> Single<I> {
    x.above(Single::ZERO).select(Single::same(1.0) / x, Single::ZERO)
}

/// Inverse of a symmetric matrix with entries xx, yy and xy. Dividing by the trace first keeps the
/// squared entries of slivers within single precision.
#[inline(always)]
pub(super) fn inverse_2x2<I: Instructions>([xx, yy, xy]: [Single<I>; 3]) -> [Single<I>; 3] {
    let scale = reciprocal(xx + yy);
    let (xx, yy, xy) = (xx * scale, yy * scale, xy * scale);
    let least = xx * yy * Single::splat(LEAST_DETERMINANT);
    let by = reciprocal((xx * yy - xy * xy).max(least)) * scale;
    [yy * by, xx * by, -(xy * by)]
}
