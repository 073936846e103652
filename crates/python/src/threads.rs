//! Threads that outlive a fork: a child has none of its parent's, and waits for them forever unless
//! it makes its own.

use crate::errors::build_error;
use pyo3::exceptions::PyRuntimeError;
use pyo3::marker::Ungil;
use pyo3::prelude::*;
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::mem;
use std::sync::{Arc, Mutex, PoisonError};

/// A pool of threads, in the process that made it.
pub(crate) struct Pool {
    pool: Option<Arc<ThreadPool>>,
    threads: usize,
    process: u32,
}

impl Pool {
    /// With so many threads; 0 means one for every processor.
    pub(crate) const fn new(threads: usize) -> Self {
        Self { pool: None, threads, process: 0 }
    }

    /// Its threads in this process.
    pub(crate) fn here(&mut self) -> PyResult<Arc<ThreadPool>> {
        let process = std::process::id();
        if self.process != process {
            // Threads of another process cannot be told to end.
            mem::forget(self.pool.take());
            self.process = process;
        }
        if let Some(pool) = &self.pool {
            return Ok(pool.clone());
        }
        let pool =
            ThreadPoolBuilder::new().num_threads(self.threads).build().map_err(build_error)?;
        Ok(self.pool.insert(Arc::new(pool)).clone())
    }
}

/// For all that belongs to no world.
static SHARED: Mutex<Pool> = Mutex::new(Pool::new(0));

/// The threads of this process that belong to no world.
pub(crate) fn shared() -> PyResult<Arc<ThreadPool>> {
    SHARED.lock().unwrap_or_else(PoisonError::into_inner).here()
}

/// Does work without the interpreter lock, on the threads of this process.
pub(crate) fn detached<T: Ungil + Send>(
    py: Python<'_>,
    work: impl FnOnce() -> T + Ungil + Send,
) -> PyResult<T> {
    let pool = shared()?;
    Ok(py.detach(|| pool.install(work)))
}

/// Somebody else uses a world.
pub(crate) fn busy() -> PyErr {
    PyRuntimeError::new_err(
        "the world is in use by another thread: only one thread at a time may use a world",
    )
}
