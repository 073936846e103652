//! Long work that can be stopped from the keyboard.

use crate::threads::shared;
use frangible::Cancel;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use rayon::ThreadPool;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often Python is asked for signals.
const POLL: Duration = Duration::from_millis(50);

/// Does the work on the threads of this process without Python's lock, and meanwhile listens to
/// signals: an exception that a signal raises is answered at once, and the work is called off. It
/// ends where it asks next, and nobody hears of it.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let pool = shared()?;
    interruptible_in(py, &pool, || py.check_signals(), work)
}

/// The same in a pool; `ask` answers with the exception that stops the work.
pub(crate) fn interruptible_in<T: Send + 'static>(
    py: Python<'_>,
    pool: &ThreadPool,
    ask: impl Fn() -> PyResult<()>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let (sender, mut receiver) = channel();
    let cancel = Cancel::default();
    let of_work = cancel.clone();
    pool.spawn(move || {
        let done = catch_unwind(AssertUnwindSafe(|| of_work.run(work)));
        // Nobody receives what was given up.
        let _ = sender.send(done);
    });
    loop {
        let (received, back) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        receiver = back;
        match received {
            Ok(Ok(Some(result))) => return Ok(result),
            Ok(Err(panic)) => resume_unwind(panic),
            Err(RecvTimeoutError::Timeout) => {
                if let Err(stop) = ask() {
                    cancel.cancel();
                    return Err(stop);
                }
            }
            Ok(Ok(None)) | Err(RecvTimeoutError::Disconnected) => {
                return Err(PyRuntimeError::new_err("the work ended without an answer"));
            }
        }
    }
}
