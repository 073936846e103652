//! Long work that can be stopped from the keyboard.

use crate::threads::shared;
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// How often Python is asked for signals.
const POLL: Duration = Duration::from_millis(50);

/// Does the work on a thread of its own without Python's lock, and meanwhile listens to signals: an
/// exception that a signal raises is answered at once. The work then goes on unheard, until it is
/// done or the process ends.
pub(crate) fn interruptible<T: Send + 'static>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Send + 'static,
) -> PyResult<T> {
    let pool = shared()?;
    let (sender, mut receiver) = channel();
    // Nobody receives what was given up.
    let thread = std::thread::spawn(move || sender.send(pool.install(work)).is_ok());
    loop {
        let (received, back) = py.detach(move || (receiver.recv_timeout(POLL), receiver));
        receiver = back;
        match received {
            Ok(result) => return Ok(result),
            Err(RecvTimeoutError::Timeout) => py.check_signals()?,
            Err(RecvTimeoutError::Disconnected) => match py.detach(|| thread.join()) {
                Err(panic) => std::panic::resume_unwind(panic),
                Ok(_) => return Err(PyRuntimeError::new_err("the work ended without an answer")),
            },
        }
    }
}
