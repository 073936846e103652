//! The world behind the door: one thread at a time uses it, and a signal ends what takes long.

use crate::errors::build_error;
use crate::interrupt::interruptible_in;
use crate::threads::{Pool, busy};
use frangible::BuildError;
use pyo3::exceptions::{PyKeyboardInterrupt, PyRuntimeError};
use pyo3::prelude::*;
use std::mem;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, MutexGuard, TryLockError};

/// A world, and what stops it.
pub(crate) struct OwnWorld {
    inner: Mutex<Inner>,
    /// The step that runs, or the next one, is to end at once.
    is_stopped: AtomicBool,
}

/// A world with its threads.
pub(crate) struct Inner {
    pub(crate) world: frangible::World,
    pub(crate) pool: Pool,
}

impl OwnWorld {
    pub(crate) fn new(world: frangible::World, pool: Pool) -> Self {
        Self { inner: Mutex::new(Inner { world, pool }), is_stopped: AtomicBool::new(false) }
    }

    /// The world, for this thread alone.
    pub(crate) fn inner(&self) -> PyResult<MutexGuard<'_, Inner>> {
        match self.inner.try_lock() {
            Ok(inner) => Ok(inner),
            Err(TryLockError::WouldBlock) => Err(busy()),
            Err(TryLockError::Poisoned(_)) => Err(PyRuntimeError::new_err(
                "the world was left in the middle of a step: build it anew",
            )),
        }
    }

    /// What a caller does to the world; answers with the rule that it breaks.
    pub(crate) fn act<T>(
        &self,
        act: impl FnOnce(&mut frangible::World) -> Result<T, BuildError>,
    ) -> PyResult<T> {
        act(&mut self.inner()?.world).map_err(build_error)
    }

    /// Does what may take long to a copy of the world, which then takes its place: a signal, or
    /// [`OwnWorld::stop`], ends it, and leaves the world as it was.
    pub(crate) fn change<T: Send + 'static>(
        &self,
        py: Python<'_>,
        change: impl FnOnce(&mut frangible::World) -> T + Send + 'static,
    ) -> PyResult<T> {
        let ask = || {
            py.check_signals()?;
            if self.is_stopped.swap(false, Ordering::Relaxed) {
                return Err(PyKeyboardInterrupt::new_err("the step was stopped"));
            }
            Ok(())
        };
        let mut inner = self.inner()?;
        ask()?;
        let pool = inner.pool.here()?;
        let before = inner.world.clone();
        let mut world = mem::replace(&mut inner.world, before);
        let (done, after) = interruptible_in(py, &pool, ask, move || {
            let done = change(&mut world);
            (done, world)
        })?;
        inner.world = after;
        Ok(done)
    }

    /// Ends the change that runs, or else the next one.
    pub(crate) fn stop(&self) {
        self.is_stopped.store(true, Ordering::Relaxed);
    }
}
