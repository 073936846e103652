//! The instruction sets that [`Lanes`](crate::lanes::Lanes) are computed with. All of them add,
//! multiply, divide and take roots as IEEE 754 says, and none contracts, so all give the same bits.

#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "the compiler does not turn these loops into vectors by itself")]
pub(crate) mod x86;

/// As many as the widest registers hold.
pub const LANES: usize = 8;

/// A number in each lane, as it lies in memory; or as many numbers of one lane.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(64))]
pub struct Numbers(
    /// One for each lane.
    pub [f64; LANES],
);

impl Numbers {
    /// Zero in each lane.
    pub const ZERO: Self = Self([0.0; LANES]);
}

/// A number in each lane in single precision: half the room, and half the work where registers hold
/// no more than eight of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[repr(C, align(32))]
pub struct Singles(
    /// One for each lane.
    pub [f32; LANES],
);

impl Singles {
    /// Zero in each lane.
    pub const ZERO: Self = Self([0.0; LANES]);
}

/// What is done to all lanes at once.
pub trait Instructions: Copy + std::fmt::Debug + PartialEq + Send + Sync + 'static {
    /// The sums.
    fn add(a: Numbers, b: Numbers) -> Numbers;
    /// The differences.
    fn sub(a: Numbers, b: Numbers) -> Numbers;
    /// The products.
    fn mul(a: Numbers, b: Numbers) -> Numbers;
    /// The quotients.
    fn div(a: Numbers, b: Numbers) -> Numbers;
    /// The roots.
    fn sqrt(a: Numbers) -> Numbers;
    /// A bit for each lane: whether `a` is greater than `b`.
    fn above(a: Numbers, b: Numbers) -> u8;
    /// In each lane whose bit is set `yes`, else `no`.
    fn select(mask: u8, yes: Numbers, no: Numbers) -> Numbers;
    /// The sums.
    fn add_singles(a: Singles, b: Singles) -> Singles;
    /// The differences.
    fn sub_singles(a: Singles, b: Singles) -> Singles;
    /// The products.
    fn mul_singles(a: Singles, b: Singles) -> Singles;
    /// The quotients.
    fn div_singles(a: Singles, b: Singles) -> Singles;
    /// The roots.
    fn sqrt_singles(a: Singles) -> Singles;
    /// The smaller ones; `b` where one is not a number, or both are equal.
    fn min_singles(a: Singles, b: Singles) -> Singles;
    /// The larger ones; `b` where one is not a number, or both are equal.
    fn max_singles(a: Singles, b: Singles) -> Singles;
    /// As [`Self::above`].
    fn above_singles(a: Singles, b: Singles) -> u8;
    /// As [`Self::select`].
    fn select_singles(mask: u8, yes: Singles, no: Singles) -> Singles;
    /// Rows become columns.
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES];
    /// As [`Self::transpose`].
    fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES];
    /// Asks for what will be needed soon; changes nothing.
    fn prefetch<T>(soon: &[T]);
    /// Runs a kernel with these instructions. Only for what [`available`](crate::available) has named: the machine
    /// must have them.
    fn run(kernel: impl FnOnce());
}

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
