//! Parallel loops on the current thread pool. Results are the same, to the bit, for any number of
//! threads: each item belongs to one thread, and results are combined in item order.
//!
//! The pool only sees item numbers and a single call type. With generic kernels each call site
//! would be compiled three times, two fifths of the whole compile time.
//!
//! All of them end early once their work is called off ([`cancel`]).

use crate::cancel;
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

/// Things, pairs or bodies, of which fewer than this are not worth sharing out.
const FEW: usize = 256;

/// True if the work is worth sharing and the pool has several threads. From outside of the pool,
/// entry costs more than most of this work.
pub fn is_shared(things: usize) -> bool {
    things > FEW && rayon::current_thread_index().is_some() && rayon::current_num_threads() > 1
}

/// Does work on a thread of the current pool, or of the global one.
pub fn in_pool<R: Send>(work: impl FnOnce() -> R + Send) -> R {
    let cancel = cancel::current();
    rayon::scope(|_| {
        let _here = cancel::enter(cancel);
        work()
    })
}

/// Calls `call` about once per thread, with an iterator over numbers below `count`; each number
/// comes once. A thread starts with its own range (the same range for the same count, for warm
/// caches), then steals unstarted numbers of other threads.
fn share(count: usize, call: &(dyn Fn(&mut dyn Iterator<Item = usize>) + Sync)) {
    let stretches = rayon::current_num_threads().min(count);
    let end = |stretch: usize| (stretch + 1) * count / stretches;
    let next: Vec<AtomicUsize> =
        (0..stretches).map(|stretch| AtomicUsize::new(stretch * count / stretches)).collect();
    let cancel = cancel::current();
    let of_thread = |_| {
        let _here = cancel::enter(cancel.clone());
        let own = rayon::current_thread_index().unwrap_or(0);
        let mut numbers = (own..own + stretches).map(|turn| turn % stretches).flat_map(|stretch| {
            let next = &next[stretch];
            std::iter::from_fn(move || {
                Some(next.fetch_add(1, Ordering::Relaxed)).filter(|&i| i < end(stretch))
            })
        });
        call(&mut numbers);
    };
    (0..stretches).into_par_iter().with_max_len(1).for_each(of_thread);
}

/// Locks a value that one thread uses at a time. Panics propagate to the waiting thread, and the
/// state left behind is never read.
fn with<T, R>(locked: &Mutex<T>, call: impl FnOnce(&mut T) -> R) -> R {
    call(&mut locked.lock().unwrap_or_else(PoisonError::into_inner))
}

/// Visits each item in parallel; `things` is the total amount of work.
pub fn for_each<T: Send>(items: &mut [T], things: usize, visit: impl Fn(&mut T) + Send + Sync) {
    for_each_with(items, things, || (), |(), item| visit(item));
}

/// As [`for_each`], with room that is used again from item to item.
pub fn for_each_with<T: Send, R>(
    items: &mut [T],
    things: usize,
    room: impl Fn() -> R + Send + Sync,
    visit: impl Fn(&mut R, &mut T) + Send + Sync,
) {
    if items.len() > 1 && is_shared(things) {
        let items: Vec<Mutex<&mut T>> = items.iter_mut().map(Mutex::new).collect();
        share(items.len(), &|numbers| {
            let mut own = None;
            for i in numbers {
                cancel::check();
                with(&items[i], |item| visit(own.get_or_insert_with(&room), item));
            }
        });
    } else {
        let mut room = room();
        for item in items {
            cancel::check();
            visit(&mut room, item);
        }
    }
}

/// Runs two closures in parallel if the amount of work, `things`, is worth it, else one after the
/// other.
pub fn join<A: Send, B: Send>(
    things: usize,
    one: impl FnOnce() -> A + Send,
    other: impl FnOnce() -> B + Send,
) -> (A, B) {
    if !is_shared(things) {
        return (one(), other());
    }
    let cancel = cancel::current();
    rayon::join(
        || {
            let _here = cancel::enter(cancel.clone());
            one()
        },
        || {
            let _here = cancel::enter(cancel.clone());
            other()
        },
    )
}

/// Maps each item in parallel.
pub fn map<T: Send, R: Send>(
    items: Vec<T>,
    things: usize,
    of: impl Fn(T) -> R + Send + Sync,
) -> Vec<R> {
    map_with(items, things, || (), |(), item| of(item))
}

/// As [`map`], with room that is used again for the next items of a thread.
pub fn map_with<T: Send, R: Send, O>(
    items: Vec<T>,
    things: usize,
    room: impl Fn() -> O + Send + Sync,
    of: impl Fn(&mut O, T) -> R + Send + Sync,
) -> Vec<R> {
    if items.len() <= 1 || !is_shared(things) {
        let mut room = room();
        let one = |item| {
            cancel::check();
            of(&mut room, item)
        };
        return items.into_iter().map(one).collect();
    }
    let mut slots: Vec<(Option<T>, Option<R>)> =
        items.into_iter().map(|item| (Some(item), None)).collect();
    for_each_with(&mut slots, things, room, |room, (item, result)| {
        *result = item.take().map(|item| of(room, item));
    });
    slots.into_iter().filter_map(|(_, result)| result).collect()
}

/// A list of `count` values, computed in parallel by index.
pub fn list<R: Send>(count: usize, of: impl Fn(usize) -> R + Send + Sync) -> Vec<R> {
    cancel::check();
    if is_shared(count) {
        let of: &(dyn Fn(usize) -> R + Sync) = &of;
        let cancel = cancel::current();
        let here = || cancel::enter(cancel.clone());
        let numbers = (0..count).into_par_iter().with_min_len(FEW);
        numbers.map_init(here, |_, i| of(i)).collect()
    } else {
        (0..count).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every number comes once for any count, even with nested calls.
    #[test]
    fn each_number_comes_once() {
        let counts = |of_each: &[AtomicUsize]| -> Vec<usize> {
            of_each.iter().map(|count| count.load(Ordering::Relaxed)).collect()
        };
        for threads in 1..=4 {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            for count in [0, 1, 2, 3, 5, 64, 257] {
                let times: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
                let within: Vec<AtomicUsize> = (0..count).map(|_| AtomicUsize::new(0)).collect();
                let add = |to: &[AtomicUsize], numbers: &mut dyn Iterator<Item = usize>| {
                    numbers.for_each(|number| {
                        to[number].fetch_add(1, Ordering::Relaxed);
                    });
                };
                pool.install(|| {
                    share(count, &|numbers| {
                        add(&times, numbers);
                        share(count, &|numbers| add(&within, numbers));
                    });
                });
                assert_eq!(counts(&times), vec![1; count]);
                // Each call runs once per thread with work.
                assert_eq!(counts(&within), vec![threads.min(count); count]);
            }
        }
    }
}
