//! Work that somebody else may call off (docs/adr/036).
//!
//! Long work asks [`check`] from time to time. Once it is called off it unwinds from there to the
//! [`Cancel::run`] that it began in, past all that is half done. The loops of [`crate::threads`] ask
//! for whoever goes through them, and take the question along to their threads.

use std::cell::RefCell;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

thread_local! {
    /// By what the work of this thread is called off.
    static CURRENT: RefCell<Option<Cancel>> = const { RefCell::new(None) };
}

/// Calls off the work that runs with it; clones are the same.
#[derive(Clone, Debug, Default)]
pub struct Cancel(Arc<AtomicBool>);

/// What unwinds.
struct CalledOff;

impl Cancel {
    /// Calls the work off, from any thread.
    pub fn cancel(&self) {
        self.0.store(true, Ordering::Relaxed);
    }

    /// Does work; `None` if it was called off. What the work was changing is half changed then, and
    /// must be dropped.
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> Option<T> {
        let _here = enter(Some(self.clone()));
        match catch_unwind(AssertUnwindSafe(work)) {
            Ok(done) => Some(done),
            Err(thrown) if thrown.is::<CalledOff>() => None,
            Err(thrown) => resume_unwind(thrown),
        }
    }
}

/// Asks whether the work that runs here was called off, and does not return if so.
#[inline]
pub fn check() {
    let is_called_off = |cancel: &Option<Cancel>| {
        cancel.as_ref().is_some_and(|cancel| cancel.0.load(Ordering::Relaxed))
    };
    if CURRENT.with_borrow(is_called_off) && !std::thread::panicking() {
        resume_unwind(Box::new(CalledOff));
    }
}

/// By what the work of this thread is called off, for its other threads to [`enter`].
pub(crate) fn current() -> Option<Cancel> {
    CURRENT.with_borrow(Clone::clone)
}

/// Lets this thread work for the owner of `cancel` until the answer is dropped.
pub(crate) fn enter(cancel: Option<Cancel>) -> Here {
    Here { before: CURRENT.replace(cancel) }
}

/// A thread at work for somebody.
pub(crate) struct Here {
    before: Option<Cancel>,
}

impl Drop for Here {
    fn drop(&mut self) {
        CURRENT.set(self.before.take());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::threads;

    /// Work that nobody calls off is as without the question.
    #[test]
    fn work_that_goes_on_is_done() {
        assert_eq!(Cancel::default().run(|| 7), Some(7));
        check();
    }

    /// Loops on any number of threads, and loops in loops, end soon, and the thread is free for the
    /// next work.
    #[test]
    fn work_that_is_called_off_ends() {
        for threads in [1, 3] {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            let cancel = Cancel::default();
            let done = pool.install(|| {
                cancel.run(|| {
                    threads::map((0..64).collect(), 1000, |item| {
                        if item == 8 {
                            cancel.cancel();
                        }
                        // Those from the eighth on go on until they are called off.
                        loop {
                            threads::for_each(&mut [0; 4], 1000, |_| {});
                            if item < 8 {
                                return item;
                            }
                        }
                    })
                })
            });
            assert_eq!(done, None);
            assert_eq!(pool.install(|| threads::list(1000, |i| i)).len(), 1000);
        }
    }

    /// A panic stays a panic.
    #[test]
    #[should_panic(expected = "at the disco")]
    fn other_panics_pass() {
        Cancel::default().run(|| panic!("at the disco"));
    }
}
