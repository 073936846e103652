//! Where the engine's memory comes from in Python.

use libmimalloc_sys::{mi_option_get, mi_option_set_default, mi_option_t};
use mimalloc::MiMalloc;
use std::ffi::c_long;

/// A heap of thousands of pieces asks for memory tens of thousands of times in a frame
/// (docs/adr/002).
#[global_allocator]
static MEMORY: MiMalloc = MiMalloc;

/// `mi_option_purge_delay` of mimalloc 3: libmimalloc-sys has no name for it.
const PURGE_DELAY: mi_option_t = 15;

/// How long the allocator keeps memory that was freed before it goes back to the system [ms]. What
/// a frame of 100,000 pieces frees the next one asks for again: with mimalloc's own second a tenth
/// of the time goes into getting it back.
const KEPT_FOR: c_long = 60_000;

/// Lets the allocator keep what is freed, unless the environment (`MIMALLOC_PURGE_DELAY`) says for
/// how long. Returns for how long it does [ms].
pub(crate) fn keep_freed() -> c_long {
    #[allow(
        unsafe_code,
        reason = "the calls write and read a number, which is safe as long as nobody else writes it: modules load one at a time"
    )]
    unsafe {
        mi_option_set_default(PURGE_DELAY, KEPT_FOR);
        mi_option_get(PURGE_DELAY)
    }
}
