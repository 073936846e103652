//! Places in memory that several threads read and write at a time, each its own: lines of numbers, and flags.

use std::cell::UnsafeCell;

/// Lines of which no two threads use the same one at a time if either writes it: whoever shares work out sees to that, and only the bodies of
/// a cluster are kept so. Threads have ranks or regions, whose groups share no body, or stretches of lists in which each body is once.
#[repr(transparent)]
pub(super) struct SharedLines<T>(Vec<UnsafeCell<T>>);

// The promise above.
#[allow(
    unsafe_code,
    reason = "only ranks, regions and lists of a cluster's bodies know that the bodies of their parts differ"
)]
unsafe impl<T: Send + Sync> Sync for SharedLines<T> {}

#[allow(unsafe_code, reason = "see there")]
impl<T: Copy> SharedLines<T> {
    pub(super) fn new(line: T, count: usize) -> Self {
        Self((0..count).map(|_| UnsafeCell::new(line)).collect())
    }

    #[inline(always)]
    pub(super) fn read(&self, at: usize) -> T {
        // Nobody writes this line now.
        unsafe { *self.0[at].get() }
    }

    #[inline(always)]
    pub(super) fn write(&self, at: usize, line: T) {
        // Nobody else uses this line now.
        unsafe { *self.0[at].get() = line }
    }

    /// All lines, to ask for their memory only.
    #[inline(always)]
    pub(super) fn all(&self) -> &[UnsafeCell<T>] {
        &self.0
    }

    /// All lines, for one thread.
    pub(super) fn as_mut_slice(&mut self) -> &mut [T] {
        let lines: *mut [UnsafeCell<T>] = self.0.as_mut_slice();
        // They are laid out as what they hold.
        unsafe { &mut *(lines as *mut [T]) }
    }
}
