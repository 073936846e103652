//! The instruction sets that [`Lanes`](crate::lanes::Lanes) are computed with. All of them add,
//! multiply, divide and take roots as IEEE 754 says, and none contracts, so all give the same bits.
//! [`with_widest`](crate::with_widest) chooses one.

#[cfg(any(target_arch = "x86_64", all(target_arch = "wasm32", target_feature = "simd128")))]
mod registers;
#[cfg(not(all(target_arch = "wasm32", target_feature = "simd128")))]
pub(crate) mod scalar;
#[cfg(all(target_arch = "wasm32", target_feature = "simd128"))]
#[allow(unsafe_code, reason = "registers are the memory of lanes, seen as another type")]
#[allow(unused_unsafe, reason = "operations on registers are safe there")]
pub(crate) mod simd128;
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code, reason = "the compiler does not turn these loops into vectors by itself")]
pub(crate) mod x86;

/// Number of lanes: the single-precision lanes of the widest registers.
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

/// Operations on all lanes at once.
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
    /// Lane bits of `a > b`.
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
    /// Lane minima; `b` for NaN or equal values.
    fn min_singles(a: Singles, b: Singles) -> Singles;
    /// Lane maxima; `b` for NaN or equal values.
    fn max_singles(a: Singles, b: Singles) -> Singles;
    /// As [`Self::above`].
    fn above_singles(a: Singles, b: Singles) -> u8;
    /// As [`Self::select`].
    fn select_singles(mask: u8, yes: Singles, no: Singles) -> Singles;
    /// Rows become columns.
    fn transpose(rows: [Numbers; LANES]) -> [Numbers; LANES];
    /// As [`Self::transpose`].
    fn transpose_singles(rows: [Singles; LANES]) -> [Singles; LANES];
    /// Prefetches memory; no other effect.
    fn prefetch<T>(soon: &[T]);
    /// Runs a function compiled for these instructions. [`with_widest`](crate::with_widest) has
    /// chosen them: the machine has them.
    fn run(kernel: impl FnOnce());
}

/// Runs a kernel as a function of its own: where it is part of its callers LLVM takes minutes.
#[inline(never)]
fn on_its_own(kernel: impl FnOnce()) {
    kernel();
}
